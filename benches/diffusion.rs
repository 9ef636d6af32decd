//! The diffusion solver: a stencil sweep beside the device's own copy, and solves by every method.
//!
//! `cargo bench --bench diffusion [FILTER]`. The device is the default one, or what `SVETLO_DEVICE` selects. Media are
//! cubes of edge 1 with 1 % absorption and a uniform source, solved to a relative residual of 10⁻⁶. Explicit steps and
//! over-relaxation take up to minutes: they run only when the filter names them.

mod timing;

use glam::DVec3;
use std::time::{Duration, Instant};
use svetlo::device::{Arg, Buffer, Catalog, Device, Program, ProgramSpec};
use svetlo::diffusion::{Boundary, Coefficients, Method, Outcome, Settings, Solver};
use svetlo::reference::random::{philox4x32, uniform};
use timing::{Times, Wanted};

/// Runs measured after one warm-up.
const RUNS: usize = 15;
/// What an element of a sweep reads and writes: source, three conductances, diagonal, φ; φ.
const SWEEP_BYTES: usize = 28;

fn main() -> svetlo::Result<()> {
    let wanted = Wanted::from_arguments();
    let selector = std::env::var("SVETLO_DEVICE").ok();
    let catalog = Catalog::enumerate();
    let info = catalog.select(selector.as_deref())?;
    println!("device {} ({}, driver {})", info.name, info.platform, info.driver);
    let device = Device::open(info)?;
    for cells in [128, 256] {
        if wanted.has(&format!("sweep: {cells}³")) {
            sweep(&device, cells)?;
        }
    }
    for cells in [64, 128] {
        for (medium, extinction) in media(cells) {
            for (name, method) in [
                ("multigrid", Method::Multigrid),
                ("conjugate gradients", Method::ConjugateGradients),
                ("over-relaxation", Method::OverRelaxation { factor: None }),
                ("explicit", Method::Explicit),
            ] {
                let row = format!("solve: {medium} {cells}³, {name}");
                let quick = matches!(method, Method::Multigrid | Method::ConjugateGradients);
                if wanted.has(&row) && (quick || wanted.names(name)) {
                    solve(&device, &row, cells, &extinction, method)?;
                }
            }
        }
    }
    Ok(())
}

/// Extinction per cell of the four media by which solvers are judged.
fn media(cells: usize) -> [(&'static str, Vec<f32>); 4] {
    let count = cells.pow(3);
    let centre = |i: usize| {
        let cell = [i % cells, i / cells % cells, i / cells / cells].map(|k| (k as f64 + 0.5) / cells as f64);
        DVec3::from_array(cell)
    };
    let ball = |i: usize| if centre(i).distance(DVec3::splat(0.5)) < 0.3 { 200.0 } else { 0.05 };
    let random = |i: usize| 10_f64.powf(-1.0 + 3.3 * uniform(philox4x32([i as u32, 1, 0, 0], [7, 0])[0]));
    let of = |value: &dyn Fn(usize) -> f64| (0..count).map(|i| value(i) as f32).collect();
    [("dense", of(&|_| 50.0)), ("thin", of(&|_| 1.0)), ("ball", of(&ball)), ("random", of(&random))]
}

/// One explicit step of all cells beside a copy of a buffer of as many bytes.
fn sweep(device: &Device, cells: usize) -> svetlo::Result<()> {
    let odd = cells | 1;
    let half = (odd * odd * cells).div_ceil(2).next_multiple_of(16);
    let guard = (odd * odd / 2 + 1).next_multiple_of(16);
    let count = 2 * (half + 2 * guard);
    let spec = ProgramSpec::new("diffusion/relax.cl").uncontracted();
    let copy = "__kernel void copy(__global float *to, __global const float *from, uint count) {\n\
                uint i = (uint)get_global_id(0);\nif (i < count) to[i] = from[i];\n}\n";
    let program = Program::build_probe(device, &spec, copy)?;
    let (mut copy, mut step) =
        (program.kernel(device, "copy")?, program.kernel(device, "diffusion_explicit")?);
    let fields: Vec<Buffer<f32>> = (0..7).map(|_| Buffer::zeroed(device, count)).collect::<Result<_, _>>()?;
    // The copy moves as many bytes as the sweep, from and to buffers that no cache holds whole.
    let moved = half * 2 * SWEEP_BYTES / 8;
    let (from, to) = (Buffer::<f32>::zeroed(device, moved)?, Buffer::<f32>::zeroed(device, moved)?);
    let copied =
        Times::of(RUNS, || copy.run(device, &[(&to).into(), (&from).into(), (moved as u32).into()], moved))?;
    let swept = Times::of(RUNS, || -> svetlo::Result<Duration> {
        let start = Instant::now();
        for colour in 0..2_u32 {
            let mut arguments: Vec<Arg<'_>> = fields.iter().map(Arg::from).collect();
            arguments.extend([half, guard, odd / 2, odd * odd / 2].map(|number| Arg::from(number as u32)));
            arguments.push(colour.into());
            step.enqueue(device, &arguments, [half, 1, 1])?;
        }
        device.finish()?;
        Ok(start.elapsed())
    })?;
    let rate = |times: &Times| (2 * half * SWEEP_BYTES) as f64 / times.median().as_secs_f64() * 1e-9;
    println!("{:<40} {copied} ms, {:.2} GB/s", format!("copy: as many bytes as {cells}³"), rate(&copied));
    println!("{:<40} {swept} ms, {:.2} GB/s", format!("sweep: {cells}³"), rate(&swept));
    println!("{:<40} {:.3}", "sweep over copy", rate(&swept) / rate(&copied));
    Ok(())
}

fn solve(device: &Device, row: &str, cells: usize, extinction: &[f32], method: Method) -> svetlo::Result<()> {
    let upload = |value: &dyn Fn(f32) -> f32| {
        Buffer::from_slice(device, &extinction.iter().map(|&sigma| value(sigma)).collect::<Vec<f32>>())
    };
    let (absorption, diffusivity) = (upload(&|sigma| 0.01 * sigma)?, upload(&|sigma| 1.0 / (3.0 * sigma))?);
    let coefficients = Coefficients { absorption: &absorption, diffusivity: &diffusivity };
    let source = upload(&|_| 1.0)?;
    let spacing = DVec3::splat(1.0 / cells as f64);
    let mut solver = Solver::new(device, [cells; 3], spacing, Boundary::OPEN)?;
    let start = Instant::now();
    let Outcome { iterations, residual, converged, .. } =
        solver.solve(device, &coefficients, &source, &Settings::new(method))?.outcome;
    println!(
        "{row:<46} {iterations:>7} iterations, residual {residual:.2e}, {:>9.3} s{}",
        start.elapsed().as_secs_f64(),
        if converged { "" } else { " (not converged)" }
    );
    Ok(())
}
