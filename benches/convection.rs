//! Convection and spreading: a step beside the device's own copy of as many bytes, and whole sweeps.
//!
//! `cargo bench --bench convection [FILTER]`. The device is the default one, or what `SVETLO_DEVICE` selects.

mod timing;

use glam::DVec3;
use std::time::{Duration, Instant};
use svetlo::Result;
use svetlo::device::{Buffer, Catalog, Device, Program};
use svetlo::irradiance::{Carrying, Cells, Convection, DirectLight, LightGrid, Spreading, steady_light};
use svetlo::reference::random::{philox4x32, uniform};
use svetlo::render::local::LocalFrame;
use svetlo::scene::Light;
use timing::{Times, Wanted};

/// Runs measured after one warm-up.
const RUNS: usize = 9;
/// Cells per axis.
const CELLS: usize = 128;
/// Steps of a run.
const STEPS: u32 = 16;
/// What a step reads and writes per cell, light and channel: share, extinction; share.
const CARRIED_BYTES: usize = 12;
/// What a step of spreading reads and writes per cell: light, weights; light.
const SPREAD_BYTES: usize = 48;

struct Setting {
    device: Device,
    local: LocalFrame,
    grid: LightGrid,
    cells: Cells,
}

fn main() -> Result<()> {
    let wanted = Wanted::from_arguments();
    let selector = std::env::var("SVETLO_DEVICE").ok();
    let catalog = Catalog::enumerate();
    let info = catalog.select(selector.as_deref())?;
    println!("device {} ({}, driver {})", info.name, info.platform, info.driver);
    let device = Device::open(info)?;
    let local = LocalFrame::new(DVec3::ZERO, DVec3::ONE, [CELLS; 3]);
    let grid = LightGrid::new(&local, 1);
    let cells = medium(&device, grid.cells())?;
    let setting = Setting { device, local, grid, cells };
    let copied = copy(&setting)?;
    for (name, chromatic) in [("grey", false), ("chromatic", true)] {
        for (lights, all) in [("directional", directional()), ("point", points())] {
            for count in [1, 3] {
                let row = format!("{count} {lights}, {name}");
                if wanted.has(&format!("steps: {row}")) {
                    steps(&setting, &format!("steps: {row}"), &all[..count], chromatic, copied)?;
                }
                if wanted.has(&format!("steady: {row}")) {
                    steady(&setting, &format!("steady: {row}"), &all[..count], chromatic)?;
                }
            }
        }
    }
    if wanted.has("spreading") { spreading(&setting, copied) } else { Ok(()) }
}

fn medium(device: &Device, count: usize) -> Result<Cells> {
    let field = |seed: u32| {
        let value = |i: usize| 0.02 * uniform(philox4x32([i as u32, seed, 0, 0], [7, 0])[0]) as f32;
        let cells: Vec<[f32; 4]> = (0..count).map(|i| [value(i), value(i), value(i), 0.0]).collect();
        Buffer::from_slice(device, &cells)
    };
    Ok(Cells { scattering: field(1)?, absorption: field(2)?, glow: None })
}

fn directional() -> [Light; 3] {
    [DVec3::new(1.0, -2.0, 0.5), DVec3::new(-1.0, -1.0, 1.0), DVec3::NEG_Z]
        .map(|direction| Light::Directional { direction: direction.normalize(), irradiance: [1.0; 3] })
}

fn points() -> [Light; 3] {
    let size = CELLS as f64;
    [DVec3::splat(0.5), DVec3::new(0.3, 1.5, 0.4), DVec3::new(-2.0, -1.0, 3.0)]
        .map(|place| Light::Point { position: place * size, intensity: [1.0; 3] })
}

/// Bytes that the device's own copy reads and writes per second.
fn copy(setting: &Setting) -> Result<f64> {
    let source = "__kernel void copy(__global float4 *to, __global const float4 *from, uint count) {\n\
                  uint i = (uint)get_global_id(0);\nif (i < count) to[i] = from[i];\n}\n";
    let program = Program::build_source(&setting.device, source, "-cl-std=CL1.2")?;
    let mut copy = program.kernel(&setting.device, "copy")?;
    let count = 2 * setting.grid.cells();
    let (from, to) = (
        Buffer::<[f32; 4]>::zeroed(&setting.device, count)?,
        Buffer::<[f32; 4]>::zeroed(&setting.device, count)?,
    );
    let times = Times::of(RUNS, || {
        copy.run(&setting.device, &[(&to).into(), (&from).into(), (count as u32).into()], count)
    })?;
    let rate = (2 * size_of::<[f32; 4]>() * count) as f64 / times.median().as_secs_f64();
    println!("{:<36} {times} ms, {:.2} GB/s", "copy", rate * 1e-9);
    Ok(rate)
}

/// What a run of `STEPS` steps says: `bytes` per cell and step in all.
fn tell(setting: &Setting, row: &str, times: &Times, bytes: usize, copied: f64) {
    let cells = setting.grid.cells() as f64 * f64::from(STEPS) / times.median().as_secs_f64();
    let rate = cells * bytes as f64;
    println!(
        "{row:<36} {times} ms, {:.1} M cells·steps/s, {:.2} GB/s at {bytes} B per cell and step, {:.3} of the copy",
        cells * 1e-6,
        rate * 1e-9,
        rate / copied
    );
}

fn timed(device: &Device, work: impl FnOnce() -> Result<()>) -> Result<Duration> {
    device.finish()?;
    let start = Instant::now();
    work()?;
    device.finish()?;
    Ok(start.elapsed())
}

fn steps(setting: &Setting, row: &str, lights: &[Light], chromatic: bool, copied: f64) -> Result<()> {
    let Setting { device, local, grid, cells } = setting;
    let carrying = Carrying { chromatic, mean_cosine: 0.0, directed: false };
    let mut convection = Convection::new(device, grid, cells, lights, local, carrying, 0.5)?;
    let times = Times::of(RUNS, || timed(device, || convection.advance(device, STEPS)))?;
    let channels = if chromatic { 4 } else { 1 };
    tell(setting, row, &times, CARRIED_BYTES * channels * lights.len(), copied);
    Ok(())
}

fn steady(setting: &Setting, row: &str, lights: &[Light], chromatic: bool) -> Result<()> {
    let Setting { device, local, grid, cells } = setting;
    let carrying = Carrying { chromatic, mean_cosine: 0.0, directed: false };
    let mut launches = 0;
    let times = Times::of(RUNS, || {
        timed(device, || {
            launches = steady_light(device, grid, cells, lights, local, carrying)?.launches;
            Ok(())
        })
    })?;
    println!("{row:<36} {times} ms, {launches} launches");
    Ok(())
}

fn spreading(setting: &Setting, copied: f64) -> Result<()> {
    let Setting { device, grid, cells, .. } = setting;
    let fluence = Buffer::from_slice(device, &vec![[1.0_f32; 4]; grid.cells()])?;
    let direct = DirectLight { fluence, reduced: None, flow: None, extent: None };
    let mut spreading = Spreading::new(device, grid, cells, 1.0 / 6.0)?;
    let times = Times::of(RUNS, || timed(device, || spreading.advance(device, &direct, STEPS)))?;
    tell(setting, "spreading", &times, SPREAD_BYTES, copied);
    Ok(())
}
