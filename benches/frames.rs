//! Frame times of whole methods, with the error and the look-ups of the same frame beside each time.
//!
//! `cargo bench --bench frames [FILTER]`. The device is the default one, or what `SVETLO_DEVICE` selects.
//! The reference of emission-absorption is the same scene by exact quadrature without early termination. Of scattering,
//! whose samples are unbiased, the RMSE is the noise of one sample, by the film's variances. Scenes on real data need `SVETLO_BENCH_DATA`, a folder with volumes of the Open SciVis Datasets, and are left out without it.

mod timing;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use svetlo::device::{Catalog, Device, DeviceInfo};
use svetlo::film::{FilmPixel, FilmSummary};
use svetlo::render::{BRICK_SHIFT, Plan, SceneData, Session};
use svetlo::scene::{Method, Scene};
use timing::{Times, Wanted};

/// Frames measured after one warm-up frame; the median is printed.
const FRAMES: usize = 9;

struct Case {
    name: &'static str,
    scene: &'static str,
    overrides: &'static [&'static str],
    /// Volume below the data folder, for scenes on real data.
    data: Option<&'static str>,
}

const CLOUD: &str = "benches/scenes/cloud.toml";
const SUNNY: &str = "configs/cloud_scattering.toml";
const BRAIN: &str = "configs/brain.toml";
const BRAIN_SCATTERING: &str = "configs/brain_scattering.toml";
const BONSAI: &str = "benches/scenes/bonsai.toml";
const BONSAI_DATA: Option<&str> = Some("bonsai_256x256x256_uint8.raw.gz");
const STEP_1: &[&str] = &["method.quadrature=step", "method.step=1", "method.jitter=false"];
const STEP_2: &[&str] = &["method.quadrature=step", "method.step=2", "method.jitter=false"];
const STEP_4: &[&str] = &["method.quadrature=step", "method.step=4", "method.jitter=false"];
const MIP: &[&str] = &["method={kind=\"mip\"}"];
const ISOSURFACE: &[&str] = &["method={kind=\"isosurface\",value=0.2}"];

const SMALL: &[&str] = &["image.width=96", "image.height=96"];
const SINGLE: &[&str] = &["method={kind=\"single-scattering\"}", "transfer.points.1.color=0.9"];
const MULTIPLE: &[&str] = &["method={kind=\"multiple-scattering\"}", "transfer.points.1.color=0.9"];

const CASES: &[Case] = &[
    Case { name: "cloud 256², per cell", scene: CLOUD, overrides: &[], data: None },
    Case { name: "cloud 256², step 1", scene: CLOUD, overrides: STEP_1, data: None },
    Case { name: "cloud 256², step 2", scene: CLOUD, overrides: STEP_2, data: None },
    Case { name: "cloud 256², step 4", scene: CLOUD, overrides: STEP_4, data: None },
    Case { name: "cloud 256², single sc.", scene: CLOUD, overrides: SINGLE, data: None },
    Case { name: "cloud 256², multiple sc.", scene: CLOUD, overrides: MULTIPLE, data: None },
    Case { name: "sunny cloud 96², multiple", scene: SUNNY, overrides: SMALL, data: None },
    Case { name: "brain 96², per cell", scene: BRAIN, overrides: SMALL, data: None },
    Case { name: "brain 96², multiple sc.", scene: BRAIN_SCATTERING, overrides: SMALL, data: None },
    Case { name: "bonsai 1024², per cell", scene: BONSAI, overrides: &[], data: BONSAI_DATA },
    Case { name: "bonsai 1024², step 1", scene: BONSAI, overrides: STEP_1, data: BONSAI_DATA },
    Case { name: "bonsai 1024², mip", scene: BONSAI, overrides: MIP, data: BONSAI_DATA },
    Case { name: "bonsai 1024², isosurface", scene: BONSAI, overrides: ISOSURFACE, data: BONSAI_DATA },
];

fn main() -> svetlo::Result<()> {
    let wanted = Wanted::from_arguments();
    let data_folder = std::env::var_os("SVETLO_BENCH_DATA").map(PathBuf::from);
    let selector = std::env::var("SVETLO_DEVICE").ok();
    let catalog = Catalog::enumerate();
    let info = catalog.select(selector.as_deref())?;
    println!("device {} ({}, driver {})", info.name, info.platform, info.driver);
    println!(
        "{:<26} {:>9} {:>8} {:>8} {:>12} {:>9} {:>8}",
        "case", "median ms", "min ms", "max ms", "look-ups/ray", "RMSE", "build ms"
    );
    for case in CASES.iter().filter(|case| wanted.has(case.name)) {
        let mut overrides: Vec<String> = case.overrides.iter().map(|&text| text.into()).collect();
        match (case.data, &data_folder) {
            (Some(file), Some(folder)) => overrides.push(format!("volume.file={:?}", folder.join(file))),
            (Some(_), None) => continue,
            (None, _) => {}
        }
        let frame = measure(info, case.scene, &overrides)?;
        println!(
            "{:<26} {} {:>12.2} {:>9.1e} {:>8.0}",
            case.name,
            frame.times,
            frame.lookups,
            frame.rmse,
            frame.build.as_secs_f64() * 1e3
        );
    }
    Ok(())
}

struct Frame {
    times: Times,
    /// Per ray of the camera: a path, where paths are followed.
    lookups: f64,
    rmse: f64,
    build: Duration,
}

fn measure(info: &DeviceInfo, scene: &str, overrides: &[String]) -> svetlo::Result<Frame> {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join(scene);
    let mut session = open(info, &Scene::load(&scene, overrides)?)?;
    let method = Scene::load(&scene, overrides)?.method;
    let times = match method {
        // Each frame is a sample more.
        Method::Scattering(_) => {
            let mut done = 0;
            Times::of(FRAMES, || {
                done += 1;
                timed(&mut session, done)
            })?
        }
        _ => Times::of(FRAMES, || {
            session.reset()?;
            timed(&mut session, 1)
        })?,
    };
    let film = session.film()?;
    let summary = FilmSummary::of(&film);
    let (rays, lookups) = match session.ledger()? {
        Some(paths) => (paths.paths, paths.lookups),
        None => (summary.samples, summary.lookups),
    };
    let rmse = match method {
        Method::Scattering(_) => {
            summary.standard_error.unwrap_or(f64::NAN) * f64::from(session.progress().samples).sqrt()
        }
        Method::EmissionAbsorption { .. } => {
            let mut exact: Vec<String> =
                overrides.iter().filter(|text| !text.starts_with("method.")).cloned().collect();
            exact.push("method.termination=0".into());
            let mut reference = open(info, &Scene::load(&scene, &exact)?)?;
            reference.render(1)?;
            rmse(&film, &reference.film()?)
        }
        // Exact as they are; no frame is of a light volume or of caustics.
        Method::Mip { .. } | Method::Isosurface { .. } | Method::LightVolume(_) | Method::Caustics(_) => 0.0,
    };
    Ok(Frame { times, lookups: lookups as f64 / rays as f64, rmse, build: session.build_time })
}

fn open(info: &DeviceInfo, scene: &Scene) -> svetlo::Result<Session> {
    let loaded = SceneData::load(scene)?;
    Session::new(Device::open(info)?, &Plan::new(scene, &loaded, BRICK_SHIFT)?)
}

fn timed(session: &mut Session, samples: u32) -> svetlo::Result<Duration> {
    let start = Instant::now();
    session.render(samples)?;
    Ok(start.elapsed())
}

fn rmse(film: &[FilmPixel], reference: &[FilmPixel]) -> f64 {
    let sum: f64 = film.iter().zip(reference).map(|(a, b)| (a.mean()[1] - b.mean()[1]).powi(2)).sum();
    (sum / film.len() as f64).sqrt()
}
