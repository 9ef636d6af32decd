//! What the solver keeps in device memory.

use super::grid::{DeviceDiffusionGrid, Grid};
use crate::Result;
use crate::device::{Buffer, Device, MemoryPlan};

/// Fields of every level, and those of the finest level besides.
const FIELDS: [u64; 2] = [8, 5];

/// One level: the equation with a source, its solution and its residual.
pub(super) struct Level {
    pub grid: Grid,
    pub device_grid: Buffer<DeviceDiffusionGrid>,
    /// Of the faces towards the next cell, per axis.
    pub conductance: [Buffer<f32>; 3],
    /// Absorption and what leaves through the boundary.
    pub loss: Buffer<f32>,
    /// 1 / the diagonal.
    pub inverse: Buffer<f32>,
    /// The solution of the level's equation: a correction of the finer level's.
    pub phi: Buffer<f32>,
    pub source: Buffer<f32>,
    pub residual: Buffer<f32>,
}

impl Level {
    pub fn new(device: &Device, grid: Grid) -> Result<Self> {
        let field = || Buffer::zeroed(device, grid.elements());
        Ok(Self {
            device_grid: Buffer::uninitialised(device, 1)?,
            conductance: [field()?, field()?, field()?],
            loss: field()?,
            inverse: field()?,
            phi: field()?,
            source: field()?,
            residual: field()?,
            grid,
        })
    }
}

/// What only the finest level has.
pub(super) struct Finest {
    /// The solution in two parts; its equation's right side is `source`, that of the level is its residual.
    pub phi: Buffer<f32>,
    pub phi_low: Buffer<f32>,
    pub source: Buffer<f32>,
    /// The direction of conjugate gradients, or the other field of an explicit step.
    pub direction: Buffer<f32>,
    /// The operator applied to it.
    pub leaving: Buffer<f32>,
}

impl Finest {
    pub fn new(device: &Device, grid: &Grid) -> Result<Self> {
        let field = || Buffer::zeroed(device, grid.elements());
        Ok(Self {
            phi: field()?,
            phi_low: field()?,
            source: field()?,
            direction: field()?,
            leaving: field()?,
        })
    }
}

/// What all levels take, and the solution for the caller.
pub(super) fn memory(levels: &[Grid]) -> MemoryPlan {
    let mut plan = MemoryPlan::default();
    for (number, grid) in levels.iter().enumerate() {
        let fields = FIELDS[0] + if number == 0 { FIELDS[1] } else { 0 };
        for field in 0..fields {
            plan.add(
                &format!("diffusion field {field} of level {number}"),
                grid.elements() as u64,
                size_of::<f32>(),
            );
        }
    }
    plan.add("diffuse fluence", levels[0].dims.iter().map(|&n| n as u64).product(), size_of::<f32>());
    plan
}
