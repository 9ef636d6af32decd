//! Statistics over repeats: medians, and intervals of what is computed from mean squared errors.
//!
//! The squared errors of a picture are summed in blocks. Between repeats, which have random numbers of their own, the
//! sum of a block differs by noise alone, and blocks are independent of each other. So the variance of anything that
//! is linear in the sums is the sum over blocks of the variance between repeats; what is not linear (a slope, a root)
//! is linearised. With B blocks and R repeats that has up to B (R − 1) degrees of freedom (Welch–Satterthwaite).

use super::results::{Interval, Spread};
use crate::metrics::student_t_975;

/// The median and the quartiles (linear interpolation between order statistics); `None` of nothing.
pub fn spread(values: impl IntoIterator<Item = f64>) -> Option<Spread> {
    let mut sorted: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    let quantile = |share: f64| {
        let position = share * last as f64;
        let (below, part) = (position.floor() as usize, position.fract());
        sorted[below] + part * (sorted[(below + 1).min(last)] - sorted[below])
    };
    Some(Spread { median: quantile(0.5), low: quantile(0.25), high: quantile(0.75), count: sorted.len() })
}

/// A variance and its degrees of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variance {
    /// The variance of an estimate.
    pub value: f64,
    /// Degrees of freedom of its own estimate.
    pub degrees: f64,
}

impl Variance {
    /// Of the sum of independent estimates (Welch–Satterthwaite).
    pub fn sum(parts: impl IntoIterator<Item = Self>) -> Self {
        let (mut value, mut spread) = (0.0, 0.0);
        for part in parts {
            value += part.value;
            spread += part.value * part.value / part.degrees;
        }
        Self { value, degrees: if spread > 0.0 { value * value / spread } else { f64::INFINITY } }
    }

    /// Of the mean of values; `None` with fewer than two.
    pub fn of_mean(values: &[f64]) -> Option<Self> {
        let degrees = values.len().checked_sub(1).filter(|&degrees| degrees > 0)? as f64;
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        Some(Self { value: squares / degrees / count, degrees })
    }

    /// The standard error.
    pub fn error(self) -> f64 {
        self.value.sqrt()
    }

    /// Half of the two-sided 95 % interval.
    pub fn half_width(self) -> f64 {
        // Rounded down: rather too wide than too narrow.
        student_t_975((self.degrees.min(1e6) as usize).max(1)) * self.error()
    }

    /// The interval around `value`.
    pub fn around(self, value: f64) -> Interval {
        let half = self.half_width();
        Interval { value, low: Some(value - half), high: Some(value + half) }
    }
}

/// Squared errors summed in blocks: `[repeat][checkpoint][block]`, all of one shape.
pub struct ErrorBlocks<'a> {
    repeats: Vec<&'a [Vec<f64>]>,
    values: f64,
}

impl<'a> ErrorBlocks<'a> {
    /// Of pictures with `values` compared values (pixels × channels) each; `None` unless the shapes are equal.
    pub fn new(repeats: Vec<&'a [Vec<f64>]>, values: f64) -> Option<Self> {
        let shape = |repeat: &[Vec<f64>]| repeat.iter().map(Vec::len).collect::<Vec<_>>();
        let first = shape(repeats.first()?);
        let equal = first.iter().all(|&blocks| blocks == first[0] && blocks > 0);
        (equal && repeats.iter().all(|repeat| shape(repeat) == first)).then_some(Self { repeats, values })
    }

    /// The mean squared error at a checkpoint, over all repeats.
    pub fn mse(&self, checkpoint: usize) -> f64 {
        let sum: f64 = self.repeats.iter().flat_map(|repeat| &repeat[checkpoint]).sum();
        sum / self.values / self.repeats.len() as f64
    }

    /// The variance of Σ_k weights\[k\] · `mse(k)`.
    ///
    /// With one repeat it is that between blocks, which holds how the error varies over the picture too: too large for
    /// a mean squared error, right for a slope, whose mean is the same in every block.
    pub fn variance(&self, weights: &[f64]) -> Option<Variance> {
        let blocks = self.repeats[0].first()?.len();
        let part = |repeat: &[Vec<f64>], block: usize| {
            weights.iter().zip(repeat).map(|(weight, sums)| weight * sums[block]).sum::<f64>() / self.values
        };
        if self.repeats.len() == 1 {
            let parts: Vec<f64> = (0..blocks).map(|block| part(self.repeats[0], block)).collect();
            let of_mean = Variance::of_mean(&parts)?;
            return Some(Variance { value: of_mean.value * (blocks * blocks) as f64, ..of_mean });
        }
        let of_block = |block: usize| {
            Variance::of_mean(&self.repeats.iter().map(|repeat| part(repeat, block)).collect::<Vec<_>>())
        };
        Some(Variance::sum((0..blocks).filter_map(of_block)))
    }
}

/// The exponent of √MSE against samples by least squares on logarithms, with its variance: `(samples, MSE)` of at least
/// three checkpoints, where `noise` was taken out of the blocks' MSE.
pub fn slope(samples: &[f64], blocks: &ErrorBlocks<'_>, noise: f64) -> Option<(f64, Variance)> {
    let mse: Vec<f64> = (0..samples.len()).map(|k| blocks.mse(k) - noise).collect();
    let used: Vec<usize> = (0..samples.len()).filter(|&k| mse[k] > 0.0 && samples[k] > 0.0).collect();
    if used.len() < 3 {
        return None;
    }
    let x = |k: usize| samples[k].ln();
    let mean = used.iter().map(|&k| x(k)).sum::<f64>() / used.len() as f64;
    let squares: f64 = used.iter().map(|&k| (x(k) - mean).powi(2)).sum();
    if squares <= 0.0 {
        return None;
    }
    // d ln √MSE = d MSE / (2 MSE)
    let weight = |k: usize| (x(k) - mean) / squares;
    let value = used.iter().map(|&k| weight(k) * 0.5 * mse[k].ln()).sum();
    let influence: Vec<f64> = (0..samples.len())
        .map(|k| if used.contains(&k) { weight(k) / (2.0 * mse[k]) } else { 0.0 })
        .collect();
    Some((value, blocks.variance(&influence)?))
}
