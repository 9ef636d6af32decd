//! Cubics on [0, 1]: the trilinear field along a ray inside a cell.

/// a + b·s + c·s² + d·s³.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cubic {
    /// Constant term.
    pub a: f64,
    /// Linear term.
    pub b: f64,
    /// Quadratic term.
    pub c: f64,
    /// Cubic term.
    pub d: f64,
}

impl Cubic {
    /// The cubic with these values at s = 0, 1/3, 2/3 and 1.
    pub fn through([p, q, r, s]: [f64; 4]) -> Self {
        Self {
            a: p,
            b: (-11.0 * p + 18.0 * q - 9.0 * r + 2.0 * s) / 2.0,
            c: 9.0 * (2.0 * p - 5.0 * q + 4.0 * r - s) / 2.0,
            d: 9.0 * (-p + 3.0 * q - 3.0 * r + s) / 2.0,
        }
    }

    /// Its value.
    pub fn value(&self, s: f64) -> f64 {
        self.a + s * (self.b + s * (self.c + s * self.d))
    }

    /// 0, the extrema between, and 1: between neighbours the cubic is monotone.
    pub fn turning_points(&self) -> Vec<f64> {
        let mut points = vec![0.0, 1.0];
        let discriminant = self.c * self.c - 3.0 * self.b * self.d;
        if discriminant >= 0.0 {
            let q = -(self.c + discriminant.sqrt().copysign(self.c));
            points.extend([self.b / q, q / (3.0 * self.d)].into_iter().filter(|s| *s > 0.0 && *s < 1.0));
        }
        points.sort_by(f64::total_cmp);
        points
    }

    /// Where the cubic crosses `level`, ascending: one per monotone stretch with ends on different sides
    /// (values equal to the level count as above), by bisection to the last bit.
    pub fn crossings(&self, level: f64) -> Vec<f64> {
        let above = |s: f64| self.value(s) >= level;
        let turns = self.turning_points();
        turns
            .windows(2)
            .filter(|pair| above(pair[0]) != above(pair[1]))
            .map(|pair| {
                let (mut low, mut high) = (pair[0], pair[1]);
                let start = above(low);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if above(middle) == start {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                0.5 * (low + high)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolates_its_samples() {
        let cubic = Cubic { a: 0.3, b: -2.0, c: 5.0, d: -1.5 };
        let again = Cubic::through([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(|s| cubic.value(s)));
        for (x, y) in [(cubic.a, again.a), (cubic.b, again.b), (cubic.c, again.c), (cubic.d, again.d)] {
            assert!((x - y).abs() < 1e-13);
        }
    }

    #[test]
    fn finds_all_three_crossings() {
        // (s - 0.1)(s - 0.5)(s - 0.9).
        let cubic = Cubic { a: -0.045, b: 0.59, c: -1.5, d: 1.0 };
        let roots = cubic.crossings(0.0);
        assert_eq!(roots.len(), 3);
        for (root, exact) in roots.into_iter().zip([0.1, 0.5, 0.9]) {
            assert!((root - exact).abs() < 1e-14);
        }
    }

    #[test]
    fn straight_lines_have_no_turning_points() {
        let line = Cubic { a: 1.0, b: -2.0, c: 0.0, d: 0.0 };
        assert_eq!(line.turning_points(), [0.0, 1.0]);
        assert_eq!(line.crossings(0.0), [0.5]);
        assert!(Cubic { b: 0.0, ..line }.crossings(1.0).is_empty());
    }
}
