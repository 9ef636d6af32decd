//! The film: per-pixel mean and second moment of the samples, and what can be said from them.

mod double;
mod merge;

pub use double::Double;
pub use merge::{FilmRest, Moments};
pub(crate) use merge::{halves, joined, single, weighted};

use crate::device_struct;

device_struct! {
    "types/film.cl",
    /// One pixel of the film, as the device keeps it: sums are unevaluated pairs of floats.
    pub struct FilmPixel {
        /// Mean of rgb radiance and opacity.
        pub mean: [f32; 4],
        /// What `mean` cannot hold.
        pub mean_low: [f32; 4],
        /// Sum of squared deviations from the mean.
        pub m2: [f32; 4],
        /// What `m2` cannot hold.
        pub m2_low: [f32; 4],
        /// Mean distance to the camera in local units, over the samples that hit something.
        pub depth: f32,
        /// Samples with a depth.
        pub hits: u32,
        /// Samples added.
        pub count: u32,
        /// Samples not added because they were not finite.
        pub rejected: u32,
        /// Cells fetched from the volume, low half.
        pub lookups_low: u32,
        /// Cells fetched from the volume, high half.
        pub lookups_high: u32,
        /// Padding.
        pub pad_0: u32,
        /// Padding.
        pub pad_1: u32,
    }
}

impl FilmPixel {
    /// Mean radiance and opacity in double precision.
    pub fn mean(&self) -> [f64; 4] {
        std::array::from_fn(|i| f64::from(self.mean[i]) + f64::from(self.mean_low[i]))
    }

    /// Unbiased variance of one sample, per channel; `None` below two samples. Infinite where the squares were too
    /// large for the device.
    pub fn variance(&self) -> Option<[f64; 4]> {
        let degrees = f64::from(self.count.checked_sub(1).filter(|&n| n > 0)?);
        Some(std::array::from_fn(|i| {
            // Beyond the largest float the pair is inf and NaN.
            let sum = f64::from(self.m2[i]) + f64::from(self.m2_low[i]);
            if sum.is_finite() { (sum / degrees).max(0.0) } else { f64::INFINITY }
        }))
    }

    /// Samples that were tried: added, or rejected.
    pub fn tried(&self) -> u32 {
        self.count.saturating_add(self.rejected)
    }

    /// Cells fetched from the volume.
    pub fn lookups(&self) -> u64 {
        u64::from(self.lookups_high) << 32 | u64::from(self.lookups_low)
    }
}

/// Pictures of a smaller mean have deviations whose squares are no float32 numbers.
const DARKEST: f64 = 1e-16;

/// What a film says as a whole.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FilmSummary {
    /// Mean radiance over pixels and channels.
    pub mean: f64,
    /// Root mean square over pixels and channels of the standard error of the mean; `None` below two samples.
    pub standard_error: Option<f64>,
    /// Samples added, over all pixels.
    pub samples: u64,
    /// Samples rejected as not finite, over all pixels.
    pub rejected: u64,
    /// Cells fetched from the volume, over all pixels and samples.
    pub lookups: u64,
}

impl FilmSummary {
    /// Sums up a film.
    pub fn of(pixels: &[FilmPixel]) -> Self {
        let mut summary = Self::default();
        let (mut total, mut variance, mut known) = (0.0, 0.0, !pixels.is_empty());
        for pixel in pixels {
            total += pixel.mean()[..3].iter().sum::<f64>();
            match pixel.variance() {
                Some(v) => variance += v[..3].iter().sum::<f64>() / f64::from(pixel.count),
                None => known = false,
            }
            summary.samples += u64::from(pixel.count);
            summary.rejected += u64::from(pixel.rejected);
            summary.lookups += pixel.lookups();
        }
        let values = 3.0 * pixels.len() as f64;
        summary.mean = if pixels.is_empty() { 0.0 } else { total / values };
        summary.standard_error = known.then(|| (variance / values).sqrt());
        summary
    }

    /// Estimated RMSE of the picture over its mean: what the stop rule `error` compares.
    ///
    /// A picture that is black everywhere with no variance has error 0. `None` below two samples in a pixel, and where
    /// the squares of radiances are too large or too small for the device.
    pub fn relative_error(&self) -> Option<f64> {
        let (error, mean) = (self.standard_error?, self.mean.abs());
        let lost = !error.is_finite() || (mean > 0.0 && mean < DARKEST);
        (!lost).then(|| if error == 0.0 { 0.0 } else { error / mean })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    fn pixel(count: u32, mean: f32, m2: f32) -> FilmPixel {
        FilmPixel { count, mean: [mean; 4], m2: [m2; 4], ..FilmPixel::zeroed() }
    }

    #[test]
    fn variance_needs_two_samples() {
        assert_eq!(pixel(0, 0.0, 0.0).variance(), None);
        assert_eq!(pixel(1, 1.0, 0.0).variance(), None);
        assert_eq!(pixel(5, 1.0, 8.0).variance(), Some([2.0; 4]));
    }

    #[test]
    fn standard_error_is_the_rms_over_pixels() {
        // Variances of the mean 2/5 and 0: RMS sqrt(0.2), mean 1.5.
        let summary = FilmSummary::of(&[pixel(5, 1.0, 8.0), pixel(2, 2.0, 0.0)]);
        assert_eq!(summary.mean, 1.5);
        assert!((summary.standard_error.unwrap() - 0.2_f64.sqrt()).abs() < 1e-15);
        assert!((summary.relative_error().unwrap() - 0.2_f64.sqrt() / 1.5).abs() < 1e-15);
        assert_eq!(FilmSummary::of(&[pixel(1, 1.0, 0.0)]).relative_error(), None);
        assert_eq!(FilmSummary::of(&[pixel(3, 0.0, 0.0)]).relative_error(), Some(0.0));
    }

    #[test]
    fn squares_beyond_float32_are_no_small_error() {
        let large = FilmPixel { m2_low: [f32::NAN; 4], ..pixel(5, 1e25, f32::INFINITY) };
        assert_eq!(large.variance(), Some([f64::INFINITY; 4]));
        assert_eq!(FilmSummary::of(&[large, pixel(5, 1.0, 8.0)]).relative_error(), None);
        assert_eq!(FilmSummary::of(&[pixel(5, 1e-25, 0.0)]).relative_error(), None);
    }
}
