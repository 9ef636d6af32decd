//! The progressive loop: launches until a stop rule holds, with snapshots on the way.

use super::plan::Plan;
use super::session::{Progress, Session};
use crate::Result;
use crate::film::FilmSummary;
use crate::scene::Stop;
use std::time::{Duration, Instant};

/// The first snapshot is due after this time, so that a wrong scene is seen early.
const FIRST_SNAPSHOT: Duration = Duration::from_secs(1);
/// Later ones at this interval, or longer when writing them is slow.
const SNAPSHOT_INTERVAL: Duration = Duration::from_secs(5);
/// Share of the time that snapshots may take: one part in this.
const SNAPSHOT_SHARE: u32 = 20;
/// Samples before the error is estimated for the first time; fewer give no honest variance.
const FIRST_ERROR_CHECK: u32 = 4;

/// Why a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// The number of samples was reached.
    Samples,
    /// The time was up.
    Time,
    /// The estimated error is below the limit.
    Error,
    /// All further samples would be the same.
    Deterministic,
    /// The observer asked for it.
    Interrupted,
}

/// Who watches a render.
pub trait Observer {
    /// Called after every launch.
    fn progress(&mut self, status: &Status);
    /// Called when a picture of the state so far should be written.
    ///
    /// # Errors
    /// Whatever keeps the picture from being written; it ends the render.
    fn snapshot(&mut self, session: &Session) -> Result<()>;
    /// Whether to stop now.
    fn interrupted(&self) -> bool;
}

/// Where a render stands.
#[derive(Clone, Copy, Debug)]
pub struct Status {
    /// Samples and launches so far.
    pub progress: Progress,
    /// Samples that will be reached unless another rule stops first.
    pub target: Option<u32>,
    /// Time since the first launch.
    pub elapsed: Duration,
    /// The last estimate of the relative error, if any.
    pub error: Option<f64>,
}

/// Runs `session` until the first stop rule holds.
///
/// # Errors
/// [`crate::Error::Failed`] when the device fails, and what [`Observer::snapshot`] returns.
pub fn run(
    session: &mut Session,
    plan: &Plan<'_>,
    stop: &Stop,
    observer: &mut dyn Observer,
) -> Result<Ended> {
    let start = Instant::now();
    let limit = stop.samples.map_or(u32::MAX, |samples| u32::try_from(samples).unwrap_or(u32::MAX));
    let target = if plan.is_deterministic() { 1 } else { limit };
    let mut next_check = FIRST_ERROR_CHECK;
    let mut error = None;
    let mut next_snapshot = start + FIRST_SNAPSHOT;
    loop {
        let progress = session.progress();
        if progress.samples >= target {
            return Ok(if target < limit { Ended::Deterministic } else { Ended::Samples });
        }
        if let Some(wanted) = stop.error
            && progress.samples >= next_check
            && progress.tiles == 0
        {
            error = FilmSummary::of(&session.film()?).relative_error();
            if error.is_some_and(|error| error <= wanted) {
                return Ok(Ended::Error);
            }
            next_check = samples_to_reach(wanted, error, progress.samples);
        }
        session.step(if stop.error.is_some() { target.min(next_check) } else { target })?;
        let elapsed = start.elapsed();
        let status = Status {
            progress: session.progress(),
            target: (target < u32::MAX).then_some(target),
            elapsed,
            error,
        };
        observer.progress(&status);
        if observer.interrupted() {
            return Ok(Ended::Interrupted);
        }
        // The first sample is always completed: a picture with holes is no estimate of anything.
        if status.progress.samples > 0 && stop.time.is_some_and(|time| elapsed >= time) {
            return Ok(Ended::Time);
        }
        if Instant::now() >= next_snapshot && status.progress.samples > 0 && status.progress.samples < target
        {
            let begin = Instant::now();
            observer.snapshot(session)?;
            next_snapshot = Instant::now() + SNAPSHOT_INTERVAL.max(begin.elapsed() * SNAPSHOT_SHARE);
        }
    }
}

/// When to estimate the error next: where it should reach `wanted` if it falls as n^-1/2, but within a factor of 2,
/// so that the sequence of checks depends on the samples alone and never on the clock.
fn samples_to_reach(wanted: f64, error: Option<f64>, samples: u32) -> u32 {
    let needed = error.map_or(0.0, |error| f64::from(samples) * (error / wanted).powi(2));
    (needed.ceil() as u32).clamp(samples.saturating_add(1), samples.saturating_mul(2))
}

#[cfg(test)]
mod tests {
    use super::samples_to_reach;

    #[test]
    fn error_checks_advance_and_at_most_double() {
        assert_eq!(samples_to_reach(0.01, Some(0.1), 4), 8);
        assert_eq!(samples_to_reach(0.01, Some(0.0101), 100), 103);
        assert_eq!(samples_to_reach(0.01, None, 4), 5);
        assert_eq!(samples_to_reach(0.01, Some(f64::INFINITY), 4), 8);
    }
}
