//! The field in bricks as the kernels compute it: gradients, rounding, and the values at points.
//!
//! Points are in grid coordinates as in `cl/volume/grid.cl`: voxel i is centred at i + PAD.

use super::grid::{BrickRanges, Grid, PAD, Voxel, with_voxels};
use crate::volume::Voxels;
use glam::DVec3;
use rayon::prelude::*;

/// Relative error of one float32 operation.
const ROUNDING: f64 = f32::EPSILON as f64 / 2.0;

/// Absolute error of `sample_raw` (`cl/volume/sampling.cl`) over voxels in low..=high.
///
/// Each of three nested a + f (b − a) adds at most half a unit in the last place of the difference (range R), of its
/// product and of the sum (magnitude A): 3 · 2^-24 · (2 R + A), and a little for rounding of rounding. Equal voxels
/// are interpolated exactly.
fn interpolation_error([low, high]: [f64; 2]) -> f64 {
    if low == high { 0.0 } else { 3.1 * ROUNDING * (2.0 * (high - low) + low.abs().max(high.abs())) }
}

/// The largest float32 number at most `x`.
pub(super) fn rounded_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x { nearest.next_down() } else { nearest }
}

/// The smallest float32 number at least `x`.
pub(super) fn rounded_up(x: f64) -> f32 {
    -rounded_down(-x)
}

/// Voxels copied out of the padded grid, as float32 values on the device.
struct Apron {
    values: Vec<f32>,
    origin: [usize; 3],
    size: [usize; 3],
}

impl Apron {
    fn at(&self, [x, y, z]: [usize; 3]) -> f32 {
        let [u, v, w] = [x - self.origin[0], y - self.origin[1], z - self.origin[2]];
        self.values[(w * self.size[1] + v) * self.size[0] + u]
    }

    fn range(&self) -> [f64; 2] {
        let join = |[a, b]: [f32; 2], &value: &f32| [a.min(value), b.max(value)];
        self.values.iter().fold([f32::INFINITY, f32::NEG_INFINITY], join).map(f64::from)
    }
}

impl Grid<'_> {
    /// The values that kernels interpolate between voxels in a brick's range, rounding included.
    ///
    /// Integers round towards 0 only: between a and b ≥ a ≥ 0, a + f (b − a) is at most a + (b − a), which is b when
    /// b is a whole number of up to 16 bits, since the difference is off by less than half a unit of b. So a
    /// brick up to the value at which a material starts stays free of it.
    pub(super) fn interpolated(&self, [low, high]: [f32; 2]) -> [f32; 2] {
        let [a, b] = [low, high].map(f64::from);
        let error = interpolation_error([a, b]);
        let whole = !matches!(self.volume.voxels, Voxels::F32(_));
        [
            if whole && b <= 0.0 { low } else { rounded_down(a - error) },
            if whole && a >= 0.0 { high } else { rounded_up(b + error) },
        ]
    }

    /// Least and largest magnitude, in each of the `bricks`, of the gradient (values on the device per local unit)
    /// that kernels compute by central differences, up to relative rounding.
    ///
    /// Central differences of one voxel on the trilinear field are the trilinear interpolation of the voxels' own
    /// central differences. So the gradient is a mean of those at voxels of the brick: no longer than the
    /// longest of them, and in the smallest box around them.
    pub fn brick_gradients(&self, bricks: &BrickRanges) -> Vec<[f32; 2]> {
        with_voxels!(self.volume, voxels => self.brick_gradients_typed(voxels, bricks))
    }

    fn brick_gradients_typed<T: Voxel>(&self, voxels: &[T], bricks: &BrickRanges) -> Vec<[f32; 2]> {
        let [nx, ny, _] = bricks.counts;
        (0..bricks.ranges.len())
            .into_par_iter()
            .map(|index| {
                self.gradient_range(voxels, [index % nx, index / nx % ny, index / (nx * ny)], bricks.shift)
            })
            .collect()
    }

    fn gradient_range<T: Voxel>(&self, voxels: &[T], brick: [usize; 3], shift: u32) -> [f32; 2] {
        let dims = self.volume.dims;
        // Voxels between which the field is interpolated: the outermost are copies of the border.
        let first = brick.map(|b| (b << shift).max(PAD - 1));
        let last: [usize; 3] = std::array::from_fn(|a| ((brick[a] + 1) << shift).min(dims[a] + PAD));
        let apron = self.apron(voxels, first.map(|i| i - 1), last.map(|i| i + 1));
        let range @ [low, high] = apron.range();
        if low == high {
            return [0.0; 2];
        }
        // Two samples and their difference; and a point plus 1 may round up, by half a unit of its coordinate,
        // which moves the sample by that part of a difference between neighbours.
        let scale = (1.0 / self.frame.spacing).to_array().map(|scale| f64::from(scale as f32));
        let error = |a: usize| {
            let moved = ROUNDING * (dims[a] + 2 * PAD + 1) as f64 * (high - low);
            0.5 * scale[a] * (2.0 * interpolation_error(range) + moved)
        };
        let error = (0..3).map(|a| error(a).powi(2)).sum::<f64>().sqrt();
        let (mut longest, mut box_low, mut box_high) = (0.0_f64, DVec3::INFINITY, DVec3::NEG_INFINITY);
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                for x in first[0]..=last[0] {
                    let difference = DVec3::new(
                        f64::from(apron.at([x + 1, y, z])) - f64::from(apron.at([x - 1, y, z])),
                        f64::from(apron.at([x, y + 1, z])) - f64::from(apron.at([x, y - 1, z])),
                        f64::from(apron.at([x, y, z + 1])) - f64::from(apron.at([x, y, z - 1])),
                    );
                    let gradient = 0.5 * difference * DVec3::from_array(scale);
                    longest = longest.max(gradient.length_squared());
                    box_low = box_low.min(gradient);
                    box_high = box_high.max(gradient);
                }
            }
        }
        let nearest = box_low.max(-box_high).max(DVec3::ZERO).length();
        // Kernels lose the squares of what is below 1e-19.
        [rounded_down((nearest - error - 1e-18).max(0.0)), rounded_up(longest.sqrt() + error)]
    }

    /// The voxels first..=last of the padded grid.
    fn apron<T: Voxel>(&self, voxels: &[T], first: [usize; 3], last: [usize; 3]) -> Apron {
        let [nx, ny, nz] = self.volume.dims;
        let inside = |i: usize, n: usize| i.saturating_sub(PAD).min(n - 1);
        let size: [usize; 3] = std::array::from_fn(|a| last[a] - first[a] + 1);
        let mut values = Vec::with_capacity(size.iter().product());
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                let row = (inside(z, nz) * ny + inside(y, ny)) * nx;
                let voxel = |x: usize| -> f32 { voxels[row + inside(x, nx)].on_device(&self.window).into() };
                values.extend((first[0]..=last[0]).map(voxel));
            }
        }
        Apron { values, origin: first, size }
    }

    /// The value on the device at a point of the box, in f64.
    pub(super) fn value_at(&self, point: DVec3) -> f64 {
        let low = point.floor();
        let first = low.to_array().map(|i| i as usize);
        let cell = with_voxels!(self.volume, voxels => self.apron(voxels, first, first.map(|i| i + 1)));
        let f = point - low;
        let between = |a: f64, b: f64, f: f64| a * (1.0 - f) + b * f;
        let row = |k: usize| between(f64::from(cell.values[k]), f64::from(cell.values[k + 1]), f.x);
        between(between(row(0), row(2), f.y), between(row(4), row(6), f.y), f.z)
    }

    /// The magnitude of the gradient at a point of the box, values on the device per local unit, in f64.
    pub(super) fn gradient_at(&self, point: DVec3) -> f64 {
        let along = |axis: DVec3| self.value_at(point + axis) - self.value_at(point - axis);
        let difference = DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z));
        (0.5 * difference / self.frame.spacing).length()
    }
}
