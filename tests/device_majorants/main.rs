//! Majorants and minorants hold for every extinction the device computes, and are no looser than they say.

#[path = "../common/mod.rs"]
mod common;
mod probe;

use common::noise;
use glam::DVec3;
use probe::Probe;
use svetlo::render::medium::MediumTable;
use svetlo::volume::{Volume, Voxels};

/// Window values of one-entry spikes, steps, plateaus and a gap, between entries and on them.
const PEAKS: [f64; 6] = [0.1, 0.2505, 0.4, 0.55, 0.8, 1.0];

/// A transfer function of spikes and steep plateaus, alternating, at [`PEAKS`]: each is 2·`width` wide.
fn peaked(width: f64, resolution: usize) -> String {
    let feature = |(k, peak): (usize, &f64)| {
        let inner = if k % 2 == 0 { 1e-3 } else { 0.9 };
        let top = [1.0, 0.3, 1e-4][k % 3];
        [(-1.0, 0.0), (-inner, top), (inner, top), (1.0, 0.0)].map(|(x, y)| (peak + x * width, y))
    };
    let points = PEAKS.iter().enumerate().flat_map(feature).filter(|(value, _)| *value <= 1.0);
    let points = points.map(|(value, opacity)| format!("{{ value = {value}, opacity = {opacity} }}"));
    format!("resolution = {resolution}\npoints = [{}]", points.collect::<Vec<_>>().join(", "))
}

const FALLING: &str = "points = [{ value = 0.2, opacity = 1 }, { value = 0.7, opacity = 0 }]";

/// Noise as stored in `voxels`, times `scale` plus `offset`.
fn noisy(dims: [usize; 3], spacing: [f64; 3], seed: u32, store: impl Fn(&[f64]) -> Voxels) -> Volume {
    Volume::new(dims, DVec3::from_array(spacing), store(&noise(dims.iter().product(), seed))).unwrap()
}

/// Volumes of all kinds with their windows.
fn volumes() -> Vec<(&'static str, Volume, (f64, f64))> {
    let u8s = |v: &[f64]| Voxels::U8(v.iter().map(|v| (v * 256.0) as u8).collect::<Vec<_>>());
    let i16s = |v: &[f64]| Voxels::I16(v.iter().map(|v| (v * 4000.0 - 1500.0) as i16).collect::<Vec<_>>());
    let high = |v: &[f64]| Voxels::U16(v.iter().map(|v| (v * 12.0 + 65500.0) as u16).collect::<Vec<_>>());
    let low = |v: &[f64]| Voxels::I16(v.iter().map(|v| (v * 9.0 - 32767.0) as i16).collect::<Vec<_>>());
    let f32s = |v: &[f64]| Voxels::F32(v.iter().map(|&v| v as f32).collect::<Vec<_>>());
    let wild = |v: &[f64]| {
        let voxel = |(k, &v): (usize, &f64)| match k % 17 {
            3 => f32::NAN,
            7 => f32::INFINITY,
            11 => (v * 1e6) as f32,
            13 => (v * -1e12) as f32,
            _ => v as f32,
        };
        Voxels::F32(v.iter().enumerate().map(voxel).collect::<Vec<_>>())
    };
    let mut falling = noisy([6, 9, 5], [1.0, 0.6, 2.3], 2, i16s);
    (falling.slope, falling.intercept) = (-2.0, 10.0);
    let aniso = [1.7, 1.0, 0.4];
    vec![
        ("uint8", noisy([9, 7, 11], [1.0; 3], 1, u8s), (0.0, 255.0)),
        ("uint8, window beyond", noisy([5, 3, 7], aniso, 3, u8s), (-31.0, 199.0)),
        ("int16, falling", falling, (-3000.0, 2000.0)),
        ("uint16, high", noisy([5, 3, 7], aniso, 4, high), (65500.0, 65512.0)),
        ("int16, low", noisy([4, 6, 5], aniso, 5, low), (-32767.0, -32758.0)),
        ("float32", noisy([8, 9, 7], [0.3, 0.3, 0.2], 6, f32s), (0.05, 0.95)),
        ("float32, wild", noisy([7, 5, 9], [1.0; 3], 7, wild), (0.0, 1.0)),
        ("a column", noisy([1, 1, 600], [1.0, 2.0, 3.0], 8, f32s), (0.0, 1.0)),
        ("one voxel", noisy([1, 1, 1], [1.0; 3], 9, u8s), (0.0, 255.0)),
    ]
}

#[test]
fn bounds_hold_for_functions_of_the_value() {
    let mut compared = 0;
    for (name, volume, window) in volumes() {
        let mut probe = Probe::new(volume, window, "", &[0.0, 1.0]);
        let functions = [
            peaked(1.0 / 1020.0, 1021),
            peaked(0.004, 65536),
            peaked(0.03, 64),
            FALLING.into(),
            String::new(),
        ];
        for (k, transfer) in functions.iter().enumerate() {
            probe = Probe::new(probe.volume, window, transfer, &PEAKS);
            // Both layouts of entries on the first; a long column has bricks enough at one size.
            let shifts = if probe.volume.dims[2] > 100 { 3..=3 } else { 1..=5 };
            for sigma_only in if k == 0 { [true, false].iter() } else { [true].iter() } {
                compared += probe.holds(&format!("{name}, {transfer}"), shifts.clone(), *sigma_only);
            }
        }
    }
    println!("{compared} look-ups");
}

#[test]
fn bounds_hold_for_functions_of_value_and_gradient() {
    let shapes = "shapes = [{ shape = \"ellipse\", centre = [0.3, 0.3], size = [0.3, 0.4], softness = 0.1 },\
        { shape = \"rectangle\", centre = [0.75, 0.55], size = [0.01, 0.1], opacity = 0.4 },\
        { shape = \"rectangle\", centre = [0.6, 0.02], size = [0.3, 0.05] }]";
    let mut compared = 0;
    for (name, volume, window) in volumes() {
        let mut volume = volume;
        // The second and third are folded in the bounds: more than 257 entries along an axis.
        for (k, resolution) in ["[64, 32]", "[300, 20]", "[17, 600]", "[2, 2]"].iter().enumerate() {
            let transfer = format!("kind = \"2d\"\nresolution = {resolution}\ngradient_max = 0.7\n{shapes}");
            let mut probe = Probe::new(volume, window, &transfer, &[]);
            probe.lanes = k % 2 == 1;
            let shifts = if probe.volume.dims[2] > 100 { 2..=3 } else { 1..=4 };
            compared += probe.holds(&format!("{name}, {resolution}"), shifts, k != 1);
            volume = probe.volume;
        }
    }
    println!("{compared} look-ups");
}

#[test]
fn bounds_are_attained_in_bricks_between_voxels() {
    // Relative to the largest extinction of the function. Voxels and peaks on edges between them are all looked up, so
    // that the largest value found is the largest there is, but for rounding: of the values, 3 · 2^-24 · 765 units of
    // 4 entries or 6e-4 entries, as of the points of peaks (2^-21 cells of at most 255 units: 5e-4 entries); a spike
    // falls by all of its height in one entry.
    const BOUND: f64 = 1.2e-3;
    let volume = || {
        let voxels = noise(9 * 7 * 11, 1).iter().map(|v| (v * 256.0) as u8).collect::<Vec<_>>();
        Volume::new([9, 7, 11], DVec3::new(1.0, 1.5, 2.0), Voxels::U8(voxels)).unwrap()
    };
    for (what, transfer) in
        [("ramp", String::new()), ("spikes", peaked(1.0 / 1020.0, 1021)), ("falling", FALLING.into())]
    {
        // All features of the functions lie on entries: peaks, and the ends of plateaus.
        let entries: Vec<f64> = (0..=1020).map(|k| f64::from(k) / 1020.0).collect();
        let mut probe = Probe::new(volume(), (0.0, 255.0), &transfer, &[]);
        probe.peaks = entries.into_iter().filter(|&v| is_bend(&probe.table, v)).collect();
        for shift in [1, 2] {
            let bricks = probe.grid().brick_ranges(shift);
            let majorants = probe.majorants(&bricks);
            let (owners, points) = probe.all_points(&bricks, 20, None);
            let mut extremes = vec![[f64::INFINITY, 0.0]; bricks.ranges.len()];
            for (&brick, [sigma, _]) in owners.iter().zip(probe.sigmas(&bricks, &points, true)) {
                let [least, most] = &mut extremes[brick];
                *least = least.min(f64::from(sigma));
                *most = most.max(f64::from(sigma));
            }
            let scale = probe.table.max_sigma();
            let slack = |(&[majorant, minorant], &[least, most]): (&[f32; 2], &[f64; 2])| {
                (f64::from(majorant.max(0.0)) - most).max(least - f64::from(minorant)) / scale
            };
            // The border's bricks hold voxels beyond the box, but those are copies.
            let worst = common::largest(majorants.bounds.iter().zip(&extremes).map(slack));
            common::report(&format!("{what}, shift {shift}"), worst, BOUND);
            assert!(worst <= BOUND, "{what}, shift {shift}: {worst}");
        }
    }
}

/// Whether a table has an extremum at this window value.
fn is_bend(table: &MediumTable, value: f64) -> bool {
    let at = |step: f64| table.sigma(value * table.intervals() + step, 0.0);
    let (before, here, after) = (at(-1.0), at(0.0), at(1.0));
    (here - before) * (after - here) <= 0.0 && (before, here) != (here, after)
}

#[test]
fn materials_that_start_at_a_value_of_the_data_leave_bricks_below_it_free() {
    // Bricks whose largest voxel is 100 or less, where extinction starts at 100 exactly.
    let voxels = noise(24 * 24 * 24, 3).iter().map(|v| (v * 101.0) as u8).collect::<Vec<_>>();
    let volume = Volume::new([24; 3], DVec3::ONE, Voxels::U8(voxels)).unwrap();
    let start = 100.0 / 255.0;
    let transfer = format!("points = [{{ value = {start}, opacity = 0 }}, {{ value = 1, opacity = 1 }}]");
    let probe = Probe::new(volume, (0.0, 255.0), &transfer, &[start]);
    let bricks = probe.grid().brick_ranges(3);
    assert!(bricks.ranges.iter().filter(|range| range[1] == 100.0).count() > 30);
    assert_eq!(probe.majorants(&bricks).occupied, None);
    probe.holds("materials that start at a voxel's value", 1..=4, true);
}

#[test]
fn rounding_between_voxels_is_bounded_at_fractions_up_to_one() {
    // A + (B - A) is not B: where B is 6000, A between -16384 and -10384 and the difference beyond 2^14, it is up to
    // 2^-10 more. Extinction starts at 6000.
    let voxel = |v: &f64| if *v < 0.5 { 6000 } else { (v * 10_000.0) as i16 - 20_500 };
    let voxels: Vec<i16> = noise(12 * 12 * 12, 4).iter().map(voxel).collect();
    let volume = Volume::new([12; 3], DVec3::ONE, Voxels::I16(voxels)).unwrap();
    let transfer = "resolution = 11\npoints = [{ value = 0.7, opacity = 0 }, { value = 0.8, opacity = 1 }]";
    let probe = Probe::new(volume, (5993.0, 6003.0), transfer, &[]);
    let bricks = probe.grid().brick_ranges(1);
    let majorants = probe.majorants(&bricks);
    let (owners, points) = probe.all_points(&bricks, 100, Some(0));
    // Fractions of 1 along y must stay in the brick: a point on its high plane is in the next cell.
    let inside = |brick: usize, point: &[f32; 4]| point[1] < probe.extent(&bricks, brick)[1][1].floor();
    let (owners, points): (Vec<_>, Vec<_>) =
        owners.into_iter().zip(points).filter(|(b, p)| inside(*b, p)).unzip();
    let sigmas = probe.run("probe_ends", &bricks, &points, true);
    assert!(sigmas.iter().flatten().any(|sigma| *sigma > 0.0), "nothing rounded beyond");
    for (brick, [a, b]) in owners.into_iter().zip(sigmas) {
        let (sigma, bounds) = (a.max(b), majorants.bounds[brick]);
        assert!(sigma <= bounds[0].max(0.0), "{sigma} in {bounds:?}");
    }
}

#[test]
fn rounding_of_gradients_is_bounded() {
    // A gradient of 2^-16 on values around 1: samples below are rounded to 2^-24, those above to 2^-23, so that their
    // difference is off by up to 2^-9 of itself. It is row 128 exactly, and extinction starts there.
    let voxels = (0..16 * 9 * 7).map(|k| 1.0 + (f64::from(k % 16) - 8.0) / 65536.0);
    let transfer = "kind = \"2d\"\nresolution = [2, 257]\ngradient_max = 3.0517578125e-5\nshapes = \
        [{ shape = \"rectangle\", centre = [0.5, 1], size = [4, 0.99609375] }]";
    let probe = Probe::new(common::volume_f32([16, 9, 7], voxels), (0.0, 1.0), transfer, &[]);
    assert_eq!([127.0, 128.0, 129.0].map(|row| probe.table.sigma(0.5, row) > 0.0), [false, false, true]);
    probe.holds("a slope on an offset", 1..=3, true);
}

#[test]
fn rounding_beside_steep_flanks_is_bounded() {
    // Constant bricks whose extinction is a small rest of the entries it is interpolated between.
    let run = |k: u32| 0.5 - 0.1 * f64::powi(0.5, (k % 128 / 8) as i32) * 0.937;
    let transfer =
        "resolution = 11\npoints = [{ value = 0.4, opacity = 0.93 }, { value = 0.5, opacity = 1e-6 }]";
    let volume = common::volume_f32([128, 4, 4], (0..128 * 16).map(run));
    Probe::new(volume, (0.0, 1.0), transfer, &[]).holds("small rests", 1..=2, true);
}
