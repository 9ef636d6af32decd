//! Gauss–Legendre quadrature, plain and adaptive.

/// Nodes and weights of the n-point rule on [0, 1]: exact for polynomials of degree 2n − 1.
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    let order = n as f64;
    (1..=n)
        .map(|i| {
            // Newton's method on the Legendre polynomial, from Tricomi's estimate of the root.
            let mut x = (std::f64::consts::PI * (i as f64 - 0.25) / (order + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..100 {
                let (value, before) = legendre(n, x);
                slope = order * (x * value - before) / (x * x - 1.0);
                x -= value / slope;
            }
            (0.5 - 0.5 * x, 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// ∫ f over [`from`, `to`] to about thirteen digits, by halving where two halves differ from the whole.
pub fn adaptive(from: f64, to: f64, f: &impl Fn(f64) -> f64) -> f64 {
    let rule = gauss_legendre(16);
    let gauss = |a: f64, b: f64| -> f64 { rule.iter().map(|(x, w)| w * (b - a) * f(a + x * (b - a))).sum() };
    let whole = gauss(from, to);
    let tolerance = 1e-14 * whole.abs().max(gauss(from, 0.5 * (from + to)).abs());
    let mut open = vec![(from, to, whole, 50)];
    let mut sum = 0.0;
    while let Some((a, b, whole, depth)) = open.pop() {
        let middle = 0.5 * (a + b);
        let (first, second) = (gauss(a, middle), gauss(middle, b));
        if depth == 0 || (first + second - whole).abs() <= tolerance {
            sum += first + second;
        } else {
            open.extend([(a, middle, first, depth - 1), (middle, b, second, depth - 1)]);
        }
    }
    sum
}

/// Pₙ(x) and Pₙ₋₁(x), by Bonnet's recurrence.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (0.0, 1.0);
    for k in 0..n {
        let k = k as f64;
        (before, value) = (value, ((2.0 * k + 1.0) * x * value - k * before) / (k + 1.0));
    }
    (value, before)
}

#[cfg(test)]
mod tests {
    use super::{adaptive, gauss_legendre};

    #[test]
    fn kinks_and_steep_places_are_found() {
        let kink = adaptive(0.0, 2.0, &|x| (x - 1.1f64.sqrt()).abs());
        let root = 1.1f64.sqrt();
        assert!((kink - 0.5 * (root * root + (2.0 - root).powi(2))).abs() < 1e-12, "{kink}");
        let peak = adaptive(-1.0, 1.0, &|x| 1e-3 / (x * x + 1e-6));
        assert!((peak - 2.0 * 1e3f64.atan()).abs() < 1e-12, "{peak}");
    }

    #[test]
    fn exact_up_to_degree_2n_minus_1_and_no_further() {
        for n in 1..=16 {
            let rule = gauss_legendre(n);
            let error = |degree: i32| {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(degree)).sum();
                (sum - 1.0 / f64::from(degree + 1)).abs()
            };
            assert!((0..2 * n as i32).all(|degree| error(degree) < 1e-14), "{n}");
            // The error on x^2n is (n!)⁴ / ((2n + 1) (2n)!²), about 2^-4n.
            assert!(n > 5 || error(2 * n as i32) > 1e-8, "{n}");
        }
    }
}
