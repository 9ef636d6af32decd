//! Scattered light in colour: updates of the limited diffusivity, iterations and time of whole solves.
//!
//! `cargo bench --bench scattered [FILTER]`. The device is the default one, or what `SVETLO_DEVICE` selects. Media are
//! cubes of edge 1 lit along an axis: smooth bumps with nothing between, and voxels of random extinction over three
//! decades. Beside the times stands how far light of the limited equation is from that of the classical one.

mod timing;

use glam::DVec3;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;
use svetlo::device::{Buffer, Catalog, Device};
use svetlo::diffusion::Method;
use svetlo::irradiance::{DirectLight, LightGrid, Limiter, LitMedium, ScatterSettings, ScatterSolver};
use svetlo::reference::random::{philox4x32, uniform};
use svetlo::render::{BRICK_SHIFT, Plan};
use svetlo::scene::Scene;
use svetlo::volume::{Volume, Voxels};
use timing::Wanted;

const SCENE: &str = "[camera]\nposition = [-9, 0, 0]\ntarget = [0, 0, 0]\n[method]\nkind = \"single-scattering\"\n\
                     [volume]\nfield = { kind = \"constant\" }\ndims = [1, 1, 1]\norigin = [0, 0, 0]\n\
                     window = { lo = 0, hi = 1 }\n[transfer]\nresolution = 2\n\
                     points = [{ value = 0, opacity = 0 }, { value = 1, opacity = 1 }]\n\
                     [medium]\nsigma_max = 200\nalbedo = [0.9, 0.99, 0.999]\n";

fn main() -> svetlo::Result<()> {
    let wanted = Wanted::from_arguments();
    let selector = std::env::var("SVETLO_DEVICE").ok();
    let catalog = Catalog::enumerate();
    let info = catalog.select(selector.as_deref())?;
    println!("device {} ({}, driver {})", info.name, info.platform, info.driver);
    let device = Device::open(info)?;
    for cells in [64, 128] {
        for (name, extinction) in [("cloud", cloud as fn(usize, DVec3) -> f64), ("random", random)] {
            let row = format!("scattered: {name} {cells}³");
            if wanted.has(&row) {
                solves(&device, &row, cells, extinction)?;
            }
        }
    }
    Ok(())
}

/// Shares of the largest extinction by voxel and place.
fn cloud(_: usize, p: DVec3) -> f64 {
    let waves = (7.0 * p.x + 1.0).sin() * (6.0 * p.y).sin() * (8.0 * p.z + 2.0).sin();
    (1.1 * (0.05 + 0.5 * waves)).clamp(0.0, 1.0)
}

fn random(i: usize, _: DVec3) -> f64 {
    10_f64.powf(-3.3 * uniform(philox4x32([i as u32, 1, 0, 0], [7, 0])[0]))
}

fn solves(
    device: &Device,
    row: &str,
    cells: usize,
    extinction: fn(usize, DVec3) -> f64,
) -> svetlo::Result<()> {
    let scene = Scene::from_loaded(&svetlo::config::parse("scattered", SCENE, &[])?, Path::new("."))?;
    let places =
        |i: usize| DVec3::new((i % cells) as f64, (i / cells % cells) as f64, (i / cells / cells) as f64);
    let centre = |i: usize| (places(i) + 0.5) / cells as f64;
    let voxels: Vec<f32> = (0..cells.pow(3)).map(|i| extinction(i, centre(i)) as f32).collect();
    let spacing = DVec3::splat(1.0 / cells as f64);
    let volume = Volume::new([cells; 3], spacing, Voxels::F32(voxels))?;
    let plan = Plan::new(&scene, &volume, BRICK_SHIFT)?;
    let medium = LitMedium::new(device, &plan, &plan.method)?;
    let grid = LightGrid::new(&plan.local, 1);
    let light: Vec<[f32; 4]> = (0..cells.pow(3)).map(|i| [(-9.0 * centre(i).z).exp() as f32; 4]).collect();
    let direct =
        DirectLight { fluence: Buffer::from_slice(device, &light)?, reduced: None, flow: None, extent: None };
    let mut classical = Vec::new();
    for limiter in [Limiter::None, Limiter::LevermorePomraning] {
        let settings = ScatterSettings { limiter, ..ScatterSettings::new(Method::Multigrid) };
        let start = Instant::now();
        let mut solver = ScatterSolver::new(device, &medium, &grid, &grid, &settings)?;
        let ready = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let found = solver.solve(device, &medium, &direct, &mut |_| ControlFlow::Continue(()))?;
        let seconds = start.elapsed().as_secs_f64();
        let fluence = found.fluence.read(device)?;
        let apart = relative(&fluence, &classical);
        let of = |value: &dyn Fn(usize) -> String| (0..3).map(value).collect::<Vec<_>>().join(" + ");
        println!(
            "{:<46} {ready:>6.2} s to make ready, {seconds:>7.2} s, {} updates, {} iterations, residual {:.1e}, \
             largest flux {:.3}, from classical {apart:.3}{}",
            format!("{row}, {}", limiter.name()),
            of(&|c| found.channels[c].outer.to_string()),
            of(&|c| found.channels[c].iterations.to_string()),
            found.channels.iter().map(|facts| facts.residual).fold(0.0, f64::max),
            found.channels.iter().map(|facts| facts.largest_flux).fold(0.0, f64::max),
            if found.channels.iter().all(|facts| facts.converged) { "" } else { " (not converged)" }
        );
        classical = fluence;
    }
    Ok(())
}

/// Root mean square of the difference over that of the second; 0 without one.
fn relative(a: &[[f32; 4]], b: &[[f32; 4]]) -> f64 {
    let square = |x: f32| f64::from(x).powi(2);
    let differences: f64 =
        a.iter().zip(b).map(|(a, b)| (0..3).map(|c| square(a[c] - b[c])).sum::<f64>()).sum();
    let sizes: f64 = b.iter().map(|b| b[..3].iter().map(|&b| square(b)).sum::<f64>()).sum();
    if sizes > 0.0 { (differences / sizes).sqrt() } else { 0.0 }
}
