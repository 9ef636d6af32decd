//! Unscattered light in the cells of a light volume.

use crate::device::Buffer;

/// Unscattered light in every cell, x fastest.
pub struct DirectLight {
    /// Fluence per channel; w: the variance of the channels' mean, 0 where it is exact.
    pub fluence: Buffer<[f32; 4]>,
    /// The fluence that sigma_tr = sigma_a + (1 − g) sigma_s leaves instead of sigma_t; `None` where g is 0 and both are
    /// the same.
    pub reduced: Option<Buffer<[f32; 4]>>,
    /// Mean direction of propagation: the flux over the fluence, of the channels' mean, at most 1 long; `None` where the
    /// medium scatters into all directions alike.
    pub flow: Option<Buffer<[f32; 4]>>,
}
