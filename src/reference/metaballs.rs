//! Metaballs: a field of balls, and where rays go through its surface, by dense samples and bisection.

use glam::DVec3;

/// A ball: it adds `weight` (1 − s²)² to the field, where s is the distance from its centre over its radius, up to s = 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    /// Its middle.
    pub centre: DVec3,
    /// Where its share of the field ends.
    pub radius: f64,
    /// The field at its centre.
    pub weight: f64,
}

/// A body: where the field of all balls is above the threshold.
#[derive(Debug, Clone, PartialEq)]
pub struct Metaballs {
    /// The balls.
    pub balls: Vec<Ball>,
    /// The field on the surface.
    pub threshold: f64,
}

/// Where a ray goes through the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Distance along the ray.
    pub t: f64,
    /// Outward unit normal.
    pub normal: DVec3,
    /// Whether the ray leaves the body there.
    pub leaves: bool,
}

impl Metaballs {
    /// The field less the threshold.
    pub fn field(&self, point: DVec3) -> f64 {
        let share = |ball: &Ball| {
            let s2 = point.distance_squared(ball.centre) / ball.radius.powi(2);
            ball.weight * (1.0 - s2).max(0.0).powi(2)
        };
        self.balls.iter().map(share).sum::<f64>() - self.threshold
    }

    /// The gradient of the field.
    pub fn gradient(&self, point: DVec3) -> DVec3 {
        let share = |ball: &Ball| {
            let s2 = point.distance_squared(ball.centre) / ball.radius.powi(2);
            -4.0 * ball.weight * (1.0 - s2).max(0.0) / ball.radius.powi(2) * (point - ball.centre)
        };
        self.balls.iter().map(share).sum()
    }

    /// The first crossing between `t_min` and `t_max`, looked for at `samples` places.
    pub fn crossing(
        &self,
        origin: DVec3,
        direction: DVec3,
        [t_min, t_max]: [f64; 2],
        samples: u32,
    ) -> Option<Crossing> {
        let inside = |t: f64| self.field(origin + t * direction) > 0.0;
        let place = |i: u32| t_min + (t_max - t_min) * f64::from(i) / f64::from(samples);
        let leaves = inside(t_min);
        let end = (1..=samples).find(|&i| inside(place(i)) != leaves)?;
        let (mut low, mut high) = (place(end - 1), place(end));
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if inside(middle) == leaves {
                low = middle;
            } else {
                high = middle;
            }
        }
        let normal = -self.gradient(origin + high * direction).normalize_or_zero();
        Some(Crossing { t: high, normal, leaves })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_ball_is_a_sphere() {
        // (1 - s^2)^2 = 1/4 at s^2 = 1/2.
        let ball = Ball { centre: DVec3::new(0.0, 0.0, 5.0), radius: 2.0, weight: 1.0 };
        let body = Metaballs { balls: vec![ball], threshold: 0.25 };
        let found = body.crossing(DVec3::ZERO, DVec3::Z, [0.0, 10.0], 100).unwrap();
        assert!((found.t - (5.0 - 2.0_f64.sqrt())).abs() < 1e-12 && !found.leaves);
        assert!((found.normal + DVec3::Z).length() < 1e-12);
        let found = body.crossing(DVec3::ZERO, DVec3::Z, [5.0, 10.0], 100).unwrap();
        assert!((found.t - (5.0 + 2.0_f64.sqrt())).abs() < 1e-12 && found.leaves);
        assert_eq!(body.crossing(DVec3::X * 1.5, DVec3::Z, [0.0, 10.0], 1000), None);
    }

    #[test]
    fn the_gradient_is_that_of_the_field() {
        let ball = |x: f64, weight| Ball { centre: DVec3::new(x, 0.1, -0.2), radius: 1.0, weight };
        let body = Metaballs { balls: vec![ball(0.0, 1.0), ball(0.7, -0.4)], threshold: 0.2 };
        let (point, h) = (DVec3::new(0.3, 0.2, 0.1), 1e-5);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let slope = (body.field(point + h * axis) - body.field(point - h * axis)) / (2.0 * h);
            assert!((slope - body.gradient(point).dot(axis)).abs() < 1e-9);
        }
    }
}
