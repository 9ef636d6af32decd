//! Who watches a render for `svetlo render`: writes pictures, shows progress, and knows of interrupts.

use super::progress::ProgressView;
use crate::Result;
use crate::picture::{Tonemap, write_exr, write_png};
use crate::render::{Observer, Plan, Session, Snapshot, Spent, Status};
use crate::scene::Stop;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// One picture on its way.
pub(super) struct Watcher<'a> {
    pub plan: &'a Plan<'a>,
    pub output: &'a Path,
    pub preview: &'a Path,
    pub data_hash: &'a str,
    /// What the runs before this one took.
    pub spent: Spent,
    pub tonemap: Tonemap,
    pub start: Instant,
    pub interrupt: Arc<AtomicBool>,
    pub stop: &'a Stop,
    pub view: ProgressView,
}

impl Watcher<'_> {
    /// Time that the render has taken, earlier runs included.
    pub fn wall(&self) -> Duration {
        self.spent.wall + self.start.elapsed()
    }

    /// Writes the preview, and the image unless it is the one that was read.
    pub fn write(&self, session: &Session, changed: bool) -> Result<Snapshot> {
        let snapshot = Snapshot::take(session, self.plan, self.data_hash, self.wall())?;
        if changed {
            write_exr(self.output, &snapshot.picture)?;
        }
        write_png(self.preview, &snapshot.picture, &self.tonemap)?;
        Ok(snapshot)
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

    fn snapshot(&mut self, session: &Session) -> Result<()> {
        self.write(session, true).map(drop)
    }

    fn interrupted(&self) -> bool {
        self.interrupt.load(Ordering::Relaxed)
    }
}
