//! How large the map's cells are, and how many.

use super::map_types::MapSettings;

/// Most cells: their keys and that of no photon fit 32 bits with room to spare.
const MOST_CELLS: f64 = 2_147_483_648.0;

/// Cells over the photons' bounds, in the space of the cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cells {
    /// Low corner.
    pub low: [f32; 3],
    /// Cells per local unit.
    pub scale: f32,
    /// Cells per axis.
    pub dims: [u32; 3],
}

impl Cells {
    /// Cells for points that look for photons within `radius` of them; in planes `planes` layers of them, otherwise the
    /// bounds tell.
    ///
    /// Cells are wider than the radius by so much that whatever rounding does to the numbers of cells (a float32
    /// difference and product, in planes a sum of three products too), photons within the radius lie at most one cell
    /// away: by 1e-4, and by 2⁻²⁰ of the coordinates.
    pub fn new(low: [f32; 3], high: [f32; 3], radius: f64, planes: Option<u32>) -> Self {
        let axes = if planes.is_some() { 2 } else { 3 };
        let [low_, high_] = [low, high].map(|corner| corner.map(f64::from));
        let reach = (0..axes).fold(0.0_f64, |reach, axis| {
            reach.max(low_[axis].abs()).max(high_[axis].abs()).max(high_[axis] - low_[axis])
        });
        let mut side = radius * (1.0 + 1e-4) + reach / f64::from(1 << 20);
        loop {
            let scale = (1.0 / side) as f32;
            let count = |axis: usize| match planes {
                Some(planes) if axis == 2 => f64::from(planes.max(1)),
                _ => f64::from(((high[axis] - low[axis]) * scale).floor()) + 1.0,
            };
            let dims = [0, 1, 2].map(count);
            if dims.iter().product::<f64>() <= MOST_CELLS {
                return Self { low, scale, dims: dims.map(|count| count as u32) };
            }
            side *= 1.25;
        }
    }

    /// Number of cells.
    pub fn count(&self) -> u64 {
        self.dims.iter().map(|&count| u64::from(count)).product()
    }

    /// Bits of the keys of cells, so that all ones is no cell's.
    pub fn key_bits(&self) -> u32 {
        u64::BITS - self.count().leading_zeros()
    }

    /// Whether the cells' ranges go into the table.
    pub fn fit_table(&self, settings: &MapSettings) -> bool {
        self.count() <= settings.table_cells as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_cover_the_bounds_and_are_wider_than_the_radius() {
        for (low, high, radius) in [
            ([0.0; 3], [10.0, 5.0, 0.0], 0.04),
            ([1e4; 3], [1e4 + 1.0; 3], 1e-3),
            ([-3.0, 2.0, 7.0], [-3.0, 2.0, 7.0], 1e-6),
            ([0.0; 3], [1.0; 3], 1e-9),
            ([-1e30; 3], [1e30; 3], 1.0),
            ([0.0; 3], [1e-3; 3], 100.0),
        ] {
            let cells = Cells::new(low, high, radius, None);
            assert!(1.0 / f64::from(cells.scale) >= radius * (1.0 + 0.99e-4), "{cells:?}");
            assert!(cells.count() <= 1 << 31);
            assert!(cells.count() < 1 << cells.key_bits());
            for axis in 0..3 {
                let last = ((high[axis] - low[axis]) * cells.scale).floor();
                assert_eq!(last + 1.0, cells.dims[axis] as f32);
            }
        }
    }

    #[test]
    fn planes_lie_one_behind_the_other() {
        let cells = Cells::new([-1.0, -1.0, 0.0], [1.0, 1.0, 0.0], 0.125, Some(3));
        assert_eq!(cells.dims, [16, 16, 3]);
        assert_eq!(Cells::new([0.0; 3], [0.0; 3], 1.0, Some(0)).dims, [1, 1, 1]);
    }
}
