//! Direct light: what reaches the cells without having been scattered.

use crate::device::Buffer;

/// Unscattered light on a light volume, one number (or rgb) per cell, x fastest.
pub struct DirectLight {
    /// Fluence of unscattered light (attenuated by σ_t), rgb; w: variance of the channels' mean (of the estimate), 0 if
    /// exact.
    pub fluence: Buffer<[f32; 4]>,
    /// The same attenuated by σ_tr = σ_a + (1 − g) σ_s; none when g = 0: then it is the same.
    pub reduced: Option<Buffer<[f32; 4]>>,
    /// Mean direction of propagation: vector flux over fluence (of the channels' mean), |flow| ≤ 1; none for the
    /// isotropic phase function.
    pub flow: Option<Buffer<[f32; 4]>>,
}
