//! The light volume of a session, for methods that project one.

use super::plan::Plan;
use crate::Result;
use crate::device::{Arg, Buffer, Device};
use crate::irradiance::{LightBuffers, LightData, LightFacts, Lighting};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How far it has come.
enum Stage {
    /// The method has none.
    None,
    Computing(Box<Lighting>),
    Done(LightBuffers),
}

/// A light volume: computed before the first sample, or given.
pub(super) struct SessionLight {
    stage: Stage,
    /// What its computation did, once it is done in this session.
    pub facts: Option<LightFacts>,
    /// Its hash, once it is there.
    pub hash: Option<String>,
    /// Whether it was read from a file.
    pub from_file: bool,
    time: Duration,
    /// Set when the user wants to stop.
    pub interrupt: Option<Arc<AtomicBool>>,
}

impl SessionLight {
    /// The light volume of `plan`: `given`, or one that is to be computed from the `voxels`.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device lacks memory, or building or copying fails.
    pub fn new(
        device: &Device,
        plan: &Plan<'_>,
        given: Option<&LightData>,
        voxels: Option<&Arc<Buffer<u8>>>,
    ) -> Result<Self> {
        let stage = match (&plan.method.light, given) {
            (Some(setup), Some(data)) => Stage::Done(LightBuffers::upload(device, setup.direct_grid, data)?),
            _ => Self::begin(device, plan, voxels)?,
        };
        let hash = given.filter(|_| plan.method.light.is_some()).map(LightData::hash);
        Ok(Self { stage, facts: None, hash, from_file: false, time: Duration::ZERO, interrupt: None })
    }

    fn begin(device: &Device, plan: &Plan<'_>, voxels: Option<&Arc<Buffer<u8>>>) -> Result<Stage> {
        Ok(match (&plan.method.light, voxels) {
            (Some(setup), Some(voxels)) => {
                Stage::Computing(Box::new(Lighting::new(device, plan, setup, Arc::clone(voxels))?))
            }
            _ => Stage::None,
        })
    }

    /// Forgets it, if there is one, and starts anew.
    ///
    /// # Errors
    /// As [`SessionLight::new`].
    pub fn restart(
        &mut self,
        device: &Device,
        plan: &Plan<'_>,
        voxels: Option<&Arc<Buffer<u8>>>,
    ) -> Result<()> {
        self.stage = Self::begin(device, plan, voxels)?;
        (self.facts, self.hash, self.time) = (None, None, Duration::ZERO);
        Ok(())
    }

    /// Whether it is to be computed and not done.
    pub fn is_wanted(&self) -> bool {
        matches!(self.stage, Stage::Computing(_))
    }

    /// The share of it that is done, 0 to 1.
    pub fn share(&self) -> f32 {
        if let Stage::Computing(lighting) = &self.stage { lighting.share() } else { 1.0 }
    }

    /// One step of its computation, and how long that took.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device fails, [`crate::Error::Interrupted`] after an interrupt.
    pub fn step(&mut self, device: &Device) -> Result<Duration> {
        let Stage::Computing(lighting) = &mut self.stage else { return Ok(Duration::ZERO) };
        let start = Instant::now();
        let interrupt = self.interrupt.as_deref();
        let interrupted = || interrupt.is_some_and(|flag| flag.load(Ordering::Relaxed));
        let done = lighting.step(device, &interrupted)?;
        let elapsed = start.elapsed();
        self.time += elapsed;
        if let Some((buffers, facts)) = done {
            self.facts = Some(LightFacts { seconds: self.time.as_secs_f64(), ..facts });
            self.hash = Some(buffers.read(device)?.hash());
            self.stage = Stage::Done(buffers);
        }
        Ok(elapsed)
    }

    /// It as numbers, once it is there.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device fails.
    pub fn read(&self, device: &Device) -> Result<Option<LightData>> {
        match &self.stage {
            Stage::Done(buffers) => Ok(Some(buffers.read(device)?)),
            _ => Ok(None),
        }
    }

    /// What kernels take of it; nothing where there is none.
    pub fn arguments(&self) -> impl Iterator<Item = Arg<'_>> {
        let buffers = if let Stage::Done(buffers) = &self.stage { Some(buffers) } else { None };
        buffers.into_iter().flat_map(LightBuffers::arguments)
    }
}
