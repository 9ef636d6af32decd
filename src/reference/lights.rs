//! Direct light at a point: samples of single lights, the environment map, and closed forms of what they sum to.
//!
//! Which light is picked, and which texel of a map, is the caller's: the twins give the density by solid angle that
//! follows from it.

use super::quadrature::gauss_legendre;
use crate::picture::Environment;
use crate::scene::Light;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Light from one direction, as an estimate of ∫ L dω.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Unit, towards the light.
    pub direction: DVec3,
    /// To the light, scene units.
    pub distance: f64,
    /// Radiance over density, or the irradiance of a light without extent.
    pub weight: [f64; 3],
    /// Density by solid angle; 0 for a light without extent.
    pub pdf: f64,
}

/// The sample of a light at `u` ∈ [0, 1)² of it; `None` for a point behind a rectangle.
pub fn sample(light: &Light, point: DVec3, u: [f64; 2]) -> Option<LightSample> {
    let towards = |place: DVec3| ((place - point).normalize(), (place - point).length());
    match *light {
        Light::Directional { direction, irradiance } => Some(LightSample {
            direction: -direction.normalize(),
            distance: f64::INFINITY,
            weight: irradiance,
            pdf: 0.0,
        }),
        Light::Point { position, intensity } => {
            let (direction, distance) = towards(position);
            let weight = intensity.map(|i| i / distance.powi(2));
            Some(LightSample { direction, distance, weight, pdf: 0.0 })
        }
        Light::Rectangle { centre, edge_u, edge_v, radiance } => {
            let (direction, distance) = towards(centre + (u[0] - 0.5) * edge_u + (u[1] - 0.5) * edge_v);
            // Area times cosine is the length of the normal along the direction.
            let facing = -edge_u.cross(edge_v).dot(direction);
            let pdf = distance.powi(2) / facing;
            let weight = radiance.map(|l| l / pdf);
            (facing > 0.0).then_some(LightSample { direction, distance, weight, pdf })
        }
    }
}

/// The solid angle of a parallelogram from `point`, negative from behind (Van Oosterom and Strackee 1983).
pub fn rectangle_solid_angle(centre: DVec3, edge_u: DVec3, edge_v: DVec3, point: DVec3) -> f64 {
    let corner = |a: f64, b: f64| centre + a * edge_u + b * edge_v - point;
    let triangle = |a: DVec3, b: DVec3, c: DVec3| {
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        2.0 * f64::atan2(-a.dot(b.cross(c)), below)
    };
    let [a, b, c, d] = [corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)];
    triangle(a, b, c) + triangle(a, c, d)
}

/// An environment map around the scene.
#[derive(Clone, Copy, Debug)]
pub struct Sky<'a> {
    /// Its texels.
    pub map: &'a Environment,
    /// Factor on its radiance.
    pub intensity: f64,
    /// Rotation about +y, radians.
    pub rotation: f64,
}

impl Sky<'_> {
    /// Column and row of a direction, continuous: texel i spans i..i + 1.
    pub fn place(&self, direction: DVec3) -> [f64; 2] {
        let azimuth = f64::atan2(direction.z, direction.x) - self.rotation;
        let from_pole = f64::atan2(direction.x.hypot(direction.z), direction.y);
        [(azimuth / TAU).rem_euclid(1.0) * self.map.width as f64, from_pole / PI * self.map.height as f64]
    }

    /// The direction of a place.
    pub fn direction(&self, [x, y]: [f64; 2]) -> DVec3 {
        let azimuth = TAU * x / self.map.width as f64 + self.rotation;
        let from_pole = PI * y / self.map.height as f64;
        DVec3::new(from_pole.sin() * azimuth.cos(), from_pole.cos(), from_pole.sin() * azimuth.sin())
    }

    /// Radiance at a place: bilinear between texel centres, around in x, constant beyond the last centres in y.
    pub fn radiance(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        let (left, top) = ((x - 0.5).floor(), (y - 0.5).floor());
        let (fx, fy) = (x - 0.5 - left, y - 0.5 - top);
        let texel = |column: f64, row: f64| {
            let column = column.rem_euclid(self.map.width as f64) as usize;
            let row = row.clamp(0.0, (self.map.height - 1) as f64) as usize;
            self.map.rgb[row * self.map.width + column].map(f64::from)
        };
        let (a, b) = (texel(left, top), texel(left + 1.0, top));
        let (c, d) = (texel(left, top + 1.0), texel(left + 1.0, top + 1.0));
        std::array::from_fn(|i| {
            let (above, below) = (a[i] + fx * (b[i] - a[i]), c[i] + fx * (d[i] - c[i]));
            self.intensity * (above + fy * (below - above))
        })
    }

    /// The solid angle of each texel of a row.
    pub fn solid_angle(&self, row: usize) -> f64 {
        let edge = |row: usize| (PI * row as f64 / self.map.height as f64).cos();
        TAU / self.map.width as f64 * (edge(row) - edge(row + 1))
    }

    /// ∫ L dω over the sphere.
    pub fn fluence(&self) -> [f64; 3] {
        // Per half texel the map is linear along both axes: the middle is the mean in x, and 8 nodes integrate
        // (a + b θ) sin θ over at most π/2 to 10⁻¹⁶.
        let nodes = gauss_legendre(8);
        let mut sum = [0.0; 3];
        for half_row in 0..2 * self.map.height {
            for &(node, weight) in &nodes {
                let y = 0.5 * (half_row as f64 + node);
                let ring = TAU / (2 * self.map.width) as f64 * PI / (2 * self.map.height) as f64;
                let measure = weight * ring * (PI * y / self.map.height as f64).sin();
                for half_column in 0..2 * self.map.width {
                    let value = self.radiance([0.5 * (half_column as f64 + 0.5), y]);
                    sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += measure * value);
                }
            }
        }
        sum
    }

    /// How likely each texel should be, row by row, sum 1: the mean over its four quarters of the mean of the
    /// channels, times the solid angle.
    pub fn probabilities(&self) -> Vec<f64> {
        let weight = |i: usize| {
            let (x, y) = (i % self.map.width, i / self.map.width);
            // Each quarter is bilinear: its middle is its mean.
            let quarters = [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)];
            let sum: f64 =
                quarters.iter().flat_map(|(dx, dy)| self.radiance([x as f64 + dx, y as f64 + dy])).sum();
            sum * self.solid_angle(y)
        };
        let weights: Vec<f64> = (0..self.map.rgb.len()).map(weight).collect();
        let total: f64 = weights.iter().sum();
        weights.iter().map(|weight| weight / total).collect()
    }

    /// The place in `texel` of the numbers `rest` ∈ (0, 1)²: directions are uniform over the texel.
    pub fn place_in_texel(&self, [x, y]: [usize; 2], rest: [f64; 2]) -> [f64; 2] {
        let edge = |row: usize| (PI * row as f64 / self.map.height as f64).cos();
        let cosine = edge(y) + rest[1] * (edge(y + 1) - edge(y));
        [x as f64 + rest[0], cosine.acos() / PI * self.map.height as f64]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::random::{philox4x32, uniform};

    fn map(width: usize, height: usize) -> Environment {
        let value = |i: usize| uniform(philox4x32([i as u32, 7, 0, 0], [1, 2])[0]) as f32;
        let rgb = (0..width * height).map(|i| [value(3 * i), value(3 * i + 1), value(3 * i + 2)]).collect();
        Environment { width, height, rgb, notes: Vec::new() }
    }

    #[test]
    fn places_and_directions_are_inverse() {
        let map = map(8, 4);
        let sky = Sky { map: &map, intensity: 1.0, rotation: 5.0 };
        for place in [[0.01, 0.02], [7.9, 3.9], [3.3, 1.7]] {
            let back = sky.place(sky.direction(place));
            assert!((0..2).all(|i| (back[i] - place[i]).abs() < 1e-13), "{place:?} {back:?}");
        }
        assert!(sky.direction([4.0, 0.0]).distance(DVec3::Y) < 1e-15, "the first row is up");
    }

    #[test]
    fn a_constant_sky_shines_four_pi() {
        let mut map = map(5, 3);
        map.rgb.fill([0.5, 1.0, 2.0]);
        let sky = Sky { map: &map, intensity: 3.0, rotation: 1.0 };
        for (found, radiance) in sky.fluence().into_iter().zip([1.5, 3.0, 6.0]) {
            assert!((found / (4.0 * PI * radiance) - 1.0).abs() < 1e-14);
        }
        for (i, probability) in sky.probabilities().into_iter().enumerate() {
            assert!((probability - sky.solid_angle(i / 5) / (4.0 * PI)).abs() < 1e-15);
        }
    }

    #[test]
    fn texels_sum_to_the_fluence() {
        // ∫ L dω with directions uniform in each texel, as samples have them, by 16×16 midpoints: their error falls
        // with the square of the spacing.
        let map = map(4, 3);
        let sky = Sky { map: &map, intensity: 1.0, rotation: 0.0 };
        let error = |n: usize| {
            let mut sum = 0.0;
            for i in 0..12 * n * n {
                let (texel, part) = ([i / (n * n) % 4, i / (n * n) / 4], i % (n * n));
                let rest = [part % n, part / n].map(|k| (k as f64 + 0.5) / n as f64);
                sum += sky.radiance(sky.place_in_texel(texel, rest))[1] * sky.solid_angle(texel[1])
                    / (n * n) as f64;
            }
            (sum / sky.fluence()[1] - 1.0).abs()
        };
        assert!(error(64) < 1e-5 && error(16) < 20.0 * error(64) + 1e-9, "{} {}", error(16), error(64));
    }

    #[test]
    fn a_square_over_its_middle_has_a_sixth_of_the_sphere() {
        // The faces of a cube seen from its centre.
        let sides = [(DVec3::X, DVec3::Y), (DVec3::Y, DVec3::Z), (DVec3::Z, DVec3::X)];
        for (u, v) in sides {
            let centre = -0.5 * u.cross(v);
            let seen = rectangle_solid_angle(centre, u, v, DVec3::ZERO);
            assert!((seen - 4.0 * PI / 6.0).abs() < 1e-14, "{seen}");
            assert!((rectangle_solid_angle(-centre, u, v, DVec3::ZERO) + seen).abs() < 1e-14, "from behind");
        }
    }

    #[test]
    fn samples_of_a_rectangle_sum_to_its_solid_angle() {
        let (centre, edge_u, edge_v) = (DVec3::new(1.0, 3.0, 0.5), DVec3::X, DVec3::new(0.5, 0.3, 2.0));
        let light = Light::Rectangle { centre, edge_u, edge_v, radiance: [2.0; 3] };
        let seen = rectangle_solid_angle(centre, edge_u, edge_v, DVec3::ZERO);
        let nodes = gauss_legendre(20);
        let mut sum = 0.0;
        for &(a, wa) in &nodes {
            for &(b, wb) in &nodes {
                sum += wa * wb * sample(&light, DVec3::ZERO, [a, b]).unwrap().weight[0];
            }
        }
        assert!((sum / (2.0 * seen) - 1.0).abs() < 1e-13, "{sum} {seen}");
        let behind = DVec3::new(1.0, 6.0, 0.5);
        assert_eq!(sample(&light, behind, [0.5; 2]), None);
    }
}
