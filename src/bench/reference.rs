//! What errors are measured against: made, read or rendered, and kept as EXR among the results.

use super::files::Folder;
use super::results::{ReferenceInfo, ReferenceKind};
use super::suite::{CaseSpec, ComputedReference, ReferenceSpec, short_hash};
use super::watch::Watch;
use crate::device::{Device, DeviceInfo, sources_hash};
use crate::metrics::{Removed, compare};
use crate::picture::{Picture, read_exr, read_picture, write_exr};
use crate::render::{
    BRICK_SHIFT, Ended, Observer, Plan, Saved, Session, Snapshot, Spent, Status, data_hash, load_volume,
    run as run_progressive,
};
use crate::scene::{Image, Stop};
use crate::{Error, Result};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A reference at hand.
pub struct Reference {
    /// What it is.
    pub info: ReferenceInfo,
    /// Identifies its content.
    pub hash: String,
    /// The picture's EXR.
    path: PathBuf,
}

impl Reference {
    /// The reference of a case: rendered on `device` unless it is there already.
    ///
    /// # Errors
    /// [`Error::Input`] when a file is no picture of the case's size, [`Error::Failed`] when the device or the disk
    /// fails, [`Error::Interrupted`].
    pub fn obtain(case: &CaseSpec, device: &DeviceInfo, folder: &Folder, watch: &Watch<'_>) -> Result<Self> {
        match &case.reference {
            ReferenceSpec::Constant(color) => constant(*color, &case.scene.image, folder),
            ReferenceSpec::File { name, path } => from_file(name, path, &case.scene.image, folder),
            ReferenceSpec::Computed(spec) => computed(spec, &case.name, device, folder, watch),
        }
    }

    /// Reads the picture.
    ///
    /// # Errors
    /// [`Error::Input`] when the file is gone or damaged.
    pub fn picture(&self) -> Result<Picture> {
        read_exr(&self.path)
    }
}

fn constant(color: [f64; 3], image: &Image, folder: &Folder) -> Result<Reference> {
    let (width, height) = (image.width as usize, image.height as usize);
    let mut picture = Picture::new(width, height);
    for (name, value) in ["R", "G", "B"].into_iter().zip(color) {
        picture = picture.with_channel(name, vec![value as f32; width * height]);
    }
    let hash = short_hash(format!("constant {color:?} {width} {height}").as_bytes());
    let [r, g, b] = color;
    let text = if r == g && g == b { format!("{r}") } else { format!("[{r}, {g}, {b}]") };
    keep(&picture, ReferenceKind::Constant, format!("the radiance {text} everywhere, exactly"), hash, folder)
}

fn from_file(name: &str, path: &Path, image: &Image, folder: &Folder) -> Result<Reference> {
    let picture = read_picture(path)?;
    let (width, height) = (image.width as usize, image.height as usize);
    if (picture.width, picture.height) != (width, height) {
        return Err(Error::Input(format!(
            "{}: the reference has {}×{} pixels, the case {width}×{height}; they must be of one size",
            path.display(),
            picture.width,
            picture.height
        )));
    }
    let bytes = std::fs::read(path)
        .map_err(|cause| Error::Input(format!("{}: cannot be read ({cause})", path.display())))?;
    keep(&picture, ReferenceKind::File, format!("the picture {name}"), short_hash(&bytes), folder)
}

fn keep(
    picture: &Picture,
    kind: ReferenceKind,
    description: String,
    hash: String,
    folder: &Folder,
) -> Result<Reference> {
    let name = format!("references/{hash}.exr");
    let path = folder.path(&name);
    write_exr(&path, picture)?;
    Ok(Reference { info: info(picture, kind, description, name)?, hash, path })
}

fn info(picture: &Picture, kind: ReferenceKind, description: String, image: String) -> Result<ReferenceInfo> {
    let itself = compare(picture, picture)?;
    let mean = itself.bias.reference_mean;
    let noise = itself.corrected.iter().find(|entry| entry.removed == Removed::Reference);
    let relative_error = noise.filter(|_| mean != 0.0).map(|entry| entry.noise.sqrt() / mean.abs());
    let number = |key: &str| picture.metadata.get(&format!("svetlo.{key}"))?.parse::<f64>().ok();
    Ok(ReferenceInfo {
        kind,
        description,
        relative_error,
        mean,
        seconds: number("seconds_wall").filter(|_| kind == ReferenceKind::Computed).unwrap_or(0.0),
        samples: number("samples").map(|samples| samples as u64),
        image: Some(image),
    })
}

/// Renders the reference, or goes on with it, until its error or its time is reached.
fn computed(
    spec: &ComputedReference,
    case: &str,
    device: &DeviceInfo,
    folder: &Folder,
    watch: &Watch<'_>,
) -> Result<Reference> {
    let scene = &spec.scene;
    let volume = load_volume(&scene.volume)?;
    let plan = Plan::new(scene, &volume, BRICK_SHIFT)?;
    let data = data_hash(&plan, &volume)?;
    let key = short_hash(
        format!("{} {data} {} {}", scene.hash, sources_hash(), env!("CARGO_PKG_VERSION")).as_bytes(),
    );
    let name = format!("references/{key}.exr");
    let path = folder.path(&name);
    // One that is damaged is no loss: it is rendered anew.
    let saved = Saved::open(&path, scene).ok().flatten();
    let film = saved.as_ref().and_then(|saved| saved.film(&plan, &data).ok());
    let spent = film.as_ref().map(|film| film.spent).unwrap_or_default();
    let before = if film.is_some() { Some(read_exr(&path)?) } else { None };
    if before.as_ref().is_none_or(|picture| !is_finished(picture, spec, &plan)) {
        let time = spec.time.map(|time| time.saturating_sub(spent.wall).max(Duration::from_millis(1)));
        let stop = Stop { samples: None, time, error: Some(spec.error) };
        let mut session = Session::new(Device::open(device)?, &plan)?;
        if let Some(film) = &film {
            session.restore(film)?;
        }
        drop((film, saved, before));
        let mut observer =
            Keeper { plan: &plan, data: &data, path: &path, case, spent, start: Instant::now(), watch };
        watch.say(&format!("reference of {case}: rendering to {:.3} %", spec.error * 100.0));
        let ended = run_progressive(&mut session, &plan, &stop, &mut observer)?;
        if session.progress().samples > 0 {
            observer.write(&session)?;
        }
        if ended == Ended::Interrupted {
            return Err(Error::Interrupted);
        }
    }
    let picture = read_exr(&path)?;
    let samples = picture.metadata.get("svetlo.samples").cloned().unwrap_or_default();
    let state = picture.metadata.get("svetlo.state_hash").cloned().unwrap_or_default();
    let with =
        if spec.overrides.is_empty() { String::new() } else { format!(" with {}", spec.overrides.join(" ")) };
    let description = format!("the same scene{with} by {samples} samples of an independent stream");
    let info = info(&picture, ReferenceKind::Computed, description, name)?;
    Ok(Reference { info, hash: short_hash(format!("{key} {state}").as_bytes()), path })
}

fn is_finished(picture: &Picture, spec: &ComputedReference, plan: &Plan<'_>) -> bool {
    let number = |key: &str| picture.metadata.get(&format!("svetlo.{key}"))?.parse::<f64>().ok();
    let long_enough =
        spec.time.zip(number("seconds_wall")).is_some_and(|(time, wall)| wall >= time.as_secs_f64());
    plan.is_deterministic()
        || long_enough
        || number("estimated_error").is_some_and(|error| error <= spec.error)
}

/// Keeps the state of a reference on disk, so that an interrupted one goes on.
struct Keeper<'a> {
    plan: &'a Plan<'a>,
    data: &'a str,
    path: &'a Path,
    case: &'a str,
    spent: Spent,
    start: Instant,
    watch: &'a Watch<'a>,
}

impl Keeper<'_> {
    fn write(&self, session: &Session) -> Result<()> {
        let wall = self.spent.wall + self.start.elapsed();
        write_exr(self.path, &Snapshot::take(session, self.plan, self.data, wall)?.picture)
    }
}

impl Observer for Keeper<'_> {
    fn progress(&mut self, status: &Status) {
        let error = status.error.map_or(String::new(), |error| format!(", error {:.3} %", error * 100.0));
        let samples = status.progress.samples;
        self.watch.now_and_then(|| format!("reference of {}: {samples} samples{error}", self.case));
    }

    fn snapshot(&mut self, session: &Session) -> Result<()> {
        self.write(session)
    }

    fn interrupted(&self) -> bool {
        self.watch.interrupted()
    }
}
