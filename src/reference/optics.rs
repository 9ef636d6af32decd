//! Smooth boundaries by the book: Snell's law and Fresnel's equations (Born and Wolf, section 1.5), in the form
//! that states them.

use glam::DVec3;

/// What a boundary does to a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Boundary {
    /// Reflected share of unpolarised light.
    pub reflectance: f64,
    /// Unit direction of what is reflected.
    pub reflected: DVec3,
    /// Unit direction of what passes; `None` where all is reflected.
    pub refracted: Option<DVec3>,
}

/// Index at a wavelength in micrometres by Cauchy's equation a + b / λ² + c / λ⁴.
pub fn cauchy([a, b, c]: [f64; 3], wavelength: f64) -> f64 {
    a + b / wavelength.powi(2) + c / wavelength.powi(4)
}

/// Share of unpolarised light reflected at a boundary from index `from` to `to`, for the cosine on the side of the ray.
pub fn fresnel(from: f64, to: f64, cosine: f64) -> f64 {
    let sine2 = (from / to).powi(2) * (1.0 - cosine * cosine);
    if sine2 > 1.0 {
        return 1.0;
    }
    let passed = (1.0 - sine2).sqrt();
    if from == to {
        return 0.0;
    }
    let across = (from * cosine - to * passed) / (from * cosine + to * passed);
    let along = (from * passed - to * cosine) / (from * passed + to * cosine);
    0.5 * (across * across + along * along)
}

/// A ray with unit `direction` at a boundary with outward unit `normal` of a body with `index` relative to its
/// surroundings; it is inside where it goes along the normal.
pub fn boundary(index: f64, direction: DVec3, normal: DVec3) -> Boundary {
    let inside = direction.dot(normal) > 0.0;
    let (from, to) = if inside { (index, 1.0) } else { (1.0, index) };
    let facing = if inside { -normal } else { normal };
    let cosine = -direction.dot(facing);
    let eta = from / to;
    let sine2 = eta * eta * (1.0 - cosine * cosine);
    let refracted = (sine2 <= 1.0).then(|| eta * direction + (eta * cosine - (1.0 - sine2).sqrt()) * facing);
    Boundary {
        reflectance: fresnel(from, to, cosine),
        reflected: direction + 2.0 * cosine * facing,
        refracted,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        // ((n - 1) / (n + 1))^2 upright; nothing of one polarisation at Brewster's angle, tan = n; all when grazing.
        let brewster = 1.5_f64.atan();
        let across = ((1.5_f64.powi(2) - 1.0) / (1.5_f64.powi(2) + 1.0)).powi(2);
        assert!((fresnel(1.0, 1.5, 1.0) - 0.04).abs() < 1e-15);
        assert!((fresnel(1.0, 1.5, brewster.cos()) - 0.5 * across).abs() < 1e-15);
        assert_eq!(fresnel(1.0, 1.5, 0.0), 1.0);
        assert_eq!(fresnel(1.5, 1.0, 0.7), 1.0, "beyond the critical angle, whose cosine is 0.745");
        assert!((cauchy([1.5, 0.004, 1e-4], 0.5) - 1.5176).abs() < 1e-15);
    }

    #[test]
    fn directions_keep_what_is_along_the_surface() {
        let direction = DVec3::new(0.6, 0.0, -0.8);
        let found = boundary(1.5, direction, DVec3::Z);
        assert!((found.refracted.unwrap() - DVec3::new(0.4, 0.0, -(0.84_f64).sqrt())).length() < 1e-15);
        assert!((found.reflected - DVec3::new(0.6, 0.0, 0.8)).length() < 1e-15);
        // sin = 0.8 > 1 / 1.5 inside.
        assert_eq!(boundary(1.5, DVec3::new(0.8, 0.0, 0.6), DVec3::Z).refracted, None);
    }
}
