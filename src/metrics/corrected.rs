//! Errors with the known noise taken out.
//!
//! For independent x and r̂, E(x−r̂)² = (bias)² + Var x + Var r̂. Subtracting the estimated
//! variances of the means leaves an unbiased estimate of what remains; it may come out negative.
//! The pictures must come from different random streams: a render compared with its own
//! continuation shares samples, and then too much is subtracted.

use serde::Serialize;

use super::{
    blocks::Estimate,
    pair::{Pair, PairChannel, decibels},
};

/// Whose noise was taken out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Removed {
    /// The reference's: what remains is the image's own error, bias and noise.
    Reference,
    /// The image's: what remains is its bias and the reference's noise.
    Image,
    /// Both: what remains is the squared bias.
    Both,
}

/// A squared error with noise taken out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Corrected {
    /// Whose noise was taken out.
    pub removed: Removed,
    /// The mean variance that was subtracted.
    pub noise: f64,
    /// The corrected MSE, over the values whose noise is known. Negative: below the noise.
    pub mse: Estimate,
    /// Standard error of `mse` from the noise that was taken out alone, for normal noise; an upper bound: the channels
    /// of a pixel are taken as fully correlated. Unlike the interval of `mse` it holds no variation over the picture.
    pub noise_error: f64,
    /// Its root; `None` where the corrected MSE is negative.
    pub rmse: Option<f64>,
    /// 10 log₁₀(P²/MSE) of the corrected MSE, P the largest value of the reference; `None` where undefined.
    pub psnr_db: Option<f64>,
    /// relMSE less the noise over the same r² + ε; `None` for a black reference.
    pub relmse: Option<Estimate>,
    /// Values (pixels × channels) left out because their noise is unknown (n < 2).
    pub unknown: usize,
}

/// z-scores of single values, (x − r)/σ with σ² the sum of the known noises.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PixelZ {
    /// Values (pixels × channels) with a known σ that is not 0, or a difference.
    pub values: usize,
    /// Share of them with |z| > 1.96. Expected for normal noise and no bias: 0.05.
    pub beyond_1_96: f64,
}

type NoiseOf = fn(&PairChannel, usize) -> Option<f64>;

/// Every correction that the files allow.
pub(super) fn corrections(pair: &Pair) -> Vec<Corrected> {
    let choices: [(Removed, NoiseOf); 3] = [
        (Removed::Reference, |channel, pixel| known(channel.reference_noise.as_deref(), pixel)),
        (Removed::Image, |channel, pixel| known(channel.image_noise.as_deref(), pixel)),
        (Removed::Both, |channel, pixel| {
            Some(
                known(channel.reference_noise.as_deref(), pixel)?
                    + known(channel.image_noise.as_deref(), pixel)?,
            )
        }),
    ];
    choices.into_iter().filter_map(|(removed, noise)| correction(pair, removed, noise)).collect()
}

fn correction(pair: &Pair, removed: Removed, noise_of: NoiseOf) -> Option<Corrected> {
    let noise = pair.mean(noise_of)?.value;
    let mse =
        pair.mean(|channel, pixel| Some(channel.difference(pixel).powi(2) - noise_of(channel, pixel)?))?;
    let values =
        pair.channels.iter().flat_map(|channel| pair.usable.iter().map(move |&pixel| (channel, pixel)));
    let unknown = values.filter(|&(channel, pixel)| noise_of(channel, pixel).is_none()).count();
    let rmse = (mse.value >= 0.0).then(|| mse.value.sqrt());
    let relmse = pair.floor().and_then(|floor| {
        pair.mean(|channel, pixel| {
            let square = channel.difference(pixel).powi(2) - noise_of(channel, pixel)?;
            Some(square / (channel.reference_value(pixel).powi(2) + floor * floor))
        })
    });
    let noise_error = noise_error(pair, noise_of);
    Some(Corrected {
        removed,
        noise,
        mse,
        noise_error,
        rmse,
        psnr_db: decibels(pair.peak(), mse.value),
        relmse,
        unknown,
    })
}

/// For d = b + e with e normal of variance v: Var d² = 4 b² v + 2 v², with b² estimated by d² − v.
fn noise_error(pair: &Pair, noise_of: NoiseOf) -> f64 {
    let (mut sum, mut values) = (0.0, 0);
    for &pixel in &pair.usable {
        let mut deviation = 0.0;
        for channel in &pair.channels {
            let Some(v) = noise_of(channel, pixel) else { continue };
            let square = (channel.difference(pixel).powi(2) - v).max(0.0);
            deviation += (4.0 * square * v + 2.0 * v * v).sqrt();
            values += 1;
        }
        sum += deviation * deviation;
    }
    sum.sqrt() / f64::from(values.max(1))
}

fn known(noise: Option<&[f64]>, pixel: usize) -> Option<f64> {
    noise.map(|noise| noise[pixel]).filter(|variance| !variance.is_nan())
}

/// Var(x − r) of one value. A picture without variance counts as exact; `None` where neither
/// picture has one or where a variance is unknown.
pub(super) fn variance_of_difference(channel: &PairChannel, pixel: usize) -> Option<f64> {
    let (image, reference) = (channel.image_noise.as_deref(), channel.reference_noise.as_deref());
    match (image, reference) {
        (None, None) => None,
        (Some(_), None) => known(image, pixel),
        (None, Some(_)) => known(reference, pixel),
        (Some(_), Some(_)) => Some(known(image, pixel)? + known(reference, pixel)?),
    }
}

pub(super) fn pixel_z(pair: &Pair) -> Option<PixelZ> {
    let (mut values, mut beyond) = (0_usize, 0_usize);
    for channel in &pair.channels {
        for &pixel in &pair.usable {
            let Some(variance) = variance_of_difference(channel, pixel) else { continue };
            let difference = channel.difference(pixel).abs();
            // Empty background, 0 in both and without noise, would only dilute the share.
            if variance > 0.0 || difference > 0.0 {
                values += 1;
                beyond += usize::from(difference > 1.96 * variance.sqrt());
            }
        }
    }
    (values > 0).then(|| PixelZ { values, beyond_1_96: beyond as f64 / values as f64 })
}
