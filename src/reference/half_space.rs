//! Isotropic scattering without far boundaries: the half space (Chandrasekhar's H-function) and the point source in an
//! infinite medium. Lengths in mean free paths.

use super::quadrature::gauss_legendre;
use std::f64::consts::PI;

/// Chandrasekhar's H-function of isotropic scattering for an albedo in 0..=1 at the cosine `mu`:
/// ln H = −(μ/π) ∫₀^∞ ln(1 − ϖ arctan(x)/x) / (1 + μ²x²) dx, here with x = tan φ.
pub fn h_function(albedo: f64, mu: f64) -> f64 {
    let integrand = |phi: f64| {
        let (sin, cos) = phi.sin_cos();
        // 1 − φ cot φ, by its series where it would cancel.
        let missing = if phi < 1e-2 {
            phi * phi / 3.0 + phi.powi(4) / 45.0 + 2.0 * phi.powi(6) / 945.0
        } else {
            1.0 - phi * cos / sin
        };
        (1.0 - albedo + albedo * missing).ln() / (cos * cos + mu * mu * sin * sin)
    };
    // The logarithm is singular at 0 for albedo 1, and the denominator is small at π/2 for small μ.
    let half = |f: &dyn Fn(f64) -> f64| graded(0.25 * PI, f);
    let integral = half(&integrand) + half(&|phi| integrand(0.5 * PI - phi));
    (-mu / PI * integral).exp()
}

/// Part of collimated light at the cosine `mu` that a half space returns: 1 − √(1 − ϖ) H(μ).
pub fn plane_albedo(albedo: f64, mu: f64) -> f64 {
    1.0 - (1.0 - albedo).sqrt() * h_function(albedo, mu)
}

/// Fluence at a distance from an isotropic source of power 1 in an infinite medium of albedo in 0..1, exclusive: the
/// inverse transform of arctan(k)/k / (1 − ϖ arctan(k)/k), by its pole and its cut (Case and Zweifel 1967).
pub fn fluence(albedo: f64, distance: f64) -> f64 {
    let kappa = diffusion_exponent(albedo);
    let square = kappa * kappa;
    let pole = 2.0 * square * (1.0 - square) / (albedo * (square + albedo - 1.0)) * (-kappa * distance).exp();
    // ∫₁^∞ e^{−rs} / D(1/s) ds with s = 1 + u, down to e^{−40}.
    let cut = graded(40.0 / distance, &|u| {
        let mu = 1.0 / (1.0 + u);
        let inverse_tanh = 0.5 * ((1.0 + mu) * (1.0 + u) / u).ln();
        let real = 1.0 - albedo * mu * inverse_tanh;
        (-distance * (1.0 + u)).exp() / (real * real + (0.5 * PI * albedo * mu).powi(2))
    });
    (pole + cut) / (4.0 * PI * distance)
}

/// The root κ of ϖ artanh(κ) = κ in 0..1, for an albedo in 0..1, exclusive: far away the fluence falls like e^{−κr}/r.
pub fn diffusion_exponent(albedo: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..200 {
        let middle: f64 = 0.5 * (low + high);
        if albedo * middle.atanh() < middle {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// ∫₀^end f, on panels that halve towards 0, where f may be singular like a logarithm.
fn graded(end: f64, f: &dyn Fn(f64) -> f64) -> f64 {
    let rule = gauss_legendre(24);
    let panel = |k: i32| {
        let (from, to) = (end * 0.5f64.powi(k + 1), end * 0.5f64.powi(k));
        rule.iter().map(|(x, w)| w * (to - from) * f(from + x * (to - from))).sum::<f64>()
    };
    (0..60).map(panel).sum()
}

#[cfg(test)]
mod tests {
    use super::super::slab::Slab;
    use super::*;
    use serde_json::Value;

    fn rows(table: &str) -> Vec<Value> {
        let truths: Value = serde_json::from_str(include_str!("../../tests/truths.json")).unwrap();
        truths[table]["rows"].as_array().unwrap().clone()
    }

    #[test]
    fn h_and_plane_albedo_are_as_published() {
        for row in rows("semi_infinite_isotropic") {
            let [w, mu, h, r] = ["w", "mu0", "H", "R"].map(|key| row[key].as_f64().unwrap());
            assert!((h_function(w, mu) / h - 1.0).abs() < 1e-12, "{row} {}", h_function(w, mu));
            assert!((plane_albedo(w, mu) - r).abs() < 1e-12, "{row}");
        }
    }

    #[test]
    fn fluences_are_as_published() {
        for row in rows("point_source_infinite") {
            let [w, r, phi] = ["w", "r", "phi"].map(|key| row[key].as_f64().unwrap());
            assert!((fluence(w, r) / phi - 1.0).abs() < 1e-12, "{row} {}", fluence(w, r));
        }
    }

    #[test]
    fn thick_slabs_tend_to_the_half_space() {
        // Without absorption T = H(μ)/√3 / (τ/... ): by the Milne problem T(μ) = H(μ) / (√3 (τ + 2·0.710446)).
        let thick = Slab { tau: 100.0, albedo: 1.0, g: 0.0 }.responses(&[1.0, 0.3]);
        for (response, mu) in thick.into_iter().zip([1.0, 0.3]) {
            let milne = h_function(1.0, mu) / (3f64.sqrt() * (100.0 + 2.0 * 0.710_446_089_8));
            assert!((response.transmitted / milne - 1.0).abs() < 1e-6, "{response:?} {milne}");
        }
        let absorbing = Slab { tau: 40.0, albedo: 0.9, g: 0.0 }.responses(&[1.0, 0.1]);
        for (response, mu) in absorbing.into_iter().zip([1.0, 0.1]) {
            assert!((response.reflected - plane_albedo(0.9, mu)).abs() < 1e-7, "{response:?}");
        }
    }
}
