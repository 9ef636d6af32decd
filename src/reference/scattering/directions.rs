//! Phase functions and how to draw from them, as textbooks have them. Directions are those of propagation.

use super::Random;
use crate::scene::Phase;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// The phase function per steradian at the cosine `mu` of the deflection.
pub fn phase_value(phase: &Phase, mu: f64) -> f64 {
    let henyey_greenstein = |g: f64| (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * mu).powf(1.5));
    match *phase {
        Phase::Isotropic => 0.25 / PI,
        Phase::HenyeyGreenstein { g } => henyey_greenstein(g),
        Phase::Rayleigh => 3.0 / (16.0 * PI) * (1.0 + mu * mu),
        Phase::TwoLobe { g: [first, second], weight } => {
            weight * henyey_greenstein(first) + (1.0 - weight) * henyey_greenstein(second)
        }
    }
}

/// A direction of that density about `direction`.
pub fn sample_phase(phase: &Phase, direction: DVec3, random: &mut Random) -> DVec3 {
    let mu = sample_cosine(phase, random);
    let (sin, cos) = (TAU * random.uniform()).sin_cos();
    let side = direction.any_orthonormal_vector();
    let third = direction.cross(side);
    let radius = (1.0 - mu * mu).max(0.0).sqrt();
    (mu * direction + radius * (cos * side + sin * third)).normalize()
}

fn sample_cosine(phase: &Phase, random: &mut Random) -> f64 {
    match *phase {
        Phase::Isotropic | Phase::HenyeyGreenstein { g: 0.0 } => 2.0 * random.uniform() - 1.0,
        Phase::HenyeyGreenstein { g } => {
            let q = (1.0 - g * g) / (1.0 - g + 2.0 * g * random.uniform());
            ((1.0 + g * g - q * q) / (2.0 * g)).clamp(-1.0, 1.0)
        }
        Phase::Rayleigh => loop {
            let mu = 2.0 * random.uniform() - 1.0;
            if 2.0 * random.uniform() < 1.0 + mu * mu {
                return mu;
            }
        },
        Phase::TwoLobe { g, weight } => {
            let g = if random.uniform() < weight { g[0] } else { g[1] };
            sample_cosine(&Phase::HenyeyGreenstein { g }, random)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::quadrature::adaptive;
    use super::*;

    const PHASES: [Phase; 6] = [
        Phase::Isotropic,
        Phase::HenyeyGreenstein { g: 0.7 },
        Phase::HenyeyGreenstein { g: -0.4 },
        Phase::HenyeyGreenstein { g: 0.0 },
        Phase::Rayleigh,
        Phase::TwoLobe { g: [0.8, -0.3], weight: 0.6 },
    ];

    #[test]
    fn they_integrate_to_one() {
        for phase in PHASES {
            let sum = adaptive(-1.0, 1.0, &|mu| TAU * phase_value(&phase, mu));
            assert!((sum - 1.0).abs() < 1e-12, "{phase:?} {sum}");
        }
    }

    #[test]
    fn samples_have_the_moments_of_the_density() {
        let direction = DVec3::new(1.0, -2.0, 0.5).normalize();
        for phase in PHASES {
            let count = 100_000;
            let cosines: Vec<f64> = (0..count)
                .map(|path| sample_phase(&phase, direction, &mut Random::new(1, 0, path)).dot(direction))
                .collect();
            for power in 1..=3 {
                let moment = |k: i32| adaptive(-1.0, 1.0, &|mu| TAU * mu.powi(k) * phase_value(&phase, mu));
                let exact = moment(power);
                let sigma = ((moment(2 * power) - exact * exact) / f64::from(count)).sqrt();
                let mean = cosines.iter().map(|mu| mu.powi(power)).sum::<f64>() / f64::from(count);
                // 18 moments: beyond 4.5σ once in 8000 sets.
                assert!((mean - exact).abs() < 4.5 * sigma, "{phase:?} {power}: {mean} {exact} ± {sigma}");
            }
        }
    }
}
