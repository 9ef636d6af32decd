//! Runs a suite: references first, then the repeats, interleaved over the cases so that a machine that becomes slower
//! for a while slows all of them.

use super::files::Folder;
use super::findings;
use super::gallery::Gallery;
use super::machine::{machine, now};
use super::piece::{Piece, Target, Task};
use super::published::published;
use super::reference::Reference;
use super::refusals;
use super::results::{Case, DeviceDescription, FORMAT, Images, Results, Summary};
use super::suite::{CaseSpec, ReferenceSpec, Suite};
use super::summary::{Measured, summarise};
use super::trust::Trust;
use super::watch::Watch;
use crate::device::DeviceInfo;
use crate::render::{BRICK_SHIFT, Plan, SceneData, data_hash, method_name};
use crate::scene::{
    Caustics, DirectLight, LightVolume, Method, Orders, Quadrature, ScatteredLight, Scattering,
};
use crate::{Error, Result};
use std::time::Instant;

/// What a case is, beyond its scene.
#[derive(Default)]
pub(super) struct Facts {
    /// Hash of the files that the scene reads.
    pub data: String,
    deterministic: bool,
    voxels: [usize; 3],
    device_bytes: u64,
}

/// A case on a device with what is measured of it.
struct Slot<'a> {
    case: &'a CaseSpec,
    facts: &'a Facts,
    device: &'a DeviceInfo,
    trust: Trust,
    reference: Option<&'a Reference>,
    pieces: Vec<Piece>,
    /// Why there are no more pieces.
    failed: Option<String>,
}

/// How a suite is run.
pub struct Options<'a> {
    /// On which devices, at least one.
    pub devices: &'a [&'a DeviceInfo],
    /// Whether devices must pass the self-test.
    pub selftest: bool,
}

/// Runs `suite`; everything that is finished is in `folder`, and in the results, even after an interrupt.
///
/// # Errors
/// [`Error::Input`] when a case's data are wrong, [`Error::Failed`] when a device or the disk fails. An interrupt is
/// none: the results are incomplete then.
pub fn run(suite: &Suite, options: &Options<'_>, folder: &Folder, watch: &Watch<'_>) -> Result<Results> {
    let devices = options.devices;
    let (started, begin) = (now(), Instant::now());
    let mut known = Vec::new();
    for case in &suite.cases {
        known.push(match facts(case, devices) {
            Ok(facts) => Ok(facts),
            // One of many is no reason to leave the others.
            Err(Error::Input(text) | Error::Failed(text)) if case.truth.is_some() => Err(text),
            Err(error) => return Err(error),
        });
    }
    let facts: Vec<(Facts, Option<String>)> = known
        .into_iter()
        .map(|facts| facts.map_or_else(|text| (Facts::default(), Some(text)), |facts| (facts, None)))
        .collect();
    let mut references = Vec::new();
    for (index, case) in suite.cases.iter().enumerate() {
        let earlier = suite.cases[..index].iter().position(|earlier| same_reference(earlier, case));
        let reference = match earlier {
            Some(earlier) => Ok(Reference::clone(&references[earlier])),
            None => Reference::obtain(case, devices[0], folder, watch),
        };
        match or_none(reference, watch)? {
            Some(reference) => references.push(reference),
            None => break,
        }
    }
    let mut slots: Vec<Slot<'_>> = Vec::new();
    for &device in devices {
        let trust = if options.selftest { Trust::of(device, folder, watch)? } else { Trust::default() };
        for (index, (case, facts)) in suite.cases.iter().zip(&facts).enumerate() {
            let (facts, failed) = facts;
            let reference = references.get(index);
            let trust = trust.clone();
            let failed = failed.clone();
            slots.push(Slot { case, facts, device, trust, reference, pieces: Vec::new(), failed });
        }
    }
    let bench = Bench { suite, folder, watch, started, begin };
    let complete = bench.measure(&mut slots)?;
    let mut results = bench.results(&slots, complete);
    results.refusals = refusals::try_all(&suite.refusals, devices);
    Gallery { folder }.fill(&mut results, &bench.pieces_of(&slots))?;
    results.findings = findings::of(&results, suite);
    folder.write_results(&results)?;
    Ok(results)
}

/// Whether two cases are measured against one and the same rendered reference: where the time ends it, going on would
/// make another.
fn same_reference(a: &CaseSpec, b: &CaseSpec) -> bool {
    let (ReferenceSpec::Computed(a), ReferenceSpec::Computed(b)) = (&a.reference, &b.reference) else {
        return false;
    };
    a.scenes[0].seedless_hash == b.scenes[0].seedless_hash
        && (a.error, a.time, &a.overrides) == (b.error, b.time, &b.overrides)
}

/// An interrupt is no error here, and neither is what a device fails at because of it.
fn or_none<T>(outcome: Result<T>, watch: &Watch<'_>) -> Result<Option<T>> {
    match outcome {
        Ok(value) => Ok(Some(value)),
        Err(Error::Interrupted) => Ok(None),
        Err(Error::Failed(text)) if watch.interrupted() => {
            watch.say(&format!("interrupted; the device gave up: {text}"));
            Ok(None)
        }
        Err(error) => Err(error),
    }
}

struct Bench<'a> {
    suite: &'a Suite,
    folder: &'a Folder,
    watch: &'a Watch<'a>,
    started: String,
    begin: Instant,
}

impl Bench<'_> {
    /// Measures what is not there yet; whether everything is in the end.
    fn measure(&self, slots: &mut [Slot<'_>]) -> Result<bool> {
        if slots.iter().any(|slot| slot.reference.is_none()) {
            return Ok(false);
        }
        // What a device computes that fails the self-test counts for nothing.
        let repeats = |slot: &Slot<'_>| if slot.trust.passed == Some(false) { 0 } else { slot.case.repeats };
        let rounds = slots.iter().map(repeats).max().unwrap_or(0);
        let total: usize = slots.iter().map(|slot| repeats(slot) as usize).sum();
        let mut done = 0;
        for round in 0..rounds {
            for index in 0..slots.len() {
                if round >= repeats(&slots[index]) || slots[index].failed.is_some() {
                    continue;
                }
                done += 1;
                match or_none(self.piece(slots, index, round, (done, total)), self.watch) {
                    Ok(Some(piece)) => slots[index].pieces.push(piece),
                    Ok(None) => return Ok(false),
                    Err(Error::Input(text) | Error::Failed(text)) if slots[index].case.truth.is_some() => {
                        self.watch.say(&format!("{}: {text}", slots[index].case.name));
                        slots[index].failed = Some(text);
                    }
                    Err(error) => return Err(error),
                }
            }
            // Pictures come at the end; the numbers so far are safe even from a kill.
            self.folder.write_results(&self.results(slots, false))?;
        }
        Ok(true)
    }

    fn piece(
        &self,
        slots: &[Slot<'_>],
        index: usize,
        round: u32,
        (done, total): (usize, usize),
    ) -> Result<Piece> {
        let slot = &slots[index];
        let task = Task {
            case: slot.case,
            device: slot.device,
            seed: self.suite.seed.wrapping_add(round.into()),
            data: &slot.facts.data,
            references: targets(slots, slot, round)?,
        };
        let place = format!("{done}/{total} {} on {}", slot.case.name, slot.device.selector);
        if let Some(piece) = task.finished(self.folder) {
            self.watch.say(&format!("{place}: there already"));
            return Ok(piece);
        }
        if self.watch.interrupted() {
            return Err(Error::Interrupted);
        }
        let piece = task.run(self.folder, self.watch)?;
        if let Some(last) = piece.repeat.checkpoints.last() {
            let error = last.metrics.relative_rmse;
            let error = error.map_or(String::new(), |error| format!(", error {:.3} %", error * 100.0));
            self.watch.say(&format!("{place}: {} samples in {:.2} s{error}", last.samples, last.seconds));
        }
        Ok(piece)
    }

    fn results(&self, slots: &[Slot<'_>], complete: bool) -> Results {
        let cases: Vec<Case> = slots.iter().filter_map(|slot| self.case(slot)).collect();
        Results {
            format: FORMAT,
            version: env!("CARGO_PKG_VERSION").into(),
            suite: self.suite.info.clone(),
            machine: machine(),
            started: self.started.clone(),
            seconds: self.begin.elapsed().as_secs_f64(),
            complete,
            published: published(&self.suite.published, &cases),
            cases,
            refusals: Vec::new(),
            findings: Vec::new(),
        }
    }

    fn case(&self, slot: &Slot<'_>) -> Option<Case> {
        let (spec, device) = (slot.case, slot.device);
        let mut case = Case {
            name: spec.name.clone(),
            about: spec.about.clone(),
            group: spec.group.clone(),
            curve: spec.curve.clone(),
            scene: spec.scene_name.clone(),
            overrides: spec.overrides.clone(),
            scene_hash: spec.scene.seedless_hash.clone(),
            device: DeviceDescription {
                selector: device.selector.clone(),
                name: device.name.clone(),
                platform: device.platform.clone(),
                driver: device.driver.clone(),
                version: device.version.clone(),
                compute_units: device.compute_units,
                selftest: slot.trust.passed,
                selftest_failures: slot.trust.failures.clone(),
            },
            method: method_name(&spec.scene.method).into(),
            estimators: estimators(&spec.scene.method),
            width: spec.scene.image.width,
            height: spec.scene.image.height,
            voxels: slot.facts.voxels,
            device_bytes: slot.facts.device_bytes,
            deterministic: slot.facts.deterministic,
            reference: slot.reference?.info.clone(),
            repeats: slot.pieces.iter().map(|piece| piece.repeat.clone()).collect(),
            pooled: None,
            summary: Summary::default(),
            images: Images::default(),
            truth: None,
            failed: slot.failed.clone(),
        };
        let measured: Vec<Measured<'_>> = slot
            .pieces
            .iter()
            .map(|piece| Measured { repeat: &piece.repeat, blocks: &piece.blocks })
            .collect();
        case.summary = summarise(&case, &measured, &self.suite.errors);
        Some(case)
    }

    /// Keys of the pieces of every case in the results, in their order, with the scene's curve of previews.
    fn pieces_of<'s>(&self, slots: &'s [Slot<'_>]) -> Vec<(&'s CaseSpec, Vec<&'s str>)> {
        let known = slots.iter().filter(|slot| slot.reference.is_some());
        known.map(|slot| (slot.case, slot.pieces.iter().map(|piece| piece.key.as_str()).collect())).collect()
    }
}

/// Loads the case's data once: whatever is wrong is found before the first measurement.
pub(super) fn facts(case: &CaseSpec, devices: &[&DeviceInfo]) -> Result<Facts> {
    let named = |error: Error| match error {
        Error::Input(text) => Error::Input(format!("case \"{}\": {text}", case.name)),
        Error::Failed(text) => Error::Failed(format!("case \"{}\": {text}", case.name)),
        other => other,
    };
    let loaded = SceneData::load(&case.scene).map_err(named)?;
    let plan = Plan::new(&case.scene, &loaded, BRICK_SHIFT).map_err(named)?;
    let memory = plan.memory();
    devices.iter().try_for_each(|device| memory.check(device)).map_err(named)?;
    Ok(Facts {
        data: data_hash(&plan, &loaded).map_err(named)?,
        deterministic: plan.is_deterministic(),
        voxels: loaded.volume.map_or([0; 3], |volume| volume.dims),
        device_bytes: memory.total(),
    })
}

/// The reference of a slot, then those of others with the same pictures that still need this round.
fn targets(slots: &[Slot<'_>], slot: &Slot<'_>, round: u32) -> Result<Vec<Target>> {
    let same = |other: &&Slot<'_>| {
        let (a, b) = (other.case, slot.case);
        other.device.selector == slot.device.selector
            && a.scene.seedless_hash == b.scene.seedless_hash
            && other.facts.data == slot.facts.data
            && (a.warmup, &a.checkpoints, a.limit) == (b.warmup, &b.checkpoints, b.limit)
            && round < a.repeats
    };
    let mut references: Vec<&Reference> = slot.reference.into_iter().collect();
    for other in slots.iter().filter(same).filter_map(|other| other.reference) {
        if references.iter().all(|known| known.hash != other.hash) {
            references.push(other);
        }
    }
    if references.is_empty() {
        return Err(Error::Interrupted);
    }
    let target = |of: &Reference| Ok(Target { hash: of.hash.clone(), picture: of.picture()? });
    references.into_iter().map(target).collect()
}

/// How a method goes about it, one phrase each.
fn estimators(method: &Method) -> Vec<String> {
    match method {
        Method::Mip { .. } | Method::Isosurface { .. } => vec!["exact per cell".into()],
        Method::EmissionAbsorption { quadrature, .. } => vec![match quadrature {
            Quadrature::Cell => "exact per cell".into(),
            Quadrature::Step { step, jitter, .. } => {
                format!("step {step} voxels{}", if *jitter { ", jittered" } else { "" })
            }
        }],
        Method::Scattering(Scattering { orders, transmittance, majorant_scale, paths }) => {
            let word = serde_json::to_value(transmittance).ok();
            let word = word.as_ref().and_then(serde_json::Value::as_str).unwrap_or("auto");
            let mut phrases = vec![format!("transmittance {word}")];
            phrases.extend(paths.map(|paths| format!("{paths} paths per sample")));
            phrases.extend((*majorant_scale != 1.0).then(|| format!("majorants × {majorant_scale}")));
            if let Orders::Multiple { max: Some(max) } = orders {
                phrases.push(format!("at most {max} scatterings"));
            }
            phrases
        }
        Method::LightVolume(volume) => light_phrases(volume),
        Method::Caustics(caustics) => caustics_phrases(caustics),
    }
}

fn caustics_phrases(caustics: &Caustics) -> Vec<String> {
    let radius = caustics.radius.map(|radius| format!("radius {radius}"));
    [Some(format!("{} photons a pass", caustics.photons)), radius].into_iter().flatten().collect()
}

fn light_phrases(volume: &LightVolume) -> Vec<String> {
    let direct = match volume.direct {
        DirectLight::Convection => "direct light upwind".into(),
        DirectLight::Tracking { estimates } => format!("{estimates} estimates of direct light"),
    };
    let scattered = match volume.scattered {
        ScatteredLight::Steady(steady) => {
            let word = |word: serde_json::Result<serde_json::Value>| {
                word.ok().and_then(|word| word.as_str().map(str::to_owned)).unwrap_or_default()
            };
            let (solver, limiter) =
                (serde_json::to_value(steady.solver), serde_json::to_value(steady.limiter));
            format!("diffusion by {}, limiter {}", word(solver), word(limiter))
        }
        ScatteredLight::Steps { count: Some(count), .. } => format!("{count} steps of diffusion"),
        ScatteredLight::Steps { count: None, .. } => "steps of diffusion while light crosses".into(),
    };
    let cells = (volume.coarsening > 1).then(|| format!("{} voxels per cell", volume.coarsening));
    [direct, scattered].into_iter().chain(cells).collect()
}
