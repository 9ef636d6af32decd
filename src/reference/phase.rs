//! Phase functions: per steradian, normalised over the sphere, of the cosine `mu` between the directions of
//! propagation before and after.

use std::f64::consts::PI;

/// The same in every direction.
pub fn isotropic() -> f64 {
    0.25 / PI
}

/// Henyey and Greenstein 1941, with mean cosine `g`, |g| < 1.
pub fn henyey_greenstein(g: f64, mu: f64) -> f64 {
    (1.0 - g * g) / (4.0 * PI * squared_distance(g, mu).powf(1.5))
}

/// Rayleigh's, for unpolarised light.
pub fn rayleigh(mu: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + mu * mu)
}

/// Two Henyey–Greenstein lobes, the first with this share.
pub fn two_lobe(g: [f64; 2], weight: f64, mu: f64) -> f64 {
    weight * henyey_greenstein(g[0], mu) + (1.0 - weight) * henyey_greenstein(g[1], mu)
}

/// The probability that Henyey and Greenstein's cosine is at most `mu`, in a form without a division by `g`.
pub fn henyey_greenstein_below(g: f64, mu: f64) -> f64 {
    let distance = squared_distance(g, mu).sqrt();
    (1.0 - g) * (1.0 + mu) / (distance * (1.0 + g + distance))
}

/// The probability that Rayleigh's cosine is at most `mu`.
pub fn rayleigh_below(mu: f64) -> f64 {
    (4.0 + 3.0 * mu + mu.powi(3)) / 8.0
}

/// 1 + g² − 2 g μ as a sum of positive terms.
fn squared_distance(g: f64, mu: f64) -> f64 {
    (1.0 - g.abs()).powi(2) + 2.0 * g.abs() * if g < 0.0 { 1.0 + mu } else { 1.0 - mu }
}

#[cfg(test)]
mod tests {
    use super::super::quadrature::gauss_legendre;
    use super::*;

    /// 2π ∫ f(μ) dμ over pieces that shrink towards both ends, where narrow lobes are.
    fn over_the_sphere(f: impl Fn(f64) -> f64) -> f64 {
        let rule = gauss_legendre(16);
        let mut sum = 0.0;
        for octave in 0..50 {
            // The last piece reaches the end.
            let far = 0.5_f64.powi(octave);
            let near = if octave == 49 { 0.0 } else { far / 2.0 };
            for (x, w) in &rule {
                let distance = near + (far - near) * x;
                sum += (far - near) * w * (f(1.0 - distance) + f(distance - 1.0));
            }
        }
        2.0 * PI * sum
    }

    const PARAMETERS: [f64; 11] = [0.0, 1e-9, -1e-9, 1e-5, -1e-5, 0.5, -0.5, 0.9, -0.9, 0.999, -0.999];

    #[test]
    fn all_are_normalised() {
        // Rounding: 1 - mu has an absolute error of 2^-53, and lobes a width of (1 - |g|)² / 2 = 5e-7.
        let mut integrals = vec![over_the_sphere(|_| isotropic()), over_the_sphere(rayleigh)];
        for g in PARAMETERS {
            integrals.push(over_the_sphere(|mu| henyey_greenstein(g, mu)));
            integrals.push(over_the_sphere(|mu| two_lobe([g, -0.3], 0.7, mu)));
        }
        for integral in integrals {
            assert!((integral - 1.0).abs() < 1e-12, "{integral}");
        }
    }

    #[test]
    fn mean_cosines_are_g() {
        for g in PARAMETERS {
            let mean = over_the_sphere(|mu| mu * henyey_greenstein(g, mu));
            assert!((mean - g).abs() < 1e-12, "{g}: {mean}");
            let mean = over_the_sphere(|mu| mu * two_lobe([g, -0.3], 0.7, mu));
            assert!((mean - (0.7 * g - 0.09)).abs() < 1e-12, "{g}: {mean}");
        }
        assert!(over_the_sphere(|mu| mu * rayleigh(mu)).abs() < 1e-15);
    }

    #[test]
    fn the_usual_forms_hold() {
        for g in PARAMETERS {
            for mu in [-1.0, -0.7, 0.0, 0.3, 1.0] {
                let usual = (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * mu).powf(1.5));
                // The usual bracket is at least (1 - |g|)² >= 1e-6 and loses 1e-16 of it.
                assert!((henyey_greenstein(g, mu) / usual - 1.0).abs() < 1e-9, "{g} {mu}");
            }
        }
    }

    #[test]
    fn probabilities_are_the_integrals_of_densities() {
        let rule = gauss_legendre(16);
        let between = |f: &dyn Fn(f64) -> f64, a: f64, b: f64| {
            2.0 * PI * (b - a) * rule.iter().map(|(x, w)| w * f(a + (b - a) * x)).sum::<f64>()
        };
        for g in [0.0, 1e-9, -1e-5, 0.3, -0.5] {
            for (a, b) in [(-1.0, -0.9), (-0.2, 0.1), (0.4, 0.6), (0.8, 1.0)] {
                let exact = henyey_greenstein_below(g, b) - henyey_greenstein_below(g, a);
                let sum = between(&|mu| henyey_greenstein(g, mu), a, b);
                assert!((sum - exact).abs() < 1e-13, "{g} {a} {b}");
                let exact = rayleigh_below(b) - rayleigh_below(a);
                assert!((between(&rayleigh, a, b) - exact).abs() < 1e-15);
            }
        }
        for g in PARAMETERS {
            assert_eq!((henyey_greenstein_below(g, -1.0), rayleigh_below(-1.0)), (0.0, 0.0));
            assert!((henyey_greenstein_below(g, 1.0) - 1.0).abs() < 1e-12);
            assert_eq!(rayleigh_below(1.0), 1.0);
        }
    }
}
