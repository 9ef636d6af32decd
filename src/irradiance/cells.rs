//! The medium per cell.

use crate::device::Buffer;

/// Coefficients of the medium, rgb per cell, per local unit.
pub struct Cells {
    /// Scattering.
    pub scattering: Buffer<[f32; 4]>,
    /// Absorption.
    pub absorption: Buffer<[f32; 4]>,
    /// Emission.
    pub glow: Option<Buffer<[f32; 4]>>,
}
