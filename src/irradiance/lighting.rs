#![allow(missing_docs)]
use super::LightBuffers;
use crate::device::{Buffer, Device};
use crate::render::Plan;
use crate::render::light_volume::LightSetup;
use crate::{Error, Result};
pub struct ScatteredLight {
    pub fluence: Buffer<[f32; 4]>,
    pub drift: Option<Buffer<[f32; 4]>>,
}
#[derive(Clone, Debug, Default)]
pub struct LightFacts {
    pub seconds: f64,
}
pub struct Lighting {}
impl Lighting {
    pub fn new(_: &Device, _: &Plan<'_>, _: &LightSetup) -> Result<Self> {
        Ok(Self {})
    }
    pub fn share(&self) -> f32 {
        0.0
    }
    pub fn step(&mut self, _: &Device) -> Result<Option<(LightBuffers, LightFacts)>> {
        Err(Error::Failed("todo".into()))
    }
}
