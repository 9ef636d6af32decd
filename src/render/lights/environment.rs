//! The table by which kernels draw directions from an environment map; see `cl/lights/environment.cl`.

use crate::picture::Environment;
use rayon::prelude::*;
use std::f64::consts::PI;

/// One unit of probability: random numbers on the device are multiples of it.
const UNITS: f64 = 16_777_216.0;

/// Beyond this many possible outcomes, the rarest of them may get no unit.
const MOST_OUTCOMES: usize = 1 << 22;

/// Sums of probabilities in proportion to `weights` (≥ 0, not all 0), up to and including each entry.
///
/// All are multiples of 2⁻²⁴, exact in float32, and so are the device's random numbers: what is drawn has the very
/// probability that its density assumes. What can happen gets at least 2⁻²⁴.
pub(super) fn probability_sums(weights: &[f64]) -> Vec<f32> {
    let total: f64 = weights.iter().sum();
    let possible = weights.iter().filter(|&&weight| weight > 0.0).count();
    let reserved = if possible <= MOST_OUTCOMES { 1.0 } else { 0.0 };
    let free = UNITS - reserved * possible as f64;
    let (mut sum, mut given) = (0.0, 0.0);
    let up_to = |&weight: &f64| {
        sum += weight;
        given += if weight > 0.0 { reserved } else { 0.0 };
        ((given + (free * (sum / total)).round()) / UNITS) as f32
    };
    weights.iter().map(up_to).collect()
}

/// Brightness by which lights and texels are drawn: 0 only where every channel is.
pub(super) fn mean(rgb: [f64; 3]) -> f64 {
    (rgb[0] + rgb[1] + rgb[2]) / 3.0
}

/// Radiance of a map, for choosing how to sample it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Brightness {
    /// Mean over the sphere.
    pub mean: f64,
    /// The brightest texel.
    pub largest: f64,
}

/// How bright the map is, without its factor.
pub(super) fn brightness(map: &Environment) -> Brightness {
    let rows = map.rgb.par_chunks(map.width).enumerate().map(|(y, row)| {
        let (sum, largest) = row.iter().fold((0.0, 0.0), |(sum, largest), texel| {
            let value = mean(texel.map(f64::from));
            (sum + value, f64::max(largest, value))
        });
        (sum / map.width as f64 * band(y, map.height), largest)
    });
    let rows: Vec<(f64, f64)> = rows.collect();
    Brightness {
        mean: rows.iter().map(|row| row.0).sum(),
        largest: rows.iter().map(|row| row.1).fold(0.0, f64::max),
    }
}

/// The part of the sphere that a row of texels covers.
fn band(row: usize, rows: usize) -> f64 {
    (PI * (row as f64 + 0.5) / rows as f64).sin() * (0.5 * PI / rows as f64).sin()
}

/// The table for a map that is not black: sums over rows, then in each row over its texels.
///
/// A texel weighs the mean of what kernels see in it, which is bilinear between texel centres: per axis 1/8, 3/4, 1/8
/// of the texel and its neighbours. So none is impossible from which light comes.
pub(super) fn table(map: &Environment) -> Vec<f32> {
    let (width, height) = (map.width, map.height);
    let mut sums = vec![0.0_f32; height + width * height];
    let (by_row, in_rows) = sums.split_at_mut(height);
    let row_weights = in_rows.par_chunks_mut(width).enumerate().map(|(y, out)| {
        let weights = texel_weights(map, y);
        if weights.iter().any(|&weight| weight > 0.0) {
            out.copy_from_slice(&probability_sums(&weights));
        }
        weights.iter().sum::<f64>() * band(y, height)
    });
    let row_weights: Vec<f64> = row_weights.collect();
    by_row.copy_from_slice(&probability_sums(&row_weights));
    sums
}

/// Mean of the interpolated brightness over each texel of a row.
fn texel_weights(map: &Environment, y: usize) -> Vec<f64> {
    let width = map.width;
    let value = |x: usize, y: usize| mean(map.rgb[y * width + x].map(f64::from));
    let (above, below) = (y.saturating_sub(1), (y + 1).min(map.height - 1));
    let blend = |before: f64, here: f64, after: f64| 0.125 * (before + after) + 0.75 * here;
    let column: Vec<f64> = (0..width).map(|x| blend(value(x, above), value(x, y), value(x, below))).collect();
    (0..width).map(|x| blend(column[(x + width - 1) % width], column[x], column[(x + 1) % width])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn sums_rise_to_one_and_share_as_told(
            weights in prop::collection::vec(prop_oneof![Just(0.0), 1e-30..1.0_f64, 1.0..1e6_f64], 1..60)
        ) {
            let total: f64 = weights.iter().sum();
            prop_assume!(total > 0.0);
            let sums = probability_sums(&weights);
            prop_assert_eq!(*sums.last().unwrap(), 1.0);
            let mut before = 0.0;
            for (&weight, &sum) in weights.iter().zip(&sums) {
                let share = f64::from(sum - before);
                prop_assert_eq!((share * UNITS).fract(), 0.0);
                prop_assert_eq!(share > 0.0, weight > 0.0);
                // Each possible entry takes a unit from all; each end of the interval is rounded by half a unit.
                let bound = (weights.len() as f64 + 1.0) / UNITS;
                prop_assert!((share - weight / total).abs() <= bound, "{share} {}", weight / total);
                before = sum;
            }
        }
    }
}
