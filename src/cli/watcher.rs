//! Who watches a render for `svetlo render`: writes pictures, shows progress, and knows of interrupts.

use super::progress::ProgressView;
use super::stderr::say;
use super::target::Target;
use crate::Result;
use crate::picture::Tonemap;
use crate::render::{Observer, Plan, Rendering, Snapshot, Spent, Status};
use crate::scene::Stop;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// One picture on its way.
pub(super) struct Watcher<'a> {
    pub plan: &'a Plan<'a>,
    pub target: Target,
    pub data_hash: &'a str,
    /// What the runs before this one took.
    pub spent: Spent,
    pub tonemap: Tonemap,
    pub start: Instant,
    pub interrupt: Arc<AtomicBool>,
    pub stop: &'a Stop,
    pub view: ProgressView,
    pub quiet: bool,
    /// The time between pictures, where the user chose it.
    pub interval: Option<Duration>,
}

impl Watcher<'_> {
    /// Time that the render has taken, earlier runs included.
    pub fn wall(&self) -> Duration {
        self.spent.wall + self.start.elapsed()
    }

    /// Writes the last picture: its preview, and the image if it `changed` since it was read.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device fails or the files cannot be written.
    pub fn finish(&mut self, session: &dyn Rendering, changed: bool) -> Result<Snapshot> {
        let snapshot = self.take(session)?;
        self.target.finish(&snapshot.picture, &self.tonemap, changed)?;
        Ok(snapshot)
    }

    fn take(&self, session: &dyn Rendering) -> Result<Snapshot> {
        Snapshot::take(session, self.plan, self.data_hash, self.wall())
    }

    /// How much of the render is done, by the rule that is nearest to its end.
    fn fraction(&self, status: &Status) -> Option<f64> {
        if status.progress.light < 1.0 {
            return Some(status.progress.light.into());
        }
        let now = f64::from(status.progress.samples);
        // Of what this run has to add.
        let begun = f64::from(self.spent.progress.samples);
        let towards = |target: f64| (now - begun) / (target - begun);
        let samples = status.target.map(|target| towards(f64::from(target)));
        let time = self.stop.time.map(|time| status.elapsed.as_secs_f64() / time.as_secs_f64());
        // The error falls as n^-1/2.
        let error = self
            .stop
            .error
            .zip(status.error)
            .map(|(wanted, error)| towards(now * (error / self.plan.share().error(wanted)).powi(2)));
        [samples, time, error].into_iter().flatten().reduce(f64::max)
    }
}

impl Observer for Watcher<'_> {
    fn progress(&mut self, status: &Status) {
        let fraction = self.fraction(status);
        self.view.show(status, fraction);
    }

    fn snapshot(&mut self, session: &dyn Rendering) -> Result<()> {
        let snapshot = self.take(session)?;
        self.target.update(&snapshot.picture, &self.tonemap);
        Ok(())
    }

    fn interval(&self) -> Option<Duration> {
        self.interval
    }

    fn note(&mut self, text: &str) {
        if !self.quiet {
            self.view.suspend(|| say(&format!("note: {text}")));
        }
    }

    fn interrupted(&self) -> bool {
        self.interrupt.load(Ordering::Relaxed)
    }
}
