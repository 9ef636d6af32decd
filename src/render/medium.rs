//! The transfer function on the device, and what bounds it.

use super::grid::{BrickRanges, Grid};
use crate::Result;
use crate::scene::{Medium, Transfer};
use crate::transfer::{TransferFunction1d, TransferFunction2d, sigma_table};

/// Classes of bricks, mirrored in `cl/render/emission_absorption.cl`: the table is a straight line over the brick's
/// values, or anything. Smaller numbers are empty bricks, see [`MediumTable::classify`].
pub(super) const BRICK_STRAIGHT: u8 = 254;
const BRICK_BENT: u8 = 255;

/// A transfer function's table in local units, with what exact averages and bounds need.
pub struct MediumTable {
    /// Entries along the value axis.
    pub size: usize,
    /// Rows along the gradient axis; 1 for a function of the value alone.
    pub rows: usize,
    /// Rows per gradient of the value (in entries) per local unit; 0 for a function of the value alone.
    pub gradient_scale: f32,
    /// Per entry colour and sigma_t per local unit, value fastest.
    entries: Vec<[f64; 4]>,
    /// Range maximum of sigma_t over the value axis: level l holds the maximum of 2^l entries (over all rows).
    maxima: Vec<Vec<f64>>,
}

impl MediumTable {
    /// The table of a scene's transfer function for a `window` in data units; `unit`: scene units per local unit,
    /// which is the smallest voxel spacing.
    ///
    /// # Errors
    /// [`crate::Error::Input`] when a 2-D table cannot be read.
    pub fn new(transfer: &Transfer, medium: &Medium, window: (f64, f64), unit: f64) -> Result<Self> {
        let (rgba, size, rows, gradient_max) = match transfer {
            Transfer::OneD(settings) => {
                let rgba = TransferFunction1d::from_settings(settings, window).rgba;
                let size = rgba.len();
                (rgba, size, 1, f64::INFINITY)
            }
            Transfer::TwoD(settings) => {
                let table = TransferFunction2d::from_settings(settings)?;
                (table.rgba, table.width, table.height, settings.gradient_max)
            }
        };
        let entries: Vec<[f64; 4]> = sigma_table(&rgba, medium, unit)
            .into_iter()
            .map(|[r, g, b, sigma]| [r, g, b, sigma * unit])
            .collect();
        let columns =
            (0..size).map(|x| (0..rows).map(|y| entries[y * size + x][3]).fold(0.0, f64::max)).collect();
        let gradient_scale = ((rows - 1) as f64 / (gradient_max * (size - 1) as f64)) as f32;
        Ok(Self { size, rows, gradient_scale, maxima: range_maxima(columns), entries })
    }

    /// Whether no entry has a hue.
    pub fn is_grey(&self) -> bool {
        self.entries.iter().all(|[r, g, b, _]| r == g && g == b)
    }

    /// Whether every colour is black: then only transmittance matters.
    pub fn is_black(&self) -> bool {
        self.entries.iter().all(|entry| entry[..3].iter().all(|&c| c == 0.0))
    }

    /// The largest extinction over all values, per local unit.
    pub fn max_sigma(&self) -> f64 {
        self.max_between(0.0, self.intervals())
    }

    /// The intervals of the value axis: what a window value of 1 is, counted in entries.
    pub fn intervals(&self) -> f64 {
        (self.size - 1) as f64
    }

    /// A bound of the extinction over values (counted in entries) between `a` and `b`; exact up to the device's
    /// rounding.
    ///
    /// The table is piecewise linear, so the maximum lies at the ends or at an entry between them. The device
    /// interpolates in float32, so an interval is widened by a thousandth of an entry; a single value is not: a
    /// field that is constant over a cell is interpolated without rounding.
    pub fn max_between(&self, a: f64, b: f64) -> f64 {
        let last = self.intervals();
        let margin = if a == b { 0.0 } else { 1e-3 };
        let low = (a.min(b) - margin).clamp(0.0, last);
        let high = (a.max(b) + margin).clamp(0.0, last);
        let ends = self.sigma_at(low).max(self.sigma_at(high));
        let (first, end) = (low.ceil() as usize, high.floor() as usize + 1);
        if first >= end {
            return ends;
        }
        let row = &self.maxima[(end - first).ilog2() as usize];
        let width = 1 << (end - first).ilog2();
        ends.max(row[first]).max(row[end - width])
    }

    /// The largest extinction over all rows at a position in entries, in 0..=size - 1.
    fn sigma_at(&self, position: f64) -> f64 {
        let columns = &self.maxima[0];
        let index = (position as usize).min(self.size - 2);
        let fraction = position - index as f64;
        columns[index] * (1.0 - fraction) + columns[index + 1] * fraction
    }

    /// The value (in entries) below which there is no extinction; negative infinity when there is at 0 already.
    pub fn empty_value(&self) -> f64 {
        match self.maxima[0].iter().position(|&sigma| sigma > 0.0) {
            Some(0) => f64::NEG_INFINITY,
            // A thousandth of an entry below, for the device's rounding.
            Some(first) => (first - 1) as f64 - 1e-3,
            None => f64::INFINITY,
        }
    }

    /// What the table does over the values of each brick, per octant of ray directions: `BRICK_STRAIGHT`,
    /// `BRICK_BENT`, or for a brick without extinction how many bricks a ray can stride over.
    pub fn classify(&self, bricks: &BrickRanges, grid: &Grid<'_>) -> Vec<u8> {
        let kinks = self.kinks_before(&self.kinks());
        let values = |range: &[f32; 2]| {
            let [a, b] = range.map(|value| grid.kernel_value(value, self.intervals()));
            (a.min(b), a.max(b))
        };
        let occupied = |range: &[f32; 2]| {
            let (low, high) = values(range);
            self.max_between(low, high) > 0.0
        };
        let mut classes = bricks.strides(BRICK_STRAIGHT - 1, occupied);
        let ranges = bricks.ranges.iter().cycle();
        for (class, range) in classes.iter_mut().zip(ranges).filter(|(class, _)| **class == 0) {
            let (low, high) = values(range);
            let straight = self.rows == 1 && self.is_straight(&kinks, low, high);
            *class = if straight { BRICK_STRAIGHT } else { BRICK_BENT };
        }
        classes
    }

    /// Whether the table is one straight line between two values, with a margin for the device's rounding.
    fn is_straight(&self, kinks: &[u32], low: f64, high: f64) -> bool {
        let last = self.intervals();
        let inside = low >= 0.0 && high <= last;
        let entry = |position: f64| kinks[(position.clamp(0.0, last) as usize).min(self.size - 2)];
        inside && entry(low - 1e-3) == entry(high + 1e-3)
    }

    /// The entries as the device reads them: four floats, or the extinction alone.
    pub fn device_entries(&self, sigma_only: bool) -> Vec<u8> {
        if sigma_only {
            return self.device_sigmas();
        }
        let entries: Vec<[f32; 4]> = self.entries.iter().map(|entry| entry.map(|x| x as f32)).collect();
        bytemuck::cast_slice(&entries).to_vec()
    }

    /// The entries as the projection of light volumes reads them: per channel the albedo times the relative `extinction`,
    /// then sigma_t times `largest`; with an `emission`, its product with the absorption after them.
    pub fn device_sources(
        &self,
        albedo: [f64; 3],
        extinction: [f64; 3],
        largest: f64,
        emission: Option<&[[f32; 4]]>,
    ) -> Vec<u8> {
        let mut values = Vec::with_capacity(self.entries.len() * 8);
        for (index, &[r, g, b, sigma]) in self.entries.iter().enumerate() {
            let albedo = [r * albedo[0], g * albedo[1], b * albedo[2]];
            let sigma = sigma * largest;
            values.extend(
                albedo.iter().zip(extinction).map(|(albedo, extinction)| (albedo * extinction) as f32),
            );
            values.push(sigma as f32);
            if let Some(emission) = emission {
                let glow =
                    |c: usize| sigma * extinction[c] * (1.0 - albedo[c]) * f64::from(emission[index][c]);
                values.extend([glow(0), glow(1), glow(2), 0.0].map(|x| x as f32));
            }
        }
        bytemuck::cast_slice(&values).to_vec()
    }

    /// The extinction of every entry, per local unit, in the precision of the device; value fastest.
    pub fn sigmas(&self) -> Vec<f32> {
        self.entries.iter().map(|entry| entry[3] as f32).collect()
    }

    /// The extinction of every entry as the device reads it: one float.
    pub fn device_sigmas(&self) -> Vec<u8> {
        bytemuck::cast_slice(&self.sigmas()).to_vec()
    }

    /// The colour of every entry times `factor` as the device reads it: four floats, the last 0.
    pub fn device_colors(&self, factor: [f64; 3]) -> Vec<u8> {
        let color = |entry: &[f64; 4]| {
            let [r, g, b] = std::array::from_fn(|c| (entry[c] * factor[c]) as f32);
            [r, g, b, 0.0_f32]
        };
        let colors: Vec<[f32; 4]> = self.entries.iter().map(color).collect();
        bytemuck::cast_slice(&colors).to_vec()
    }

    /// Extinction (per local unit) at a value in entries and a row, in f64.
    pub fn sigma(&self, value: f64, row: f64) -> f64 {
        let place = |x: f64, entries: usize| {
            let x = x.clamp(0.0, (entries - 1) as f64);
            let index = (x as usize).min(entries.saturating_sub(2));
            (index, x - index as f64)
        };
        let ((i, f), (j, g)) = (place(value, self.size), place(row, self.rows));
        let between = |j: usize| {
            let row = &self.entries[j * self.size..];
            row[i][3] * (1.0 - f) + row[i + 1][3] * f
        };
        if g == 0.0 { between(j) } else { between(j) * (1.0 - g) + between(j + 1) * g }
    }

    /// (offset, slope), both at least 0, when the extinction is offset + slope · value (in entries) over the whole
    /// table of a function of the value alone: then a kernel needs no table.
    ///
    /// A falling line is none: near its end the kernel's sum would cancel, even below 0.
    pub fn linear_ramp(&self) -> Option<(f64, f64)> {
        let (first, last) = (self.entries[0][3], self.entries[self.size - 1][3]);
        let slope = (last - first) / self.intervals();
        // Entries are a few roundings in f64 away from the line they were sampled from; the device knows 24 bits.
        let on_line = |(k, entry): (usize, &[f64; 4])| {
            let line = first + slope * k as f64;
            (entry[3] - line).abs() <= 1e-12 * line
        };
        let straight = self.rows == 1 && slope >= 0.0 && self.entries.iter().enumerate().all(on_line);
        straight.then_some((first, slope))
    }

    /// The colour, when it is the same wherever there is extinction among the entries `columns` by `rows` (first and
    /// last); `None` also when there is no extinction.
    pub fn constant_color(&self, columns: [usize; 2], rows: [usize; 2]) -> Option<[f64; 3]> {
        let entry = |k: usize| self.entries[k].map(|x| x as f32);
        let around = |i: usize, [first, last]: [usize; 2]| i.saturating_sub(1).max(first)..=(i + 1).min(last);
        let entries = (rows[0]..=rows[1]).flat_map(|j| (columns[0]..=columns[1]).map(move |i| (i, j)));
        let mut constant = None;
        for (i, j) in entries.filter(|(i, j)| entry(j * self.size + i)[3] > 0.0) {
            // Up to the neighbours the extinction of this entry reaches, and there their colours count.
            for (u, v) in around(j, rows).flat_map(|v| around(i, columns).map(move |u| (u, v))) {
                let here = v * self.size + u;
                if entry(*constant.get_or_insert(here))[..3] != entry(here)[..3] {
                    return None;
                }
            }
        }
        constant.map(|k| std::array::from_fn(|c| self.entries[k][c]))
    }

    /// The entries at which the table's slope jumps, ascending; the first and the last always count, since beyond
    /// them the table is constant.
    ///
    /// A kink is a second difference that stands out from those two entries away, or that is large as such:
    /// kinks may follow each other closely. A smooth curve (opacity to extinction is a logarithm) has none, and
    /// Gauss quadrature is accurate on it.
    pub fn kinks(&self) -> Vec<u32> {
        let bend = |k: usize, c: usize| -> f64 {
            if k == 0 || k + 1 >= self.size {
                return 0.0;
            }
            let [a, b, d] = [k - 1, k, k + 1].map(|i| self.entries[i][c]);
            (a - 2.0 * b + d).abs()
        };
        let largest = |c: usize| self.entries.iter().fold(0.0_f64, |m, entry| m.max(entry[c].abs()));
        let scale: [f64; 4] = std::array::from_fn(largest);
        let is_kink = |&k: &usize| {
            let ends = k == 0 || k + 1 == self.size;
            ends || (0..4).any(|c| {
                let around = bend(k.saturating_sub(2), c).max(bend(k + 2, c));
                bend(k, c) > (4.0 * around + 1e-9 * scale[c]).min(1e-4 * scale[c])
            })
        };
        (0..self.size).filter(is_kink).map(|k| k as u32).collect()
    }

    /// Per entry, how many of the `kinks` lie at or before it.
    pub fn kinks_before(&self, kinks: &[u32]) -> Vec<u32> {
        (0..self.size as u32).map(|entry| kinks.partition_point(|&kink| kink <= entry) as u32).collect()
    }
}

/// Sparse table of maxima: level l, position i covers entries i..i + 2^l.
fn range_maxima(values: Vec<f64>) -> Vec<Vec<f64>> {
    let mut levels = vec![values];
    let mut width = 1;
    while 2 * width <= levels[0].len() {
        let previous = &levels[levels.len() - 1];
        let next = (0..=levels[0].len() - 2 * width).map(|i| previous[i].max(previous[i + width])).collect();
        levels.push(next);
        width *= 2;
    }
    levels
}

#[cfg(test)]
mod tests {
    use crate::render::majorants::tests::table;

    #[test]
    fn straight_tables_are_ramps() {
        let (offset, slope) = table("").linear_ramp().unwrap();
        assert_eq!(offset, 0.0);
        // Opacity 1 of 10 per unit over 1020 intervals; a rounding of f64.
        assert!((slope - 10.0 / 1020.0).abs() < 1e-17, "{slope}");
        let flat = "points = [{ value = 0.5, opacity = 0.3 }]";
        assert_eq!(table(flat).linear_ramp(), Some((3.0, 0.0)));
        let shifted = "domain = \"data\"\npoints = [{ value = -1, opacity = 0 }, { value = 1, opacity = 1 }]\nresolution = 11";
        let (offset, slope) = table(shifted).linear_ramp().unwrap();
        assert!((offset - 5.0).abs() < 1e-14 && (slope - 0.5).abs() < 1e-14);
    }

    #[test]
    fn bent_falling_and_2d_tables_are_none() {
        for transfer in [
            "points = [{ value = 0.001, opacity = 0 }, { value = 1, opacity = 1 }]",
            "points = [{ value = 0, opacity = 1 }, { value = 1, opacity = 0 }]",
            "kind = \"2d\"\nshapes = [{ shape = \"rectangle\", centre = [0.5, 0.5], size = [4, 4] }]",
        ] {
            assert_eq!(table(transfer).linear_ramp(), None, "{transfer}");
        }
    }

    #[test]
    fn colours_count_where_there_is_extinction() {
        // Red up to entry 4, of which entry 3 is the last with extinction; green from entry 5.
        let transfer = "resolution = 11\npoints = [{ value = 0, opacity = 1, color = \"#ff0000\" }, \
            { value = 0.3, opacity = 1, color = \"#ff0000\" }, { value = 0.4, opacity = 0, color = \"#ff0000\" }, \
            { value = 0.5, opacity = 0, color = \"#00ff00\" }, { value = 1, opacity = 0, color = \"#00ff00\" }]";
        let red = Some([1.0, 0.0, 0.0]);
        assert_eq!(table(transfer).constant_color([0, 10], [0, 0]), red);
        assert_eq!(table(transfer).constant_color([4, 10], [0, 0]), None, "no extinction");
        // Extinction reaches from entry 4 towards 5, where the colour changes.
        let transfer = transfer.replace("0.4, opacity = 0", "0.4, opacity = 0.1");
        assert_eq!(table(&transfer).constant_color([0, 10], [0, 0]), None);
        assert_eq!(table(&transfer).constant_color([0, 4], [0, 0]), red);
    }

    #[test]
    fn the_device_gets_extinction_and_colours_apart() {
        let table = table("resolution = 2\npoints = [{ value = 0, opacity = 0.5, color = [1, 0.5, 0.25] }]");
        let floats = |bytes: Vec<u8>| bytemuck::pod_collect_to_vec::<u8, f32>(&bytes);
        assert_eq!(floats(table.device_sigmas()), [5.0; 2]);
        assert_eq!(floats(table.device_entries(false)), [1.0, 0.5, 0.25, 5.0, 1.0, 0.5, 0.25, 5.0]);
        let colors = floats(table.device_colors([0.5, 1.0, 2.0]));
        assert_eq!(colors, [0.5, 0.5, 0.5, 0.0, 0.5, 0.5, 0.5, 0.0]);
    }
}
