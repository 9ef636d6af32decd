//! The comparison of a picture with a reference.

use serde::Serialize;

use super::{
    blocks::Estimate,
    corrected::{Corrected, PixelZ, corrections, pixel_z, variance_of_difference},
    pair::{Pair, PairChannel, decibels},
};
use crate::{
    error::Result,
    picture::{Picture, srgb_encode},
};

/// How far a picture is from its reference. Errors are in the units of the pictures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `["R", "G", "B"]`, or `["Y"]` where both are grey.
    pub channels: Vec<&'static str>,
    /// Pixels that were compared: finite in both.
    pub pixels: usize,
    /// Pixels that were left out.
    pub non_finite: NonFinite,
    /// Mean squared error, of both pictures' noise too.
    pub mse: Estimate,
    /// √MSE.
    pub rmse: f64,
    /// Peak signal-to-noise ratios.
    pub psnr: Psnr,
    /// Relative squared error; `None` for a black reference.
    pub relmse: Option<Estimate>,
    /// Mean absolute relative error (1 = 100 %); `None` for a black reference.
    pub mape: Option<Estimate>,
    /// Mean signed error.
    pub bias: Bias,
    /// The error with known noise taken out; empty where neither picture carries its variance.
    pub corrected: Vec<Corrected>,
    /// How often the difference exceeds its noise; `None` where neither carries its variance.
    pub pixel_z: Option<PixelZ>,
}

/// Pixels with a value that is NaN or infinite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct NonFinite {
    /// In the image.
    pub image: usize,
    /// In the reference.
    pub reference: usize,
}

/// Peak signal-to-noise ratios in dB; `None` where undefined: for equal pictures (infinite) and,
/// for `linear_db`, where the peak is not positive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Psnr {
    /// P of `linear_db`: the largest value of the reference.
    pub peak: f64,
    /// On linear values, with P = `peak`.
    pub linear_db: Option<f64>,
    /// On sRGB codes of the values clamped to [0, 1], with P = 1.
    pub display_db: Option<f64>,
}

/// The mean signed error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bias {
    /// Mean (x − r) over all channels.
    pub mean: f64,
    /// Mean of the reference.
    pub reference_mean: f64,
    /// `mean` over `reference_mean`; `None` where that is 0.
    pub relative: Option<f64>,
    /// Standard error of `mean` from the noise of both pictures, an upper bound: the channels of
    /// a pixel share their paths and are taken as fully correlated. A picture without variance
    /// counts as exact. `None` where neither has one, or a pixel's is unknown.
    pub standard_error: Option<f64>,
    /// `mean` / `standard_error`.
    pub z: Option<f64>,
    /// Each channel by itself.
    pub channels: Vec<ChannelBias>,
}

/// The mean signed error of one channel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelBias {
    /// `R`, `G`, `B` or `Y`.
    pub name: &'static str,
    /// Mean (x − r).
    pub mean: f64,
    /// Its standard error, for pixels independent of each other.
    pub standard_error: Option<f64>,
}

/// Compares the colour (`R G B`, or `Y`) of two linear pictures of one size.
///
/// Pixels that are not finite in either picture are left out and counted. The metrics are defined
/// in the [module](super); ε of relMSE and MAPE uses mean |r|, which is mean r for radiance.
///
/// # Errors
/// [`crate::Error::Input`] where the sizes differ, a picture has no colour, or no pixel is finite.
pub fn compare(image: &Picture, reference: &Picture) -> Result<Comparison> {
    let pair = Pair::new(image, reference)?;
    let mse = pair.mean_of_all(|channel, pixel| channel.difference(pixel).powi(2));
    Ok(Comparison {
        width: pair.width,
        height: pair.height,
        channels: pair.channels.iter().map(|channel| channel.name).collect(),
        pixels: pair.usable.len(),
        non_finite: NonFinite { image: pair.bad_image, reference: pair.bad_reference },
        mse,
        rmse: mse.value.sqrt(),
        psnr: psnr(&pair, mse.value),
        relmse: relmse(&pair),
        mape: mape(&pair),
        bias: bias(&pair),
        corrected: corrections(&pair),
        pixel_z: pixel_z(&pair),
    })
}

/// The squared differences, summed over the channels and pixels of each block of the picture, for statistics over
/// several pictures against one reference.
///
/// # Errors
/// As [`compare`].
pub fn squared_error_blocks(image: &Picture, reference: &Picture) -> Result<Vec<f64>> {
    Ok(Pair::new(image, reference)?.block_sums(|channel, pixel| channel.difference(pixel).powi(2)))
}

fn psnr(pair: &Pair, mse: f64) -> Psnr {
    let peak = pair.peak();
    let code = |value: f32| srgb_encode(f64::from(value).clamp(0.0, 1.0));
    let display_mse =
        pair.mean_of_all(|channel, p| (code(channel.image[p]) - code(channel.reference[p])).powi(2)).value;
    Psnr { peak, linear_db: decibels(peak, mse), display_db: decibels(1.0, display_mse) }
}

fn relmse(pair: &Pair) -> Option<Estimate> {
    let epsilon = pair.floor()?.powi(2);
    Some(pair.mean_of_all(|channel, pixel| {
        channel.difference(pixel).powi(2) / (channel.reference_value(pixel).powi(2) + epsilon)
    }))
}

fn mape(pair: &Pair) -> Option<Estimate> {
    let floor = pair.floor()?;
    Some(pair.mean_of_all(|channel, pixel| {
        channel.difference(pixel).abs() / (channel.reference_value(pixel).abs() + floor)
    }))
}

fn bias(pair: &Pair) -> Bias {
    let mean = pair.mean_of_all(|channel, pixel| channel.difference(pixel)).value;
    let reference = pair.mean_of_all(|channel, pixel| channel.reference_value(pixel)).value;
    let standard_error = bias_error(pair);
    Bias {
        mean,
        reference_mean: reference,
        relative: (reference != 0.0).then(|| mean / reference),
        standard_error,
        z: standard_error.filter(|&error| error > 0.0).map(|error| mean / error),
        channels: pair.channels.iter().map(|channel| channel_bias(pair, channel)).collect(),
    }
}

/// √(Σ_pixels (Σ_channels σ)²) / M.
fn bias_error(pair: &Pair) -> Option<f64> {
    let mut sum = 0.0;
    for &pixel in &pair.usable {
        let mut sigma = 0.0;
        for channel in &pair.channels {
            sigma += variance_of_difference(channel, pixel)?.sqrt();
        }
        sum += sigma * sigma;
    }
    Some(sum.sqrt() / (pair.usable.len() * pair.channels.len()) as f64)
}

fn channel_bias(pair: &Pair, channel: &PairChannel) -> ChannelBias {
    let count = pair.usable.len() as f64;
    let mean = pair.usable.iter().map(|&pixel| channel.difference(pixel)).sum::<f64>() / count;
    let variance: Option<f64> = pair.usable.iter().map(|&pixel| variance_of_difference(channel, pixel)).sum();
    ChannelBias { name: channel.name, mean, standard_error: variance.map(|sum| sum.sqrt() / count) }
}

#[cfg(test)]
#[path = "compare_tests.rs"]
mod tests;
