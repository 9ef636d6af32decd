//! Shares of a picture: every N-th sample, so that runs that know nothing of each other render one picture together.

use std::fmt;
use std::str::FromStr;

/// Part `number` of `of`: the samples whose numbers, from 0, are `number` − 1 modulo `of`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Share {
    number: u32,
    of: u32,
}

impl Share {
    /// All samples.
    pub const WHOLE: Self = Self { number: 1, of: 1 };
    /// The largest number of parts.
    pub const MOST: u32 = 1_000_000;

    /// Part `number` of `of`; `None` unless `number` is 1 to `of` and `of` at most [`Share::MOST`].
    pub fn new(number: u32, of: u32) -> Option<Self> {
        ((1..=of).contains(&number) && of <= Self::MOST).then_some(Self { number, of })
    }

    /// Which part, from 1.
    pub fn number(self) -> u32 {
        self.number
    }

    /// Of how many.
    pub fn of(self) -> u32 {
        self.of
    }

    /// The number in the whole picture of its first sample.
    pub fn first(self) -> u32 {
        self.number - 1
    }

    /// The number in the whole picture of its sample `turn`.
    pub fn sample(self, turn: u32) -> u32 {
        self.first().saturating_add(turn.saturating_mul(self.of))
    }

    /// How many of the first `whole` samples of the picture it has; samples are numbered in 32 bits.
    pub fn count(self, whole: u64) -> u32 {
        let whole = u32::try_from(whole).unwrap_or(u32::MAX);
        whole.checked_sub(self.number).map_or(0, |after| after / self.of + 1)
    }

    /// The relative error of this part where that of the whole, of parts like it, is `whole`: they are independent.
    pub fn error(self, whole: f64) -> f64 {
        whole * f64::from(self.of).sqrt()
    }
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Share {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text.split_once('/').and_then(|(number, of)| {
            let number_of = |text: &str| {
                text.bytes().all(|byte| byte.is_ascii_digit()).then(|| text.parse().ok()).flatten()
            };
            Self::new(number_of(number)?, number_of(of)?)
        });
        parsed.ok_or_else(|| format!("a part is I/N, such as 2/8: I is 1 to N, and N at most {}", Self::MOST))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_disjoint_and_all_of_them_are_the_whole() {
        for of in [1, 2, 3, 7] {
            for whole in [0_u32, 1, 2, 6, 7, 8, 50] {
                let shares = (1..=of).filter_map(|number| Share::new(number, of));
                let mut samples: Vec<u32> = shares
                    .flat_map(|share| (0..share.count(whole.into())).map(move |turn| share.sample(turn)))
                    .collect();
                samples.sort_unstable();
                assert_eq!(samples, (0..whole).collect::<Vec<_>>(), "{whole} samples in {of} parts");
            }
        }
    }

    #[test]
    fn numbers_of_samples_end_with_32_bits() {
        assert_eq!(Share::WHOLE.count(u64::MAX), u32::MAX);
        assert_eq!(Share::WHOLE.count(1 << 31), 1 << 31);
        for number in [1, 2, 3] {
            let share = Share::new(number, 3).unwrap();
            let last = share.sample(share.count(u64::MAX) - 1);
            assert!((u32::MAX - 3..u32::MAX).contains(&last), "{last}");
        }
    }

    #[test]
    fn parts_are_written_as_they_are_read() {
        for text in ["1/1", "3/3", "12/1000000"] {
            assert_eq!(text.parse::<Share>().unwrap().to_string(), text);
        }
        for text in [
            "",
            "1",
            "0/3",
            "4/3",
            "1/0",
            "-1/3",
            "+1/3",
            "1/3/5",
            "1 / 3",
            "a/b",
            "1/1000001",
            "1/9999999999",
        ] {
            assert!(text.parse::<Share>().unwrap_err().contains("such as 2/8"), "{text}");
        }
    }

    #[test]
    fn four_parts_of_twice_the_error_are_right() {
        assert_eq!(Share::new(3, 4).unwrap().error(0.01), 0.02);
    }
}
