//! Gathering photons: maps of them and a frame of points, beside how many photons each point looks at.
//!
//! `cargo bench --bench gather [FILTER]`. The device is the default one, or what `SVETLO_DEVICE` selects. The sizes are
//! those of Bogolepov, Sopin and Turlapov: a floor of 10 × 10 that is gathered within 0.04. Half of the photons lie in a
//! caustic about its middle, the others anywhere.

mod timing;

use glam::DVec3;
use std::time::Duration;
use svetlo::Result;
use svetlo::caustics::{Acceleration, MapFacts, MapSettings, Photon, PhotonMap, Receiver};
use svetlo::device::{Buffer, Catalog, Device, Program, ProgramSpec};
use svetlo::reference::random::{philox4x32, uniform};
use timing::{Times, Wanted, count};

const RUNS: usize = 3;
const FLOOR: f64 = 10.0;
const RADIUS: f32 = 0.04;
/// Points of a frame; a fifth of 1920 × 1080 along each side.
const FRAME: [usize; 2] = [384, 216];
const PHOTONS: [usize; 4] = [1 << 14, 1 << 16, 1 << 18, 1 << 20];
/// More are too many to look at by every point.
const MOST_BRUTE: usize = 1 << 14;

const PROBE: &str = "
__kernel void bench_gather(PHOTON_MAP_ARGUMENTS(map), __global float4 *out, float floor_size, uint width, uint height) {
    uint i = (uint)get_global_id(0);
    if (i >= width * height) return;
    struct PhotonMap map = PHOTON_MAP(map);
    float3 point = (float3)(((float)(i % width) + 0.5f) / (float)width, ((float)(i / width) + 0.5f) / (float)height, 0.0f);
    uint looked_at = 0;
    float3 found = gathered_irradiance(&map, floor_size * point, (float3)(0.0f, 0.0f, 1.0f), 0u, false, &looked_at);
    out[i] = (float4)(found, as_float(looked_at));
}
";

fn main() -> Result<()> {
    let wanted = Wanted::from_arguments();
    let selector = std::env::var("SVETLO_DEVICE").ok();
    let catalog = Catalog::enumerate();
    let info = catalog.select(selector.as_deref())?;
    println!("device {} ({}, driver {})", info.name, info.platform, info.driver);
    println!(
        "{} x {} points; milliseconds: keys, sort, fill, order; frame: median, least, most",
        FRAME[0], FRAME[1]
    );
    let device = Device::open(info)?;
    for photons in PHOTONS {
        let slots = Buffer::from_slice(&device, &floor(photons))?;
        for (name, acceleration, table_cells) in [
            ("brute force", Acceleration::BruteForce, 0),
            ("lexicographic", Acceleration::Lexicographic, 0),
            ("voxels", Acceleration::Voxels, 1 << 24),
            ("voxels, searched", Acceleration::Voxels, 0),
            ("planar", Acceleration::Planar, 1 << 24),
        ] {
            let skipped = acceleration == Acceleration::BruteForce && photons > MOST_BRUTE;
            if wanted.has(&format!("{name} {photons}")) && !skipped {
                let settings = MapSettings { acceleration, table_cells, ..MapSettings::default() };
                row(&device, name, settings, &slots)?;
            }
        }
    }
    Ok(())
}

fn floor(photons: usize) -> Vec<Photon> {
    let one = |i: usize| {
        let [a, b, c] = [0, 1, 2].map(|k| uniform(philox4x32([i as u32, k, 0, 0], [11, 0])[0]));
        let [x, y] = if i.is_multiple_of(2) {
            [a, b]
        } else {
            let (sin, cos) = (std::f64::consts::TAU * a).sin_cos();
            let r = 0.1 + 0.1 * (b + c - 1.0);
            [0.5 + r * cos, 0.5 + r * sin]
        };
        // Packed octahedrally.
        let down = f32::from_bits(u32::MAX);
        let facing_up = (32 | 32 << 6) << 19 | 1;
        Photon {
            position: [(FLOOR * x) as f32, (FLOOR * y) as f32, 0.0, down],
            flux: [1.0, 1.0, 1.0, f32::from_bits(facing_up)],
        }
    };
    (0..photons).map(one).collect()
}

fn row(device: &Device, name: &str, settings: MapSettings, slots: &Buffer<Photon>) -> Result<()> {
    let floor = Receiver::parallelogram(DVec3::ZERO, FLOOR * DVec3::X, FLOOR * DVec3::Y);
    let mut map = PhotonMap::new(device, settings, &[floor], slots.len())?;
    let mut facts = MapFacts::default();
    for _ in 0..RUNS {
        facts = map.build(device, slots, 0..slots.len(), RADIUS)?;
    }
    let spec = settings.define(ProgramSpec::new("caustics/gather.cl"), device.info());
    let mut kernel = Program::build_probe(device, &spec, PROBE)?.kernel(device, "bench_gather")?;
    let points = FRAME[0] * FRAME[1];
    let out = Buffer::<[f32; 4]>::zeroed(device, points)?;
    let times = Times::of(RUNS, || {
        let rest = [(&out).into(), (FLOOR as f32).into(), (FRAME[0] as u32).into(), (FRAME[1] as u32).into()];
        let arguments: Vec<_> = map.arguments().into_iter().chain(rest).collect();
        kernel.run(device, &arguments, points)
    })?;
    let looked_at: u64 = out.read(device)?.iter().map(|found| u64::from(found[3].to_bits())).sum();
    let ms = |time: Duration| time.as_secs_f64() * 1e3;
    println!(
        "{name:<18} {:>9} photons {:>7.2} {:>7.2} {:>7.2} {:>7.2} {times}  {:>9} looked at per point",
        count(slots.len() as u64),
        ms(facts.keys),
        ms(facts.sort),
        ms(facts.fill),
        ms(facts.order),
        looked_at / points as u64
    );
    Ok(())
}
