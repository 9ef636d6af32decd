//! Means over a picture with confidence intervals from its blocks.
//!
//! Neighbouring pixels are correlated (filters, shared paths, the scene itself), so pixels are not
//! independent observations. Blocks of 32×32 pixels nearly are. The interval is Student's t over
//! the block sums, with the ratio estimator for blocks of unequal count at the border. It covers
//! noise and the variation of the error over the picture; it is not about a second render alone.

use serde::{Deserialize, Serialize};

/// The edge of a block in pixels; halved until a picture has [`MIN_BLOCKS`] of them.
const EDGE: usize = 32;
/// Fewer blocks than this make the interval itself too uncertain (physics: K ≥ 16 batches).
const MIN_BLOCKS: usize = 16;

/// A mean with its two-sided 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The mean.
    pub value: f64,
    /// Lower end of the interval; `None` with fewer than two blocks.
    pub low: Option<f64>,
    /// Upper end of the interval; `None` with fewer than two blocks.
    pub high: Option<f64>,
}

/// How a picture is cut into blocks.
#[derive(Clone, Copy, Debug)]
pub(super) struct BlockGrid {
    edge: usize,
    columns: usize,
    rows: usize,
    width: usize,
}

impl BlockGrid {
    pub fn new(width: usize, height: usize) -> Self {
        let mut edge = EDGE;
        while edge > 1 && width.div_ceil(edge) * height.div_ceil(edge) < MIN_BLOCKS {
            edge /= 2;
        }
        Self { edge, columns: width.div_ceil(edge), rows: height.div_ceil(edge), width }
    }

    fn block_of(&self, pixel: usize) -> usize {
        let (x, y) = (pixel % self.width, pixel / self.width);
        y / self.edge * self.columns + x / self.edge
    }
}

/// Sums of values per block.
pub(super) struct BlockMeans {
    grid: BlockGrid,
    sums: Vec<f64>,
    counts: Vec<f64>,
}

impl BlockMeans {
    pub fn new(grid: BlockGrid) -> Self {
        let blocks = grid.columns * grid.rows;
        Self { grid, sums: vec![0.0; blocks], counts: vec![0.0; blocks] }
    }

    pub fn add(&mut self, pixel: usize, value: f64) {
        let block = self.grid.block_of(pixel);
        self.sums[block] += value;
        self.counts[block] += 1.0;
    }

    /// The sum of the values of each block.
    pub fn into_sums(self) -> Vec<f64> {
        self.sums
    }

    /// The mean of all values; `None` where there are none.
    pub fn estimate(&self) -> Option<Estimate> {
        let count: f64 = self.counts.iter().sum();
        if count == 0.0 {
            return None;
        }
        let value = self.sums.iter().sum::<f64>() / count;
        let half = self.half_width(value, count);
        Some(Estimate { value, low: half.map(|half| value - half), high: half.map(|half| value + half) })
    }

    /// Cochran, *Sampling Techniques* (1977), eq. 6.13: variance of a ratio of block sums.
    fn half_width(&self, mean: f64, count: f64) -> Option<f64> {
        let used = self.counts.iter().filter(|&&count| count > 0.0).count();
        if used < 2 {
            return None;
        }
        let residual = |(sum, count): (&f64, &f64)| (sum - mean * count).powi(2);
        let squares: f64 = self.sums.iter().zip(&self.counts).map(residual).sum();
        let blocks = used as f64;
        Some(student_t_975(used - 1) * (squares * blocks / (blocks - 1.0)).sqrt() / count)
    }
}

/// The 97.5 % point of Student's t: the table to 10 degrees of freedom, then the expansion of
/// Abramowitz & Stegun (26.7.5), right to 10⁻⁴ from there on.
pub(crate) fn student_t_975(degrees: usize) -> f64 {
    const TABLE: [f64; 10] =
        [12.7062, 4.3027, 3.1824, 2.7764, 2.5706, 2.4469, 2.3646, 2.3060, 2.2622, 2.2281];
    const Z: f64 = 1.959_963_985;
    if let Some(&value) = degrees.checked_sub(1).and_then(|row| TABLE.get(row)) {
        return value;
    }
    let n = degrees as f64;
    let g1 = (Z.powi(3) + Z) / 4.0;
    let g2 = (5.0 * Z.powi(5) + 16.0 * Z.powi(3) + 3.0 * Z) / 96.0;
    let g3 = (3.0 * Z.powi(7) + 19.0 * Z.powi(5) + 17.0 * Z.powi(3) - 15.0 * Z) / 384.0;
    Z + g1 / n + g2 / (n * n) + g3 / (n * n * n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::test_pictures::Normal;

    #[test]
    fn student_t_agrees_with_tables() {
        // NIST/SEMATECH e-Handbook, table 1.3.6.7.2.
        for (degrees, value) in [(1, 12.706), (5, 2.571), (11, 2.201), (15, 2.131), (30, 2.042), (100, 1.984)]
        {
            assert!((student_t_975(degrees) - value).abs() < 6e-4, "{degrees}: {}", student_t_975(degrees));
        }
    }

    #[test]
    fn equal_blocks_give_the_textbook_interval() {
        // A 4×4 picture has 16 blocks of one pixel: 0…15, mean 7.5, s² = 22.666…, t₁₅ = 2.1314.
        let mut means = BlockMeans::new(BlockGrid::new(4, 4));
        for pixel in 0..16 {
            means.add(pixel, pixel as f64);
        }
        let estimate = means.estimate().unwrap();
        let half = 2.1314 * (22.666_667_f64 / 16.0).sqrt();
        assert_eq!(estimate.value, 7.5);
        assert!((estimate.high.unwrap() - 7.5 - half).abs() < 1e-3);
        assert!((estimate.low.unwrap() - 7.5 + half).abs() < 1e-3);
    }

    #[test]
    fn no_value_and_one_value_have_no_interval() {
        let mut means = BlockMeans::new(BlockGrid::new(1, 1));
        assert_eq!(means.estimate(), None);
        means.add(0, 3.0);
        assert_eq!(means.estimate(), Some(Estimate { value: 3.0, low: None, high: None }));
    }

    /// The interval must hold the true mean in 95 % of the cases: 400 trials, so σ = 1.09 %; 4σ.
    #[test]
    fn the_interval_covers_the_truth() {
        let mut normal = Normal::new(11);
        let grid = BlockGrid::new(50, 37);
        let mut covered = 0;
        for _ in 0..400 {
            let mut means = BlockMeans::new(grid);
            for pixel in 0..50 * 37 {
                means.add(pixel, 2.0 + normal.next());
            }
            let estimate = means.estimate().unwrap();
            covered += usize::from(estimate.low.unwrap() <= 2.0 && 2.0 <= estimate.high.unwrap());
        }
        let share = covered as f64 / 400.0;
        assert!((share - 0.95).abs() < 4.0 * 0.0109, "{share}");
    }
}
