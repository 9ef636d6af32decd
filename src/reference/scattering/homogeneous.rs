//! Single scattering in a homogeneous box, by quadrature along the camera ray:
//! L = ∫ e^{−σt} σ ϖ p(μ) E(x_t) e^{−σ d(x_t)} dt, where d is the way to the light inside the box.

use super::super::camera::Ray;
use super::super::quadrature::adaptive;
use super::phase_value;
use crate::scene::{Light, Phase};
use glam::DVec3;

/// A homogeneous box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HomogeneousBox {
    /// Low corner.
    pub low: DVec3,
    /// High corner.
    pub high: DVec3,
    /// Extinction per scene unit.
    pub sigma_t: f64,
    /// Single-scattering albedo.
    pub albedo: f64,
    /// How it scatters.
    pub phase: Phase,
}

impl HomogeneousBox {
    /// Where the line is inside the box.
    fn clip(&self, origin: DVec3, direction: DVec3) -> (f64, f64) {
        let (a, b) = ((self.low - origin) / direction, (self.high - origin) / direction);
        // Along axes that the line does not move in, 0/0 and ±∞ leave the other axes to decide.
        let parts = (0..3).filter(|&axis| direction[axis] != 0.0);
        parts.fold((f64::NEG_INFINITY, f64::INFINITY), |(near, far), axis| {
            (near.max(a[axis].min(b[axis])), far.min(a[axis].max(b[axis])))
        })
    }

    /// Light of a point or directional light that a ray which hits the box sees scattered once; no other light.
    pub fn single_scattering(&self, ray: &Ray, light: &Light) -> [f64; 3] {
        let (near, far) = self.clip(ray.origin, ray.direction);
        let near = near.max(ray.start);
        let integrand = |t: f64| {
            let point = ray.at(t);
            let (to, distance, falloff) = match *light {
                Light::Point { position, .. } => {
                    let to = position - point;
                    (to.normalize(), to.length(), 1.0 / to.length_squared())
                }
                Light::Directional { direction, .. } => (-direction, f64::INFINITY, 1.0),
                Light::Rectangle { .. } => (DVec3::Y, 0.0, 0.0),
            };
            let inside = self.clip(point, to).1.clamp(0.0, distance);
            let scattered = self.sigma_t * self.albedo * phase_value(&self.phase, ray.direction.dot(to));
            scattered * falloff * (-self.sigma_t * (t - near + inside)).exp()
        };
        // Cut where the ray is nearest to the light.
        let nearest = match *light {
            Light::Point { position, .. } => (position - ray.origin).dot(ray.direction).clamp(near, far),
            _ => near,
        };
        let sum = adaptive(near, nearest, &integrand) + adaptive(nearest, far, &integrand);
        match *light {
            Light::Point { intensity: color, .. } | Light::Directional { irradiance: color, .. } => {
                color.map(|c| c * sum)
            }
            Light::Rectangle { .. } => [0.0; 3],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    #[test]
    fn the_published_cube_is_met() {
        let truths: Value = serde_json::from_str(include_str!("../../../tests/truths.json")).unwrap();
        for row in truths["single_scattering_cube"]["rows"].as_array().unwrap() {
            let [sigma_t, directional, point] =
                ["sigma_t", "L_dir", "L_point"].map(|key| row[key].as_f64().unwrap());
            let cube = HomogeneousBox {
                low: DVec3::ZERO,
                high: DVec3::ONE,
                sigma_t,
                albedo: 0.8,
                phase: Phase::Isotropic,
            };
            let ray = Ray { origin: DVec3::new(0.5, 0.0, 0.5), direction: DVec3::Y, start: 0.0 };
            let sun = Light::Directional { direction: DVec3::NEG_Z, irradiance: [1.0; 3] };
            let lamp = Light::Point { position: DVec3::new(0.5, 0.5, 2.0), intensity: [1.0; 3] };
            for (light, exact) in [(sun, directional), (lamp, point)] {
                let found = cube.single_scattering(&ray, &light)[1];
                assert!((found / exact - 1.0).abs() < 1e-10, "{row}: {found}");
            }
        }
    }
}
