//! Numbers as unevaluated sums of two float64: about 106 bits (Dekker 1971; Hida, Li and Bailey 2001).

use std::ops::{Add, Mul, Sub};

/// `high + low`, where `low` is what `high` cannot hold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Double {
    high: f64,
    low: f64,
}

/// The bits of a float64 that are its exponent.
const EXPONENT: u64 = 0x7ff << 52;
/// 2^-89.
const GRAIN: f64 = 1.0 / (1_u128 << 89) as f64;

impl Double {
    /// An integer, exactly.
    pub fn of_count(count: u64) -> Self {
        // Halves of 32 bits are exact, and so is their sum.
        Self::sum((count >> 32) as f64 * (1_u64 << 32) as f64, f64::from(count as u32))
    }

    /// a + b, exactly (Knuth's TwoSum).
    pub fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let part = high - a;
        Self { high, low: (a - (high - part)) + (b - part) }
    }

    /// a + b where |a| is not below |b| (Dekker's FastTwoSum).
    fn of_ordered(a: f64, b: f64) -> Self {
        let high = a + b;
        Self { high, low: b - (high - a) }
    }

    /// a · b, exactly.
    fn product(a: f64, b: f64) -> Self {
        let high = a * b;
        Self { high, low: a.mul_add(b, -high) }
    }

    /// The nearest float64.
    pub fn value(self) -> f64 {
        self.high
    }

    /// What [`Double::value`] cannot hold.
    pub fn rest(self) -> f64 {
        self.low
    }

    /// Rounded to a multiple of some 2^-89 of `scale`, a positive number, or 0 for no rounding.
    ///
    /// Sums in other orders differ by less. What is a number of few bits, such as 3/8, comes out as that one.
    #[must_use]
    pub fn rounded(self, scale: f64) -> Self {
        if scale == 0.0 || !scale.is_finite() {
            return self;
        }
        // A power of two, so that quotients and products are exact.
        let unit = f64::from_bits(scale.to_bits() & EXPONENT) * GRAIN;
        let [high, low] = [self.high, self.low].map(|x| (x / unit).round() * unit);
        Self::of_ordered(high, low)
    }

    /// The quotient by a number that is not 0.
    #[must_use]
    pub fn over(self, divisor: f64) -> Self {
        // Long division in base 2^53.
        let first = self.high / divisor;
        let left = self - Self::product(first, divisor);
        let second = left.high / divisor;
        let third = (left - Self::product(second, divisor)).high / divisor;
        Self::of_ordered(first, second) + Self::from(third)
    }
}

impl From<f64> for Double {
    fn from(value: f64) -> Self {
        Self { high: value, low: 0.0 }
    }
}

impl Add for Double {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let high = Self::sum(self.high, other.high);
        let low = Self::sum(self.low, other.low);
        let sum = Self::of_ordered(high.high, high.low + low.high);
        Self::of_ordered(sum.high, sum.low + low.low)
    }
}

impl Sub for Double {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + Self { high: -other.high, low: -other.low }
    }
}

impl Mul for Double {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let product = Self::product(self.high, other.high);
        let mixed = self.high * other.low + self.low * other.high;
        Self::of_ordered(product.high, product.low + mixed)
    }
}

impl Mul<f64> for Double {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        self * Self::from(factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The exact value of a sum of integers.
    fn integer(x: Double) -> i128 {
        x.high as i128 + x.low as i128
    }

    proptest! {
        /// Integers below 2^105 are exact, and so are their sums and products as long as they are.
        #[test]
        fn integers_are_exact(a in any::<u64>(), b in any::<u64>(), c in any::<u32>()) {
            let (x, y) = (Double::of_count(a), Double::of_count(b));
            prop_assert_eq!(integer(x), i128::from(a));
            prop_assert_eq!(integer(x + y), i128::from(a) + i128::from(b));
            prop_assert_eq!(integer(x - y), i128::from(a) - i128::from(b));
            prop_assert_eq!(integer(x * f64::from(c)), i128::from(a) * i128::from(c));
            let (p, q) = (a >> 14, b >> 14);
            let product = Double::of_count(p) * Double::of_count(q);
            prop_assert_eq!(integer(product), i128::from(p) * i128::from(q));
        }

        /// Thirds of whole numbers that are added up to whole numbers are these.
        #[test]
        fn rounding_takes_the_dust_away(a in 1..u32::MAX, b in any::<u32>()) {
            let third = Double::of_count(a.into()).over(3.0);
            let sum = third + third + third + Double::of_count(b.into());
            let wanted = Double::of_count(u64::from(a) + u64::from(b));
            prop_assert_eq!(sum.rounded(wanted.value()), wanted);
            prop_assert_eq!((sum - wanted).rounded(wanted.value()).value(), 0.0);
            prop_assert!((third.rounded(third.value()) - third).value().abs() <= third.value() * GRAIN);
        }

        /// Quotients times the divisor are the dividend, to 2^-100 of it.
        #[test]
        fn quotients_have_a_hundred_bits(a in any::<u64>(), b in 1..u32::MAX) {
            let back = Double::of_count(a).over(f64::from(b)) * f64::from(b);
            let error = (back - Double::of_count(a)).value().abs();
            prop_assert!(error <= a as f64 * 2_f64.powi(-100), "{}", error);
        }
    }
}
