//! `svetlo render`.

use super::interrupt::{or_interrupted, watch_interrupt};
use super::output::{check_inputs_survive, output_paths};
use super::progress::ProgressView;
use super::stderr::say;
use super::summary::Summary;
use super::target::Target;
use super::watcher::Watcher;
use super::{load_scene, outlive_file_size_limit, pretty, print_line};
use crate::config::formats::{parse_duration, parse_percentage};
use crate::crew::Crew;
use crate::device::{Catalog, Device, DeviceInfo};
use crate::irradiance::LightData;
use crate::picture::{check_writable, remove_leftovers};
use crate::render::{
    BRICK_SHIFT, Ended, Observer, Plan, Rendering, Saved, SceneData, Session, Share, Spent, announced_memory,
    data_hash, method_name, preview_tonemap, run as run_progressive,
};
use crate::scene::{Method, Scene, Stop};
use crate::{Error, Result};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// Arguments of `svetlo render`.
#[derive(clap::Args)]
pub struct RenderArgs {
    /// The scene file.
    scene: PathBuf,
    /// The image to write; the preview goes beside it as .png [default: the scene's name with .exr, here]. A scene with
    /// several views writes OUT.0001.exr, OUT.0002.exr and so on.
    #[arg(short, long, value_name = "OUT.exr")]
    output: Option<PathBuf>,
    /// Override a value of the scene, such as `image.width=256` (repeatable).
    #[arg(long, value_name = "KEY.PATH=VALUE")]
    set: Vec<String>,
    /// The device: a selector of `svetlo devices`, a kind (cpu, gpu) or part of a name. Repeat it for several that share the
    /// work, or say all, or all:gpu [env: SVETLO_DEVICE, several with commas between].
    #[arg(long, value_name = "SELECTOR")]
    device: Vec<String>,
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
    /// Rewrite the image and its preview after this time, and again and again, such as 10m [default: after 1s, then every
    /// 5s, or less often where that would take more than a twentieth of the time].
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    snapshot: Option<Duration>,
    /// Write the light volume (hybrid-diffusion, convection-diffusion) to this file, too.
    #[arg(long, value_name = "LIGHT.nrrd", conflicts_with = "load_light")]
    save_light: Option<PathBuf>,
    /// Take the light volume from this file instead of computing it: the scene may differ in camera, image and stop
    /// rules alone.
    #[arg(long, value_name = "LIGHT.nrrd")]
    load_light: Option<PathBuf>,
    /// Render part I of N, for `svetlo merge` to add up: the samples I, I + N, I + 2N … of the picture, as a picture of its
    /// own. --samples and --error stay those of the whole picture: a part stops with its share of the samples, or where N
    /// parts like it have that error together. [default output: the scene's name with .I-of-N.exr]
    #[arg(long, value_name = "I/N", value_parser = clap::value_parser!(Share))]
    part: Option<Share>,
    /// Print nothing but errors.
    #[arg(long)]
    quiet: bool,
    /// Print a JSON summary to stdout at the end, and nothing else there.
    #[arg(long)]
    json: bool,
}

/// Renders the scene's views.
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
    let outputs =
        output_paths(&arguments.scene, arguments.output.as_deref(), arguments.part, scene.views.len())?;
    check_share(arguments, &scene)?;
    for output in &outputs {
        for path in [output, &output.with_extension("png")] {
            check_writable(path)?;
            check_inputs_survive(path, &arguments.scene, &scene)?;
        }
    }
    check_light_files(arguments, &scene)?;
    remove_leftovers(&outputs[0]);
    let interrupt = watch_interrupt()?;
    let catalog = Catalog::enumerate();
    let infos = catalog.select_several(&selectors(arguments))?;
    let infos = with_room(infos, &scene, arguments.quiet)?;
    let data = SceneData::load(&scene)?;
    let mut job = Job {
        arguments,
        infos,
        data: &data,
        interrupt,
        light: None,
        views: scene.views.len(),
        said: 0,
        reports: Vec::new(),
    };
    let mut start = start;
    let ended = scene.views.iter().zip(&outputs).try_for_each(|(view, output)| {
        let ended = job.render(&scene.of_view(view), output, start);
        start = Instant::now();
        ended
    });
    job.report()?;
    ended
}

/// One picture that is to be made.
struct Task<'a> {
    plan: &'a Plan<'a>,
    data_hash: &'a str,
    output: &'a Path,
    /// When the work for it began.
    start: Instant,
}

/// What the pictures of a scene share.
struct Job<'a> {
    arguments: &'a RenderArgs,
    /// The devices, at least one.
    infos: Vec<&'a DeviceInfo>,
    data: &'a SceneData,
    interrupt: Arc<AtomicBool>,
    /// The light volume, once a picture has computed it and others need it.
    light: Option<LightData>,
    views: usize,
    /// How many notes have been said: those of one picture are those of all.
    said: usize,
    /// Summaries for `--json`.
    reports: Vec<Value>,
}

impl Job<'_> {
    /// Renders one picture; `start`: when the work for it began.
    fn render(&mut self, scene: &Scene, output: &Path, start: Instant) -> Result<()> {
        let arguments = self.arguments;
        let saved = if arguments.resume { saved(arguments, output, scene)? } else { None };
        let plan = Plan::new(scene, self.data, BRICK_SHIFT)?.of_part(arguments.part)?;
        let data_hash = data_hash(&plan, self.data)?;
        let film = saved.as_ref().map(|saved| saved.film(&plan, &data_hash)).transpose()?;
        if !arguments.quiet {
            let resumed = saved.as_ref().and_then(|saved| {
                saved.note(&self.infos.iter().map(|info| info.names()).collect::<Vec<_>>())
            });
            let notes = plan.notes.iter().skip(self.said).chain(&resumed);
            notes.for_each(|note| say(&format!("note: {note}")));
            self.said = plan.notes.len();
        }
        let light = self.given_light(&plan, &data_hash)?;
        if let Some(saved) = &saved {
            saved.check_light(light.map(LightData::hash).as_deref())?;
        }
        // Its planes are as large as the image.
        drop(saved);
        let task = Task { plan: &plan, data_hash: &data_hash, output, start };
        if let [info] = *self.infos {
            let session =
                Device::open(info).and_then(|device| Session::lit(device, &plan, self.light.as_ref()));
            let mut session = session.map_err(|error| or_interrupted(&self.interrupt, error))?;
            session.set_light_from_file(arguments.load_light.is_some());
            session.interrupt_by(Arc::clone(&self.interrupt));
            let spent = film.as_ref().map(|film| film.spent);
            film.map(|film| session.restore(&film)).transpose()?;
            return self.finish(&mut session, &task, spent);
        }
        let spent = film.as_ref().map(|film| film.spent);
        let devices = self.open_devices()?;
        let light = self.light.clone();
        std::thread::scope(|scope| {
            let mut crew = Crew::start(scope, &plan, devices, light.as_ref(), film)?;
            crew.set_light_from_file(arguments.load_light.is_some());
            self.finish(&mut crew, &task, spent)
        })
    }

    /// The devices that can be opened; of the others the user is told.
    fn open_devices(&self) -> Result<Vec<Device>> {
        let mut devices = Vec::new();
        let mut refusals = Vec::new();
        for info in &self.infos {
            match Device::open(info) {
                Ok(device) => devices.push(device),
                Err(error) => refusals.push(error.to_string()),
            }
        }
        if devices.is_empty() {
            return Err(Error::Failed(refusals.join("; ")));
        }
        if !self.arguments.quiet {
            refusals.iter().for_each(|refusal| say(&format!("note: left out: {refusal}")));
        }
        Ok(devices)
    }

    /// Renders to the end, writes the pictures and says so.
    fn finish(&mut self, session: &mut dyn Rendering, task: &Task<'_>, spent: Option<Spent>) -> Result<()> {
        let arguments = self.arguments;
        let Task { plan, data_hash, output, start } = *task;
        let preview = output.with_extension("png");
        let begun = session.progress();
        let stop = stop_rules(arguments, plan.scene);
        let mut watcher = Watcher {
            plan,
            data_hash,
            spent: spent.unwrap_or_default(),
            target: Target::new(output, &preview),
            tonemap: preview_tonemap(&plan.scene.film),
            start,
            interrupt: Arc::clone(&self.interrupt),
            stop: &stop,
            view: ProgressView::new(arguments.quiet),
            quiet: arguments.quiet,
            interval: arguments.snapshot,
        };
        let ended = run_progressive(session, plan, &stop, &mut watcher);
        watcher.view.finish();
        // Of what was lost with the last samples, too.
        session.take_notes().iter().for_each(|note| watcher.note(note));
        let ended = ended.map_err(|error| or_interrupted(&self.interrupt, error))?;
        if ended == Ended::Interrupted && session.progress().samples == 0 {
            // A picture with holes must not replace an older one.
            say("interrupted before the first sample of every pixel was done; nothing was written");
            return Err(Error::Interrupted);
        }
        let added = session.progress().samples != begun.samples || session.progress().tiles != begun.tiles;
        let snapshot = watcher.finish(session, added)?;
        self.keep_light(session, plan, data_hash)?;
        let summary = Summary {
            scene: &arguments.scene,
            output,
            preview: &preview,
            plan,
            session,
            snapshot: &snapshot,
            ended,
            wall: watcher.wall(),
            resumed: spent,
            added,
        };
        let mut printed = Ok(());
        if arguments.json {
            self.reports.push(summary.json());
            if !arguments.quiet {
                summary.warn();
            }
        } else {
            printed = summary.print(arguments.quiet);
        }
        // After the end of the terminal, stdout takes nothing: the interrupt is the reason then.
        summary.outcome().and(printed)
    }

    /// Reads the light volume that is to be taken from a file, if that is asked for.
    fn given_light(&mut self, plan: &Plan<'_>, data_hash: &str) -> Result<Option<&LightData>> {
        let Some(path) = &self.arguments.load_light else { return Ok(None) };
        if self.light.is_none() {
            self.light = Some(LightData::read(path, plan, data_hash)?);
        }
        Ok(self.light.as_ref())
    }

    /// Writes the light volume that a session has computed if that is asked for, and keeps it for further pictures.
    fn keep_light(&mut self, session: &mut dyn Rendering, plan: &Plan<'_>, data_hash: &str) -> Result<()> {
        let wanted = self.views > 1 || self.arguments.save_light.is_some();
        if self.light.is_some() || !wanted {
            return Ok(());
        }
        if self.arguments.save_light.is_some() {
            // A picture that was finished before has not asked for it.
            session.compute_light().map_err(|error| or_interrupted(&self.interrupt, error))?;
        }
        self.light = session.light()?;
        match (&self.arguments.save_light, &self.light) {
            (Some(path), Some(light)) => light.write(path, plan, data_hash),
            _ => Ok(()),
        }
    }

    /// Prints what `--json` asks for: one summary, or a list of them where the scene has several views.
    fn report(&self) -> Result<()> {
        match self.reports.as_slice() {
            [] => Ok(()),
            [one] if self.views == 1 => print_line(&pretty(one)),
            all => print_line(&pretty(&json!({ "views": all }))),
        }
    }
}

/// Refuses files for the light volume where there is none, or where they could not be written.
fn check_light_files(arguments: &RenderArgs, scene: &Scene) -> Result<()> {
    let lit = matches!(scene.method, Method::LightVolume(_));
    for (option, path) in [("--load-light", &arguments.load_light), ("--save-light", &arguments.save_light)] {
        if let (Some(_), false) = (path, lit) {
            return Err(Error::Input(format!(
                "{option} needs a method that computes light in the volume (hybrid-diffusion or convection-diffusion); \
                 this scene's is {}",
                method_name(&scene.method)
            )));
        }
    }
    let Some(path) = &arguments.save_light else { return Ok(()) };
    if !path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("nrrd")) {
        return Err(Error::Input(format!(
            "{}: the light volume is written as NRRD, so its name must end in .nrrd",
            path.display()
        )));
    }
    check_writable(path)?;
    check_inputs_survive(path, &arguments.scene, scene)
}

/// Refuses a part that has none of the samples.
fn check_share(arguments: &RenderArgs, scene: &Scene) -> Result<()> {
    let samples = stop_rules(arguments, scene).samples;
    match (arguments.part, samples) {
        (Some(share), Some(samples)) if share.count(samples) == 0 => Err(Error::Input(format!(
            "--part {share}: a picture of {samples} samples has none for this part; render it in {samples} parts at most, \
             or with more --samples"
        ))),
        _ => Ok(()),
    }
}

/// The image to continue, if there is one.
fn saved(arguments: &RenderArgs, output: &Path, scene: &Scene) -> Result<Option<Saved>> {
    let saved = Saved::open(output, scene)?;
    if saved.is_none() && !arguments.quiet {
        say(&format!("note: there is no {} to resume: the render starts anew", output.display()));
    }
    Ok(saved)
}

/// Those of the devices that have room for what the scene announces; of the others the user is told.
fn with_room<'a>(infos: Vec<&'a DeviceInfo>, scene: &Scene, quiet: bool) -> Result<Vec<&'a DeviceInfo>> {
    let needed = announced_memory(scene);
    let mut able = Vec::new();
    let mut refusals = Vec::new();
    for info in infos {
        match needed.check(info) {
            Ok(()) => able.push(info),
            Err(error) => refusals.push(error),
        }
    }
    if able.is_empty()
        && let Some(error) = refusals.pop()
    {
        return Err(error);
    }
    if !quiet {
        refusals.iter().for_each(|error| say(&format!("note: left out: {error}")));
    }
    Ok(able)
}

/// `--device`, else `SVETLO_DEVICE` unless it is empty, as an unset variable of a script is.
fn selectors(arguments: &RenderArgs) -> Vec<String> {
    if !arguments.device.is_empty() {
        return arguments.device.clone();
    }
    let variable = std::env::var("SVETLO_DEVICE").unwrap_or_default();
    let words = variable.split(',').map(str::trim).filter(|word| !word.is_empty());
    words.map(str::to_owned).collect()
}

fn stop_rules(arguments: &RenderArgs, scene: &Scene) -> Stop {
    if arguments.samples.is_none() && arguments.time.is_none() && arguments.error.is_none() {
        return scene.stop;
    }
    Stop { samples: arguments.samples, time: arguments.time, error: arguments.error }
}
