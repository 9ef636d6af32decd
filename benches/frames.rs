//! Frame times of whole methods, with the error and the look-ups of the same frame beside each time.
//!
//! `cargo bench --bench frames [FILTER]`. The device is the default one, or what `SVETLO_DEVICE` selects.
//! The reference of emission-absorption is the same scene by exact quadrature without early termination. Scenes on
//! real data need `SVETLO_BENCH_DATA`, a folder with volumes of the Open SciVis Datasets, and are left out without it.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use svetlo::device::{Catalog, Device, DeviceInfo};
use svetlo::film::{FilmPixel, FilmSummary};
use svetlo::render::{BRICK_SHIFT, Plan, Session, load_volume};
use svetlo::scene::Scene;

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
const BONSAI: &str = "benches/scenes/bonsai.toml";
const BONSAI_DATA: Option<&str> = Some("bonsai_256x256x256_uint8.raw.gz");
const STEP_1: &[&str] = &["method.quadrature=step", "method.step=1", "method.jitter=false"];
const STEP_2: &[&str] = &["method.quadrature=step", "method.step=2", "method.jitter=false"];
const STEP_4: &[&str] = &["method.quadrature=step", "method.step=4", "method.jitter=false"];
const MIP: &[&str] = &["method={kind=\"mip\"}"];
const ISOSURFACE: &[&str] = &["method={kind=\"isosurface\",value=0.2}"];

const CASES: &[Case] = &[
    Case { name: "cloud 256², per cell", scene: CLOUD, overrides: &[], data: None },
    Case { name: "cloud 256², step 1", scene: CLOUD, overrides: STEP_1, data: None },
    Case { name: "cloud 256², step 2", scene: CLOUD, overrides: STEP_2, data: None },
    Case { name: "cloud 256², step 4", scene: CLOUD, overrides: STEP_4, data: None },
    Case { name: "bonsai 1024², per cell", scene: BONSAI, overrides: &[], data: BONSAI_DATA },
    Case { name: "bonsai 1024², step 1", scene: BONSAI, overrides: STEP_1, data: BONSAI_DATA },
    Case { name: "bonsai 1024², mip", scene: BONSAI, overrides: MIP, data: BONSAI_DATA },
    Case { name: "bonsai 1024², isosurface", scene: BONSAI, overrides: ISOSURFACE, data: BONSAI_DATA },
];

fn main() -> svetlo::Result<()> {
    let filter = std::env::args().skip(1).find(|argument| !argument.starts_with('-')).unwrap_or_default();
    let data_folder = std::env::var_os("SVETLO_BENCH_DATA").map(PathBuf::from);
    let selector = std::env::var("SVETLO_DEVICE").ok();
    let catalog = Catalog::enumerate();
    let info = catalog.select(selector.as_deref())?;
    println!("device {} ({}, driver {})", info.name, info.platform, info.driver);
    println!(
        "{:<26} {:>9} {:>8} {:>8} {:>12} {:>9} {:>8}",
        "case", "median ms", "min ms", "max ms", "look-ups/ray", "RMSE", "build ms"
    );
    for case in CASES.iter().filter(|case| case.name.contains(&filter)) {
        let mut overrides: Vec<String> = case.overrides.iter().map(|&text| text.into()).collect();
        match (case.data, &data_folder) {
            (Some(file), Some(folder)) => overrides.push(format!("volume.file={:?}", folder.join(file))),
            (Some(_), None) => continue,
            (None, _) => {}
        }
        let frame = measure(info, case.scene, &overrides)?;
        println!(
            "{:<26} {:>9.2} {:>8.2} {:>8.2} {:>12.2} {:>9.1e} {:>8.0}",
            case.name,
            ms(frame.times[FRAMES / 2]),
            ms(frame.times[0]),
            ms(frame.times[FRAMES - 1]),
            frame.lookups,
            frame.rmse,
            ms(frame.build)
        );
    }
    Ok(())
}

fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

struct Frame {
    /// Ascending.
    times: Vec<Duration>,
    lookups: f64,
    rmse: f64,
    build: Duration,
}

fn measure(info: &DeviceInfo, scene: &str, overrides: &[String]) -> svetlo::Result<Frame> {
    let (film, times, build) = frames(info, scene, overrides, FRAMES)?;
    // MIP and isosurface are exact as they are.
    let reference = if overrides.iter().any(|text| text.starts_with("method=")) {
        film.clone()
    } else {
        let mut exact: Vec<String> =
            overrides.iter().filter(|text| !text.starts_with("method.")).cloned().collect();
        exact.push("method.termination=0".into());
        frames(info, scene, &exact, 0)?.0
    };
    let summary = FilmSummary::of(&film);
    let lookups = summary.lookups as f64 / summary.samples as f64;
    Ok(Frame { times, lookups, rmse: rmse(&film, &reference), build })
}

/// Renders one sample per pixel `count` times after a warm-up; the film, the sorted times, and the build time.
fn frames(
    info: &DeviceInfo,
    scene: &str,
    overrides: &[String],
    count: usize,
) -> svetlo::Result<(Vec<FilmPixel>, Vec<Duration>, Duration)> {
    let scene = Scene::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join(scene), overrides)?;
    let volume = load_volume(&scene.volume)?;
    let plan = Plan::new(&scene, &volume, BRICK_SHIFT)?;
    let mut session = Session::new(Device::open(info)?, &plan)?;
    session.render(1)?;
    let mut times = Vec::new();
    for _ in 0..count {
        session.reset()?;
        let start = Instant::now();
        session.render(1)?;
        times.push(start.elapsed());
    }
    times.sort();
    Ok((session.film()?, times, session.build_time))
}

fn rmse(film: &[FilmPixel], reference: &[FilmPixel]) -> f64 {
    let sum: f64 = film.iter().zip(reference).map(|(a, b)| (a.mean()[1] - b.mean()[1]).powi(2)).sum();
    (sum / film.len() as f64).sqrt()
}
