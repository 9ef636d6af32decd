//! The model ladder: one scene by ever better models of light, the error of each against the last, and what each costs.
//!
//! | rung | what it knows of light |
//! | --- | --- |
//! | emission-absorption | the medium glows by itself; its radiance is the one that comes nearest to the last rung |
//! | single-scattering | every shadow, no bounce |
//! | convection-diffusion | light carried from cell to cell, bounces as steps of diffusion |
//! | hybrid-diffusion | every shadow of the cells, bounces as diffusion |
//! | multiple-scattering | all of it |
//!
//! A rung that the scene does not allow is left out, with the reason. The error of a model is what no number of samples
//! removes: the squared difference less the noise of both sides. It is measured against the last rung, and against single
//! scattering, for the sake of those who compare with that. The time to the tolerance is that at which model error and
//! noise together come down to it; light volumes are computed as the scene says, or else with the defaults.

use super::computed;
use super::files::Folder;
use super::measure::measure;
use super::piece::{Target, Task};
use super::reference::Reference;
use super::results::{Case, Interval, Metrics, SuiteInfo};
use super::run::{Options, facts, run};
use super::suite::{CaseSpec, Checkpoints, ComputedReference, Gates, REFERENCE_SEED, ReferenceSpec, Suite};
use super::watch::Watch;
use crate::picture::{Picture, read_exr};
use crate::render::method_name;
use crate::scene::{Method, Scene};
use crate::{Error, Result};
use serde::Serialize;
use std::path::Path;
use std::time::Duration;

/// Methods from the cheapest model to the right one.
const RUNGS: [&str; 5] = [GLOW, SINGLE, "convection-diffusion", "hybrid-diffusion", LAST];
const GLOW: &str = "emission-absorption";
const SINGLE: &str = "single-scattering";
const LAST: &str = "multiple-scattering";
/// Independent runs of every rung.
const REPEATS: u32 = 3;
/// The reference may be this much better than the tolerance, and take this many times the time of a run.
const REFERENCE_ERROR: f64 = 0.2;
const REFERENCE_TIME: u32 = 6;
/// Samples of the pictures that the radiance of emission-absorption is fitted on.
const FIT_SAMPLES: u32 = 4;

/// What is asked.
pub struct Request<'a> {
    /// The scene file.
    pub scene: &'a Path,
    /// Overrides.
    pub sets: &'a [String],
    /// Largest relative error that will do, a fraction.
    pub tolerance: f64,
    /// Time for each run of a rung.
    pub time: Duration,
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct Ladder {
    /// The scene file.
    pub scene: String,
    /// Largest relative error that will do, a fraction.
    pub tolerance: f64,
    /// From the cheapest model to the right one.
    pub rungs: Vec<Rung>,
    /// Models that the scene does not allow.
    pub left_out: Vec<LeftOut>,
    /// Name of the rung that is within the tolerance soonest; `None` when none was measured.
    pub cheapest: Option<String>,
    /// Relative error of the reference itself.
    pub reference_error: Option<f64>,
    /// The same of the reference by single scattering.
    pub single_reference_error: Option<f64>,
    /// Whether every rung was measured.
    pub complete: bool,
}

/// A model that the scene does not allow.
#[derive(Clone, Debug, Serialize)]
pub struct LeftOut {
    /// Name of the method.
    pub method: String,
    /// What is in the way.
    pub why: String,
}

/// A model of light and what it costs.
#[derive(Clone, Debug, Serialize)]
pub struct Rung {
    /// Name of the method.
    pub method: String,
    /// Overrides that make the scene this rung.
    pub overrides: Vec<String>,
    /// Model error: RMS over the mean of the last rung; the interval is one of 95 %, and a value of 0 is below noise.
    pub model_error: Interval,
    /// The same against single scattering, over the mean of that.
    pub single_error: Option<Interval>,
    /// To compute the light volume; 0 for methods without.
    pub light_seconds: f64,
    /// Noise of the light volume, which samples do not remove (RMS over the mean), at most; 0 for methods without.
    pub light_noise: f64,
    /// Noise (RMS over the mean) after one second of samples.
    pub noise_in_a_second: Option<f64>,
    /// To render one sample per pixel.
    pub seconds_per_sample: f64,
    /// Until model error and noise together are within the tolerance; `None` when they never are.
    pub seconds_to_tolerance: Option<f64>,
    /// Look-ups per pixel and sample.
    pub lookups_per_sample: Option<f64>,
}

/// Climbs the ladder.
///
/// # Errors
/// [`Error::Input`] when the scene is wrong or dark, [`Error::Failed`] when the device or the disk fails,
/// [`Error::Interrupted`] when not even the reference was finished.
pub fn climb(
    request: &Request<'_>,
    options: &Options<'_>,
    folder: &Folder,
    watch: &Watch<'_>,
) -> Result<Ladder> {
    let own = Scene::load(request.scene, request.sets)?;
    if let Method::Caustics(_) = own.method {
        return Err(Error::Input(format!(
            "{}: the ladder compares models of light in a volume, and this scene's method is caustics",
            request.scene.display()
        )));
    }
    let last = rung(request, LAST, &[])?;
    let reference = Reference::obtain(&last, options.devices[0], folder, watch)?;
    if reference.info.mean <= 0.0 {
        return Err(Error::Input(format!(
            "{}: no light reaches the camera by scattering: give the scene a [[light]] or a [background]",
            request.scene.display()
        )));
    }
    let single = against(request, SINGLE, rung(request, SINGLE, &[])?)?;
    let single = Reference::obtain(&single, options.devices[0], folder, watch)?;
    let radiance = fitted_radiance(request, options, &reference.picture()?, folder, watch)?;
    let (mut cases, mut left_out) = (Vec::new(), Vec::new());
    for method in RUNGS {
        let glow = (method == GLOW).then(|| format!("method.radiance={radiance}"));
        let case = rung(request, method, glow.as_slice())
            .and_then(|case| facts(&case, options.devices).map(|_| case));
        match case {
            Ok(case) => cases.push(case),
            // The scene itself is right: it was rendered by the last rung.
            Err(Error::Input(text)) if method != LAST => {
                let why = text.strip_prefix(&format!("case \"{method}\": ")).unwrap_or(&text).into();
                left_out.push(LeftOut { method: method.into(), why });
            }
            Err(error) => return Err(error),
        }
    }
    let suite = Suite {
        info: SuiteInfo {
            title: "Model ladder".into(),
            about: String::new(),
            file: request.scene.display().to_string(),
            hash: String::new(),
        },
        devices: Vec::new(),
        seed: 1,
        errors: vec![request.tolerance],
        slower: 0.1,
        published: Vec::new(),
        cases,
        refusals: Vec::new(),
    };
    let results = run(&suite, options, folder, watch)?;
    let measured = results.cases.iter().map(|case| describe(case, request.tolerance, &single, folder));
    let rungs: Vec<Rung> = measured.filter_map(Result::transpose).collect::<Result<_>>()?;
    let soonest = rungs
        .iter()
        .filter_map(|rung| Some((rung.seconds_to_tolerance?, &rung.method)))
        .min_by(|a, b| a.0.total_cmp(&b.0));
    Ok(Ladder {
        scene: request.scene.display().to_string(),
        tolerance: request.tolerance,
        cheapest: soonest.map(|(_, method)| method.clone()),
        reference_error: reference.info.relative_error,
        single_reference_error: single.info.relative_error,
        complete: results.complete,
        rungs,
        left_out,
    })
}

/// The scene by another method: its own parameters stay where it is the scene's method already.
fn overrides(request: &Request<'_>, method: &str, more: &[String]) -> Result<Vec<String>> {
    let own = Scene::load(request.scene, request.sets)?;
    let mut sets = request.sets.to_vec();
    if method_name(&own.method) != method {
        sets.push(format!("method={{kind=\"{method}\"}}"));
    }
    if method == GLOW {
        // It knows no light, and some kinds of light are errors there.
        sets.push("light=[]".into());
    }
    if ![SINGLE, LAST].contains(&method) {
        sets.push("film.auxiliary=false".into());
    }
    sets.extend_from_slice(more);
    Ok(sets)
}

fn rung(request: &Request<'_>, method: &str, more: &[String]) -> Result<CaseSpec> {
    let sets = overrides(request, method, more)?;
    let scene = Scene::load(request.scene, &sets)?;
    // A light volume would be computed twice; the median of its times is none of the first run's.
    let warmup = if matches!(scene.method, Method::LightVolume(_)) { 0 } else { 1 };
    let case = CaseSpec {
        name: method.into(),
        about: String::new(),
        group: "ladder".into(),
        curve: None,
        scene_name: request.scene.display().to_string(),
        scene_path: request.scene.to_owned(),
        scene,
        overrides: sets,
        repeats: REPEATS,
        warmup,
        checkpoints: Checkpoints::Times(vec![request.time]),
        reference: ReferenceSpec::Constant([0.0; 3]),
        gates: Gates::default(),
        truth: None,
        limit: None,
    };
    against(request, LAST, case)
}

/// The case with a reference by a method.
fn against(request: &Request<'_>, method: &str, case: CaseSpec) -> Result<CaseSpec> {
    let sets = overrides(request, method, &[])?;
    let reference = ReferenceSpec::Computed(Box::new(ComputedReference {
        scenes: computed::scenes(request.scene, &sets, REFERENCE_SEED)?,
        overrides: Vec::new(),
        error: REFERENCE_ERROR * request.tolerance,
        time: Some(request.time * REFERENCE_TIME),
    }));
    Ok(CaseSpec { reference, ..case })
}

/// The radiance L₀ with which emission-absorption comes nearest to the reference in the least squares: the picture is
/// linear in it, x = x₀ + L₀ (x₁ − x₀).
fn fitted_radiance(
    request: &Request<'_>,
    options: &Options<'_>,
    reference: &Picture,
    folder: &Folder,
    watch: &Watch<'_>,
) -> Result<f64> {
    let picture = |radiance: f64| -> Result<Picture> {
        let mut case = rung(request, GLOW, &[format!("method.radiance={radiance}")])?;
        case.checkpoints = Checkpoints::Samples(vec![FIT_SAMPLES]);
        let facts = facts(&case, options.devices)?;
        // The folder is keyed by what is rendered; the errors of these pictures are not asked for.
        let task = Task {
            case: &case,
            device: options.devices[0],
            seed: 1,
            data: &facts.data,
            references: vec![Target { hash: "none".into(), picture: reference.clone() }],
        };
        let piece = match task.finished(folder) {
            Some(piece) => piece,
            None => task.run(folder, watch)?,
        };
        read_exr(&folder.path(&super::piece::picture_name(&piece.key)))
    };
    Ok(least_squares(&picture(0.0)?, &picture(1.0)?, reference))
}

/// ⟨x₁ − x₀, r − x₀⟩ / ⟨x₁ − x₀, x₁ − x₀⟩, at least 0; 1 where nothing glows.
fn least_squares(dark: &Picture, bright: &Picture, reference: &Picture) -> f64 {
    let (mut product, mut square) = (0.0, 0.0);
    for name in ["R", "G", "B"] {
        let plane = |picture: &Picture| picture.channel(name).map(|samples| samples.to_f32().into_owned());
        let (Some(dark), Some(bright), Some(reference)) = (plane(dark), plane(bright), plane(reference))
        else {
            continue;
        };
        for ((&dark, &bright), &reference) in dark.iter().zip(&bright).zip(&reference) {
            let (dark, glow) = (f64::from(dark), f64::from(bright) - f64::from(dark));
            product += glow * (f64::from(reference) - dark);
            square += glow * glow;
        }
    }
    if square > 0.0 { (product / square).max(0.0) } else { 1.0 }
}

/// The rung of a case that was measured.
fn describe(case: &Case, tolerance: f64, single: &Reference, folder: &Folder) -> Result<Option<Rung>> {
    let Some(((pooled, last), image)) =
        case.pooled.as_ref().zip(case.summary.points.last()).zip(case.images.image.as_ref())
    else {
        return Ok(None);
    };
    let mean = case.reference.mean.abs();
    let model_error = difference(pooled, mean, case.method == LAST);
    let single_error = if single.info.mean > 0.0 {
        let measured = measure(&read_exr(&folder.path(image))?, &single.picture()?)?;
        Some(difference(&measured, single.info.mean, case.method == SINGLE))
    } else {
        None
    };
    let light_seconds = case.summary.light.map_or(0.0, |light| light.median);
    let seconds = last.seconds.median - light_seconds;
    let sample = seconds / last.samples;
    let noise = noise(case, pooled).map(|noise| noise / (mean * mean));
    let (fixed, falling) = if case.summary.light.is_some() {
        (noise.unwrap_or(0.0), film_noise(case).map(|noise| noise / (mean * mean)))
    } else {
        (0.0, noise)
    };
    let left = tolerance * tolerance - model_error.value * model_error.value - fixed;
    let samples = falling.map_or(sample, |noise| (seconds * noise / left).max(sample));
    Ok(Some(Rung {
        method: case.method.clone(),
        overrides: case.overrides.clone(),
        model_error,
        single_error,
        light_seconds,
        light_noise: fixed.sqrt(),
        noise_in_a_second: falling.map(|noise| (noise * seconds).sqrt()),
        seconds_per_sample: sample,
        seconds_to_tolerance: (left > 0.0).then_some(light_seconds + samples),
        lookups_per_sample: case.summary.lookups_per_sample,
    }))
}

/// What differs from a reference beyond noise, RMS over its mean; `same`: the reference is of this model.
fn difference(pooled: &Metrics, mean: f64, same: bool) -> Interval {
    let square = pooled.squared_bias.unwrap_or(pooled.mse);
    let relative = |square: f64| square.max(0.0).sqrt() / mean;
    Interval {
        // What differs from the same model is noise.
        value: if same { 0.0 } else { relative(square.value) },
        low: square.low.map(relative),
        high: square.high.map(relative),
    }
}

/// The variance between repeats: the pooled picture is their mean.
fn noise(case: &Case, pooled: &Metrics) -> Option<f64> {
    pooled.own_noise.map(|noise| noise * case.repeats.len() as f64)
}

/// The variance of the last pictures by their films, which do not see the noise of a light volume.
fn film_noise(case: &Case) -> Option<f64> {
    let last = case.repeats.iter().filter_map(|repeat| repeat.checkpoints.last());
    let noises: Vec<f64> = last.filter_map(|last| last.metrics.own_noise).collect();
    (!noises.is_empty()).then(|| noises.iter().sum::<f64>() / noises.len() as f64)
}

impl Ladder {
    /// The ladder as a table for people.
    pub fn table(&self) -> String {
        let percent = |share: f64| format!("{:.2} %", share * 100.0);
        let mut lines = vec![format!(
            "{:<20} {:>11} {:>19} {:>10} {:>8} {:>12} {:>12} {:>12}",
            "model",
            "vs multiple",
            "95 % interval",
            "vs single",
            "light s",
            "s per sample",
            "noise in 1 s",
            format!("{} in s", percent(self.tolerance))
        )];
        for rung in &self.rungs {
            let error = rung.model_error;
            let same = |method: &str| rung.method == method;
            let interval = error.low.zip(error.high).filter(|_| !same(LAST));
            let light = rung.light_seconds;
            lines.push(format!(
                "{:<20} {:>11} {:>19} {:>10} {:>8} {:>12.4} {:>12} {:>12}",
                rung.method,
                if same(LAST) { "itself".into() } else { percent(error.value) },
                interval.map_or("–".into(), |(low, high)| format!("{} … {}", percent(low), percent(high))),
                match rung.single_error {
                    _ if same(SINGLE) => "itself".into(),
                    Some(error) => percent(error.value),
                    None => "–".into(),
                },
                if light > 0.0 { format!("{light:.3}") } else { "–".into() },
                rung.seconds_per_sample,
                rung.noise_in_a_second.map_or("–".into(), percent),
                rung.seconds_to_tolerance.map_or("never".into(), |seconds| format!("{seconds:.3}")),
            ));
        }
        for LeftOut { method, why } in &self.left_out {
            lines.push(format!("{method:<20} left out: {why}"));
        }
        lines.push(match &self.cheapest {
            Some(method) => format!("cheapest within {}: {method}", percent(self.tolerance)),
            None => format!("nothing was measured that is within {}", percent(self.tolerance)),
        });
        lines.join("\n")
    }
}
