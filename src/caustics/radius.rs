//! How the radius shrinks from pass to pass, so that the mean of the passes converges (Knaus and Zwicker 2011).

/// Passes whose factors are multiplied one by one.
const COUNTED: u32 = 256;

/// The radius of a pass: r² of pass p is r² of pass p − 1 times (p + α) / (p + 1), passes being counted from 0.
///
/// The variance of the mean of n passes falls as n^−α and its bias as n^(α − 1), for 0 < `alpha` < 1; the radius stays for
/// `alpha` 1. A function of the pass alone, so that any device can make any pass.
pub fn pass_radius(first: f64, alpha: f64, pass: u32) -> f64 {
    let counted = pass.min(COUNTED);
    let product: f64 = (1..=counted).map(|p| (f64::from(p) + alpha) / f64::from(p + 1)).product();
    let rest = if pass > counted { gamma_ratio(pass, alpha) / gamma_ratio(counted, alpha) } else { 1.0 };
    first * (product * rest).sqrt()
}

/// Γ(p + 1 + α) / Γ(p + 2), by its expansion for large p in the middle of the arguments (DLMF 5.11.14): the product over
/// all passes to p, but for a factor that does not depend on p. Its next term is below 1e-17 from p = 256 on.
fn gamma_ratio(pass: u32, alpha: f64) -> f64 {
    let difference = alpha - 1.0;
    let middle = f64::from(pass) + 1.0 + 0.5 * alpha;
    let choose = |k: u32| (0..k).map(|j| (difference - f64::from(j)) / f64::from(j + 1)).product::<f64>();
    let first = -choose(2) * alpha / 12.0;
    let second = choose(4) * alpha * (2.0 + 5.0 * alpha) / 240.0;
    let square = middle * middle;
    middle.powf(difference) * (1.0 + first / square + second / (square * square))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Products of many factors, each rounded twice, and powers of numbers up to 1e6.
    const ROUNDING: f64 = 1e-12;

    #[test]
    fn radii_are_those_of_the_product() {
        for alpha in [0.0, 0.1, 0.5, 2.0 / 3.0, 0.9, 1.0] {
            // In two floats, so that a million factors round once.
            let (mut log, mut rest) = (0.0_f64, 0.0_f64);
            for pass in 0..=1_000_000_u32 {
                if pass > 0 {
                    let term = ((alpha - 1.0) / f64::from(pass + 1)).ln_1p() - rest;
                    let sum = log + term;
                    rest = (sum - log) - term;
                    log = sum;
                }
                if pass < 600 || pass % 99_991 == 0 || pass == 1_000_000 {
                    let (found, expected) = (pass_radius(3.0, alpha, pass), 3.0 * (0.5 * log).exp());
                    let error = (found / expected - 1.0).abs();
                    assert!(error < ROUNDING, "alpha {alpha}, pass {pass}: {found}, not {expected}");
                }
            }
        }
    }

    #[test]
    fn it_starts_with_the_first_and_stays_for_alpha_1() {
        for pass in [0, 1, 255, 256, 257, u32::MAX - 1] {
            assert!((pass_radius(0.04, 1.0, pass) - 0.04).abs() < 1e-17);
        }
        assert_eq!(pass_radius(0.04, 2.0 / 3.0, 0), 0.04);
        // alpha 0: r^2 of pass p is that of the first over p + 1.
        assert!((pass_radius(1.0, 0.0, 9_999) - 0.01).abs() < 1e-14);
    }
}
