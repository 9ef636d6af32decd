//! Bounds of the extinction per brick of cells, for null-collision tracking.
//!
//! In: ranges of the data ([`BrickRanges`], [`Grid::brick_gradients`]) and the transfer function. Out: per brick an
//! upper bound (majorant) and a lower bound (minorant) of sigma_t, per local unit, over every value that kernels
//! compute by `cl/volume/transfer.cl` in the closed cube of the brick: a point that rounding put beyond the brick must
//! be moved back to its planes, where only the brick's voxels have weight. Another transfer function needs other bounds,
//! not other ranges.

use super::bricks::{rounded_down, rounded_up};
use super::extrema::TableExtrema;
use super::grid::{BrickRanges, Grid, PAD};
use super::local::LocalFrame;
use super::medium::MediumTable;
use glam::DVec3;
use rayon::prelude::*;

/// Most bricks that one step reaches over.
const MOST_REACH: u8 = 127;

/// Relative error of what a kernel computes from entries no larger than the bound: 3 · 2^-24 for the difference,
/// product and sum of an interpolation, of which two are nested in a 2-D table, or of a [`MediumTable::linear_ramp`]
/// with its slope; one more for a factor per channel. 16 · 2^-24 leaves room.
const RELATIVE: f64 = 16.0 * (f32::EPSILON as f64 / 2.0);

/// Relative error of a kernel's row of the table, given the gradient's components: a dot product (3 · 2^-24), a
/// square root of 3 units in the last place, two factors.
const ROW: f64 = 16.0 * (f32::EPSILON as f64 / 2.0);

/// Points at which the mean extinction is estimated.
const SAMPLES: u32 = 1 << 16;

/// Bounds of the extinction in every brick, and what follows from them.
#[derive(Clone, Debug, PartialEq)]
pub struct Majorants {
    /// [majorant, minorant] per brick, per local unit, x fastest. Where there is no extinction −k instead of the
    /// majorant, 1 ≤ k ≤ 127: no brick of the (2k − 1)³ around this one has any, and nothing beyond the volume does.
    pub bounds: Vec<[f32; 2]>,
    /// Low and high planes, in grid coordinates, of the box around all bricks with extinction, where they hold cells;
    /// `None` without any.
    pub occupied: Option<([i32; 3], [i32; 3])>,
    /// The largest majorant.
    pub largest: f32,
    /// The extinction, when it is one number in the whole box.
    pub constant: Option<f64>,
    /// The transfer function's colour, when it is one wherever there is extinction.
    pub constant_color: Option<[f64; 3]>,
    /// What tracking through these bounds will cost.
    pub statistics: Statistics,
}

/// Means over the volume's box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// Share of the box in bricks without extinction.
    pub empty: f64,
    /// Mean majorant per local unit.
    pub majorant: f64,
    /// Mean minorant per local unit.
    pub minorant: f64,
    /// Mean extinction per local unit, estimated from 2^16 points.
    pub sigma: f64,
}

impl Statistics {
    /// Look-ups per unit of optical depth: 1 when the majorant is the extinction; infinite without extinction at any
    /// of the points.
    pub fn lookups(&self) -> f64 {
        self.majorant / self.sigma
    }
}

/// Values in entries and rows of the table.
type Rectangle = [[f64; 2]; 2];

impl Majorants {
    /// The bounds of a medium over `bricks`; `gradients`, which only 2-D functions read, are theirs
    /// ([`Grid::brick_gradients`]). Without them a 2-D function is bounded over all of its rows.
    pub fn new(
        grid: &Grid<'_>,
        bricks: &BrickRanges,
        gradients: Option<&[[f32; 2]]>,
        table: &MediumTable,
    ) -> Self {
        let extrema = TableExtrema::new(&table.sigmas(), table.size);
        let rows = |index: usize| match gradients {
            _ if table.rows == 1 => [0.0; 2],
            Some(gradients) => rows(grid, table, gradients[index]),
            None => [0.0, (table.rows - 1) as f64],
        };
        let rectangle = |index: usize| [values(grid, table, bricks.ranges[index]), rows(index)];
        let rectangles: Vec<Rectangle> = (0..bricks.ranges.len()).into_par_iter().map(rectangle).collect();
        let over =
            |&[values, rows]: &Rectangle| (extrema.over(values, rows), extrema.largest_read(values, rows));
        let exact: Vec<([f64; 2], f64)> = rectangles.par_iter().map(over).collect();

        let free: Vec<bool> = exact.iter().map(|([_, largest], _)| *largest == 0.0).collect();
        let reaches = bricks.reaches(MOST_REACH, &free);
        let bound = |(&(exact, read), &reach): (&([f64; 2], f64), &u8)| {
            if reach > 0 { [-f32::from(reach), 0.0] } else { widened(exact, read) }
        };
        let bounds: Vec<[f32; 2]> = exact.iter().zip(&reaches).map(bound).collect();

        let first = exact[0].0[0];
        let constant = exact.iter().all(|(bounds, _)| *bounds == [first; 2]).then_some(first);
        let all = rectangles[1..].iter().fold(rectangles[0], |all, rectangle| {
            std::array::from_fn(|k| [all[k][0].min(rectangle[k][0]), all[k][1].max(rectangle[k][1])])
        });
        let entries = |[a, b]: [f64; 2], count: usize| {
            [a.floor(), b.ceil()].map(|x| x.clamp(0.0, (count - 1) as f64) as usize)
        };
        Self {
            occupied: occupied(grid.volume.dims, bricks, &free),
            largest: bounds.iter().fold(0.0, |most, &[majorant, _]| most.max(majorant)),
            constant,
            constant_color: table.constant_color(entries(all[0], table.size), entries(all[1], table.rows)),
            statistics: statistics(grid, bricks, table, &bounds),
            bounds,
        }
    }

    /// Low and high corners, in local units, of boxes that hold all bricks with extinction: short runs along x, at most
    /// 32 in a row, since long ones would seem to cover much of a tilted view.
    pub(super) fn boxes(&self, bricks: &BrickRanges, local: &LocalFrame) -> Vec<[DVec3; 2]> {
        let corner = |planes: [usize; 3]| {
            let grid = DVec3::from_array(planes.map(|b| (b << bricks.shift) as f64)) - (PAD as f64 - 0.5);
            (grid * local.spacing).clamp(DVec3::ZERO, local.size())
        };
        let [nx, ny, _] = bricks.counts;
        let run = nx.div_ceil(32);
        let boxes_of_row = |(row, bounds): (usize, &[[f32; 2]])| -> Vec<[DVec3; 2]> {
            let (y, z) = (row % ny, row / ny);
            let box_of_run = |(k, bounds): (usize, &[[f32; 2]])| {
                let first = bounds.iter().position(|bound| bound[0] > 0.0)?;
                let last = bounds.iter().rposition(|bound| bound[0] > 0.0)?;
                let [low, high] = [first, last + 1].map(|x| k * run + x);
                Some([corner([low, y, z]), corner([high, y + 1, z + 1])])
            };
            bounds.chunks(run).enumerate().filter_map(box_of_run).collect()
        };
        self.bounds.par_chunks(nx).enumerate().flat_map_iter(boxes_of_row).collect()
    }

    /// The bounds times factors, which must be at least 0 and where they bound something, at least 1 and at most 1.
    pub fn scaled(&self, majorant: f64, minorant: f64) -> Vec<[f32; 2]> {
        let scaled = |&[a, b]: &[f32; 2]| {
            let a = if a > 0.0 { rounded_up(f64::from(a) * majorant).max(f32::MIN_POSITIVE) } else { a };
            [a, rounded_down(f64::from(b) * minorant)]
        };
        self.bounds.iter().map(scaled).collect()
    }
}

/// The values (in entries) that a kernel computes in a brick. Subtracting and scaling are monotone in float32 too.
fn values(grid: &Grid<'_>, table: &MediumTable, range: [f32; 2]) -> [f64; 2] {
    let [a, b] = grid.interpolated(range).map(|value| grid.kernel_value(value, table.intervals()));
    [a.min(b), a.max(b)]
}

/// The rows that a kernel computes in a brick from the gradient's magnitude.
fn rows(grid: &Grid<'_>, table: &MediumTable, [least, largest]: [f32; 2]) -> [f64; 2] {
    let scale = f64::from(grid.value_scale(table.intervals())).abs() * f64::from(table.gradient_scale);
    [f64::from(least) * scale * (1.0 - ROW), f64::from(largest) * scale * (1.0 + ROW)]
}

/// Exact bounds widened by what float32 may add to them. `read`: the largest entry that takes part. Where a rectangle
/// ends between entries it can be far larger than the bound, and differences and products of that size are rounded:
/// 2 · 2^-24 for each of two nested interpolations. Where nothing but zeros has weight, the kernels' result is 0.
fn widened([least, largest]: [f64; 2], read: f64) -> [f32; 2] {
    let error = 4.0 * (f32::EPSILON as f64 / 2.0) * read;
    let majorant = rounded_up((largest + error) * (1.0 + RELATIVE)).max(f32::MIN_POSITIVE);
    let minorant = rounded_down(((least - error) * (1.0 - RELATIVE)).max(0.0));
    // Devices may flush what is smaller to 0.
    [majorant, if minorant < f32::MIN_POSITIVE { 0.0 } else { minorant }]
}

/// Numbers of a brick along the axes.
fn brick(bricks: &BrickRanges, index: usize) -> [usize; 3] {
    let [nx, ny, _] = bricks.counts;
    [index % nx, index / nx % ny, index / (nx * ny)]
}

fn occupied(dims: [usize; 3], bricks: &BrickRanges, free: &[bool]) -> Option<([i32; 3], [i32; 3])> {
    let occupied = (0..free.len()).filter(|&index| !free[index]).map(|index| brick(bricks, index));
    let corners = occupied.fold(None, |corners: Option<([usize; 3], [usize; 3])>, here| {
        let (low, high) = corners.unwrap_or((here, here));
        let join =
            |f: fn(usize, usize) -> usize, with: [usize; 3]| std::array::from_fn(|a| f(with[a], here[a]));
        Some((join(usize::min, low), join(usize::max, high)))
    });
    corners.map(|(low, high)| {
        let low = low.map(|b| (b << bricks.shift).max(PAD - 1) as i32);
        let high = std::array::from_fn(|a| ((high[a] + 1) << bricks.shift).min(dims[a] + PAD) as i32);
        (low, high)
    })
}

fn statistics(grid: &Grid<'_>, bricks: &BrickRanges, table: &MediumTable, bounds: &[[f32; 2]]) -> Statistics {
    let dims = DVec3::from_array(grid.volume.dims.map(|n| n as f64));
    let low = DVec3::splat(PAD as f64 - 0.5);
    let side = f64::from(1 << bricks.shift);
    let share = |index: usize| {
        let start = DVec3::from_array(brick(bricks, index).map(|b| b as f64)) * side;
        let inside = (start + side).min(low + dims) - start.max(low);
        (inside.max(DVec3::ZERO) / dims).element_product()
    };
    let mut statistics = Statistics { empty: 0.0, majorant: 0.0, minorant: 0.0, sigma: 0.0 };
    for (index, &[majorant, minorant]) in bounds.iter().enumerate() {
        let share = share(index);
        if majorant < 0.0 {
            statistics.empty += share;
        } else {
            statistics.majorant += share * f64::from(majorant);
            statistics.minorant += share * f64::from(minorant);
        }
    }
    let sigma = |k: u32| {
        let point = low + low_discrepancy(k) * dims;
        let [x, y, z] = (point / side).floor().to_array().map(|b| b as usize);
        let index = (z * bricks.counts[1] + y) * bricks.counts[0] + x;
        if bounds[index][0] < 0.0 { 0.0 } else { sigma_at(grid, table, point) }
    };
    // In blocks of a fixed size, so that the sum does not depend on the number of threads.
    let block = |block: u32| (block << 10..(block + 1) << 10).map(sigma).sum::<f64>();
    let sums: Vec<f64> = (0..SAMPLES >> 10).into_par_iter().map(block).collect();
    statistics.sigma = sums.iter().sum::<f64>() / f64::from(SAMPLES);
    statistics
}

/// The extinction (per local unit) at 2^16 points that are spread evenly over the box.
pub(super) fn sampled(grid: &Grid<'_>, table: &MediumTable) -> Vec<f64> {
    let dims = DVec3::from_array(grid.volume.dims.map(|n| n as f64));
    let low = DVec3::splat(PAD as f64 - 0.5);
    (0..SAMPLES).into_par_iter().map(|k| sigma_at(grid, table, low + low_discrepancy(k) * dims)).collect()
}

/// Points in the unit cube: multiples of the inverse powers of the real root of x⁴ = x + 1, modulo 1 (Roberts 2018).
fn low_discrepancy(k: u32) -> DVec3 {
    const ROOT: f64 = 1.220_744_084_605_759_5;
    let step = DVec3::new(1.0 / ROOT, 1.0 / (ROOT * ROOT), 1.0 / (ROOT * ROOT * ROOT));
    (0.5 + f64::from(k) * step).fract()
}

fn sigma_at(grid: &Grid<'_>, table: &MediumTable, point: DVec3) -> f64 {
    let window = grid.device_window();
    let value = window.value(grid.value_at(point)) * table.intervals();
    if table.rows == 1 {
        return table.sigma(value, 0.0);
    }
    let magnitude = grid.gradient_at(point) / (window.one - window.zero).abs() * table.intervals();
    table.sigma(value, magnitude * f64::from(table.gradient_scale))
}

#[cfg(test)]
#[path = "majorants_tests.rs"]
pub(super) mod tests;
