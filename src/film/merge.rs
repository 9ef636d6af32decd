//! Films of the same pixels added up: the moments of all samples together from the moments of groups of them.
//!
//! Chan, Golub and LeVeque (1979): with n = nₐ + n_b and δ = μ_b − μₐ, μ = μₐ + δ n_b / n and
//! M₂ = M₂ₐ + M₂_b + δ² nₐ n_b / n. In double-double arithmetic, which keeps some 100 bits, and rounded to 89 before the
//! film's floats are taken: in whatever order and groups films are added, their pixels come out the same.

use super::{Double, FilmPixel};
use crate::device_struct;
use bytemuck::Zeroable;

device_struct! {
    "no kernel has it",
    /// What the floats of a [`FilmPixel`] cannot hold of the sums of several films: float64, low and high halves of
    /// their bits.
    pub struct FilmRest {
        /// Of the mean.
        pub mean_low: [u32; 4],
        /// High half.
        pub mean_high: [u32; 4],
        /// Of the sum of squared deviations.
        pub m2_low: [u32; 4],
        /// High half.
        pub m2_high: [u32; 4],
        /// Of the depth.
        pub depth_low: u32,
        /// High half.
        pub depth_high: u32,
        /// Padding.
        pub pad_0: u32,
        /// Padding.
        pub pad_1: u32,
    }
}

/// A pixel of several films together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    mean: [Double; 4],
    m2: [Double; 4],
    depth: Double,
    hits: u32,
    count: u32,
    rejected: u32,
    lookups: u64,
}

impl Moments {
    /// Those of a film's pixel.
    pub fn of(pixel: &FilmPixel, rest: &FilmRest) -> Self {
        let sum = |high: f32, low: f32, rest: f64| Double::sum(high.into(), low.into()) + Double::from(rest);
        let mean =
            |c: usize| sum(pixel.mean[c], pixel.mean_low[c], joined(rest.mean_low[c], rest.mean_high[c]));
        let m2 = |c: usize| {
            let m2 = sum(pixel.m2[c], pixel.m2_low[c], joined(rest.m2_low[c], rest.m2_high[c]));
            // Beyond the largest float the pair is inf and NaN.
            if m2.value().is_finite() { m2 } else { f64::INFINITY.into() }
        };
        Self {
            mean: std::array::from_fn(mean),
            m2: std::array::from_fn(m2),
            depth: sum(pixel.depth, 0.0, joined(rest.depth_low, rest.depth_high)),
            hits: pixel.hits,
            count: pixel.count,
            rejected: pixel.rejected,
            lookups: pixel.lookups(),
        }
    }

    /// Samples.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Those of both together. The samples of both must not be more than 2³² − 1.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        let count = self.count.wrapping_add(other.count);
        let hits = self.hits.wrapping_add(other.hits);
        let mut all = Self {
            depth: weighted(self.depth, self.hits, other.depth, other.hits),
            hits,
            count,
            rejected: self.rejected.wrapping_add(other.rejected),
            lookups: self.lookups.wrapping_add(other.lookups),
            ..*self
        };
        for c in 0..4 {
            all.mean[c] = weighted(self.mean[c], self.count, other.mean[c], other.count);
            all.m2[c] = squares(self, other, c);
        }
        all
    }

    /// As the film keeps them, and what it cannot hold.
    pub fn pixel(&self) -> (FilmPixel, FilmRest) {
        let (mut pixel, mut rest) = (FilmPixel::zeroed(), FilmRest::zeroed());
        for c in 0..4 {
            let more;
            // Means may cancel, as far as deviations go.
            let scale = self.mean[c].value().abs() + self.m2[c].value().sqrt();
            (pixel.mean[c], pixel.mean_low[c], more) = pair(self.mean[c], scale);
            (rest.mean_low[c], rest.mean_high[c]) = halves(more);
            let more;
            (pixel.m2[c], pixel.m2_low[c], more) = pair(self.m2[c], self.m2[c].value());
            (rest.m2_low[c], rest.m2_high[c]) = halves(more);
        }
        let more;
        (pixel.depth, more) = single(self.depth, self.depth.value().abs());
        (rest.depth_low, rest.depth_high) = halves(more);
        (pixel.hits, pixel.count, pixel.rejected) = (self.hits, self.count, self.rejected);
        (pixel.lookups_low, pixel.lookups_high) = (self.lookups as u32, (self.lookups >> 32) as u32);
        (pixel, rest)
    }
}

/// The mean of two groups from theirs; that of one where the other is empty.
pub fn weighted(a: Double, count_a: u32, b: Double, count_b: u32) -> Double {
    match (count_a, count_b) {
        (_, 0) => a,
        (0, _) => b,
        _ => {
            let count = f64::from(count_a) + f64::from(count_b);
            a + ((b - a) * f64::from(count_b)).over(count)
        }
    }
}

/// The sum of squared deviations of two pixels together.
fn squares(a: &Moments, b: &Moments, c: usize) -> Double {
    match (a.count, b.count) {
        (_, 0) => return a.m2[c],
        (0, _) => return b.m2[c],
        _ => {}
    }
    let sum = a.m2[c] + b.m2[c];
    if !sum.value().is_finite() {
        return f64::INFINITY.into();
    }
    let apart = b.mean[c] - a.mean[c];
    let (count_a, count_b) = (f64::from(a.count), f64::from(b.count));
    sum + (apart * apart * count_a * count_b).over(count_a + count_b)
}

/// Rounded to a float, and what is left. `scale`: of [`Double::rounded`].
pub fn single(x: Double, scale: f64) -> (f32, f64) {
    let high = x.rounded(scale).value() as f32;
    if high.is_finite() { (high, (x - Double::from(f64::from(high))).value()) } else { (high, 0.0) }
}

/// Rounded to a float and what it cannot hold to another, and what is left.
fn pair(x: Double, scale: f64) -> (f32, f32, f64) {
    let rounded = x.rounded(scale);
    let high = rounded.value() as f32;
    if !high.is_finite() {
        return (high, 0.0, 0.0);
    }
    let low = (rounded - Double::from(f64::from(high))).value() as f32;
    (high, low, (x - Double::sum(high.into(), low.into())).value())
}

/// The halves of a float64's bits, low and high.
pub fn halves(x: f64) -> (u32, u32) {
    (x.to_bits() as u32, (x.to_bits() >> 32) as u32)
}

/// The float64 of these [`halves`].
pub fn joined(low: u32, high: u32) -> f64 {
    f64::from_bits(u64::from(high) << 32 | u64::from(low))
}

#[cfg(test)]
#[path = "merge_tests.rs"]
mod tests;
