//! The trilinear field of a volume, seen through its window.

use super::camera::Ray;
use super::cubic::Cubic;
use crate::volume::Volume;
use glam::DVec3;

/// A grid of window values in space: voxel i is centred at origin + (i + ½)·spacing.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Voxels per axis.
    pub dims: [usize; 3],
    /// Voxel spacing.
    pub spacing: DVec3,
    /// Low corner of the box.
    pub origin: DVec3,
    /// Window values (0 at the window's low end, 1 at its high end), not clamped, x fastest.
    pub values: Vec<f64>,
}

/// A piece of a ray inside one cell of the field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// Where it starts, distance along the ray.
    pub start: f64,
    /// Where it ends.
    pub end: f64,
    /// The field from start (0) to end (1).
    pub cubic: Cubic,
}

impl Piece {
    /// Distance along the ray at a fraction of the piece.
    pub fn at(&self, s: f64) -> f64 {
        self.start + s * (self.end - self.start)
    }
}

impl Field {
    /// The field of `volume` through the window `(lo, hi)` in data units. NaN counts as the low end, infinities as
    /// the end they point to.
    pub fn new(volume: &Volume, origin: DVec3, spacing: DVec3, (lo, hi): (f64, f64)) -> Self {
        let values = (0..volume.voxels.len()).map(|index| {
            let stored = volume.voxels.get(index).unwrap_or(f64::NAN);
            let data = volume.slope * stored + volume.intercept;
            if data.is_nan() {
                0.0
            } else if data.is_infinite() {
                f64::from(data > 0.0)
            } else {
                (data - lo) / (hi - lo)
            }
        });
        Self { dims: volume.dims, spacing, origin, values: values.collect() }
    }

    /// Extent of the box.
    pub fn size(&self) -> DVec3 {
        self.spacing * DVec3::from_array(self.dims.map(|n| n as f64))
    }

    /// The value at a voxel; indices are clamped to the grid.
    fn voxel(&self, index: [i64; 3]) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|axis| index[axis].clamp(0, self.dims[axis] as i64 - 1) as usize);
        self.values[(z * self.dims[1] + y) * self.dims[0] + x]
    }

    /// The field at a point, not clamped to 0..1. Outside the box the border continues.
    pub fn value(&self, point: DVec3) -> f64 {
        let grid = (point - self.origin) / self.spacing - 0.5;
        let cell = grid.floor();
        let fraction = grid - cell;
        let low = cell.to_array().map(|c| c as i64);
        let mut sum = 0.0;
        for corner in 0..8 {
            let offset = [corner & 1, corner >> 1 & 1, corner >> 2];
            let weight = |axis: usize| {
                if offset[axis] == 1 { fraction[axis] } else { 1.0 - fraction[axis] }
            };
            let index = [0, 1, 2].map(|axis| low[axis] + offset[axis] as i64);
            sum += weight(0) * weight(1) * weight(2) * self.voxel(index);
        }
        sum
    }

    /// Central differences over one voxel to either side, per scene unit.
    pub fn gradient(&self, point: DVec3) -> DVec3 {
        let difference = |axis: DVec3| {
            let h = axis * self.spacing;
            (self.value(point + h) - self.value(point - h)) / (2.0 * h.length())
        };
        DVec3::new(difference(DVec3::X), difference(DVec3::Y), difference(DVec3::Z))
    }

    /// Where the ray is inside the box, as distances from its origin; `None` when it misses.
    pub fn clip(&self, ray: &Ray) -> Option<(f64, f64)> {
        let (mut start, mut end) = (ray.start, f64::INFINITY);
        let (low, high) = (self.origin, self.origin + self.size());
        for axis in 0..3 {
            let (o, d) = (ray.origin[axis], ray.direction[axis]);
            if d == 0.0 {
                if o < low[axis] || o > high[axis] {
                    return None;
                }
                continue;
            }
            let (a, b) = ((low[axis] - o) / d, (high[axis] - o) / d);
            start = start.max(a.min(b));
            end = end.min(a.max(b));
        }
        (start < end).then_some((start, end))
    }

    /// The pieces of the ray between the planes through voxel centres: inside each the field is a cubic.
    pub fn pieces(&self, ray: &Ray) -> Vec<Piece> {
        let Some((start, end)) = self.clip(ray) else { return Vec::new() };
        let mut cuts = vec![start, end];
        for axis in 0..3 {
            if ray.direction[axis] == 0.0 {
                continue;
            }
            for voxel in 0..self.dims[axis] {
                let plane = self.origin[axis] + (voxel as f64 + 0.5) * self.spacing[axis];
                let t = (plane - ray.origin[axis]) / ray.direction[axis];
                if t > start && t < end {
                    cuts.push(t);
                }
            }
        }
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
        cuts.windows(2)
            .map(|pair| {
                let sample = |s: f64| self.value(ray.at(pair[0] + s * (pair[1] - pair[0])));
                let cubic = Cubic::through([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(sample));
                Piece { start: pair[0], end: pair[1], cubic }
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::Voxels;

    fn field(dims: [usize; 3], values: Vec<f32>) -> Field {
        let volume = Volume::new(dims, DVec3::ONE, Voxels::F32(values)).unwrap();
        Field::new(&volume, DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.5, 1.0, 2.0), (0.0, 2.0))
    }

    #[test]
    fn voxels_are_at_their_centres_and_the_border_continues() {
        let field = field([2, 2, 1], vec![0.0, 2.0, 4.0, 8.0]);
        let at = |x: f64, y: f64| field.value(DVec3::new(1.0 + 0.5 * x, 2.0 + y, 3.0));
        assert_eq!([at(0.5, 0.5), at(1.5, 0.5), at(0.5, 1.5), at(1.5, 1.5)], [0.0, 1.0, 2.0, 4.0]);
        assert_eq!(at(1.0, 1.0), 1.75);
        assert_eq!([at(0.0, 0.0), at(2.0, 2.0), at(1.0, 0.25)], [0.0, 4.0, 0.5]);
    }

    #[test]
    fn gradients_are_per_scene_unit() {
        let field = field([3, 1, 1], vec![0.0, 2.0, 4.0]);
        assert_eq!(field.gradient(DVec3::new(1.75, 2.5, 4.0)), DVec3::new(2.0, 0.0, 0.0));
    }

    #[test]
    fn pieces_follow_the_field() {
        let values = (0..60).map(|i| ((i * 37) % 23) as f32 / 10.0).collect();
        let field = field([5, 4, 3], values);
        let ray = Ray::towards(DVec3::new(0.9, 1.8, 2.5), DVec3::new(3.6, 6.1, 9.4));
        let pieces = field.pieces(&ray);
        assert!(pieces.len() > 8, "{}", pieces.len());
        for piece in &pieces {
            for k in 0..=10 {
                let s = f64::from(k) / 10.0;
                let exact = field.value(ray.at(piece.at(s)));
                assert!((piece.cubic.value(s) - exact).abs() < 1e-13, "{piece:?} {s}");
            }
        }
        assert!(field.pieces(&Ray::towards(DVec3::ZERO, DVec3::NEG_X)).is_empty());
    }

    #[test]
    fn voxels_that_are_not_finite_go_to_the_ends_of_the_window() {
        let field = field([4, 1, 1], vec![f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.0]);
        assert_eq!(field.values, [0.0, 1.0, 0.0, 0.5]);
    }
}
