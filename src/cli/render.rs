//! `svetlo render`.

use super::interrupt::{or_interrupted, watch_interrupt};
use super::output::{check_inputs_survive, output_path};
use super::progress::ProgressView;
use super::stderr::say;
use super::summary::Summary;
use super::{load_scene, outlive_file_size_limit};
use crate::config::formats::{parse_duration, parse_percentage};
use crate::device::{Catalog, Device};
use crate::picture::{Tonemap, check_writable, write_exr, write_png};
use crate::render::{
    BRICK_SHIFT, Ended, Observer, Plan, Saved, Session, Snapshot, Spent, Status, announced_memory, data_hash,
    load_volume, preview_tonemap, run as run_progressive,
};
use crate::scene::{Scene, Stop};
use crate::{Error, Result};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Arguments of `svetlo render`.
#[derive(clap::Args)]
pub struct RenderArgs {
    /// The scene file.
    scene: PathBuf,
    /// The image to write; the preview goes beside it as .png [default: the scene's name with .exr, here].
    #[arg(short, long, value_name = "OUT.exr")]
    output: Option<PathBuf>,
    /// Override a value of the scene, such as `image.width=256` (repeatable).
    #[arg(long, value_name = "KEY.PATH=VALUE")]
    set: Vec<String>,
    /// The device: a selector of `svetlo devices`, a kind (cpu, gpu) or part of a name [env: SVETLO_DEVICE].
    #[arg(long, value_name = "SELECTOR")]
    device: Option<String>,
    /// Stop after N samples per pixel; given here, --samples, --time and --error replace all stop rules of the scene.
    #[arg(long, value_name = "N", allow_negative_numbers = true,
        value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    samples: Option<u64>,
    /// Stop after this time, such as 500ms, 30s, 2m.
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    time: Option<Duration>,
    /// Stop when the estimated relative error is below this, such as 1%.
    #[arg(long, value_name = "ERROR", value_parser = parse_percentage)]
    error: Option<f64>,
    /// Seed of the random numbers; overrides the scene's.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    seed: Option<u64>,
    /// Continue the render whose image is at the output, bit for bit as if it had never stopped. --samples is the
    /// total then, --error that of the whole, --time that of this run. Without an image there, start anew.
    #[arg(long)]
    resume: bool,
    /// Print nothing but errors.
    #[arg(long)]
    quiet: bool,
    /// Print a JSON summary to stdout at the end, and nothing else there.
    #[arg(long)]
    json: bool,
}

/// Renders the scene.
///
/// Whatever can be wrong is found in the order of its cost: scene, output, device, memory, data.
///
/// # Errors
/// With the documented exit codes; see [`Error`].
pub fn run(arguments: &RenderArgs) -> Result<()> {
    let start = Instant::now();
    outlive_file_size_limit()?;
    let mut sets = arguments.set.clone();
    sets.extend(arguments.seed.map(|seed| format!("seed={seed}")));
    let scene = load_scene(&arguments.scene, &sets)?;
    let output = output_path(&arguments.scene, arguments.output.as_deref())?;
    let preview = output.with_extension("png");
    for path in [&output, &preview] {
        check_writable(path)?;
        check_inputs_survive(path, &arguments.scene, &scene)?;
    }
    let saved = if arguments.resume { saved(arguments, &output, &scene)? } else { None };
    let interrupt = watch_interrupt()?;
    let catalog = Catalog::enumerate();
    let info = catalog.select(selector(arguments).as_deref())?;
    announced_memory(&scene).check(info)?;
    let volume = load_volume(&scene.volume)?;
    let plan = Plan::new(&scene, &volume, BRICK_SHIFT)?;
    let data_hash = data_hash(&plan, &volume)?;
    let film = saved.as_ref().map(|saved| saved.film(&plan, &data_hash)).transpose()?;
    if !arguments.quiet {
        let resumed = saved.as_ref().and_then(|saved| saved.note(info));
        plan.notes.iter().chain(&resumed).for_each(|note| say(&format!("note: {note}")));
    }
    // Its planes are as large as the image.
    drop(saved);
    let requested = Arc::clone(&interrupt);
    let mut session =
        Session::new(Device::open(info)?, &plan).map_err(|error| or_interrupted(&requested, error))?;
    let spent = film.as_ref().map(|film| film.spent);
    if let Some(film) = film {
        session.restore(&film)?;
    }
    let begun = session.progress();
    let stop = stop_rules(arguments, &scene);
    let mut watcher = Watcher {
        plan: &plan,
        data_hash: &data_hash,
        spent: spent.unwrap_or_default(),
        output: &output,
        preview: &preview,
        tonemap: preview_tonemap(&scene.film),
        start,
        interrupt,
        stop: &stop,
        view: ProgressView::new(arguments.quiet),
    };
    let ended = run_progressive(&mut session, &plan, &stop, &mut watcher);
    watcher.view.finish();
    let ended = ended.map_err(|error| or_interrupted(&requested, error))?;
    if ended == Ended::Interrupted && session.progress().samples == 0 {
        // A picture with holes must not replace an older one.
        say("interrupted before the first sample of every pixel was done; nothing was written");
        return Err(Error::Interrupted);
    }
    let added = session.progress() != begun;
    let snapshot = watcher.write(&session, added)?;
    let summary = Summary {
        scene: &arguments.scene,
        output: &output,
        preview: &preview,
        plan: &plan,
        session: &session,
        snapshot: &snapshot,
        ended,
        wall: watcher.wall(),
        resumed: spent,
        added,
    };
    summary.print(arguments.json, arguments.quiet)?;
    summary.outcome()
}

/// The image to continue, if there is one.
fn saved(arguments: &RenderArgs, output: &Path, scene: &Scene) -> Result<Option<Saved>> {
    let saved = Saved::open(output, scene)?;
    if saved.is_none() && !arguments.quiet {
        say(&format!("note: there is no {} to resume: the render starts anew", output.display()));
    }
    Ok(saved)
}

/// `--device`, else `SVETLO_DEVICE` unless it is empty, as an unset variable of a script is.
fn selector(arguments: &RenderArgs) -> Option<String> {
    let variable = || std::env::var("SVETLO_DEVICE").ok().filter(|text| !text.trim().is_empty());
    arguments.device.clone().or_else(variable)
}

fn stop_rules(arguments: &RenderArgs, scene: &Scene) -> Stop {
    if arguments.samples.is_none() && arguments.time.is_none() && arguments.error.is_none() {
        return scene.stop;
    }
    Stop { samples: arguments.samples, time: arguments.time, error: arguments.error }
}

struct Watcher<'a> {
    plan: &'a Plan<'a>,
    output: &'a Path,
    preview: &'a Path,
    data_hash: &'a str,
    /// What the runs before this one took.
    spent: Spent,
    tonemap: Tonemap,
    start: Instant,
    interrupt: Arc<AtomicBool>,
    stop: &'a Stop,
    view: ProgressView,
}

impl Watcher<'_> {
    /// Time that the render has taken, earlier runs included.
    fn wall(&self) -> Duration {
        self.spent.wall + self.start.elapsed()
    }

    /// Writes the preview, and the image unless it is the one that was read.
    fn write(&self, session: &Session, changed: bool) -> Result<Snapshot> {
        let snapshot = Snapshot::take(session, self.plan, self.data_hash, self.wall())?;
        if changed {
            write_exr(self.output, &snapshot.picture)?;
        }
        write_png(self.preview, &snapshot.picture, &self.tonemap)?;
        Ok(snapshot)
    }

    /// How much of the render is done, by the rule that is nearest to its end.
    fn fraction(&self, status: &Status) -> Option<f64> {
        let now = f64::from(status.progress.samples);
        // Of what this run has to add.
        let begun = f64::from(self.spent.progress.samples);
        let towards = |target: f64| (now - begun) / (target - begun);
        let samples = status.target.map(|target| towards(f64::from(target)));
        let time = self.stop.time.map(|time| status.elapsed.as_secs_f64() / time.as_secs_f64());
        // The error falls as n^-1/2.
        let error =
            self.stop.error.zip(status.error).map(|(wanted, error)| towards(now * (error / wanted).powi(2)));
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
