//! Zhang and Ma's convection–diffusion model, one channel: direct light by upwind differences of first order, in explicit
//! steps and at rest, and scattered light by explicit diffusion.
//!
//! Positions are measured from the box's low corner. What is carried is the share of a light's own light that reaches a
//! cell; 1 comes in through the box's sides, and cells within two cells of a point light in the box keep 1. In the slab
//! of cells that a point lies in, its light does not travel across the slab.

use glam::DVec3;

/// Squared distance, in cells, up to which cells keep a point light's own value.
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
                return 1.0;
            }
            let gains = self.inflows(source, i).into_iter();
            let gain: f64 =
                gains.map(|flow| flow.rate * (flow.from.map_or(1.0, |j| shares[j]) - shares[i])).sum();
            (shares[i] + way * gain) * (-self.extinction[i] * way).exp()
        };
        (0..self.extinction.len()).map(next).collect()
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
            shares[i] = if self.is_held(source, i) { 1.0 } else { arriving / leaving };
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

    /// Whether a cell keeps a point light's own value.
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
