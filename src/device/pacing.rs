//! Launch sizes that follow measured time, so that no watchdog fires and an interrupt is answered at once.

use std::time::Duration;

/// Launches aim at this length: long enough to hide their overhead, short enough for watchdogs and Ctrl-C.
pub const LAUNCH_TARGET: Duration = Duration::from_millis(100);

/// Chooses how many work units the next launch covers, from the time the last ones took.
#[derive(Clone, Debug)]
pub struct Pacer {
    target: f64,
    per_second: Option<f64>,
}

impl Pacer {
    /// A pacer that aims at launches of `target` length (50 to 200 ms are sensible).
    pub fn new(target: Duration) -> Self {
        Self { target: target.as_secs_f64(), per_second: None }
    }

    /// Units for the next launch, at least 1; `first` is the careful guess before anything was measured.
    pub fn next(&self, first: u64) -> u64 {
        match self.per_second {
            None => first.max(1),
            Some(rate) => ((rate * self.target) as u64).max(1),
        }
    }

    /// Reports that a launch of `units` took `elapsed`. Growth is limited to a factor of 8 a launch, since the
    /// next pixels may cost more than the last ones.
    pub fn measured(&mut self, units: u64, elapsed: Duration) {
        let seconds = elapsed.as_secs_f64().max(self.target / 8.0);
        self.per_second = Some(units as f64 / seconds);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_the_measured_rate() {
        let mut pacer = Pacer::new(Duration::from_millis(100));
        assert_eq!(pacer.next(64), 64);
        pacer.measured(64, Duration::from_micros(1));
        assert_eq!(pacer.next(64), 512, "growth is limited to a factor of 8");
        pacer.measured(512, Duration::from_millis(400));
        assert_eq!(pacer.next(64), 128);
        pacer.measured(1, Duration::from_secs(10));
        assert_eq!(pacer.next(64), 1, "never zero");
    }
}
