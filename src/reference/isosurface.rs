//! The first surface of constant value along a ray, and its local shading.

use super::camera::Ray;
use super::field::Field;
use crate::scene::{Light, Material};
use glam::DVec3;

/// Samples of a cell in which a crossing is looked for, besides the turning points.
const SAMPLES: usize = 16;

/// The distance at which the window value first changes from below `iso` to at least `iso` or back.
///
/// Every cell is sampled densely and at the turning points of its cubic, so that double crossings are seen; the
/// bracket is bisected on the field itself.
pub fn first_hit(field: &Field, ray: &Ray, iso: f64) -> Option<f64> {
    let above = |t: f64| field.value(ray.at(t)) >= iso;
    let (start, _) = field.clip(ray)?;
    let side = above(start);
    let mut before = start;
    for piece in field.pieces(ray) {
        let mut places: Vec<f64> = piece.cubic.turning_points();
        places.extend((1..SAMPLES).map(|k| k as f64 / SAMPLES as f64));
        places.sort_by(f64::total_cmp);
        for t in places.into_iter().map(|s| piece.at(s)) {
            if above(t) != side {
                let (mut low, mut high) = (before, t);
                for _ in 0..80 {
                    let middle = 0.5 * (low + high);
                    if above(middle) == side {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                return Some(0.5 * (low + high));
            }
            before = t;
        }
    }
    None
}

/// The unit normal at a point, on the viewer's side; against the view where the gradient vanishes.
pub fn normal(field: &Field, point: DVec3, view_direction: DVec3) -> DVec3 {
    let normal = field.gradient(point).try_normalize().unwrap_or(-view_direction);
    if normal.dot(view_direction) > 0.0 { -normal } else { normal }
}

/// Radiance of a surface point: ambient·albedo + Σ E·(diffuse·albedo·cos θ + specular·(n·h)^shininess)/π, where E is
/// the irradiance perpendicular to the light. Without lights, irradiance π arrives along the view.
pub fn shade(
    material: &Material,
    lights: &[Light],
    point: DVec3,
    normal: DVec3,
    view_direction: DVec3,
) -> [f64; 3] {
    let headlight = Light::Directional { direction: view_direction, irradiance: [std::f64::consts::PI; 3] };
    let lights = if lights.is_empty() { std::slice::from_ref(&headlight) } else { lights };
    let mut radiance = material.color.map(|c| material.ambient * c);
    for light in lights {
        let (to_light, irradiance) = match *light {
            Light::Point { position, intensity } => {
                let to = position - point;
                (to.normalize(), intensity.map(|i| i / to.length_squared()))
            }
            Light::Directional { direction, irradiance } => (-direction.normalize(), irradiance),
            // Scenes with an isosurface have none.
            Light::Rectangle { .. } => continue,
        };
        let cosine = normal.dot(to_light);
        if cosine <= 0.0 {
            continue;
        }
        let half = (to_light - view_direction).normalize();
        let lobe = material.specular * normal.dot(half).max(0.0).powf(material.shininess);
        for c in 0..3 {
            let diffuse = material.diffuse * material.color[c] * cosine;
            radiance[c] += irradiance[c] * (diffuse + lobe) / std::f64::consts::PI;
        }
    }
    radiance
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slab(values: Vec<f64>) -> Field {
        Field { dims: [values.len(), 1, 1], spacing: DVec3::ONE, origin: DVec3::ZERO, values }
    }

    #[test]
    fn crossings_of_a_line_are_where_it_says() {
        let ray = Ray::towards(DVec3::new(-1.0, 0.5, 0.5), DVec3::new(0.0, 0.5, 0.5));
        let hit = |values, iso| first_hit(&slab(values), &ray, iso);
        // From 0 at x = 0.5 to 1 at x = 1.5: 0.25 at x = 0.75, distance 1.75.
        assert!((hit(vec![0.0, 1.0, 0.0], 0.25).unwrap() - 1.75).abs() < 1e-14);
        assert!((hit(vec![1.0, 1.0, 0.0], 0.25).unwrap() - 3.25).abs() < 1e-14, "from inside");
        assert_eq!(hit(vec![1.0, 1.0], 0.25), None, "the box's face is no surface");
    }

    #[test]
    fn a_headlight_on_a_facing_surface_shows_the_colour() {
        let material =
            Material { color: [0.2, 0.4, 0.6], ambient: 0.0, diffuse: 1.0, specular: 0.0, shininess: 1.0 };
        let seen = shade(&material, &[], DVec3::ZERO, DVec3::Z, DVec3::NEG_Z);
        assert!(seen.iter().zip(material.color).all(|(a, b)| (a - b).abs() < 1e-15));
    }
}
