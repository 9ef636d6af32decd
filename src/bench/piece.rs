//! One piece of a bench: one repeat of a case on a device, measured at its checkpoints.

use super::files::{Folder, read_json, write_json};
use super::measure::measure;
use super::pool::without_state;
use super::results::{Checkpoint, LightRun, PhotonRun, Repeat};
use super::suite::{CaseSpec, Checkpoints, short_hash};
use super::watch::Watch;
use crate::device::{Device, DeviceInfo, sources_hash};
use crate::metrics::squared_error_blocks;
use crate::picture::{Picture, read_exr, write_exr};
use crate::render::{BRICK_SHIFT, Plan, Progress, SceneData, Session, Snapshot, data_hash};
use crate::scene::Scene;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// The format of pieces; part of their keys.
const FORMAT: u32 = 1;
/// Voxels that a look-up reads.
const VOXELS_PER_LOOKUP: u64 = 8;

/// A finished piece, as it is kept for later runs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Piece {
    /// Identifies everything that it depends on.
    pub key: String,
    /// What was measured.
    pub repeat: Repeat,
    /// Squared errors by checkpoint, summed over blocks.
    pub blocks: Vec<Vec<f64>>,
}

/// What to measure.
pub struct Task<'a> {
    /// The case.
    pub case: &'a CaseSpec,
    /// Where.
    pub device: &'a DeviceInfo,
    /// Seed of the repeat.
    pub seed: u64,
    /// Hash of the data that the case's scene reads.
    pub data: &'a str,
    /// The case's reference, then those of other cases with the same pictures: they are measured in passing, and kept
    /// as pieces of their own.
    pub references: Vec<Target>,
}

/// A reference to measure against.
pub struct Target {
    /// Its hash.
    pub hash: String,
    /// The picture.
    pub picture: Picture,
}

impl Task<'_> {
    /// Identifies the piece: whatever changes its numbers, or the device they are of, changes it.
    pub fn key(&self) -> String {
        self.key_of(&self.references[0])
    }

    fn key_of(&self, reference: &Target) -> String {
        let Self { case, device, seed, data, .. } = self;
        let reference_hash = &reference.hash;
        let DeviceInfo { selector, platform, name, driver, version, .. } = device;
        let parts = format!(
            "{FORMAT} {} {} {}\n{data} {reference_hash} {seed} {} {:?}\n{selector} {platform} {name} {driver} {version}",
            env!("CARGO_PKG_VERSION"),
            sources_hash(),
            case.scene.seedless_hash,
            case.warmup,
            case.checkpoints,
        );
        short_hash(parts.as_bytes())
    }

    /// The piece that an earlier run left, if it is whole: one that is damaged is measured anew.
    pub fn finished(&self, folder: &Folder) -> Option<Piece> {
        let key = self.key();
        let piece: Piece = read_json(&folder.path(&format!("runs/{key}.json")), "a piece").ok()?;
        (piece.key == key && read_exr(&folder.path(&picture_name(&key))).is_ok()).then_some(piece)
    }

    /// Measures the piece and keeps it.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device or the disk fails, [`Error::Interrupted`].
    pub fn run(&self, folder: &Folder, watch: &Watch<'_>) -> Result<Piece> {
        let begin = Instant::now();
        let mut sets = self.case.overrides.clone();
        sets.push(format!("seed={}", self.seed));
        let scene = Scene::load(&self.case.scene_path, &sets)?;
        let loaded = SceneData::load(&scene)?;
        let plan = Plan::new(&scene, &loaded, BRICK_SHIFT)?;
        let data = data_hash(&plan, &loaded)?;
        let mut session = Session::new(Device::open(self.device)?, &plan)?;
        let prepare = begin.elapsed().saturating_sub(session.build_time);
        let warmup = warm_up(&mut session, &plan, self.case.warmup, watch)?;
        let mut run = Run {
            task: self,
            session: &mut session,
            plan: &plan,
            data: &data,
            bytes: plan
                .volume
                .as_ref()
                .map_or(0, |volume| VOXELS_PER_LOOKUP * volume.grid.device_voxels().1 as u64),
            clock: Duration::ZERO,
            measured: self.references.iter().map(|_| (Vec::new(), Vec::new())).collect(),
            last: None,
            watch,
        };
        if let Some(limit) = self.case.limit {
            watch.arm(limit, &format!("{} on {}", self.case.name, self.device.selector));
        }
        let outcome = run.checkpoints();
        watch.disarm();
        outcome?;
        let (measured, last) = (run.measured, run.last.map(without_state));
        let light = session.light_facts().map(LightRun::of);
        let photons = session.pass_facts().map(PhotonRun::of);
        let repeat = |checkpoints| Repeat {
            seed: self.seed,
            build_seconds: session.build_time.as_secs_f64(),
            build_cached: session.build_cached,
            prepare_seconds: prepare.as_secs_f64(),
            warmup_seconds: warmup.as_secs_f64(),
            light,
            photons,
            checkpoints,
        };
        let mut pieces = Vec::new();
        for (reference, (checkpoints, blocks)) in self.references.iter().zip(measured) {
            let key = self.key_of(reference);
            if let Some(picture) = &last {
                write_exr(&folder.path(&picture_name(&key)), picture)?;
            }
            let piece = Piece { key, repeat: repeat(checkpoints), blocks };
            write_json(&folder.path(&format!("runs/{}.json", piece.key)), &piece)?;
            pieces.push(piece);
        }
        Ok(pieces.swap_remove(0))
    }
}

/// The picture of a piece at its last checkpoint, relative to the folder.
pub fn picture_name(key: &str) -> String {
    format!("runs/{key}.exr")
}

/// Launches that do not count: the first ones compile, and find the launches' sizes. A light volume is computed for them,
/// and again when the clock runs.
fn warm_up(session: &mut Session, plan: &Plan<'_>, samples: u32, watch: &Watch<'_>) -> Result<Duration> {
    if samples == 0 {
        return Ok(Duration::ZERO);
    }
    let begin = Instant::now();
    while session.progress().samples < samples {
        session.step(samples)?;
        stop_if_asked(watch)?;
    }
    let elapsed = begin.elapsed();
    session.restart(plan)?;
    Ok(elapsed)
}

fn stop_if_asked(watch: &Watch<'_>) -> Result<()> {
    if watch.interrupted() { Err(Error::Interrupted) } else { Ok(()) }
}

struct Run<'a> {
    task: &'a Task<'a>,
    session: &'a mut Session,
    plan: &'a Plan<'a>,
    data: &'a str,
    /// Per look-up.
    bytes: u64,
    /// Time of all steps.
    clock: Duration,
    /// Checkpoints and squared errors by checkpoint, for each reference.
    measured: Vec<(Vec<Checkpoint>, Vec<Vec<f64>>)>,
    last: Option<Picture>,
    watch: &'a Watch<'a>,
}

impl Run<'_> {
    fn checkpoints(&mut self) -> Result<()> {
        // Of the warm-up; a reset keeps the count.
        let launches = self.session.progress().launches;
        let targets = match &self.task.case.checkpoints {
            _ if self.plan.is_deterministic() => Checkpoints::Samples(vec![1]),
            given => given.clone(),
        };
        match targets {
            Checkpoints::Samples(samples) => samples.into_iter().try_for_each(|samples| {
                self.advance(samples, |_, progress| progress >= samples)?;
                self.checkpoint(launches)
            }),
            Checkpoints::Times(times) => times.into_iter().try_for_each(|time| {
                self.advance(u32::MAX, |clock, samples| samples > 0 && clock >= time)?;
                self.checkpoint(launches)
            }),
        }
    }

    /// Steps towards `target` samples until `done(time, samples)` holds at a whole sample.
    fn advance(&mut self, target: u32, done: impl Fn(Duration, u32) -> bool) -> Result<()> {
        loop {
            let progress = self.session.progress();
            if progress.tiles == 0 && done(self.clock, progress.samples) {
                return Ok(());
            }
            let begin = Instant::now();
            self.session.step(target)?;
            self.clock += begin.elapsed();
            stop_if_asked(self.watch)?;
            if let Some(limit) = self.task.case.limit.filter(|&limit| self.clock > limit) {
                let samples = self.session.progress().samples;
                let took = self.clock.as_secs_f64();
                return Err(Error::Failed(format!(
                    "{samples} samples took {took:.1} s, longer than its limit of {:.1} s",
                    limit.as_secs_f64()
                )));
            }
            self.watch.now_and_then(|| {
                let (name, seconds) = (&self.task.case.name, self.clock.as_secs_f64());
                let Progress { samples, light, .. } = self.session.progress();
                if light < 1.0 {
                    return format!("{name}: {:.0} % of the light in {seconds:.1} s", 100.0 * light);
                }
                format!("{name}: {samples} samples in {seconds:.1} s")
            });
        }
    }

    fn checkpoint(&mut self, launches_before: u64) -> Result<()> {
        let snapshot = Snapshot::take(self.session, self.plan, self.data, self.clock)?;
        let progress = self.session.progress();
        let light = self.session.light_facts().and_then(|facts| facts.cost);
        let state = |metrics| Checkpoint {
            samples: progress.samples.into(),
            seconds: self.clock.as_secs_f64(),
            device_seconds: progress.device_time.as_secs_f64(),
            launches: progress.launches - launches_before,
            lookups: snapshot.summary.lookups,
            bytes: snapshot.summary.lookups * self.bytes,
            rejected: snapshot.summary.rejected,
            faults: snapshot.paths.map_or(0, |paths| paths.above_majorant + paths.unfinished)
                + light.map_or(0, |cost| cost.above_majorant),
            metrics,
        };
        for (Target { picture, .. }, (checkpoints, blocks)) in
            self.task.references.iter().zip(&mut self.measured)
        {
            checkpoints.push(state(measure(&snapshot.picture, picture)?));
            blocks.push(squared_error_blocks(&snapshot.picture, picture)?);
        }
        self.last = Some(snapshot.picture);
        Ok(())
    }
}
