//! Direct light per cell.

use crate::device::Buffer;

/// Direct light in every cell of a grid.
pub struct DirectLight {
    /// Fluence of light that was not scattered, rgb; w: variance of the estimate of the channels' mean, 0 if exact.
    pub fluence: Buffer<[f32; 4]>,
    /// The same where only absorption and (1 − g) of scattering take light away; `None` for g = 0, where it is the same.
    pub reduced: Option<Buffer<[f32; 4]>>,
    /// Mean direction of travel, of the channels' mean: vector flux over fluence, of length 1 at most; `None` for the
    /// isotropic phase function.
    pub flow: Option<Buffer<[f32; 4]>>,
}
