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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::test_pictures::Normal;

    #[test]
    fn medians_and_quartiles_interpolate() {
        // Hyndman & Fan (1996), type 7: of 1, 2, 3, 4 these are 1.75, 2.5 and 3.25.
        let found = spread([4.0, 1.0, 3.0, f64::NAN, 2.0]).unwrap();
        assert_eq!((found.low, found.median, found.high, found.count), (1.75, 2.5, 3.25, 4));
        let one = spread([7.0]).unwrap();
        assert_eq!((one.low, one.median, one.high), (7.0, 7.0, 7.0));
        assert_eq!(spread([]), None);
    }

    #[test]
    fn independent_variances_add_up_with_their_degrees_of_freedom() {
        let mean = Variance::of_mean(&[1.0, 2.0, 6.0]).unwrap();
        // s² = 7, over 3.
        assert!((mean.value - 7.0 / 3.0).abs() < 1e-15 && mean.degrees == 2.0);
        assert_eq!(Variance::of_mean(&[1.0]), None);
        // Ten equal ones of two degrees have twenty together.
        let sum = Variance::sum([Variance { value: 0.5, degrees: 2.0 }; 10]);
        assert!((sum.value - 5.0).abs() < 1e-12 && (sum.degrees - 20.0).abs() < 1e-9);
        // t₂₀ = 2.086 (NIST/SEMATECH e-Handbook, table 1.3.6.7.2).
        assert!((sum.half_width() - 2.086 * 5.0_f64.sqrt()).abs() < 1e-3);
    }

    const SAMPLES: [f64; 4] = [1.0, 4.0, 16.0, 64.0];
    const BLOCKS: usize = 16;
    const PIXELS: usize = 64;

    /// Squared errors of running means of normal noise whose strength grows from block to block, with a constant bias.
    fn repeat(normal: &mut Normal, bias: f64) -> Vec<Vec<f64>> {
        let mut sums = vec![vec![0.0; BLOCKS]; SAMPLES.len()];
        for strength in 1..=BLOCKS {
            for _ in 0..PIXELS {
                let (mut sum, mut count) = (0.0, 0.0);
                for (checkpoint, &samples) in SAMPLES.iter().enumerate() {
                    // The sum of so many draws is normal, too.
                    sum += (samples - count).sqrt() * strength as f64 * normal.next();
                    count = samples;
                    sums[checkpoint][strength - 1] += (sum / count + bias).powi(2);
                }
            }
        }
        sums
    }

    fn slopes(repeats: usize, bias: f64, normal: &mut Normal) -> Interval {
        let all: Vec<_> = (0..repeats).map(|_| repeat(normal, bias)).collect();
        let blocks =
            ErrorBlocks::new(all.iter().map(Vec::as_slice).collect(), (BLOCKS * PIXELS) as f64).unwrap();
        let (value, variance) = slope(&SAMPLES, &blocks, 0.0).unwrap();
        variance.around(value)
    }

    /// 200 trials of a 95 % interval: σ = 1.54 %, 4σ.
    #[test]
    fn the_interval_of_a_slope_covers_one_half() {
        let mut normal = Normal::new(3);
        for repeats in [1, 3] {
            let holds = |slope: Interval| slope.low.unwrap() <= -0.5 && -0.5 <= slope.high.unwrap();
            let covered = (0..200).filter(|_| holds(slopes(repeats, 0.0, &mut normal))).count();
            let share = covered as f64 / 200.0;
            assert!((share - 0.95).abs() < 4.0 * 0.0154, "{repeats}: {share}");
        }
    }

    #[test]
    fn a_bias_makes_the_slope_flat() {
        // RMS of the noise at 64 samples: √(mean of 1² … 16²)/8 = 1.2.
        let slope = slopes(3, 2.4, &mut Normal::new(4));
        assert!(slope.low.unwrap() > -0.45, "{slope:?}");
    }

    #[test]
    fn a_slope_needs_three_errors_above_the_noise() {
        let mut normal = Normal::new(5);
        let sums = repeat(&mut normal, 0.0);
        let blocks = ErrorBlocks::new(vec![&sums], (BLOCKS * PIXELS) as f64).unwrap();
        assert!(slope(&SAMPLES, &blocks, blocks.mse(2)).is_none());
        assert!(slope(&[4.0; 4], &blocks, 0.0).is_none());
        assert!(ErrorBlocks::new(vec![&sums, &sums[1..]], 1.0).is_none());
    }
}
