//! A volume and a medium, their bounds per brick, and the extinction that the device computes at points.

use crate::common::{self, noise, scene};
use bytemuck::Zeroable;
use glam::DVec3;
use svetlo::device::{Buffer, Device, Program, ProgramSpec};
use svetlo::render::grid::{BrickRanges, Grid, StoredWindow};
use svetlo::render::local::LocalFrame;
use svetlo::render::majorants::Majorants;
use svetlo::render::medium::MediumTable;
use svetlo::render::method::DeviceFrame;
use svetlo::volume::Volume;

/// Grid coordinate of voxel 0, `GRID_PAD` in `cl/types/volume.cl`.
const PAD: usize = 2;

/// Extinction by table, and by the straight line that the table may be.
const PROBE: &str = "\
#ifdef TRANSMITTANCE_ONLY
#define medium_sigma(m) (m)
#else
#define medium_sigma(m) ((m).w)
#endif
__kernel void probe(__constant struct Frame *frame, __constant struct Volume *volume, __global const VOXEL *voxels,
    __global const Medium *table, __global const float2 *line, __global const float4 *points,
    __global float2 *sigmas, uint count) {
    size_t i = get_global_id(0);
    if (i >= count) return;
    float value = window_value(volume, sample_raw(volume, voxels, points[i]));
    sigmas[i].x = medium_sigma(medium_at(frame, volume, voxels, table, points[i]));
    sigmas[i].y = line->x + line->y * clamp(value, 0.0f, (float)(frame->table_size - 1));
}
#ifndef TF_2D
// As above at the far corner of each point's cell, by fractions of 1 and one unit in the last place less.
__kernel void probe_ends(__constant struct Frame *frame, __constant struct Volume *volume,
    __global const VOXEL *voxels, __global const Medium *table, __global const float2 *line,
    __global const float4 *points, __global float2 *sigmas, uint count) {
    size_t i = get_global_id(0);
    if (i >= count) return;
    int4 cell = convert_int4(points[i]);
    struct Corners corners = fetch_cell(volume, voxels, cell);
    float4 f = points[i] - convert_float4(cell);
    f.y = 1.0f;
    float value = window_value(volume, trilinear(corners, f));
    sigmas[i].x = medium_sigma(medium_of_value(frame, table, value));
    f.y = 1.0f - 0x1p-24f;
    value = window_value(volume, trilinear(corners, f));
    sigmas[i].y = medium_sigma(medium_of_value(frame, table, value));
}
#endif
";

/// A volume, what its window is, and a medium.
pub struct Probe {
    device: Device,
    /// The voxels.
    pub volume: Volume,
    window: (f64, f64),
    /// The medium.
    pub table: MediumTable,
    /// Window values at which the transfer function has its peaks.
    pub peaks: Vec<f64>,
    /// Whether the device works in lanes of eight samples.
    pub lanes: bool,
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
    pub fn new(volume: Volume, window: (f64, f64), transfer: &str, peaks: &[f64]) -> Self {
        let text = format!(
            "[image]\nwidth = 1\nheight = 1\n[camera]\nposition = [0, 0, -9]\ntarget = [0, 0, 0]\nfov = 30\n\
             [volume]\n[medium]\nsigma_max = 37\n[transfer]\n{transfer}\n[method]\nkind = \"emission-absorption\"\n"
        );
        let scene = scene(&text);
        let unit = volume.spacing.min_element();
        let table = MediumTable::new(&scene.transfer, &scene.medium, window, unit).unwrap();
        Self { device: common::device(), volume, window, table, peaks: peaks.to_vec(), lanes: false }
    }

    /// The field with its window.
    pub fn grid(&self) -> Grid<'_> {
        let frame = LocalFrame::new(DVec3::ZERO, self.volume.spacing, self.volume.dims);
        Grid::new(&self.volume, StoredWindow::new(&self.volume, self.window), frame)
    }

    /// The bounds in bricks.
    pub fn majorants(&self, bricks: &BrickRanges) -> Majorants {
        let grid = self.grid();
        let gradients = (self.table.rows > 1).then(|| grid.brick_gradients(bricks));
        Majorants::new(&grid, bricks, gradients.as_deref(), &self.table)
    }

    /// What the device computes at points in grid coordinates.
    pub fn sigmas(&self, bricks: &BrickRanges, points: &[[f32; 4]], sigma_only: bool) -> Vec<[f32; 2]> {
        self.run("probe", bricks, points, sigma_only)
    }

    /// What one of the kernels computes at points in grid coordinates.
    pub fn run(
        &self,
        kernel: &'static str,
        bricks: &BrickRanges,
        points: &[[f32; 4]],
        sigma_only: bool,
    ) -> Vec<[f32; 2]> {
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
        program.kernel(device, kernel).unwrap().run(device, &arguments, points.len()).unwrap();
        sigmas.read(device).unwrap()
    }

    /// Low and high planes of a brick, where they hold points of the box.
    pub fn extent(&self, bricks: &BrickRanges, index: usize) -> [[f32; 2]; 3] {
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
    pub fn all_points(
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
    pub fn holds(&self, what: &str, shifts: std::ops::RangeInclusive<u32>, sigma_only: bool) -> usize {
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
