//! Least and largest value of the transfer function's table over rectangles, in constant time.
//!
//! The table is linear between entries along each axis, so over a rectangle its extrema lie at entries inside, where
//! the rectangle's edges cross lines of entries, or at its corners.

/// Most blocks per axis of a 2-D table: n blocks per axis take about (n log2 n)^2 extrema, 26 MB at 256.
const MOST_BLOCKS: usize = 256;

/// Least and largest of a block of entries.
type Extrema = [f32; 2];

/// Extrema of a table over rectangles of positions, which count entries.
///
/// Exact over a table of one row. With more rows, an edge between two rows is bounded by interpolating between the
/// rows' extrema, and an axis of more than 257 entries is divided into blocks, of which the rectangle counts whole.
pub struct TableExtrema {
    columns: Axis,
    rows: Axis,
    /// Level (l, m), at index l · (row levels) + m: extrema of 2^l columns by 2^m rows, columns fastest.
    levels: Vec<Vec<Extrema>>,
}

/// One axis of the table.
#[derive(Clone, Copy)]
struct Axis {
    entries: usize,
    /// Intervals between entries per block; 1: the blocks are the entries themselves.
    fold: usize,
    blocks: usize,
}

/// Two runs of blocks (first, last), and where the table is between them: 0 is in the first run.
#[derive(Clone, Copy)]
struct Section {
    low: [usize; 2],
    high: [usize; 2],
    fraction: f64,
}

impl Section {
    fn whole(run: [usize; 2]) -> Self {
        Self { low: run, high: run, fraction: 0.0 }
    }
}

impl Axis {
    fn new(entries: usize, most: usize) -> Self {
        let fold = (entries - 1).div_ceil(most).max(1).next_power_of_two();
        let blocks = if fold == 1 { entries } else { (entries - 1).div_ceil(fold) };
        Self { entries, fold, blocks }
    }

    /// log2 of the longest run that a level covers, plus 1.
    fn levels(&self) -> usize {
        self.blocks.ilog2() as usize + 1
    }

    /// First and last entry of a block; neighbours share one.
    fn extent(&self, block: usize) -> [usize; 2] {
        match self.fold {
            1 => [block, block],
            fold => [block * fold, ((block + 1) * fold).min(self.entries - 1)],
        }
    }

    fn clamped(&self, position: f64) -> f64 {
        position.clamp(0.0, (self.entries - 1) as f64)
    }

    /// The entry at or below a position as the kernels find it.
    fn interval(&self, position: f64) -> usize {
        (position as usize).min(self.entries.saturating_sub(2))
    }

    fn folded(&self, [a, b]: [f64; 2]) -> [usize; 2] {
        [a, b].map(|position| (position as usize / self.fold).min(self.blocks - 1))
    }

    /// Where extrema over a..=b can lie: at either end, and at the entries between.
    fn sections(&self, range: [f64; 2]) -> [Option<Section>; 3] {
        let range @ [a, b] = range.map(|position| self.clamped(position));
        if self.entries == 1 || self.fold > 1 {
            return [Some(Section::whole(self.folded(range))), None, None];
        }
        let end = |position: f64| {
            let i = self.interval(position);
            Section { low: [i; 2], high: [i + 1; 2], fraction: position - i as f64 }
        };
        let (first, last) = (a.ceil() as usize, b.floor() as usize);
        let inside = (first <= last).then(|| Section::whole([first, last]));
        [Some(end(a)), inside, (a < b).then(|| end(b))]
    }

    /// All blocks that interpolation over a..=b reads.
    fn touched(&self, range: [f64; 2]) -> [usize; 2] {
        let range @ [a, b] = range.map(|position| self.clamped(position));
        if self.entries == 1 || self.fold > 1 {
            return self.folded(range);
        }
        [self.interval(a), self.interval(b) + 1]
    }
}

fn join(a: Extrema, b: Extrema) -> Extrema {
    [a[0].min(b[0]), a[1].max(b[1])]
}

impl TableExtrema {
    /// Of a table of `size` columns and as many rows as `values` (column fastest) has.
    pub fn new(values: &[f32], size: usize) -> Self {
        let height = values.len() / size;
        let most = if height == 1 { size } else { MOST_BLOCKS };
        let (columns, rows) = (Axis::new(size, most), Axis::new(height, most));
        let block = |index: usize| {
            let [x0, x1] = columns.extent(index % columns.blocks);
            let [y0, y1] = rows.extent(index / columns.blocks);
            let entries = (y0..=y1).flat_map(|y| &values[y * size + x0..=y * size + x1]);
            entries.fold([f32::INFINITY, f32::NEG_INFINITY], |all, &value| join(all, [value; 2]))
        };
        let mut levels: Vec<Vec<Extrema>> = vec![(0..columns.blocks * rows.blocks).map(block).collect()];
        for l in 0..columns.levels() {
            if l > 0 {
                let previous = &levels[(l - 1) * rows.levels()];
                levels.push(doubled(previous, columns.blocks + 1 - (1 << (l - 1)), [1 << (l - 1), 0]));
            }
            for m in 1..rows.levels() {
                let width = columns.blocks + 1 - (1 << l);
                levels.push(doubled(&levels[levels.len() - 1], width, [0, 1 << (m - 1)]));
            }
        }
        Self { columns, rows, levels }
    }

    /// Lower and upper bound over a rectangle (first and last position per axis); beyond its ends the table is
    /// constant.
    pub fn over(&self, columns: [f64; 2], rows: [f64; 2]) -> [f64; 2] {
        let mut bounds = [f64::INFINITY, f64::NEG_INFINITY];
        for y in self.rows.sections(rows).into_iter().flatten() {
            for x in self.columns.sections(columns).into_iter().flatten() {
                let across =
                    |rows| mixed(x.fraction, || self.blocks(x.low, rows), || self.blocks(x.high, rows));
                let [least, largest] = mixed(y.fraction, || across(y.low), || across(y.high));
                bounds = [bounds[0].min(least), bounds[1].max(largest)];
            }
        }
        bounds
    }

    /// The largest entry that interpolation over a rectangle reads.
    pub fn largest_read(&self, columns: [f64; 2], rows: [f64; 2]) -> f64 {
        self.blocks(self.columns.touched(columns), self.rows.touched(rows))[1]
    }

    /// Extrema over runs of blocks, from four overlapping powers of two.
    fn blocks(&self, [x0, x1]: [usize; 2], [y0, y1]: [usize; 2]) -> [f64; 2] {
        let (l, m) = ((x1 - x0 + 1).ilog2() as usize, (y1 - y0 + 1).ilog2() as usize);
        let level = &self.levels[l * self.rows.levels() + m];
        let width = self.columns.blocks + 1 - (1 << l);
        let row = |y: usize| join(level[y * width + x0], level[y * width + x1 + 1 - (1 << l)]);
        join(row(y0), row(y1 + 1 - (1 << m))).map(f64::from)
    }
}

/// The next level of a table `width` wide: each element joined with the one at an offset.
fn doubled(level: &[Extrema], width: usize, [dx, dy]: [usize; 2]) -> Vec<Extrema> {
    let rows = level.len() / width;
    (0..rows - dy)
        .flat_map(|y| (0..width - dx).map(move |x| y * width + x))
        .map(|index| join(level[index], level[index + dy * width + dx]))
        .collect()
}

/// Between two bounds. Equal ends give the end itself, and what has no weight is not asked for.
fn mixed(fraction: f64, low: impl FnOnce() -> [f64; 2], high: impl FnOnce() -> [f64; 2]) -> [f64; 2] {
    if fraction == 0.0 {
        return low();
    }
    let (low, high) = (low(), high());
    if fraction == 1.0 {
        return high;
    }
    std::array::from_fn(|k| low[k] + fraction * (high[k] - low[k]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::random::{philox4x32, uniform};

    fn noise(count: usize, seed: u32) -> impl Iterator<Item = f64> {
        (0..count as u32).map(move |i| uniform(philox4x32([i, seed, 0, 0], [7, 0])[0]))
    }

    /// The interpolated table, written for reading.
    fn at(values: &[f32], size: usize, x: f64, y: f64) -> f64 {
        let rows = values.len() / size;
        let entry = |i: usize, j: usize| f64::from(values[j.min(rows - 1) * size + i.min(size - 1)]);
        let (x, y) = (x.clamp(0.0, (size - 1) as f64), y.clamp(0.0, (rows - 1) as f64));
        let (i, j, f, g) = (x as usize, y as usize, x.fract(), y.fract());
        let row = |j| entry(i, j) * (1.0 - f) + entry(i + 1, j) * f;
        row(j) * (1.0 - g) + row(j + 1) * g
    }

    /// Positions at which extrema can lie: the ends and the entries between.
    fn candidates([a, b]: [f64; 2]) -> Vec<f64> {
        let inside = (a.ceil() as i64..=b.floor() as i64).map(|k| k as f64);
        [a, b].into_iter().chain(inside).collect()
    }

    fn exact(values: &[f32], size: usize, columns: [f64; 2], rows: [f64; 2]) -> [f64; 2] {
        let mut bounds = [f64::INFINITY, f64::NEG_INFINITY];
        for x in candidates(columns) {
            for y in candidates(rows) {
                let value = at(values, size, x, y);
                bounds = [bounds[0].min(value), bounds[1].max(value)];
            }
        }
        bounds
    }

    /// Ordered pairs from beyond the table on either side; every third starts and ends on entries.
    fn ranges(last: f64, seed: u32) -> Vec<[f64; 2]> {
        let ends: Vec<f64> = noise(600, seed).map(|u| (u * 1.4 - 0.2) * last).collect();
        let pair = |(k, pair): (usize, &[f64])| {
            let [a, b] = if k % 3 == 0 { [pair[0].round(), pair[1].round()] } else { [pair[0], pair[1]] };
            [a.min(b), a.max(b)]
        };
        ends.chunks(2).enumerate().map(pair).collect()
    }

    #[test]
    fn one_row_is_exact() {
        for size in [2, 3, 7, 64, 1021] {
            // Sparse spikes: most entries are 0, so emptiness is tested as well.
            let values: Vec<f32> =
                noise(size, 1).map(|u| if u < 0.8 { 0.0 } else { u as f32 * 40.0 }).collect();
            let table = TableExtrema::new(&values, size);
            for range in ranges((size - 1) as f64, size as u32) {
                let (found, expected) = (table.over(range, [0.0; 2]), exact(&values, size, range, [0.0; 2]));
                for (found, expected) in found.into_iter().zip(expected) {
                    // Two ways to write one interpolation in f64: a few roundings of numbers up to 40.
                    assert!((found - expected).abs() < 40.0 * 4.0 * f64::EPSILON, "{range:?}");
                    assert_eq!(found == 0.0, expected == 0.0, "{range:?}");
                }
            }
        }
    }

    #[test]
    fn rectangles_are_bounded_and_exact_on_entries() {
        // 300 columns are folded by two, 2000 rows by eight.
        for [size, rows] in [[2, 2], [16, 9], [257, 40], [300, 5], [3, 2000]] {
            let values: Vec<f32> = noise(size * rows, 2).map(|u| (u as f32).powi(20)).collect();
            let table = TableExtrema::new(&values, size);
            let xs = ranges((size - 1) as f64, 3);
            for (k, (x, y)) in xs.into_iter().zip(ranges((rows - 1) as f64, 4)).enumerate() {
                let (found, expected) = (table.over(x, y), exact(&values, size, x, y));
                assert!(found[0] <= expected[0] + 1e-15 && found[1] >= expected[1] - 1e-15, "{x:?} {y:?}");
                if k % 3 == 0 && size <= 257 && rows <= 257 {
                    assert_eq!(found, expected, "{x:?} {y:?}");
                }
                assert!(table.largest_read(x, y) >= expected[1]);
            }
        }
    }

    #[test]
    fn a_flat_table_is_flat_to_the_last_bit() {
        let table = TableExtrema::new(&[0.1; 30], 6);
        for (x, y) in ranges(5.0, 5).into_iter().zip(ranges(4.0, 6)) {
            assert_eq!(table.over(x, y), [f64::from(0.1_f32); 2]);
        }
    }
}
