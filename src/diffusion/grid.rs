//! The levels of the solver: how their cells are stored and how a coarser level joins them.

use crate::device_struct;
use glam::DVec3;

device_struct! {
    "types/diffusion.cl",
    /// The grid of one level; see `cl/types/diffusion.cl`.
    pub struct DeviceDiffusionGrid {
        /// Conductance of a face per diffusivity, per axis.
        pub face: [f32; 4],
        /// Half a cell's resistance to the boundary per 1 / diffusivity, per axis; largest diffusivity.
        pub open: [f32; 4],
        /// Resistance of the boundary itself, per axis; negative where nothing leaves.
        pub outside: [f32; 4],
        /// Coarse faces over the sum of the fine ones, per axis.
        pub narrower: [f32; 4],
        /// The same for the last face of the axis.
        pub last: [f32; 4],
        /// Cells along x.
        pub nx: u32,
        /// Cells along y.
        pub ny: u32,
        /// Cells along z.
        pub nz: u32,
        /// Distance of neighbours along y.
        pub row: u32,
        /// Distance of neighbours along z.
        pub slice: u32,
        /// Elements per colour.
        pub half_count: u32,
        /// Zeros before and after each colour.
        pub guard: u32,
        /// Axes along which the next level joins two cells: bits 0, 1, 2.
        pub halved: u32,
    }
}

/// Cells of a level that is solved exactly.
const COARSEST: usize = 216;
/// Along axes whose cells are longer than this times the shortest ones, cells are not joined: they are weakly coupled.
const WEAK: f64 = 1.5;
/// Elements of a colour come in multiples of this.
const ALIGNMENT: usize = 16;

/// One level: a box of cells that all have one size, except for the last one along an axis, which may be shorter.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Grid {
    pub dims: [usize; 3],
    /// Axes along which the next coarser level joins two cells.
    pub halved: [bool; 3],
    /// Length of the cells and of the last cell, per axis.
    length: [[f64; 2]; 3],
}

impl Grid {
    /// All levels, finest first.
    pub fn hierarchy(dims: [usize; 3], spacing: DVec3) -> Vec<Self> {
        let mut levels = vec![Self::new(dims, spacing.to_array().map(|h| [h, h]))];
        while let Some(coarser) = levels[levels.len() - 1].coarser() {
            levels.push(coarser);
        }
        levels
    }

    fn new(dims: [usize; 3], length: [[f64; 2]; 3]) -> Self {
        let long = |axis: usize| dims[axis] > 1;
        let least =
            (0..3).filter(|&axis| long(axis)).map(|axis| length[axis][0]).fold(f64::INFINITY, f64::min);
        let many = dims.iter().product::<usize>() > COARSEST;
        let halved = std::array::from_fn(|axis| many && long(axis) && length[axis][0] <= WEAK * least);
        Self { dims, halved, length }
    }

    fn coarser(&self) -> Option<Self> {
        if self.halved == [false; 3] {
            return None;
        }
        let dims = std::array::from_fn(|axis| self.dims[axis].div_ceil(self.joined(axis)));
        let length = std::array::from_fn(|axis| {
            let [cell, last] = self.length[axis];
            match (self.halved[axis], self.dims[axis] % 2) {
                (false, _) => [cell, last],
                (true, 0) => [2.0 * cell, cell + last],
                (true, _) => [2.0 * cell, last],
            }
        });
        Some(Self::new(dims, length))
    }

    /// Cells that the next level joins along an axis.
    fn joined(&self, axis: usize) -> usize {
        1 + usize::from(self.halved[axis])
    }

    /// Distance of neighbouring cells along y and along z: odd, so that the parity of a cell's place is its colour.
    pub fn strides(&self) -> [usize; 2] {
        let row = self.dims[0] | 1;
        [row, row * (self.dims[1] | 1)]
    }

    /// Elements per colour.
    pub fn half_count(&self) -> usize {
        (self.strides()[1] * self.dims[2]).div_ceil(2).next_multiple_of(ALIGNMENT)
    }

    /// Zeros before and after each colour.
    pub fn guard(&self) -> usize {
        (self.strides()[1] / 2 + 1).next_multiple_of(ALIGNMENT)
    }

    /// Elements of a field.
    pub fn elements(&self) -> usize {
        2 * (self.half_count() + 2 * self.guard())
    }

    /// The element of a cell.
    pub fn element(&self, [x, y, z]: [usize; 3]) -> usize {
        let [row, slice] = self.strides();
        let place = x + row * y + slice * z;
        (place % 2) * (self.elements() / 2) + self.guard() + place / 2
    }

    /// For an axis: how much narrower coarse faces are than the sum of the fine ones, and the last face.
    fn narrower(&self, axis: usize) -> [f64; 2] {
        let Some(coarser) = self.coarser().filter(|_| self.halved[axis]) else {
            return [1.0; 2];
        };
        let [cell, last] = self.length[axis];
        let [coarse, coarse_last] = coarser.length[axis];
        // The last coarse face is the last fine one where the last fine cell stays alone.
        let fine_last = if self.dims[axis].is_multiple_of(2) { cell } else { 0.5 * (cell + last) };
        [cell / coarse, fine_last / (0.5 * (coarse + coarse_last))]
    }

    /// What kernels see. Coefficients are those of the equation times the shortest edge of the finest cells.
    pub fn device(&self, boundary: &super::Boundary, largest_diffusivity: f64) -> DeviceDiffusionGrid {
        let spacing = self.length.map(|[cell, _]| cell);
        let unit = spacing.into_iter().fold(f64::INFINITY, f64::min);
        let per_axis = |value: &dyn Fn(usize) -> f64, w: f64| {
            [value(0), value(1), value(2), w].map(|number| number as f32)
        };
        let outside = |axis: usize| match 2.0 * boundary.reflection[axis] * spacing[axis] / unit {
            resistance if resistance.is_finite() => resistance,
            _ => -1.0,
        };
        let [nx, ny, nz] = self.dims.map(|n| n as u32);
        let [row, slice] = self.strides().map(|n| n as u32);
        DeviceDiffusionGrid {
            face: per_axis(&|axis| unit / spacing[axis].powi(2), 0.0),
            open: per_axis(&|axis| spacing[axis].powi(2) / (2.0 * unit), largest_diffusivity),
            outside: per_axis(&outside, 0.0),
            narrower: per_axis(&|axis| self.narrower(axis)[0], 0.0),
            last: per_axis(&|axis| self.narrower(axis)[1], 0.0),
            nx,
            ny,
            nz,
            row,
            slice,
            half_count: self.half_count() as u32,
            guard: self.guard() as u32,
            halved: (0..3).map(|axis| u32::from(self.halved[axis]) << axis).sum(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_have_the_other_colour_at_fixed_distances() {
        for dims in [[1, 1, 1], [4, 6, 3], [5, 4, 3], [1, 7, 2], [9, 1, 4]] {
            let grid = Grid::hierarchy(dims, DVec3::ONE).remove(0);
            let colour = grid.elements() / 2;
            let [row, slice] = grid.strides().map(|n| n / 2);
            let mut seen = std::collections::HashSet::new();
            let cells = (0..dims.iter().product::<usize>())
                .map(|i| [i % dims[0], i / dims[0] % dims[1], i / dims[0] / dims[1]]);
            for cell in cells {
                let own = grid.element(cell);
                assert!(seen.insert(own) && own % colour >= grid.guard(), "{dims:?} {cell:?}");
                assert!(own % colour < grid.guard() + grid.half_count());
                assert_eq!(own / colour, cell.iter().sum::<usize>() % 2);
                let high = own % colour + own / colour + (1 - own / colour) * colour;
                for (axis, distance) in [0, row, slice].into_iter().enumerate() {
                    let mut next = cell;
                    next[axis] += 1;
                    if next[axis] < dims[axis] {
                        assert_eq!(grid.element(next), high + distance, "{dims:?} {cell:?} {axis}");
                    }
                }
            }
        }
    }

    #[test]
    fn levels_halve_the_finest_axes_until_few_cells_are_left() {
        let dims = |dims, spacing| -> Vec<_> {
            Grid::hierarchy(dims, spacing).into_iter().map(|grid| grid.dims).collect()
        };
        assert_eq!(dims([65, 64, 9], DVec3::ONE), [[65, 64, 9], [33, 32, 5], [17, 16, 3], [9, 8, 2]]);
        assert_eq!(
            dims([64, 64, 16], DVec3::new(1.0, 1.0, 4.0)),
            [[64, 64, 16], [32, 32, 16], [16, 16, 16], [8, 8, 8], [4, 4, 4]]
        );
        assert_eq!(dims([1, 1, 1000], DVec3::ONE), [[1, 1, 1000], [1, 1, 500], [1, 1, 250], [1, 1, 125]]);
        assert_eq!(dims([6, 6, 6], DVec3::ONE), [[6, 6, 6]]);
    }

    #[test]
    fn coarse_faces_are_narrowed_by_the_distance_of_centres() {
        let levels = Grid::hierarchy([13, 12, 14], DVec3::ONE);
        // 13 cells: the last one stays alone, 1.5 from the centre of the pair before it.
        assert_eq!(levels[0].narrower(0), [0.5, 1.0 / 1.5]);
        assert_eq!(levels[0].narrower(1), [0.5, 0.5]);
        // 14 → 7 → 4: the last of four is one pair; 7 → 4 joins centres 2 apart into ones 3 apart.
        assert_eq!(levels[1].narrower(2), [0.5, 2.0 / 3.0]);
    }
}
