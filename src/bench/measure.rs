//! The error of one picture against a reference, as `svetlo compare` finds it.

use super::results::{Interval, Metrics};
use crate::Result;
use crate::metrics::{Comparison, Corrected, Removed, compare};
use crate::picture::Picture;

/// Standard errors on either side of a normal 95 % interval.
const NORMAL_95: f64 = 1.959_963_985;

/// Measures `image` against `reference`.
///
/// # Errors
/// As [`compare`].
pub fn measure(image: &Picture, reference: &Picture) -> Result<Metrics> {
    Ok(metrics(&compare(image, reference)?))
}

/// The metrics of a comparison.
pub fn metrics(comparison: &Comparison) -> Metrics {
    let corrected = |whose: Removed| comparison.corrected.iter().find(|entry| entry.removed == whose);
    let clean: Option<&Corrected> = corrected(Removed::Reference);
    let mse = clean.map_or(comparison.mse, |clean| clean.mse);
    let rmse = root(mse);
    let bias = &comparison.bias;
    let mean = bias.reference_mean.abs();
    let relative = |value: f64| (mean > 0.0).then(|| value / mean);
    // An exact reference, or a picture of unknown noise, leaves one noise to take out.
    let own = corrected(Removed::Image);
    Metrics {
        mse,
        rmse,
        relative_rmse: rmse.and_then(|rmse| relative(rmse.value)),
        reference_noise: clean.map_or(0.0, |clean| clean.noise),
        own_noise: own.map(|own| own.noise),
        psnr_peak: comparison.psnr.peak,
        psnr_linear_db: clean.map_or(comparison.psnr.linear_db, |clean| clean.psnr_db),
        psnr_display_db: comparison.psnr.display_db,
        relmse: clean.map_or(comparison.relmse, |clean| clean.relmse),
        mape: comparison.mape,
        bias: plus_minus(bias.mean, bias.standard_error),
        relative_bias: bias.relative,
        bias_z: bias.z,
        squared_bias: corrected(Removed::Both)
            .or(own)
            .map(|both| plus_minus(both.mse.value, Some(both.noise_error))),
    }
}

/// The root of a mean square; `None` where that is negative.
pub(super) fn root(square: Interval) -> Option<Interval> {
    let end = |end: Option<f64>| end.map(|end| end.max(0.0).sqrt());
    (square.value >= 0.0).then(|| Interval {
        value: square.value.sqrt(),
        low: end(square.low),
        high: end(square.high),
    })
}

fn plus_minus(value: f64, error: Option<f64>) -> Interval {
    let half = error.map(|error| NORMAL_95 * error);
    Interval { value, low: half.map(|half| value - half), high: half.map(|half| value + half) }
}
