//! Zhang and Ma's convection–diffusion model, one channel: direct light by upwind differences of first order, in explicit
//! steps and at rest, and scattered light by explicit diffusion.
//!
//! Positions are measured from the box's low corner. What is carried is the share of a light's own light that reaches a
//! cell; 1 comes in through the box's sides, and cells within two cells of a point light in the box keep the mean of what
//! reaches them. In the slab
//! of cells that a point lies in, its light does not travel across the slab.

use glam::DVec3;
use std::f64::consts::TAU;

/// Lines through a cell near a point light, per axis, and points on the way to it.
const NEAR: usize = 6;
const STEPS: usize = 16;

/// Squared distance, in cells, up to which cells keep the mean of a point light's light.
const HELD2: f64 = 4.001;

/// A light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// Parallel light: its unit direction of travel.
    Parallel(DVec3),
    /// A point: its position.
    Point(DVec3),
}

/// A box of cells, x fastest.
pub struct Convection {
    /// Cells per axis.
    pub dims: [usize; 3],
    /// Edges of a cell.
    pub cell: DVec3,
    /// Extinction per cell.
    pub extinction: Vec<f64>,
}

/// What a cell gets along an axis.
struct Inflow {
    /// |u| / h.
    rate: f64,
    /// The cell it comes from; `None` outside the box.
    from: Option<usize>,
}

impl Convection {
    /// A step of cΔt = `way`.
    pub fn step(&self, source: Source, shares: &[f64], way: f64) -> Vec<f64> {
        let next = |i: usize| {
            if self.is_held(source, i) {
                return shares[i];
            }
            let gains = self.inflows(source, i).into_iter();
            let gain: f64 =
                gains.map(|flow| flow.rate * (flow.from.map_or(1.0, |j| shares[j]) - shares[i])).sum();
            (shares[i] + way * gain) * (-self.extinction[i] * way).exp()
        };
        (0..self.extinction.len()).map(next).collect()
    }

    /// Darkness, but for what cells about a point light in the box keep.
    pub fn begin(&self, source: Source) -> Vec<f64> {
        (0..self.extinction.len()).map(|i| self.held_share(source, i).unwrap_or(0.0)).collect()
    }

    /// The share of a point light's light in the box that a cell about it keeps: the mean over the cell of e^−τ / r², over
    /// that of 1/r².
    pub fn held_share(&self, source: Source, i: usize) -> Option<f64> {
        self.held(source, i).map(|[left, all]| left / all)
    }

    /// The squared distance from which a point light has its mean over a cell that is held.
    pub fn held_distance2(&self, source: Source, i: usize) -> Option<f64> {
        self.held(source, i).map(|[_, all]| 1.0 / all)
    }

    /// Means over a cell that is held of e^−τ / r² and of 1/r².
    fn held(&self, source: Source, i: usize) -> Option<[f64; 2]> {
        let Source::Point(point) = source else { return None };
        if !self.is_held(source, i) {
            return None;
        }
        let own = self.sides(source, i) == [0; 3];
        let centre = self.centre(i);
        let sigma = self.extinction[i];
        let n = NEAR as f64;
        let mean_left = |depth: f64| if depth == 0.0 { 1.0 } else { -(-depth).exp_m1() / depth };
        let lines = NEAR * NEAR * NEAR * if own { 2 } else { 1 };
        let mut sums = [0.0; 2];
        for index in 0..lines {
            let [i, j, k] = [index / (NEAR * NEAR), index / NEAR % NEAR, index % NEAR].map(|x| x as f64);
            let [u, v, w] = [i, j, k].map(|x| (x + 0.5) / n);
            let direction = if own {
                let height = 1.0 - (i + (j + w) / n) / n;
                let angle = TAU * ((k + v) / n + i * 0.38196601);
                let radius = (1.0 - height * height).max(0.0).sqrt();
                DVec3::new(radius * angle.cos(), radius * angle.sin(), height)
            } else {
                (centre + self.cell * (DVec3::new(u, v, w) - 0.5) - point).normalize_or_zero()
            };
            let [first, last] = self.way_in_cell(point, direction, centre);
            let length = last - first;
            let weight = if own {
                2.0 * TAU * length / self.cell.element_product()
            } else {
                3.0 / (first * first + first * last + last * last).max(1e-30)
            };
            let left = mean_left(sigma * length) * (-self.depth(point, direction, first)).exp();
            sums[0] += weight * left / lines as f64;
            sums[1] += weight / lines as f64;
        }
        Some(sums)
    }

    fn way_in_cell(&self, from: DVec3, direction: DVec3, centre: DVec3) -> [f64; 2] {
        let (mut first, mut last) = (0.0_f64, f64::INFINITY);
        for axis in 0..3 {
            let inverse = 1.0 / if direction[axis].abs() < 1e-20 { 1e-20 } else { direction[axis] };
            let middle = (centre[axis] - from[axis]) * inverse;
            let reach = 0.5 * self.cell[axis] * inverse.abs();
            (first, last) = (first.max(middle - reach), last.min(middle + reach));
        }
        [first, first.max(last)]
    }

    fn depth(&self, from: DVec3, direction: DVec3, way: f64) -> f64 {
        let step = way / STEPS as f64;
        let sigma = |k: usize| {
            let place = (from + (k as f64 + 0.5) * step * direction) / self.cell;
            let at: [usize; 3] =
                std::array::from_fn(|axis| (place[axis].floor().max(0.0) as usize).min(self.dims[axis] - 1));
            self.extinction[at[0] + self.dims[0] * (at[1] + self.dims[1] * at[2])]
        };
        step * (0..STEPS).map(sigma).sum::<f64>()
    }

    /// The state at rest of the equation u·∇T + σT = 0, cell by cell from the light.
    pub fn steady(&self, source: Source) -> Vec<f64> {
        let mut order: Vec<usize> = (0..self.extinction.len()).collect();
        order.sort_by_key(|&i| self.distance(source, i));
        let mut shares = vec![f64::NAN; order.len()];
        for i in order {
            let flows = self.inflows(source, i);
            let arriving: f64 = flows
                .iter()
                .filter(|flow| flow.rate > 0.0)
                .map(|flow| flow.rate * flow.from.map_or(1.0, |j| shares[j]))
                .sum();
            let leaving: f64 = flows.iter().map(|flow| flow.rate).sum::<f64>() + self.extinction[i];
            shares[i] = self.held_share(source, i).unwrap_or(arriving / leaving);
        }
        shares
    }

    /// |u_x|/h_x + |u_y|/h_y + |u_z|/h_z in a cell: 1 over the longest step that is stable there.
    pub fn rate(&self, source: Source, i: usize) -> f64 {
        self.inflows(source, i).into_iter().map(|flow| flow.rate).sum()
    }

    /// Centre of a cell.
    pub fn centre(&self, i: usize) -> DVec3 {
        (DVec3::from_array(self.index(i).map(|k| k as f64)) + 0.5) * self.cell
    }

    /// Whether a cell keeps what a point light gives it.
    pub fn is_held(&self, source: Source, i: usize) -> bool {
        let Source::Point(point) = source else { return false };
        let size = self.cell * DVec3::from_array(self.dims.map(|n| n as f64));
        let inside = point.cmpge(DVec3::ZERO).all() && point.cmplt(size).all();
        inside && ((self.centre(i) - point) / self.cell).length_squared() <= HELD2
    }

    fn index(&self, i: usize) -> [usize; 3] {
        let [nx, ny, _] = self.dims;
        [i % nx, i / nx % ny, i / nx / ny]
    }

    /// Per axis: on which side of the light's slab of cells a cell lies, and how many cells away.
    fn sides(&self, source: Source, i: usize) -> [i64; 3] {
        let index = self.index(i);
        std::array::from_fn(|axis| {
            let (k, n) = (index[axis] as i64, self.dims[axis] as i64);
            let slab = match source {
                Source::Parallel(u) if u[axis] < 0.0 => n,
                Source::Parallel(_) => -1,
                Source::Point(p) => ((p / self.cell)[axis].floor() as i64).clamp(-1, n),
            };
            k - slab
        })
    }

    fn distance(&self, source: Source, i: usize) -> u64 {
        self.sides(source, i).map(i64::unsigned_abs).into_iter().sum()
    }

    fn inflows(&self, source: Source, i: usize) -> [Inflow; 3] {
        let (index, sides) = (self.index(i), self.sides(source, i));
        let across = DVec3::from_array(sides.map(|side| if side == 0 { 0.0 } else { 1.0 }));
        let direction = match source {
            Source::Parallel(u) => u,
            Source::Point(p) => ((self.centre(i) - p) * across).normalize_or_zero(),
        };
        let strides = [1, self.dims[0], self.dims[0] * self.dims[1]];
        std::array::from_fn(|axis| {
            let from = match sides[axis] > 0 {
                true => (index[axis] > 0).then(|| i - strides[axis]),
                false => (index[axis] + 1 < self.dims[axis]).then(|| i + strides[axis]),
            };
            Inflow { rate: direction[axis].abs() / self.cell[axis], from }
        })
    }
}

/// Light that spreads between neighbours of a box of cells, x fastest.
pub struct Spreading {
    /// Cells per axis.
    pub dims: [usize; 3],
    /// Factor of an axis.
    pub along: DVec3,
    /// Weight of a cell as a neighbour.
    pub weight: Vec<f64>,
}

impl Spreading {
    /// A step of all light, direct and scattered.
    pub fn step(&self, light: &[f64]) -> Vec<f64> {
        let [nx, ny, _] = self.dims;
        let strides = [1, nx, nx * ny];
        let next = |i: usize| {
            let mut sum = light[i];
            for (axis, stride) in strides.into_iter().enumerate() {
                let k = i / stride % self.dims[axis];
                let below = (k > 0).then(|| i - stride);
                let above = (k + 1 < self.dims[axis]).then(|| i + stride);
                for neighbour in [below, above] {
                    // Outside it is dark.
                    let (weight, there) =
                        neighbour.map_or((self.weight[i], 0.0), |j| (self.weight[j], light[j]));
                    sum += self.along[axis] * weight * (there - light[i]);
                }
            }
            sum
        };
        (0..light.len()).map(next).collect()
    }
}
