//! Majorants and minorants hold for every extinction the device computes, and are no looser than they say.

mod common;

use bytemuck::Zeroable;
use common::{noise, scene};
use glam::DVec3;
use svetlo::device::{Buffer, Device, Program, ProgramSpec};
use svetlo::render::grid::{BrickRanges, Grid, StoredWindow};
use svetlo::render::local::LocalFrame;
use svetlo::render::majorants::Majorants;
use svetlo::render::medium::MediumTable;
use svetlo::render::method::DeviceFrame;
use svetlo::volume::{Volume, Voxels};

/// Grid coordinate of voxel 0, `GRID_PAD` in `cl/types/volume.cl`.
const PAD: usize = 2;

/// Extinction by table, and by the straight line that the table may be.
const PROBE: &str = "\
__kernel void probe(__constant struct Frame *frame, __constant struct Volume *volume, __global const VOXEL *voxels,
    __global const Medium *table, __global const float2 *line, __global const float4 *points,
    __global float2 *sigmas, uint count) {
    size_t i = get_global_id(0);
    if (i >= count) return;
    float value = window_value(volume, sample_raw(volume, voxels, points[i]));
    sigmas[i].x = medium_sigma(medium_at(frame, volume, voxels, table, points[i]));
    sigmas[i].y = line->x + line->y * clamp(value, 0.0f, (float)(frame->table_size - 1));
}
";

/// A volume, what its window is, and a medium.
struct Probe {
    device: Device,
    volume: Volume,
    window: (f64, f64),
    table: MediumTable,
    /// Window values at which the transfer function has its peaks.
    peaks: Vec<f64>,
    lanes: bool,
}

/// Numbers in [0, 1), one after the other.
struct Random {
    values: std::iter::Cycle<std::vec::IntoIter<f64>>,
}

impl Random {
    fn new(seed: u32) -> Self {
        Self { values: noise(100_003, seed).into_iter().cycle() }
    }

    fn next(&mut self) -> f64 {
        self.values.next().unwrap()
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() * count as f64) as usize
    }
}

impl Probe {
    /// `transfer` is the text of `[transfer]`.
    fn new(volume: Volume, window: (f64, f64), transfer: &str, peaks: &[f64]) -> Self {
        let text = format!(
            "[image]\nwidth = 1\nheight = 1\n[camera]\nposition = [0, 0, -9]\ntarget = [0, 0, 0]\nfov = 30\n\
             [volume]\n[medium]\nsigma_max = 37\n[transfer]\n{transfer}\n[method]\nkind = \"emission-absorption\"\n"
        );
        let scene = scene(&text);
        let unit = volume.spacing.min_element();
        let table = MediumTable::new(&scene.transfer, &scene.medium, window, unit).unwrap();
        Self { device: common::device(), volume, window, table, peaks: peaks.to_vec(), lanes: false }
    }

    fn grid(&self) -> Grid<'_> {
        let frame = LocalFrame::new(DVec3::ZERO, self.volume.spacing, self.volume.dims);
        Grid::new(&self.volume, StoredWindow::new(&self.volume, self.window), frame)
    }

    fn majorants(&self, bricks: &BrickRanges) -> Majorants {
        let grid = self.grid();
        let gradients = (self.table.rows > 1).then(|| grid.brick_gradients(bricks));
        Majorants::new(&grid, bricks, gradients.as_deref(), &self.table)
    }

    /// What the device computes at points in grid coordinates.
    fn sigmas(&self, bricks: &BrickRanges, points: &[[f32; 4]], sigma_only: bool) -> Vec<[f32; 2]> {
        let (device, table, grid) = (&self.device, &self.table, self.grid());
        let spec = ProgramSpec::new("volume/transfer.cl")
            .define("VOXEL", grid.device_type())
            .feature("TF_2D", table.rows > 1)
            .feature("LANES", self.lanes)
            .feature("TRANSMITTANCE_ONLY", sigma_only);
        let program = Program::build_probe(device, &spec, PROBE).unwrap();
        let frame = DeviceFrame {
            table_size: table.size as u32,
            table_rows: table.rows as u32,
            gradient_scale: table.gradient_scale,
            ..DeviceFrame::zeroed()
        };
        let (offset, slope) = table.linear_ramp().unwrap_or_default();
        let frame = Buffer::from_slice(device, &[frame]).unwrap();
        let volume = Buffer::from_slice(device, &[grid.describe(bricks, table.intervals())]).unwrap();
        let voxels = grid.upload(device).unwrap();
        let entries = Buffer::from_slice(device, &table.device_entries(sigma_only)).unwrap();
        let line = Buffer::from_slice(device, &[[offset as f32, slope as f32]]).unwrap();
        let places = Buffer::from_slice(device, points).unwrap();
        let sigmas = Buffer::<[f32; 2]>::zeroed(device, points.len()).unwrap();
        let arguments = [
            (&frame).into(),
            (&volume).into(),
            (&voxels).into(),
            (&entries).into(),
            (&line).into(),
            (&places).into(),
            (&sigmas).into(),
            (points.len() as u32).into(),
        ];
        program.kernel(device, "probe").unwrap().run(device, &arguments, points.len()).unwrap();
        sigmas.read(device).unwrap()
    }

    /// Low and high planes of a brick, where they hold points of the box.
    fn extent(&self, bricks: &BrickRanges, index: usize) -> [[f32; 2]; 3] {
        let [nx, ny, _] = bricks.counts;
        let brick = [index % nx, index / nx % ny, index / (nx * ny)];
        std::array::from_fn(|a| {
            let planes = [brick[a], brick[a] + 1].map(|b| (b << bricks.shift) as f32);
            [planes[0].max(PAD as f32 - 0.5), planes[1].min((self.volume.dims[a] + PAD) as f32 - 0.5)]
        })
    }

    /// Points of a brick's closed cube: anywhere, on faces, edges and corners of cells, and just beside them.
    fn points(&self, extent: [[f32; 2]; 3], count: usize, random: &mut Random) -> Vec<[f32; 4]> {
        let mut coordinate = |[low, high]: [f32; 2]| {
            let anywhere = low + (high - low) * random.next() as f32;
            let near = match random.below(8) {
                0 => low,
                1 => high,
                2 => high.next_down(),
                3 => anywhere.round(),
                4 => anywhere.round().next_down(),
                5 => anywhere.round().next_up(),
                6 => anywhere.round() + 2.0_f32.powi(-(random.below(22) as i32)),
                _ => anywhere,
            };
            near.clamp(low, high)
        };
        let mut point = || extent.map(&mut coordinate);
        (0..count).map(|_| point()).map(|[x, y, z]| [x, y, z, 0.0]).collect()
    }

    /// Points of a brick at which the field is a peak of the transfer function, on edges between voxels. All edges,
    /// and all voxels of the brick before them, unless `few` are wanted.
    fn peak_points(&self, extent: [[f32; 2]; 3], few: Option<usize>, random: &mut Random) -> Vec<[f32; 4]> {
        let voxels = |[low, high]: [f32; 2]| low.ceil() as usize..=high.floor() as usize;
        let [xs, ys, zs] = extent.map(voxels);
        let lattice = zs.flat_map(|z| ys.clone().map(move |y| (y, z)));
        let mut lattice: Vec<[usize; 3]> =
            lattice.flat_map(|(y, z)| xs.clone().map(move |x| [x, y, z])).collect();
        if let (Some(few), false) = (few, lattice.is_empty()) {
            lattice = (0..few).map(|_| lattice[random.below(lattice.len())]).collect();
        }
        let value = |voxel: [usize; 3]| {
            let [x, y, z] = voxel.map(|i| i.saturating_sub(PAD));
            (self.volume.value(x, y, z) - self.window.0) / (self.window.1 - self.window.0)
        };
        let mut points: Vec<[f32; 4]> = Vec::new();
        for voxel in lattice {
            let at = voxel.map(|i| i as f32);
            points.push([at[0], at[1], at[2], 0.0]);
            for axis in 0..3 {
                let mut next = voxel;
                next[axis] += 1;
                let (a, b) = (value(voxel), value(next));
                let inside = at[axis] + 1.0 <= extent[axis][1];
                for peak in self.peaks.iter().map(|peak| (peak - a) / (b - a)) {
                    if inside && (0.0..=1.0).contains(&peak) {
                        let mut point = [at[0], at[1], at[2], 0.0];
                        point[axis] += peak as f32;
                        points.push(point);
                    }
                }
            }
        }
        points
    }

    /// Points of every brick, with the brick.
    fn all_points(
        &self,
        bricks: &BrickRanges,
        count: usize,
        few: Option<usize>,
    ) -> (Vec<usize>, Vec<[f32; 4]>) {
        let random = &mut Random::new(bricks.shift);
        let (mut owners, mut points) = (Vec::new(), Vec::new());
        for index in 0..bricks.ranges.len() {
            let extent = self.extent(bricks, index);
            let mut here = self.points(extent, count, random);
            here.extend(self.peak_points(extent, few, random));
            owners.extend(std::iter::repeat_n(index, here.len()));
            points.append(&mut here);
        }
        (owners, points)
    }

    /// Asserts that the bounds hold in bricks of several sizes; returns how many look-ups were compared.
    #[track_caller]
    fn holds(&self, what: &str, shifts: std::ops::RangeInclusive<u32>, sigma_only: bool) -> usize {
        let mut compared = 0;
        for shift in shifts {
            let bricks = self.grid().brick_ranges(shift);
            let majorants = self.majorants(&bricks);
            let (owners, points) = self.all_points(&bricks, 40, Some(10));
            let sigmas = self.sigmas(&bricks, &points, sigma_only);
            let both = if self.table.linear_ramp().is_some() { 2 } else { 1 };
            let mut violations = Vec::new();
            for ((&brick, point), sigmas) in owners.iter().zip(&points).zip(&sigmas) {
                let [majorant, minorant] = majorants.bounds[brick];
                for &sigma in &sigmas[..both] {
                    if !(sigma <= majorant.max(0.0) && sigma >= minorant) {
                        violations.push((brick, *point, sigma, majorants.bounds[brick]));
                    }
                }
            }
            let first = &violations[..violations.len().min(5)];
            assert!(
                violations.is_empty(),
                "{what}, shift {shift}: {} of {}: {first:?}",
                violations.len(),
                points.len()
            );
            let most = sigmas.iter().map(|s| s[0]).fold(0.0, f32::max);
            assert!(most <= majorants.largest, "{what}, shift {shift}");
            compared += both * points.len();
        }
        compared
    }
}

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
    let u8s = |v: &[f64]| Voxels::U8(v.iter().map(|v| (v * 256.0) as u8).collect::<Vec<_>>().into());
    let i16s =
        |v: &[f64]| Voxels::I16(v.iter().map(|v| (v * 4000.0 - 1500.0) as i16).collect::<Vec<_>>().into());
    let high =
        |v: &[f64]| Voxels::U16(v.iter().map(|v| (v * 12.0 + 65500.0) as u16).collect::<Vec<_>>().into());
    let low =
        |v: &[f64]| Voxels::I16(v.iter().map(|v| (v * 9.0 - 32767.0) as i16).collect::<Vec<_>>().into());
    let f32s = |v: &[f64]| Voxels::F32(v.iter().map(|&v| v as f32).collect::<Vec<_>>().into());
    let wild = |v: &[f64]| {
        let voxel = |(k, &v): (usize, &f64)| match k % 17 {
            3 => f32::NAN,
            7 => f32::INFINITY,
            11 => (v * 1e6) as f32,
            13 => (v * -1e12) as f32,
            _ => v as f32,
        };
        Voxels::F32(v.iter().enumerate().map(voxel).collect::<Vec<_>>().into())
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
        Volume::new([9, 7, 11], DVec3::new(1.0, 1.5, 2.0), Voxels::U8(voxels.into())).unwrap()
    };
    for (what, transfer) in
        [("ramp", String::new()), ("spikes", peaked(1.0 / 1020.0, 1021)), ("falling", FALLING.into())]
    {
        // All features of the functions lie on entries: peaks, and the ends of plateaus.
        let entries: Vec<f64> = (0..=1020).map(|k| f64::from(k) / 1020.0).collect();
        let probe = Probe::new(volume(), (0.0, 255.0), &transfer, &[]);
        let bends = entries.iter().copied().filter(|&v| is_bend(&probe.table, v));
        let probe = Probe { peaks: bends.collect(), ..probe };
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
    let volume = Volume::new([24; 3], DVec3::ONE, Voxels::U8(voxels.into())).unwrap();
    let start = 100.0 / 255.0;
    let transfer = format!("points = [{{ value = {start}, opacity = 0 }}, {{ value = 1, opacity = 1 }}]");
    let probe = Probe::new(volume, (0.0, 255.0), &transfer, &[start]);
    let bricks = probe.grid().brick_ranges(3);
    assert!(bricks.ranges.iter().filter(|range| range[1] == 100.0).count() > 30);
    assert_eq!(probe.majorants(&bricks).occupied, None);
    probe.holds("materials that start at a voxel's value", 1..=4, true);
}
