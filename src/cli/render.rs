//! `svetlo render`.

use super::progress::ProgressView;
use super::{pretty, print_line};
use crate::config::formats::{parse_duration, parse_percentage};
use crate::device::{Catalog, Device};
use crate::picture::{Curve, Encoding, Tonemap, check_writable, write_exr, write_png};
use crate::render::{
    BRICK_SHIFT, Ended, Observer, Plan, Session, Snapshot, Status, load_volume, method_name,
    run as run_progressive,
};
use crate::scene::{FilmSettings, Scene, Stop, Tonemap as SceneTonemap};
use crate::{Error, Result};
use serde_json::json;
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
    /// The device: a selector of `svetlo devices`, a kind (cpu, gpu) or part of a name.
    #[arg(long, env = "SVETLO_DEVICE", value_name = "SELECTOR")]
    device: Option<String>,
    /// Stop after N samples per pixel. Stop rules given here replace those of the scene.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    samples: Option<u64>,
    /// Stop after this time, such as 500ms, 30s, 2m.
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    time: Option<Duration>,
    /// Stop when the estimated relative error is below this, such as 1%.
    #[arg(long, value_name = "ERROR", value_parser = parse_percentage)]
    error: Option<f64>,
    /// Seed of the random numbers; overrides the scene's.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Show no progress.
    #[arg(long)]
    quiet: bool,
    /// Print a JSON summary to stdout at the end.
    #[arg(long)]
    json: bool,
}

/// Renders the scene.
///
/// # Errors
/// With the documented exit codes; see [`Error`].
pub fn run(arguments: &RenderArgs) -> Result<()> {
    let start = Instant::now();
    let scene = load_scene(arguments)?;
    let output = output_path(arguments)?;
    let preview = output.with_extension("png");
    check_writable(&output)?;
    check_writable(&preview)?;
    let volume = load_volume(&scene.volume)?;
    let plan = Plan::new(&scene, &volume, BRICK_SHIFT)?;
    if !arguments.quiet {
        plan.notes.iter().for_each(|note| eprintln!("note: {note}"));
    }
    let catalog = Catalog::enumerate();
    let info = catalog.select(arguments.device.as_deref())?;
    let interrupt = watch_interrupt()?;
    let mut session = Session::new(Device::open(info)?, &plan)?;
    let stop = stop_rules(arguments, &scene);
    let tonemap = tonemap(&scene.film);
    let mut watcher = Watcher {
        plan: &plan,
        output: &output,
        preview: &preview,
        tonemap,
        start,
        interrupt,
        stop: &stop,
        view: ProgressView::new(arguments.quiet),
    };
    let ended = run_progressive(&mut session, &plan, &stop, &mut watcher);
    watcher.view.finish();
    let ended = ended?;
    let snapshot = watcher.write(&session)?;
    report(arguments, &session, &plan, &snapshot, ended, &output, &preview, start.elapsed())
}

fn load_scene(arguments: &RenderArgs) -> Result<Scene> {
    let mut sets = arguments.set.clone();
    sets.extend(arguments.seed.map(|seed| format!("seed={seed}")));
    Scene::load(&arguments.scene, &sets)
}

/// `-o`, or the scene's name with `.exr` in the current folder.
fn output_path(arguments: &RenderArgs) -> Result<PathBuf> {
    let Some(path) = &arguments.output else {
        let stem = arguments.scene.file_stem().unwrap_or_default();
        return Ok(Path::new(stem).with_extension("exr"));
    };
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr")) {
        return Ok(path.clone());
    }
    Err(Error::Input(format!(
        "{}: the image is written as EXR, so its name must end in .exr (a .png preview appears beside it)",
        path.display()
    )))
}

fn stop_rules(arguments: &RenderArgs, scene: &Scene) -> Stop {
    if arguments.samples.is_none() && arguments.time.is_none() && arguments.error.is_none() {
        return scene.stop;
    }
    Stop { samples: arguments.samples, time: arguments.time, error: arguments.error }
}

fn tonemap(film: &FilmSettings) -> Tonemap {
    Tonemap {
        curve: match film.tonemap {
            SceneTonemap::Linear => Curve::Linear,
            SceneTonemap::Reinhard => Curve::Reinhard,
            SceneTonemap::Filmic => Curve::Filmic,
        },
        exposure: film.exposure,
        encoding: film.gamma.map_or(Encoding::Srgb, Encoding::Gamma),
    }
}

/// Ctrl-C (and termination) sets a flag; the render stops after the launch that runs and writes its image.
fn watch_interrupt() -> Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    let set = Arc::clone(&flag);
    ctrlc::set_handler(move || {
        if set.swap(true, Ordering::Relaxed) {
            // A second request does not wait for the image.
            std::process::exit(130);
        }
    })
    .map_err(|error| Error::Failed(format!("cannot watch for Ctrl-C: {error}")))?;
    Ok(flag)
}

struct Watcher<'a> {
    plan: &'a Plan<'a>,
    output: &'a Path,
    preview: &'a Path,
    tonemap: Tonemap,
    start: Instant,
    interrupt: Arc<AtomicBool>,
    stop: &'a Stop,
    view: ProgressView,
}

impl Watcher<'_> {
    fn write(&self, session: &Session) -> Result<Snapshot> {
        let snapshot = Snapshot::take(session, self.plan, self.start.elapsed())?;
        write_exr(self.output, &snapshot.picture)?;
        write_png(self.preview, &snapshot.picture, &self.tonemap)?;
        Ok(snapshot)
    }

    /// How much of the render is done, by the rule that is nearest to its end.
    fn fraction(&self, status: &Status) -> Option<f64> {
        let samples = status.target.map(|target| f64::from(status.progress.samples) / f64::from(target));
        let time = self.stop.time.map(|time| status.elapsed.as_secs_f64() / time.as_secs_f64());
        let error = self.stop.error.zip(status.error).map(|(wanted, error)| (wanted / error).powi(2));
        [samples, time, error].into_iter().flatten().reduce(f64::max)
    }
}

impl Observer for Watcher<'_> {
    fn progress(&mut self, status: &Status) {
        let fraction = self.fraction(status);
        self.view.show(status, fraction);
    }

    fn snapshot(&mut self, session: &Session) -> Result<()> {
        self.write(session).map(drop)
    }

    fn interrupted(&self) -> bool {
        self.interrupt.load(Ordering::Relaxed)
    }
}

#[allow(clippy::too_many_arguments)]
fn report(
    arguments: &RenderArgs,
    session: &Session,
    plan: &Plan<'_>,
    snapshot: &Snapshot,
    ended: Ended,
    output: &Path,
    preview: &Path,
    wall: Duration,
) -> Result<()> {
    let progress = session.progress();
    let summary = &snapshot.summary;
    if arguments.json {
        let device = session.device().info();
        print_line(&pretty(&json!({
            "scene": arguments.scene,
            "scene_hash": plan.scene.hash,
            "method": method_name(&plan.scene.method),
            "output": output,
            "preview": preview,
            "ended": format!("{ended:?}").to_lowercase(),
            "samples": progress.samples,
            "seed": plan.scene.seed,
            "seconds": {
                "wall": wall.as_secs_f64(),
                "device": progress.device_time.as_secs_f64(),
                "build": session.build_time.as_secs_f64(),
            },
            "build_cached": session.build_cached,
            "launches": progress.launches,
            "lookups": summary.lookups,
            "lookups_per_ray": summary.lookups as f64 / summary.samples.max(1) as f64,
            "mean": summary.mean,
            "estimated_error": summary.relative_error(),
            "rejected_samples": summary.rejected,
            "device": { "selector": device.selector, "name": device.name, "platform": device.platform, "driver": device.driver },
            "notes": plan.notes,
        })))?;
    } else if !arguments.quiet {
        let error = summary
            .relative_error()
            .map_or(String::new(), |error| format!(", estimated error {:.3} %", error * 100.0));
        eprintln!(
            "{} samples in {:.2} s ({:.2} s on {}){error}",
            progress.samples,
            wall.as_secs_f64(),
            progress.device_time.as_secs_f64(),
            session.device().info().name
        );
        print_line(&format!("wrote {} and its preview {}", output.display(), preview.display()))?;
    }
    if summary.rejected > 0 {
        return Err(Error::Failed(format!(
            "{} samples were not finite and were left out: the image is not to be trusted (it was written to {})",
            summary.rejected,
            output.display()
        )));
    }
    if ended == Ended::Interrupted {
        eprintln!(
            "interrupted after {} samples; the image so far is in {}",
            progress.samples,
            output.display()
        );
        return Err(Error::Interrupted);
    }
    Ok(())
}
