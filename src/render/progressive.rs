//! The progressive loop: launches until a stop rule holds, with snapshots on the way.

use super::plan::Plan;
use super::rendering::Rendering;
use super::session::Progress;
use crate::film::FilmSummary;
use crate::scene::Stop;
use crate::{Error, Result};
use std::time::{Duration, Instant};

/// The first snapshot is due after this time, so that a wrong scene is seen early.
const FIRST_SNAPSHOT: Duration = Duration::from_secs(1);
/// Later ones at this interval, or longer when writing them is slow.
const SNAPSHOT_INTERVAL: Duration = Duration::from_secs(5);
/// Share of the time that snapshots may take: one part in this.
const SNAPSHOT_SHARE: u32 = 20;
/// Samples before the error is estimated for the first time; fewer give no honest variance.
const FIRST_CHECK: u32 = 4;
/// From this many samples on, the error is estimated at as many sample counts per doubling.
const CHECKS_PER_DOUBLING: u32 = 8;

/// Why a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// The number of samples was reached.
    Samples,
    /// The time was up.
    Time,
    /// The estimated error is below the limit.
    Error,
    /// No error can be estimated, so that it will never be below the limit.
    Unknown,
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
    /// Whatever must end the render. A picture that cannot be written now need not: the next one may.
    fn snapshot(&mut self, session: &dyn Rendering) -> Result<()>;
    /// Called with what the user should know.
    fn note(&mut self, _text: &str) {}
    /// Whether to stop now.
    fn interrupted(&self) -> bool;
    /// The time from one snapshot to the next, if the user has chosen it.
    fn interval(&self) -> Option<Duration> {
        None
    }
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
    session: &mut dyn Rendering,
    plan: &Plan<'_>,
    stop: &Stop,
    observer: &mut dyn Observer,
) -> Result<Ended> {
    let start = Instant::now();
    // Stop rules are those of the whole picture.
    let share = plan.share();
    let limit = share.count(stop.samples.unwrap_or(u64::MAX));
    let target = if plan.is_deterministic() { 1 } else { limit };
    let mut error = None;
    let mut next_snapshot = start + observer.interval().unwrap_or(FIRST_SNAPSHOT);
    loop {
        let progress = session.progress();
        if progress.samples >= target {
            return Ok(if target < limit { Ended::Deterministic } else { Ended::Samples });
        }
        if let Some(wanted) = stop.error
            && progress.tiles == 0
            && is_check(progress.samples)
        {
            error = FilmSummary::of(&session.film()?).relative_error();
            match error {
                Some(error) if error <= share.error(wanted) => return Ok(Ended::Error),
                Some(_) => {}
                // There are samples enough: they are not finite, or their squares are beyond float32.
                None => return Ok(Ended::Unknown),
            }
        }
        let goal = if stop.error.is_some() { target.min(next_check(progress.samples)) } else { target };
        match session.step(goal) {
            Err(Error::Interrupted) => return Ok(Ended::Interrupted),
            other => other?,
        }
        let elapsed = start.elapsed();
        let status = Status {
            progress: session.progress(),
            target: (target < u32::MAX).then_some(target),
            elapsed,
            error,
        };
        session.take_notes().iter().for_each(|note| observer.note(note));
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
            let usual = || SNAPSHOT_INTERVAL.max(begin.elapsed() * SNAPSHOT_SHARE);
            next_snapshot = Instant::now() + observer.interval().unwrap_or_else(usual);
        }
    }
}

/// Whether the error is estimated when every pixel has `samples` samples.
///
/// The number alone decides, neither the clock nor earlier estimates: a render that was stopped and resumed ends where
/// one that never stopped ends.
fn is_check(samples: u32) -> bool {
    samples >= FIRST_CHECK && samples.is_multiple_of(check_step(samples))
}

/// The next larger number of samples at which the error is estimated.
fn next_check(samples: u32) -> u32 {
    let step = check_step(samples);
    (samples / step + 1).saturating_mul(step).max(FIRST_CHECK)
}

/// Samples between checks: constant from one power of two to the next.
fn check_step(samples: u32) -> u32 {
    let octave = samples.checked_ilog2().map_or(0, |log| 1 << log);
    (octave / CHECKS_PER_DOUBLING).max(1)
}

#[cfg(test)]
mod tests {
    use super::{is_check, next_check};

    #[test]
    fn errors_are_checked_eight_times_per_doubling() {
        let checks: Vec<u32> = (0..70).filter(|&n| is_check(n)).collect();
        let expected = (4..16).chain((16..32).step_by(2)).chain((32..64).step_by(4)).chain([64]);
        assert_eq!(checks, expected.collect::<Vec<_>>());
    }

    #[test]
    fn wherever_a_render_continues_its_next_check_is_the_same() {
        for samples in 0..1000 {
            assert_eq!(Some(next_check(samples)), (samples + 1..2000).find(|&n| is_check(n)), "{samples}");
        }
        assert_eq!(next_check(1 << 30), (1 << 30) + (1 << 27));
        assert_eq!(next_check(u32::MAX), u32::MAX);
    }
}
