//! The light that reaches the cells of a light volume unscattered.

use crate::Result;
use crate::device::{Buffer, Device};

/// Light in the cells of a light volume before the medium scatters it, x fastest.
pub struct DirectLight {
    /// Fluence, attenuated by the extinction σ_t, per channel; w: the variance of this estimate of the channels' mean,
    /// 0 where it is exact, infinite where it is not known.
    pub fluence: Buffer<[f32; 4]>,
    /// Fluence attenuated by σ_a + (1 − g) σ_s; `None` where the phase function's mean cosine g is 0: then it is the
    /// same.
    pub reduced: Option<Buffer<[f32; 4]>>,
    /// The mean direction of propagation: vector flux over fluence, of the channels' mean, no longer than 1, 0 in the
    /// dark; `None` for the isotropic phase function, which does not ask for it.
    pub flow: Option<Buffer<[f32; 4]>>,
    /// Of which part of a cell it is the light: in the last number the share of each edge, about the centre, over which it is
    /// a mean, weighted by the extinction, 0 to 1. Before it, where in the cell it is scattered, on average: from −1 to 1
    /// along each axis. `None` where all is light at centres.
    pub extent: Option<Buffer<[f32; 4]>>,
}

impl DirectLight {
    /// RMS standard error of the fluence over its RMS, both of the channels' mean and over all cells; 0 in the dark.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device fails.
    pub fn relative_error(&self, device: &Device) -> Result<f64> {
        let (mut squares, mut variances) = (0.0, 0.0);
        for [r, g, b, variance] in self.fluence.read(device)? {
            let mean = (f64::from(r) + f64::from(g) + f64::from(b)) / 3.0;
            squares += mean * mean;
            variances += f64::from(variance);
        }
        Ok(if variances == 0.0 { 0.0 } else { (variances / squares).sqrt() })
    }
}
