//! Times of the kernels' parts, with a count beside each time that does not depend on the machine.
//!
//! `cargo bench --bench parts [FILTER]`. The device is the default one, or what `SVETLO_DEVICE` selects. Parts that are
//! functions are called by a kernel that does little else; tracking is the path tracer itself on a medium that absorbs
//! everything, so a path is one ray. `bytes` are those that an item reads and writes, by its definition: caches may
//! make them fewer.

mod timing;

use bytemuck::Zeroable;
use glam::DVec3;
use std::path::Path;
use std::time::{Duration, Instant};
use svetlo::device::{Arg, Buffer, Catalog, Device, DeviceInfo, Program, ProgramSpec};
use svetlo::film::{FilmPixel, FilmSummary};
use svetlo::irradiance::{Direct, LightGrid, LitMedium};
use svetlo::picture::Environment;
use svetlo::render::grid::{Grid, StoredWindow};
use svetlo::render::lights::Lights;
use svetlo::render::local::LocalFrame;
use svetlo::render::method::DeviceFrame;
use svetlo::render::{BRICK_SHIFT, Plan, SceneData, Session};
use svetlo::scene::{Background, EnvironmentSampling, Scene};
use svetlo::volume::{Volume, Voxels};
use timing::{Times, Wanted, count};

/// Runs measured after one warm-up.
const RUNS: usize = 9;
/// Work-items of a run.
const ITEMS: usize = 1 << 18;
/// Times that a work-item does its part.
const TURNS: u32 = 16;

fn main() -> svetlo::Result<()> {
    let wanted = Wanted::from_arguments();
    let selector = std::env::var("SVETLO_DEVICE").ok();
    let catalog = Catalog::enumerate();
    let info = catalog.select(selector.as_deref())?;
    println!("device {} ({}, driver {})", info.name, info.platform, info.driver);
    println!(
        "{:<34} {:>9} {:>8} {:>8} {:>22} {:>9} {:>6}",
        "part", "median ms", "min ms", "max ms", "count", "ns each", "bytes"
    );
    let bench = Bench { device: Device::open(info)?, wanted };
    bench.random_numbers()?;
    bench.look_ups()?;
    bench.film()?;
    bench.environment()?;
    bench.tracking(info)?;
    bench.direct_light()
}

struct Bench {
    device: Device,
    wanted: Wanted,
}

/// One row of the table.
fn row(name: &str, times: &Times, items: u64, what: &str, bytes: usize) {
    println!(
        "{name:<34} {times} {:>22} {:>9.3} {:>6}",
        format!("{} {what}", count(items)),
        times.median().as_secs_f64() * 1e9 / items as f64,
        if bytes == 0 { "-".into() } else { bytes.to_string() }
    );
}

impl Bench {
    /// Times `body`, statements over `i` (the work-item), `turn` and `sum` (a float4) that run `TURNS` times in each
    /// of `ITEMS` work-items, with `arguments` declared by `parameters`.
    fn function(
        &self,
        spec: ProgramSpec,
        parameters: &str,
        body: &str,
        arguments: Vec<Arg<'_>>,
    ) -> svetlo::Result<Times> {
        let kernel = format!(
            "__kernel void bench({parameters}__global float4 *out, uint count, uint turns) {{\n\
             uint i = (uint)get_global_id(0);\nif (i >= count) return;\nfloat4 sum = (float4)(0.0f);\n\
             for (uint turn = 0; turn < turns; ++turn) {{\n{body}\n}}\nout[i] = sum;\n}}\n"
        );
        let out = Buffer::<[f32; 4]>::zeroed(&self.device, ITEMS)?;
        let mut kernel = Program::build_probe(&self.device, &spec, &kernel)?.kernel(&self.device, "bench")?;
        let mut all = arguments;
        all.extend([Arg::from(&out), (ITEMS as u32).into(), TURNS.into()]);
        Times::of(RUNS, || kernel.run(&self.device, &all, ITEMS))
    }

    fn random_numbers(&self) -> svetlo::Result<()> {
        let items = ITEMS as u64 * u64::from(TURNS);
        if self.wanted.has("random: Philox4x32 block") {
            let body = "sum += uniform_float4(philox4x32((uint4)(i, turn, 0u, 1u), (uint2)(7u, 8u)));";
            let times = self.function(ProgramSpec::new("common/rng.cl"), "", body, vec![])?;
            row("random: Philox4x32 block", &times, items, "blocks", 0);
        }
        if self.wanted.has("random: Sobol pair") {
            let body = "sum.xy += sobol_pair(i + turn, (uint4)(1u, 2u, 3u, 4u), 0);";
            let times = self.function(ProgramSpec::new("common/sobol.cl"), "", body, vec![])?;
            row("random: Sobol pair", &times, items, "pairs", 0);
        }
        Ok(())
    }

    /// Trilinear look-ups: all over the volume, where caches help little, and along x, where they help much.
    fn look_ups(&self) -> svetlo::Result<()> {
        let scattered = "float4 p = (float4)(i, i, i, 0.0f) + (float)turn * (float4)(977.0f, 331.0f, 113.0f, 0.0f);\n\
                         p *= (float4)(0.8191725134f, 0.6710436067f, 0.5497004779f, 0.0f);\n\
                         p = (p - floor(p)) * SIZE + 2.0f;";
        let along = "float4 p = (float4)(0.5f * (float)turn + (float)((i * 16u) % (uint)(SIZE - 16.0f)), \
                     (float)((i >> 4) % (uint)SIZE), (float)((i >> 12) % (uint)SIZE), 0.0f) + 2.3f;";
        for (n, order, place) in
            [(64, "scattered", scattered), (256, "scattered", scattered), (256, "along rays", along)]
        {
            for kind in ["uchar", "float"] {
                let name = format!("look-up: {kind} {n}³, {order}");
                if self.wanted.has(&name) {
                    let (times, bytes) = self.look_up(n, kind, place)?;
                    row(&name, &times, ITEMS as u64 * u64::from(TURNS), "look-ups", bytes);
                }
            }
        }
        Ok(())
    }

    fn look_up(&self, n: usize, kind: &str, place: &str) -> svetlo::Result<(Times, usize)> {
        let count = n * n * n;
        let byte = |i: usize| (i as u32).wrapping_mul(2_654_435_761).to_be_bytes()[0];
        let (voxels, size) = match kind {
            "uchar" => (Voxels::U8((0..count).map(byte).collect::<Vec<u8>>()), 1),
            _ => (Voxels::F32((0..count).map(|i| f32::from(byte(i))).collect::<Vec<f32>>()), 4),
        };
        let volume = Volume::new([n; 3], DVec3::ONE, voxels)
            .map_err(|error| svetlo::Error::Failed(error.to_string()))?;
        let local = LocalFrame::new(DVec3::ZERO, DVec3::ONE, [n; 3]);
        let grid = Grid::new(&volume, StoredWindow::new(&volume, (0.0, 255.0)), local);
        let described = grid.describe(&grid.brick_ranges(BRICK_SHIFT), 1.0);
        let described = Buffer::from_slice(&self.device, &[described])?;
        let voxels = grid.upload(&self.device)?;
        let spec = ProgramSpec::new("volume/sampling.cl")
            .define("VOXEL", grid.device_type())
            .define("SIZE", format!("{n}.0f"));
        let times = self.function(
            spec,
            "__constant struct Volume *volume, __global const VOXEL *voxels, ",
            &format!("{place}\nsum.x += sample_raw(volume, voxels, p);"),
            vec![(&described).into(), (&voxels).into()],
        )?;
        Ok((times, 8 * size))
    }

    /// Samples added to pixels.
    fn film(&self) -> svetlo::Result<()> {
        let name = "film: sample added";
        if !self.wanted.has(name) {
            return Ok(());
        }
        let film = Buffer::<FilmPixel>::zeroed(&self.device, ITEMS)?;
        let body = "struct FilmPixel pixel = film[i];\n\
                    film_add(&pixel, (float4)((float)(i ^ turn)), -1.0f, 1u);\nfilm[i] = pixel;";
        let spec = ProgramSpec::new("film/accumulate.cl");
        let times = self.function(spec, "__global struct FilmPixel *film, ", body, vec![(&film).into()])?;
        row(name, &times, ITEMS as u64 * u64::from(TURNS), "samples", 2 * size_of::<FilmPixel>());
        Ok(())
    }

    /// Directions drawn from an environment map by its brightness.
    fn environment(&self) -> svetlo::Result<()> {
        let name = "environment: direction, 512×256";
        if !self.wanted.has(name) {
            return Ok(());
        }
        let map = Environment::read(
            &Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/data/studio_512x256.exr"),
        )?;
        let background = Background::Environment {
            path: "unread".into(),
            intensity: 1.0,
            rotation: 0.0,
            sampling: EnvironmentSampling::Importance,
        };
        let local = LocalFrame::new(DVec3::ZERO, DVec3::ONE, [1; 3]);
        let mut frame = DeviceFrame::zeroed();
        (frame.environment_width, frame.environment_height) = (map.width as u32, map.height as u32);
        let lights = Lights::new(&[], &background, Some(&map), &local);
        lights.describe(&mut frame);
        let [_, sums] = lights.buffers();
        let (frame, sums) =
            (Buffer::from_slice(&self.device, &[frame])?, Buffer::from_slice(&self.device, &sums.bytes)?);
        let body = "float pdf;\n\
                    float2 u = (float2)((float)((i * 2654435761u + turn) >> 8), (float)(((i ^ turn) * 2246822519u) >> 8)) \
                    * 0x1p-24f;\nsum += environment_direction(frame, sums, u, &pdf);\nsum.w += pdf;";
        let times = self.function(
            ProgramSpec::new("lights/environment.cl").feature("ENVIRONMENT", true),
            "__constant struct Frame *frame, __global const float *sums, ",
            body,
            vec![(&frame).into(), (&sums).into()],
        )?;
        // Two searches, of 256 rows and of 512 columns.
        row(name, &times, ITEMS as u64 * u64::from(TURNS), "directions", (8 + 9 + 2) * 4);
        Ok(())
    }

    /// Rays through a black cloud, by each estimator: what a look-up costs, and how many a ray takes for which noise.
    fn tracking(&self, info: &DeviceInfo) -> svetlo::Result<()> {
        let mut headed = false;
        for estimator in ["analog", "ratio", "auto", "residual-ratio", "ray-marching"] {
            let name = format!("tracking: {estimator}");
            if !self.wanted.has(&name) {
                continue;
            }
            if !headed {
                println!(
                    "\n{:<34} {:>9} {:>8} {:>8} {:>22} {:>9} {:>13} {:>7}",
                    "part", "median ms", "min ms", "max ms", "count", "ns each", "look-ups/path", "noise"
                );
                headed = true;
            }
            let tracked = track(info, estimator)?;
            println!(
                "{name:<34} {} {:>22} {:>9.3} {:>13.3} {:>7.4}",
                tracked.times,
                format!("{} look-ups", count(tracked.lookups)),
                tracked.times.median().as_secs_f64() * 1e9 / tracked.lookups as f64,
                tracked.lookups as f64 / tracked.paths as f64,
                tracked.noise
            );
        }
        Ok(())
    }

    /// Direct light of a sun in the cells of a cloud: a ray from each towards it.
    fn direct_light(&self) -> svetlo::Result<()> {
        let name = "light volume: direct light, 128³";
        if !self.wanted.has(name) {
            return Ok(());
        }
        let overrides = [
            "light=[{kind=\"directional\",direction=[1,-2,1],irradiance=1}]".into(),
            "background.color=0".into(),
            "method={kind=\"single-scattering\"}".into(),
        ];
        let scene = cloud(&overrides)?;
        let loaded = SceneData::load(&scene)?;
        let plan = Plan::new(&scene, &loaded, BRICK_SHIFT)?;
        let medium = LitMedium::new(&self.device, &plan, &plan.method)?;
        let grid = LightGrid::new(&plan.local, 1);
        let mut direct = Direct::new(&self.device, &medium, &grid, &scene.phase)?;
        let mut passes = 0;
        let times = Times::of(RUNS, || {
            passes += 1;
            let begin = Instant::now();
            while !direct.is_done(passes) {
                direct.step(&self.device, &medium, passes)?;
            }
            self.device.finish()?;
            Ok::<Duration, svetlo::Error>(begin.elapsed())
        })?;
        let lookups = direct.cost(&self.device)?.lookups / u64::from(passes);
        row(name, &times, lookups, "look-ups", 8 * plan.volume()?.grid.device_voxels().1);
        Ok(())
    }
}

fn cloud(overrides: &[String]) -> svetlo::Result<Scene> {
    Scene::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/scenes/cloud.toml"), overrides)
}

/// What a sample of the cloud took.
struct Tracked {
    times: Times,
    /// In the mean, per sample.
    lookups: u64,
    paths: u64,
    /// Standard deviation of a path, RMS over the pixels.
    noise: f64,
}

fn track(info: &DeviceInfo, estimator: &str) -> svetlo::Result<Tracked> {
    let overrides = [
        "medium.albedo=0".into(),
        "transfer={resolution=2}".into(),
        format!("method={{kind=\"multiple-scattering\",transmittance=\"{estimator}\",paths=4}}"),
    ];
    let scene = cloud(&overrides)?;
    let loaded = SceneData::load(&scene)?;
    let plan = Plan::new(&scene, &loaded, BRICK_SHIFT)?;
    let mut session = Session::new(Device::open(info)?, &plan)?;
    let mut done = 0;
    // Each run adds a sample to every pixel.
    let times = Times::of(RUNS, || {
        done += 1;
        let before = session.progress().device_time;
        session.render(done)?;
        Ok::<Duration, svetlo::Error>(session.progress().device_time - before)
    })?;
    let paths = session.ledger()?.unwrap_or_default();
    let error = FilmSummary::of(&session.film()?).standard_error.unwrap_or(f64::NAN);
    Ok(Tracked {
        times,
        lookups: paths.lookups / u64::from(done),
        paths: paths.paths / u64::from(done),
        noise: error * (f64::from(done) * 4.0).sqrt(),
    })
}
