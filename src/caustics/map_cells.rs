//! How large the map's cells are, and how many.

use super::map_types::MapSettings;

/// Most cells: their keys and that of no photon fit 32 bits with room to spare.
const MOST_CELLS: f64 = 2_147_483_648.0;

/// The part of space that the cells should hold: a cube about what makes caustics and shows them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Focus {
    /// Its middle.
    pub centre: [f32; 3],
    /// Half its edge.
    pub reach: f32,
}

/// Cells over the photons' bounds, in the space of the cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cells {
    /// Low corner.
    pub low: [f32; 3],
    /// Cells per local unit.
    pub scale: f32,
    /// Cells per axis.
    pub dims: [u32; 3],
    /// Whether some photons may lie outside: they count as of the nearest cell.
    pub clamped: bool,
}

impl Cells {
    /// Cells for points that look for photons within `radius` of them; in planes `planes` layers of them, otherwise the
    /// bounds tell.
    ///
    /// Cells are wider than the radius by so much that whatever rounding does to the numbers of cells (a float32
    /// difference and product, in planes a sum of three products too), photons within the radius lie at most one cell
    /// away: by 1e-4, and by 2⁻²⁰ of the coordinates.
    #[cfg(test)]
    fn new(low: [f32; 3], high: [f32; 3], radius: f64, planes: Option<u32>) -> Self {
        Self::around(low, high, radius, planes, None, 0)
    }

    /// The same for photons of which a few may lie far away: where there would be more cells than `table`, only those near
    /// the focus are there, as many as go into the table, but at least all that the focus reaches.
    pub fn around(
        low: [f32; 3],
        high: [f32; 3],
        radius: f64,
        planes: Option<u32>,
        focus: Option<Focus>,
        table: usize,
    ) -> Self {
        let whole = Self::covering(low, high, radius, planes);
        let Some(Focus { centre, reach }) = focus.filter(|_| whole.count() > table as u64) else {
            return whole;
        };
        let size = (0..3).fold(0.0_f32, |size, axis| size.max(high[axis] - low[axis]));
        let mut half = size.max(reach);
        loop {
            half = (0.8 * half).max(reach);
            // Not beyond the photons, and not past them.
            let cut = |end: f32, axis: usize| (centre[axis] + end * half).clamp(low[axis], high[axis]);
            let [from, to] = [-1.0, 1.0].map(|end| [0, 1, 2].map(|axis| cut(end, axis)));
            let cells = Self { clamped: true, ..Self::covering(from, to, radius, planes) };
            if cells.count() <= table as u64 || half <= reach {
                return cells;
            }
        }
    }

    fn covering(low: [f32; 3], high: [f32; 3], radius: f64, planes: Option<u32>) -> Self {
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
                return Self { low, scale, dims: dims.map(|count| count as u32), clamped: false };
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
    fn photons_far_away_do_not_make_cells_many_or_wide() {
        let focus = Focus { centre: [0.5, 0.5, 0.5], reach: 1.0 };
        let (low, high) = ([-1e6, -3e5, 0.0], [2e5, 1e6, 0.0]);
        let cells = Cells::around(low, high, 0.02, None, Some(focus), 1 << 24);
        assert!(cells.clamped && cells.count() <= 1 << 24 && cells.count() > 1 << 22, "{cells:?}");
        // Still as narrow as those around the focus alone: not by 2^-20 of a million.
        assert!(1.0 / cells.scale < 0.0202, "{cells:?}");
        for axis in 0..3 {
            let end = cells.low[axis] + cells.dims[axis] as f32 / cells.scale;
            assert!(cells.low[axis] <= 0.5 - f32::from(axis < 2) && end >= 0.5 * f32::from(axis < 2));
        }
        // What is within reach stays, though the table is too small for it.
        let solid = Cells::around([0.0; 3], [1.0; 3], 1e-3, None, Some(focus), 1 << 24);
        assert!(solid.clamped && solid.count() > 1 << 24);
        assert_eq!(solid.dims, Cells::new([0.0; 3], [1.0; 3], 1e-3, None).dims);
        // Few cells are left as they are.
        let few = Cells::around([0.0; 3], [1.0; 3], 0.1, None, Some(focus), 1 << 24);
        assert_eq!(few, Cells::new([0.0; 3], [1.0; 3], 0.1, None));
    }

    #[test]
    fn planes_lie_one_behind_the_other() {
        let cells = Cells::new([-1.0, -1.0, 0.0], [1.0, 1.0, 0.0], 0.125, Some(3));
        assert_eq!(cells.dims, [16, 16, 3]);
        assert_eq!(Cells::new([0.0; 3], [0.0; 3], 1.0, Some(0)).dims, [1, 1, 1]);
    }
}
