//! What the benchmarks share: medians, and which rows are wanted.
//!
//! Each benchmark uses a part of this.
#![allow(dead_code)]

use std::fmt;
use std::time::Duration;

/// Times of the same work, ascending.
pub struct Times(Vec<Duration>);

impl Times {
    /// Times `runs` runs after one that does not count.
    pub fn of<E>(runs: usize, mut run: impl FnMut() -> Result<Duration, E>) -> Result<Self, E> {
        run()?;
        let mut times = (0..runs).map(|_| run()).collect::<Result<Vec<_>, E>>()?;
        times.sort();
        Ok(Self(times))
    }

    pub fn median(&self) -> Duration {
        self.0[self.0.len() / 2]
    }
}

/// Median, least and most in milliseconds.
impl fmt::Display for Times {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ms = |time: Duration| time.as_secs_f64() * 1e3;
        let last = self.0.len() - 1;
        write!(f, "{:>9.2} {:>8.2} {:>8.2}", ms(self.median()), ms(self.0[0]), ms(self.0[last]))
    }
}

/// The rows that the command line asks for.
pub struct Wanted(String);

impl Wanted {
    /// The first argument that is no option: text that names must hold.
    pub fn from_arguments() -> Self {
        Self(std::env::args().skip(1).find(|argument| !argument.starts_with('-')).unwrap_or_default())
    }

    pub fn has(&self, name: &str) -> bool {
        name.contains(&self.0)
    }

    /// Whether the command line itself has the text.
    pub fn names(&self, text: &str) -> bool {
        self.0.contains(text)
    }
}

/// A number of things, exactly, in groups of three digits.
pub fn count(n: u64) -> String {
    let digits = n.to_string();
    let first = digits.len() % 3;
    let mut groups: Vec<&str> = Vec::new();
    if first > 0 {
        groups.push(&digits[..first]);
    }
    groups.extend((first..digits.len()).step_by(3).map(|start| &digits[start..start + 3]));
    groups.join(" ")
}
