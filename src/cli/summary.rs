//! What `svetlo render` says at the end: one JSON document, or two lines for people.

use super::stderr::say;
use super::{energy, light, photons, print_line};
use crate::post::Traffic;
use crate::render::{Ended, Facts, Plan, Rendering, Shift, Snapshot, Spent, method_name, of_devices};
use crate::scene::{Caustics, Method};
use crate::{Error, Result};
use serde_json::{Value, json};
use std::path::Path;
use std::time::Duration;

/// Why a film with samples enough knows no error.
const BEYOND_SQUARES: &str = "squares of the radiances are not float32 numbers; scale the lights, and `film.exposure` \
                              the other way";

/// A render that has ended and whose images are written.
pub struct Summary<'a> {
    /// The scene file.
    pub scene: &'a Path,
    /// The EXR image.
    pub output: &'a Path,
    /// The PNG preview.
    pub preview: &'a Path,
    /// What was rendered.
    pub plan: &'a Plan<'a>,
    /// Where.
    pub session: &'a dyn Rendering,
    /// What was written.
    pub snapshot: &'a Snapshot,
    /// Why it ended.
    pub ended: Ended,
    /// Time that the render has taken, earlier runs included.
    pub wall: Duration,
    /// What earlier runs took, if this one continued them.
    pub resumed: Option<Spent>,
    /// Whether this run added anything.
    pub added: bool,
    /// How many processes share the work, and what they have written to each other, where there are several.
    pub processes: Option<(usize, Traffic)>,
}

impl Summary<'_> {
    /// Prints the summary for people, unless `quiet`.
    ///
    /// # Errors
    /// [`Error::Failed`] when stdout takes nothing.
    pub fn print(&self, quiet: bool) -> Result<()> {
        if quiet {
            return Ok(());
        }
        say(&self.line());
        let facts = self.facts();
        share_lines(&self.session.shifts()).iter().for_each(|text| say(text));
        if let Some(light) = facts.light {
            say(&light::line(light));
        }
        if let Some(paths) = &self.snapshot.paths {
            say(&energy::line(paths, &self.plan.scene.method));
        }
        if let (Some(ledger), Some(passes)) = (&self.snapshot.photons, &facts.passes) {
            photons::line(ledger, passes).iter().for_each(|text| say(text));
        }
        self.warn();
        let summary = &self.snapshot.summary;
        if summary.standard_error.is_some()
            && summary.relative_error().is_none()
            && self.ended != Ended::Unknown
        {
            say(&format!("note: the error is not known: {BEYOND_SQUARES}"));
        }
        let (output, preview) = (self.output.display(), self.preview.display());
        print_line(&if self.added {
            format!("wrote {output} and its preview {preview}")
        } else {
            format!("{output} is finished already and was left as it is; wrote its preview {preview}")
        })
    }

    /// What the user should know about how it went.
    fn warnings(&self) -> Vec<String> {
        let light = self.facts().light.map(light::warnings).unwrap_or_default();
        let method = &self.plan.scene.method;
        let paths = self.snapshot.paths.as_ref().and_then(|paths| energy::warning(paths, method));
        let photons = match (&self.snapshot.photons, method) {
            (Some(ledger), Method::Caustics(Caustics { depth, .. })) => photons::warning(ledger, *depth),
            _ => None,
        };
        light.into_iter().chain(paths).chain(photons).collect()
    }

    /// Says it on stderr.
    pub fn warn(&self) {
        self.warnings().iter().for_each(|text| say(&format!("note: {text}")));
    }

    /// What the end means for the exit code.
    ///
    /// # Errors
    /// [`Error::Failed`] when samples were not finite or paths went wrong, [`Error::Interrupted`] after an interrupt.
    pub fn outcome(&self) -> Result<()> {
        let rejected = self.snapshot.summary.rejected;
        if let Some(what) = self.snapshot.paths.as_ref().and_then(|paths| energy::failure(paths, rejected)) {
            return Err(Error::Failed(format!("{what} (it was written to {})", self.output.display())));
        }
        if rejected > 0 {
            return Err(Error::Failed(format!(
                "{rejected} samples were not finite and were left out: the image is not to be trusted \
                 (it was written to {})",
                self.output.display()
            )));
        }
        if self.ended == Ended::Unknown {
            return Err(Error::Failed(format!(
                "the error cannot be estimated: {BEYOND_SQUARES} (the image was written to {})",
                self.output.display()
            )));
        }
        if self.ended == Ended::Interrupted {
            say(&format!(
                "interrupted after {}; the image so far is in {}",
                count(self.session.progress().samples),
                self.output.display()
            ));
            return Err(Error::Interrupted);
        }
        Ok(())
    }

    fn facts(&self) -> Facts<'_> {
        self.session.facts()
    }

    fn line(&self) -> String {
        let progress = self.session.progress();
        let error = self.snapshot.summary.relative_error();
        let error = error.map_or(String::new(), |error| format!(", estimated error {:.3} %", error * 100.0));
        let why = match self.ended {
            Ended::Deterministic => "; more would be the same: nothing in this scene is random",
            Ended::Time => "; the time is up",
            Ended::Error if self.plan.part.is_some() => "; the error is small enough, with the other parts",
            Ended::Error => "; the error is small enough",
            Ended::Samples | Ended::Unknown | Ended::Interrupted => "",
        };
        let earlier = self.resumed.map_or(String::new(), |spent| {
            format!(", {} of them from earlier runs,", spent.progress.samples)
        });
        format!(
            "{}{earlier} in {:.2} s ({:.2} s on {}){error}{why}",
            count(progress.samples),
            self.wall.as_secs_f64(),
            progress.device_time.as_secs_f64(),
            of_devices(&self.facts().devices, |device| &device.name)
        )
    }

    /// The summary for programs.
    pub fn json(&self) -> Value {
        let progress = self.session.progress();
        let summary = &self.snapshot.summary;
        let facts = self.facts();
        let device = &facts.devices[0];
        json!({
            // JSON is Unicode; a path need not be.
            "scene": self.scene.to_string_lossy(),
            "scene_hash": self.plan.scene.hash,
            "method": method_name(&self.plan.scene.method),
            "output": self.output.to_string_lossy(),
            "preview": self.preview.to_string_lossy(),
            "ended": format!("{:?}", self.ended).to_lowercase(),
            "samples": progress.samples,
            "part": self.plan.part.map(|share| share.to_string()),
            "seed": self.plan.scene.seed,
            "seconds": {
                "wall": self.wall.as_secs_f64(),
                "device": progress.device_time.as_secs_f64(),
                "build": facts.build_time.as_secs_f64(),
            },
            // What of this earlier runs contributed.
            "resumed": self.resumed.map(|spent| json!({
                "samples": spent.progress.samples,
                "seconds": {
                    "wall": spent.wall.as_secs_f64(),
                    "device": spent.progress.device_time.as_secs_f64(),
                    "build": spent.build.as_secs_f64(),
                },
                "launches": spent.progress.launches,
            })),
            "build_cached": facts.build_cached,
            "launches": progress.launches,
            "lookups": summary.lookups,
            "lookups_per_ray": summary.lookups as f64 / summary.samples.max(1) as f64,
            "light": facts.light,
            "paths": self.snapshot.paths.as_ref().map(energy::report),
            "photons": self.snapshot.photons.as_ref()
                .map(|ledger| photons::report(ledger, facts.passes.as_ref())),
            "mean": summary.mean,
            "estimated_error": summary.relative_error(),
            "rejected_samples": summary.rejected,
            "device": {
                "selector": device.selector,
                "name": device.name,
                "platform": device.platform,
                "driver": device.driver,
            },
            // Where there are several: `device` is the first.
            "devices": self.session.shifts(),
            "mpi": self.processes.map(|(ranks, letters)| json!({ "ranks": ranks, "letters": letters })),
            "notes": self.plan.notes.iter().cloned().chain(self.warnings()).collect::<Vec<_>>(),
        })
    }
}

/// What each of several devices has done.
fn share_lines(shifts: &[Shift]) -> Vec<String> {
    let total = shifts.iter().map(|shift| shift.samples).sum::<u64>().max(1) as f64;
    let line = |shift: &Shift| {
        let Shift { selector, name, samples, seconds, lost } = shift;
        let share = *samples as f64 / total * 100.0;
        let lost = if lost.is_some() { "; it failed on the way" } else { "" };
        format!("{name} ({selector}): {share:.1} % of the samples in {seconds:.2} s{lost}")
    };
    shifts.iter().map(line).collect()
}

fn count(samples: u32) -> String {
    if samples == 1 { "1 sample".into() } else { format!("{samples} samples") }
}
