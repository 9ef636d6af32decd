//! References that are rendered: several independent streams, whose spread is their error.
//!
//! The film's own variance is not trusted here: where samples of a pixel are spread evenly on purpose, it is far above
//! that of their mean, and taking it out of a measured error would take out too much. The streams' means are independent
//! whatever the samples are. The picture that is kept holds their mean, `variance.*` between them, and their number as
//! `samples`. Each stream has an image of its own, from which it goes on after an interrupt.

use super::files::Folder;
use super::pool::pool_equal;
use super::suite::{ComputedReference, short_hash};
use super::watch::Watch;
use crate::device::{Device, DeviceInfo, sources_hash};
use crate::metrics::{Removed, compare};
use crate::picture::{Picture, read_exr, write_exr};
use crate::render::{
    BRICK_SHIFT, Ended, Observer, Plan, Rendering, Saved, SceneData, Session, Snapshot, Spent, Status,
    data_hash, run as run_progressive,
};
use crate::scene::{Scene, Stop};
use crate::{Error, Result};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Independent streams: their variance is summed over all pixels, so few are enough.
const STREAMS: u64 = 4;
/// Samples of each stream in the first round.
const FIRST: u64 = 2;
/// Most that a round multiplies the samples by: the error of the first rounds is a rough guess.
const GROWTH: f64 = 4.0;
/// Aims a little below the error that is asked for, so that the last round is not a series of small ones.
const MARGIN: f64 = 0.95;

/// An error that is above this share of what it was at half the samples no longer falls: noise would be at 0.71 of it.
const FALL: f64 = 0.9;

/// A reference that was rendered.
pub struct Rendered {
    /// Mean of the streams, with the variance between them.
    pub picture: Picture,
    /// Samples per pixel of all streams.
    pub samples: u64,
    /// Wall time of all streams.
    pub seconds: f64,
    /// Identifies the picture.
    pub hash: String,
    /// Its EXR, relative to the folder.
    pub name: String,
}

/// Renders a reference, or goes on with it, until its error or its time is reached.
///
/// # Errors
/// [`Error::Input`] when the scene's data are wrong, [`Error::Failed`] when the device or the disk fails,
/// [`Error::Interrupted`].
pub fn render(
    spec: &ComputedReference,
    case: &str,
    device: &DeviceInfo,
    folder: &Folder,
    watch: &Watch<'_>,
) -> Result<Rendered> {
    let loaded = SceneData::load(&spec.scenes[0])?;
    let plan = Plan::new(&spec.scenes[0], &loaded, BRICK_SHIFT)?;
    let data = data_hash(&plan, &loaded)?;
    let (random, lit) = (plan.depends_on_seed(), plan.method.light.is_some());
    drop(plan);
    let version = env!("CARGO_PKG_VERSION");
    let key = short_hash(
        format!("{} {data} {} {version}", spec.scenes[0].seedless_hash, sources_hash()).as_bytes(),
    );
    let streams = if random { STREAMS as usize } else { 1 };
    let streams =
        spec.scenes.iter().take(streams).enumerate().map(|(index, scene)| Stream {
            scene,
            path: folder.path(&format!("references/{key}-{index}.exr")),
        });
    let streams = streams.collect();
    let mut job = Job { spec, case, device, loaded: &loaded, data: &data, watch, lit, streams };
    let (pictures, samples, seconds) = job.run()?;
    let hash = short_hash(format!("{key} {samples}").as_bytes());
    let name = format!("references/{key}.exr");
    let picture = pool_equal(&pictures).ok_or_else(|| Error::Failed("a reference without streams".into()))?;
    write_exr(&folder.path(&name), &picture)?;
    Ok(Rendered { picture: read_exr(&folder.path(&name))?, samples, seconds, hash, name })
}

/// RMSE of a picture over its mean, by its own variance; `None` without one.
pub fn relative_error(picture: &Picture) -> Result<Option<f64>> {
    let itself = compare(picture, picture)?;
    let mean = itself.bias.reference_mean.abs();
    let noise = itself.corrected.iter().find(|entry| entry.removed == Removed::Reference);
    Ok(noise.map(|entry| if entry.noise == 0.0 { 0.0 } else { entry.noise.sqrt() / mean }))
}

/// The scenes of a reference's streams: one for each seed.
pub fn scenes(path: &Path, sets: &[String], first_seed: u64) -> Result<Vec<Scene>> {
    let with_seed = |stream: u64| {
        let seed = format!("seed={}", first_seed + stream);
        Scene::load(path, &[sets, &[seed]].concat())
    };
    (0..STREAMS).map(with_seed).collect()
}

/// Samples and errors of the rounds so far.
#[derive(Default)]
struct Rounds(Vec<(u64, f64)>);

impl Rounds {
    /// Whether more samples are in vain: the noise of a light volume, which comes before the first sample, stays.
    fn is_floor(&mut self, samples: u64, error: f64) -> bool {
        let repeated = self.0.last().is_some_and(|&(before, _)| samples <= before);
        let in_vain = |&(before, known): &(u64, f64)| 2 * before <= samples && error > FALL * known;
        let floor = repeated || self.0.iter().any(in_vain);
        self.0.push((samples, error));
        floor
    }
}

struct Stream<'a> {
    scene: &'a Scene,
    path: PathBuf,
}

struct Job<'a> {
    spec: &'a ComputedReference,
    case: &'a str,
    device: &'a DeviceInfo,
    loaded: &'a SceneData,
    data: &'a str,
    watch: &'a Watch<'a>,
    /// Whether there is a light volume.
    lit: bool,
    streams: Vec<Stream<'a>>,
}

impl Job<'_> {
    /// The streams' pictures, all with the same number of samples; samples and seconds of all.
    fn run(&mut self) -> Result<(Vec<Picture>, u64, f64)> {
        let mut target = self.samples_there().max(FIRST);
        let mut rounds = Rounds::default();
        loop {
            let mut pictures = Vec::new();
            let (mut samples, mut seconds) = (0, 0.0);
            for stream in &self.streams {
                let (picture, spent) = self.advance(stream, target)?;
                samples += u64::from(spent.progress.samples);
                seconds += spent.wall.as_secs_f64();
                pictures.push(picture);
            }
            let pooled = pool_equal(&pictures);
            let error = pooled.as_ref().map(relative_error).transpose()?.flatten();
            let over = self.spec.time.is_some_and(|time| seconds >= time.as_secs_f64())
                || self.lit && error.is_some_and(|error| rounds.is_floor(samples, error));
            let Some(error) = error.filter(|&error| error > self.spec.error && !over) else {
                return Ok((pictures, samples, seconds));
            };
            self.watch.say(&format!(
                "reference of {}: {samples} samples, error {:.3} % (wanted {:.3} %)",
                self.case,
                error * 100.0,
                self.spec.error * 100.0
            ));
            target = self.next_target(target, error, seconds);
        }
    }

    /// As many samples as the error asks for by the n^−1/2 law, within the growth of a round and the time.
    fn next_target(&self, target: u64, error: f64, seconds: f64) -> u64 {
        let wanted = (error / (MARGIN * self.spec.error)).powi(2).min(GROWTH);
        let possible = self.spec.time.map_or(f64::MAX, |time| time.as_secs_f64() / seconds.max(1e-3));
        let next = (target as f64 * wanted.min(possible.max(1.05))).ceil();
        (next as u64).max(target + 1).min(u64::from(u32::MAX))
    }

    /// The samples that every stream has: where an earlier run of the bench ended.
    fn samples_there(&self) -> u64 {
        let of = |stream: &Stream<'_>| {
            let picture = read_exr(&stream.path).ok()?;
            picture.metadata.get("svetlo.samples")?.parse::<u64>().ok()
        };
        self.streams.iter().map(|stream| of(stream).unwrap_or(0)).min().unwrap_or(0)
    }

    /// Brings a stream to `target` samples, or leaves it where it is if it has them.
    fn advance(&self, stream: &Stream<'_>, target: u64) -> Result<(Picture, Spent)> {
        let plan = Plan::new(stream.scene, self.loaded, BRICK_SHIFT)?;
        let target = if plan.is_deterministic() { 1 } else { target };
        // One that is damaged is no loss: it is rendered anew.
        let saved = Saved::open(&stream.path, stream.scene).ok().flatten();
        let film = saved.as_ref().and_then(|saved| saved.film(&plan, self.data).ok());
        let spent = film.as_ref().map(|film| film.spent).unwrap_or_default();
        let there = spent.progress;
        if film.is_some() && there.tiles == 0 && u64::from(there.samples) == target {
            return Ok((read_exr(&stream.path)?, spent));
        }
        let mut session = Session::new(Device::open(self.device)?, &plan)?;
        // More than are wanted would be another picture than without the interrupt.
        if let Some(film) = film.filter(|_| u64::from(there.samples) < target) {
            session.restore(&film)?;
        }
        let stop = Stop { samples: Some(target), time: None, error: None };
        let start = Instant::now();
        let spent = if session.progress().samples > 0 { spent.wall } else { Duration::ZERO };
        let mut keeper = Keeper { job: self, plan: &plan, path: &stream.path, spent, start };
        let ended = run_progressive(&mut session, &plan, &stop, &mut keeper)?;
        let picture = keeper.write(&session)?;
        if ended == Ended::Interrupted {
            return Err(Error::Interrupted);
        }
        let wall = keeper.wall();
        Ok((picture, Spent { progress: session.progress(), wall, build: session.build_time }))
    }
}

/// Keeps the state of a stream on disk, so that an interrupted one goes on.
struct Keeper<'a> {
    job: &'a Job<'a>,
    plan: &'a Plan<'a>,
    path: &'a Path,
    spent: Duration,
    start: Instant,
}

impl Keeper<'_> {
    fn wall(&self) -> Duration {
        self.spent + self.start.elapsed()
    }

    fn write(&self, session: &dyn Rendering) -> Result<Picture> {
        let picture = Snapshot::take(session, self.plan, self.job.data, self.wall())?.picture;
        if session.progress().samples > 0 {
            write_exr(self.path, &picture)?;
        }
        Ok(picture)
    }
}

impl Observer for Keeper<'_> {
    fn progress(&mut self, status: &Status) {
        let (samples, target) = (status.progress.samples, status.target.unwrap_or_default());
        self.job.watch.now_and_then(|| {
            format!("reference of {}: {samples}/{target} samples of a stream", self.job.case)
        });
    }

    fn snapshot(&mut self, session: &dyn Rendering) -> Result<()> {
        self.write(session).map(drop)
    }

    fn interrupted(&self) -> bool {
        self.job.watch.interrupted()
    }
}

#[cfg(test)]
mod tests {
    use super::Rounds;

    #[test]
    fn what_no_longer_falls_is_a_floor() {
        let floor_at = |errors: &[(u64, f64)]| {
            let mut rounds = Rounds::default();
            errors.iter().position(|&(samples, error)| rounds.is_floor(samples, error))
        };
        assert_eq!(floor_at(&[(8, 0.1), (32, 0.05), (64, 0.036), (80, 0.032), (90, 0.03)]), None);
        assert_eq!(floor_at(&[(8, 0.1), (32, 0.05), (128, 0.047)]), Some(2));
        // In small steps, too.
        assert_eq!(floor_at(&[(8, 0.1), (12, 0.099), (15, 0.098), (18, 0.098)]), Some(3));
        // Where nothing is random but the light, there are no more samples to be had.
        assert_eq!(floor_at(&[(4, 0.1), (4, 0.1)]), Some(1));
    }
}
