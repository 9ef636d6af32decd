//! Environment maps: radiance by direction, a latitude-longitude EXR.
//!
//! Row v and column u of a texel centre give θ = π·v, φ = 2π·u and
//! ω = (sinθ cosφ, cosθ, sinθ sinφ): the first row is up (+y).

use std::{f64::consts::PI, path::Path};

use super::{exr::read_exr, types::Picture};
use crate::error::{Error, Result};

/// The most texels of a map: 2²⁶, or 11585×5793, 768 MiB in memory.
pub const MAX_TEXELS: usize = 1 << 26;

/// A latitude-longitude map of radiance. Every value is finite and at least 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Texels around, φ from 0 to 2π.
    pub width: usize,
    /// Texels from the zenith (+y) to the nadir.
    pub height: usize,
    /// Linear radiance, row by row from the top, `width · height` texels.
    pub rgb: Vec<[f32; 3]>,
    /// What was repaired or looks odd in the file, one sentence each, for the user.
    pub notes: Vec<String>,
}

impl Environment {
    /// Reads a map from an EXR file (any compression that [`read_exr`] decodes).
    ///
    /// Texels with a value that is not finite are replaced by 0 and negative values are raised to
    /// 0; [`Environment::notes`] says how many.
    ///
    /// # Errors
    /// [`Error::Input`] where the file is unreadable, has no colour or more than [`MAX_TEXELS`].
    pub fn read(path: &Path) -> Result<Self> {
        let picture = read_exr(path)?;
        Self::from_picture(&picture).map_err(|what| Error::Input(format!("{}: {what}", path.display())))
    }

    /// Takes a map from a picture with `R G B` or `Y`, repaired as in [`Environment::read`].
    ///
    /// # Errors
    /// What is wrong and what would be right, as a clause without the path.
    pub fn from_picture(picture: &Picture) -> Result<Self, String> {
        picture.validate()?;
        let (width, height) = (picture.width, picture.height);
        if width * height > MAX_TEXELS {
            return Err(format!(
                "an environment map of {width}×{height}; at most {MAX_TEXELS} texels, so scale it down"
            ));
        }
        let planes = picture.colour().ok_or("no channels R, G, B or Y; an environment map needs colour")?;
        let plane = |c: usize| &planes[c.min(planes.len() - 1)].data;
        let (r, g, b) = (plane(0), plane(1), plane(2));
        let mut rgb: Vec<[f32; 3]> = (0..r.len()).map(|i| [r[i], g[i], b[i]]).collect();
        let mut notes = repair(&mut rgb);
        if width != 2 * height {
            notes.push(format!("{width}×{height} is not 2:1; it is stretched over the whole sphere"));
        }
        Ok(Self { width, height, rgb, notes })
    }

    /// The mean radiance over the sphere per channel, texels weighted by their solid angle.
    pub fn mean_radiance(&self) -> [f64; 3] {
        let edge = |y: usize| (PI * y as f64 / self.height as f64).cos();
        let mut sum = [0.0; 3];
        for (row, texels) in self.rgb.chunks(self.width).enumerate() {
            let weight = (edge(row) - edge(row + 1)) / (2.0 * self.width as f64);
            for texel in texels {
                for (sum, value) in sum.iter_mut().zip(texel) {
                    *sum += weight * f64::from(*value);
                }
            }
        }
        sum
    }

    /// The map at a smaller size, averaged exactly with the solid angle as weight, so that the
    /// integral of radiance over the sphere stays the same.
    ///
    /// # Errors
    /// [`Error::Input`] where a side is 0 or larger than the map's.
    pub fn downsample(&self, width: usize, height: usize) -> Result<Self> {
        if !(1..=self.width).contains(&width) || !(1..=self.height).contains(&height) {
            return Err(Error::Input(format!(
                "cannot reduce an environment map of {}×{} to {width}×{height}; give sides from 1 to the map's",
                self.width, self.height
            )));
        }
        let across = overlaps(self.width, width, |u| u);
        // The solid angle between two latitudes goes with the difference of cosθ.
        let down = overlaps(self.height, height, |v| -(PI * v).cos());
        let mut rgb = Vec::with_capacity(width * height);
        for rows in &down {
            for columns in &across {
                rgb.push(self.weighted_mean(rows, columns));
            }
        }
        Ok(Self { width, height, rgb, notes: self.notes.clone() })
    }

    fn weighted_mean(&self, rows: &[(usize, f64)], columns: &[(usize, f64)]) -> [f32; 3] {
        let mut sum = [0.0; 3];
        for &(y, by_row) in rows {
            for &(x, by_column) in columns {
                for (sum, value) in sum.iter_mut().zip(self.rgb[y * self.width + x]) {
                    *sum += by_row * by_column * f64::from(value);
                }
            }
        }
        sum.map(|mean| mean as f32)
    }
}

/// Removes what is no radiance; the notes say what was there.
fn repair(rgb: &mut [[f32; 3]]) -> Vec<String> {
    let (mut broken, mut negative) = (0_usize, 0_usize);
    for texel in rgb {
        if texel.iter().any(|value| !value.is_finite()) {
            broken += 1;
            *texel = [0.0; 3];
        } else if texel.iter().any(|&value| value < 0.0) {
            negative += 1;
            *texel = texel.map(|value| value.max(0.0));
        }
    }
    let mut notes = Vec::new();
    if broken > 0 {
        notes.push(format!("{broken} texels are not finite and were replaced by 0"));
    }
    if negative > 0 {
        notes.push(format!("{negative} texels have negative values, which were raised to 0"));
    }
    notes
}

/// For each of `to` cells of [0, 1]: the cells of `from` that it overlaps, with weights of sum 1.
/// `measure` is the increasing function whose differences are the size of an interval.
fn overlaps(from: usize, to: usize, measure: impl Fn(f64) -> f64) -> Vec<Vec<(usize, f64)>> {
    // Edges compared as integers in units of 1/(from·to): no cell is missed or doubled by rounding.
    let cell = |j: usize| {
        let (start, end) = (j * from, (j + 1) * from);
        let total = measure(end as f64 / (from * to) as f64) - measure(start as f64 / (from * to) as f64);
        let first = start / to;
        let last = end.div_ceil(to);
        let weight = |i: usize| {
            let low = start.max(i * to) as f64 / (from * to) as f64;
            let high = end.min((i + 1) * to) as f64 / (from * to) as f64;
            (measure(high) - measure(low)) / total
        };
        (first..last).map(|i| (i, weight(i))).collect()
    };
    (0..to).map(cell).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫ L dω of a map, texel by texel.
    fn power(map: &Environment) -> f64 {
        let edge = |y: usize| (PI * y as f64 / map.height as f64).cos();
        let mut sum = 0.0;
        for (i, texel) in map.rgb.iter().enumerate() {
            let y = i / map.width;
            sum += (edge(y) - edge(y + 1)) * 2.0 * PI / map.width as f64 * f64::from(texel[1]);
        }
        sum
    }

    fn map(width: usize, height: usize, value: impl Fn(usize) -> f32) -> Environment {
        let values: Vec<f32> = (0..width * height).map(value).collect();
        Environment::from_picture(&Picture::new(width, height).with_channel("Y", values)).unwrap()
    }

    #[test]
    fn downsampling_keeps_a_constant_and_the_power() {
        let flat = map(10, 5, |_| 3.5);
        assert!((power(&flat) - 4.0 * PI * 3.5).abs() < 1e-9);
        let uneven = map(30, 15, |i| ((i * 7919) % 101) as f32);
        for (width, height) in [(30, 15), (10, 5), (7, 4), (1, 1), (29, 14), (30, 2)] {
            let small = flat.downsample(width.min(10), height.min(5)).unwrap();
            assert!(small.rgb.iter().flatten().all(|value| (value - 3.5).abs() < 1e-6));
            let small = uneven.downsample(width, height).unwrap();
            assert_eq!(small.rgb.len(), width * height);
            let (before, after) = (power(&uneven), power(&small));
            // Each texel is rounded to f32: relative error below 2⁻²⁴.
            assert!((after / before - 1.0).abs() < 6e-8, "{width}×{height}: {before} {after}");
        }
        assert_eq!(uneven.downsample(30, 15).unwrap().rgb, uneven.rgb);
    }

    #[test]
    fn two_rows_of_four_weigh_by_solid_angle() {
        // cosθ at the row edges: 1, 1/√2, 0. Upper half mean: a(1−1/√2) + b/√2.
        let small = map(1, 4, |i| [1.0, 5.0, 0.0, 0.0][i]).downsample(1, 2).unwrap();
        let root = 0.5_f64.sqrt();
        assert!((f64::from(small.rgb[0][0]) - (1.0 - root + 5.0 * root)).abs() < 1e-6);
    }

    #[test]
    fn impossible_sizes_are_errors() {
        for (width, height) in [(0, 1), (1, 0), (11, 1), (1, 6)] {
            assert_eq!(map(10, 5, |_| 1.0).downsample(width, height).unwrap_err().exit_code(), 2);
        }
    }

    #[test]
    fn repairs_are_counted() {
        let values = vec![f32::NAN, 1.0, f32::INFINITY, -2.0, 0.0, -0.0, 3.0, 4.0];
        let map = Environment::from_picture(&Picture::new(4, 2).with_channel("Y", values)).unwrap();
        assert_eq!(
            map.rgb.iter().map(|texel| texel[0]).collect::<Vec<_>>(),
            [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 3.0, 4.0]
        );
        assert_eq!(map.notes.len(), 2);
        assert!(
            map.notes[0].starts_with("2 texels") && map.notes[1].starts_with("1 texels"),
            "{:?}",
            map.notes
        );
        let depth = Picture::new(1, 1).with_channel("Z", vec![1.0]);
        assert!(Environment::from_picture(&depth).unwrap_err().contains("colour"));
    }
}
