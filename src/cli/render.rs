//! `svetlo render`.

use super::interrupt::{or_interrupted, watch_interrupt};
use super::output::{check_inputs_survive, output_paths};
use super::places;
use super::progress::ProgressView;
use super::render_args::RenderArgs;
use super::stderr::say;
use super::summary::Summary;
use super::target::Target;
use super::watcher::Watcher;
use super::{load_scene, outlive_file_size_limit, pretty, print_line};
use crate::cluster::{Fleet, Identity, Place};
use crate::crew::{Crew, Team};
use crate::device::{Catalog, Device, DeviceInfo, DeviceName};
use crate::irradiance::LightData;
use crate::picture::{check_writable, remove_leftovers};
use crate::render::{
    BRICK_SHIFT, Ended, Observer, Origin, Plan, Rendering, Saved, SceneData, Session, Spent, data_hash,
    method_name, preview_tonemap, run as run_progressive,
};
use crate::scene::{Method, Scene, Stop};
use crate::{Error, Result};
use serde_json::{Value, json};
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Renders the scene's views.
///
/// Whatever can be wrong is found in the order of its cost: scene, output, device, memory, data.
///
/// `fleet`: the other processes that do so, of which this one has its `place`.
///
/// # Errors
/// With the documented exit codes; see [`Error`].
pub fn run(arguments: &RenderArgs, place: &Place, mut fleet: Option<&mut Fleet<'_>>) -> Result<()> {
    let start = Instant::now();
    outlive_file_size_limit()?;
    let scene = load_scene(&arguments.scene, &arguments.sets())?;
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
    let infos = places::chosen(arguments, &catalog, place)
        .and_then(|infos| places::with_room(infos, &scene, arguments.quiet));
    let (infos, lack) = match (infos, &mut fleet) {
        (infos, None) => (infos?, None),
        (infos, Some(fleet)) => {
            let identity = Identity::of(&scene, arguments.part);
            fleet.muster(&identity, &patience(&interrupt, arguments.quiet)).map_err(unbegun)?;
            fleet.begin(0)?;
            // Others may have devices where this machine has none.
            infos.map_or_else(|error| (Vec::new(), Some(error)), |infos| (infos, None))
        }
    };
    let data = SceneData::load(&scene)?;
    let mut job = Job {
        arguments,
        infos,
        lack,
        fleet,
        data: &data,
        interrupt,
        light: None,
        views: scene.views.len(),
        said: 0,
        reports: Vec::new(),
    };
    let ended = job.render_all(&scene, &outputs, start);
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
struct Job<'a, 'e> {
    arguments: &'a RenderArgs,
    /// The devices of this process, at least one unless there are other processes.
    infos: Vec<&'a DeviceInfo>,
    /// Why there is none.
    lack: Option<Error>,
    /// The other processes.
    fleet: Option<&'a mut Fleet<'e>>,
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

impl<'e> Job<'_, 'e> {
    /// Renders all pictures; `start`: when the work began. One that fails while running keeps no other from being made.
    fn render_all(&mut self, scene: &Scene, outputs: &[PathBuf], mut start: Instant) -> Result<()> {
        let mut failures: Vec<String> = Vec::new();
        for (index, (view, output)) in scene.views.iter().zip(outputs).enumerate() {
            if let Some(fleet) = &mut self.fleet {
                fleet.begin(index)?;
            }
            match self.render(&scene.of_view(view), output, start) {
                Err(Error::Failed(reason)) if self.views > 1 => {
                    if index + 1 < self.views {
                        say(&format!("warning: {reason} (the other views are rendered)"));
                    }
                    failures.push(reason);
                }
                other => other?,
            }
            start = Instant::now();
        }
        if failures.is_empty() {
            return Ok(());
        }
        let count = failures.len();
        failures.dedup();
        Err(Error::Failed(format!("{count} of {} views failed: {}", self.views, failures.join("; "))))
    }

    /// Renders one picture; `start`: when the work for it began.
    fn render(&mut self, scene: &Scene, output: &Path, start: Instant) -> Result<()> {
        let arguments = self.arguments;
        let saved = if arguments.resume { saved(arguments, output, scene)? } else { None };
        let plan = Plan::new(scene, self.data, BRICK_SHIFT)?.of_part(arguments.part)?;
        let data_hash = data_hash(&plan, self.data)?;
        let film = saved.as_ref().map(|saved| saved.film(&plan, &data_hash)).transpose()?;
        plan.notes.iter().skip(self.said).for_each(|note| self.note(note));
        self.said = plan.notes.len();
        let origin = saved.as_ref().map(Saved::origin);
        let light = self.given_light(&plan, &data_hash)?;
        if let Some(saved) = &saved {
            saved.check_light(light.map(LightData::hash).as_deref())?;
        }
        // Its planes are as large as the image.
        drop(saved);
        let task = Task { plan: &plan, data_hash: &data_hash, output, start };
        if let ([info], None) = (&*self.infos, &self.fleet) {
            self.note_origin(origin.as_ref(), &[info.names()]);
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
        let team = self.team(&data_hash)?;
        self.note_origin(origin.as_ref(), &team.names());
        let light = self.light.clone();
        let ended = std::thread::scope(|scope| {
            let mut crew = Crew::start(scope, &plan, team, light.as_ref(), film)?;
            crew.set_light_from_file(arguments.load_light.is_some());
            self.finish(&mut crew, &task, spent)
        });
        self.fleet.as_mut().map_or(Ok(()), |fleet| fleet.close()).and(ended)
    }

    /// Those that work together: the devices that can be opened, and those of other processes.
    fn team<'s>(&self, data_hash: &str) -> Result<Team<'s>>
    where
        'e: 's,
    {
        let (devices, refusals) = places::open(&self.infos);
        let mut notes: Vec<String> = refusals.iter().map(|refusal| format!("left out: {refusal}")).collect();
        let mut colleagues = Vec::new();
        if let Some(fleet) = &self.fleet {
            let go_on = patience(&self.interrupt, self.arguments.quiet);
            let (theirs, remarks) = fleet.devices(data_hash, &go_on).map_err(unbegun)?;
            colleagues = theirs;
            notes.extend(remarks);
        }
        let lack = self.lack.as_ref().filter(|_| !colleagues.is_empty());
        notes.extend(lack.map(|error| format!("rank 0 takes no part: {error}")));
        notes.iter().for_each(|note| self.note(note));
        if devices.is_empty() && colleagues.is_empty() {
            return Err(self.lack.clone().unwrap_or_else(|| Error::Failed(refusals.join("; "))));
        }
        Ok(Team { devices, colleagues })
    }

    /// Says where the image that is resumed was begun, if that matters.
    fn note_origin(&self, origin: Option<&Origin>, devices: &[DeviceName]) {
        origin.and_then(|origin| origin.note(devices)).iter().for_each(|note| self.note(note));
    }

    fn note(&self, text: &str) {
        if !self.arguments.quiet {
            say(&format!("note: {text}"));
        }
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
        let added = session.progress().samples != begun.samples || session.progress().tiles != begun.tiles;
        let ended = ended.map_err(|error| or_interrupted(&self.interrupt, error));
        // A picture with holes must not replace an older one.
        let has_holes = session.progress().samples == 0;
        if let Err(Error::Failed(why)) = &ended
            && session.outlives_devices()
            && added
            && !has_holes
        {
            let kept = match watcher.finish(session, added) {
                Ok(_) => format!("the image so far is in {}", output.display()),
                Err(error) => error.to_string(),
            };
            return Err(Error::Failed(format!("{why}; {kept}")));
        }
        let ended = ended?;
        if ended == Ended::Interrupted && has_holes {
            return Err(unbegun(Error::Interrupted));
        }
        let snapshot = watcher.finish(session, added);
        // Further pictures need it, whatever has become of this one.
        let kept = self.keep_light(session, plan, data_hash);
        let snapshot = snapshot?;
        // An interrupt takes nothing from the picture.
        let kept = match kept {
            Err(Error::Interrupted) => Err(Error::Interrupted),
            other => Ok(other?),
        };
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
            processes: self.fleet.as_ref().map(|fleet| (fleet.size(), fleet.traffic())),
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
        summary.outcome().and(printed).and(kept)
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
            let go_on = || !self.interrupt.load(Ordering::Relaxed);
            let computed =
                session.compute_light(&go_on).map_err(|error| or_interrupted(&self.interrupt, error));
            if matches!(computed, Err(Error::Interrupted)) {
                say("interrupted before the light volume was computed; it was not written");
            }
            computed?;
        }
        self.light = session.light()?;
        match (&self.arguments.save_light, &self.light) {
            (Some(path), Some(light)) => light.write(path, plan, data_hash),
            (Some(path), None) => {
                Err(Error::Failed(format!("{}: there is no light volume to write", path.display())))
            }
            (None, _) => Ok(()),
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

/// Waits for other processes until an interrupt comes, and says so once where it takes long.
fn patience(interrupt: &AtomicBool, quiet: bool) -> impl Fn(&str, Duration) -> bool {
    const LONG: Duration = Duration::from_secs(10);
    let said = RefCell::new(String::new());
    move |rank, waited| {
        if !quiet && waited > LONG && *said.borrow() != rank {
            say(&format!("note: still waiting for {rank}"));
            said.replace(rank.to_owned());
        }
        !interrupt.load(Ordering::Relaxed)
    }
}

/// Says that an interrupt has come before there was a picture.
fn unbegun(error: Error) -> Error {
    if matches!(error, Error::Interrupted) {
        say("interrupted before the first sample of every pixel was done; nothing was written");
    }
    error
}

fn stop_rules(arguments: &RenderArgs, scene: &Scene) -> Stop {
    if arguments.samples.is_none() && arguments.time.is_none() && arguments.error.is_none() {
        return scene.stop;
    }
    Stop { samples: arguments.samples, time: arguments.time, error: arguments.error }
}
