//! The Marschner–Lobb test signal.
//!
//! Source: S. Marschner & R. Lobb, *An Evaluation of Reconstruction Filters for Volume Rendering*, IEEE
//! Visualization 1994, eqs. (1)–(2).

use super::{Field, FieldError};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// `ρ = [1 − sin(πz/2) + α(1 + ρ_r(√(x²+y²)))] / (2(1+α))` with `ρ_r(r) = cos(2πf cos(πr/2))`.
///
/// Its own coordinates are `q = 2p − 1 ∈ [−1, 1]³`; the values lie in [0, 1]. The usual signal has `f = 6` and
/// `α = 0.25`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MarschnerLobb {
    frequency: f64,
    alpha: f64,
}

impl MarschnerLobb {
    /// # Errors
    /// When the frequency is not in (0, 10⁶] or `alpha` not in [0, 10⁶].
    pub fn new(frequency: f64, alpha: f64) -> Result<Self, FieldError> {
        if !(frequency > 0.0 && frequency <= 1e6) {
            return Err(FieldError::new("frequency", frequency, "it must be greater than 0 and at most 1e6"));
        }
        if !(0.0..=1e6).contains(&alpha) {
            return Err(FieldError::new("alpha", alpha, "it must be from 0 to 1e6"));
        }
        Ok(Self { frequency, alpha })
    }

    fn norm(&self) -> f64 {
        1.0 / (2.0 * (1.0 + self.alpha))
    }
}

impl Field for MarschnerLobb {
    fn value(&self, p: DVec3) -> f64 {
        let q = 2.0 * p - 1.0;
        let ring = (TAU * self.frequency * (FRAC_PI_2 * q.x.hypot(q.y)).cos()).cos();
        (1.0 - (FRAC_PI_2 * q.z).sin() + self.alpha * (1.0 + ring)) * self.norm()
    }

    fn gradient(&self, p: DVec3) -> DVec3 {
        let q = 2.0 * p - 1.0;
        let radius = q.x.hypot(q.y);
        let (sin, cos) = (FRAC_PI_2 * radius).sin_cos();
        let ring_slope = PI * PI * self.frequency * sin * (TAU * self.frequency * cos).sin();
        let outward = DVec3::new(q.x, q.y, 0.0).normalize_or_zero();
        let fall = DVec3::new(0.0, 0.0, FRAC_PI_2 * (FRAC_PI_2 * q.z).cos());
        (self.alpha * ring_slope * outward - fall) * self.norm()
    }

    fn extent(&self) -> DVec3 {
        DVec3::splat(2.0)
    }
}
