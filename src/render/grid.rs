//! The voxel grid on the device: window, padding and brick bounds.

use super::local::{LocalFrame, float4};
use crate::device::{Buffer, Device};
use crate::volume::{Volume, Voxels};
use crate::{Result, device_struct};
use bytemuck::Pod;
use rayon::prelude::*;

/// Copies of the border voxels around the grid, per side: one for the trilinear kernel beyond the outermost voxel
/// centres, one more for central differences. Mirrors `GRID_PAD` in `cl/types/volume.cl`.
pub(super) const PAD: usize = 2;

/// Bytes staged at a time while uploading.
const SLAB_BYTES: usize = 8 << 20;

device_struct! {
    "types/volume.cl",
    /// The voxel grid; see `cl/types/volume.cl`.
    pub struct DeviceVolume {
        /// Grid units per local unit.
        pub scale: [f32; 4],
        /// Voxels per axis.
        pub dims: [i32; 4],
        /// Distance in memory between bricks that are neighbours along x, y, z; last: log2 of the cells per edge.
        pub bricks: [i32; 4],
        /// Bricks per axis.
        pub brick_counts: [i32; 4],
        /// Elements per row of the padded buffer.
        pub row: u32,
        /// Elements per slice of the padded buffer.
        pub slice: u32,
        /// Window value per value on the device.
        pub value_scale: f32,
        /// The value on the device whose window value is 0.
        pub value_zero: f32,
        /// Number of bricks: the distance between octants in tables of strides.
        pub octant: i32,
        /// Padding.
        pub pad_0: u32,
        /// Padding.
        pub pad_1: u32,
        /// Padding.
        pub pad_2: u32,
    }
}

/// Window values of floats on the device stay within this: far enough beyond the window to change nothing, and
/// their squares are float32 numbers.
const FARTHEST: f64 = 1e18;

/// Which stored values the window maps to 0 and 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StoredWindow {
    /// The stored value shown as 0.
    pub zero: f64,
    /// The stored value shown as 1; smaller than `zero` when the file's slope is negative.
    pub one: f64,
}

impl StoredWindow {
    /// The window `lo..hi` in data units of `volume`.
    pub fn new(volume: &Volume, (lo, hi): (f64, f64)) -> Self {
        let stored = |data: f64| (data - volume.intercept) / volume.slope;
        Self { zero: stored(lo), one: stored(hi) }
    }

    /// The stored value at a window value.
    pub fn stored(&self, value: f64) -> f64 {
        self.zero + value * (self.one - self.zero)
    }

    /// The window value of a stored value, not clamped.
    pub fn value(&self, stored: f64) -> f64 {
        (stored - self.zero) / (self.one - self.zero)
    }

    /// What a voxel that is not finite counts as: NaN as the window's low end, an infinity as the end on its side.
    fn clean(&self, voxel: f32) -> f32 {
        if voxel.is_finite() {
            voxel
        } else if voxel.is_nan() {
            self.zero as f32
        } else if voxel == f32::INFINITY {
            self.zero.max(self.one) as f32
        } else {
            self.zero.min(self.one) as f32
        }
    }
}

/// Lower and upper bound of the values on the device that the trilinear field takes in each brick, x fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct BrickRanges {
    /// Bricks per axis.
    pub counts: [usize; 3],
    /// log2 of the cells per brick edge.
    pub shift: u32,
    /// (low, high) per brick.
    pub ranges: Vec<[f32; 2]>,
}

impl BrickRanges {
    /// For each of the eight octants of ray directions and each brick, how many bricks a ray can cross before one
    /// whose range is `wanted`: 0 for those themselves, else the edge of the largest cube of unwanted bricks that
    /// starts at this one and extends along the octant, at most `limit` (at least 1).
    ///
    /// Octant bits: 1 where the ray moves towards larger x, 2 for y, 4 for z. Octants follow each other in memory.
    pub fn strides(&self, limit: u8, wanted: impl Fn(&[f32; 2]) -> bool) -> Vec<u8> {
        let free: Vec<bool> = self.ranges.iter().map(|range| !wanted(range)).collect();
        (0..8_usize)
            .into_par_iter()
            .flat_map_iter(|octant| self.octant_strides(octant, limit, &free))
            .collect()
    }

    /// For each brick that is not `free` 0, else the largest k, at most `limit` (at least 1), for which all bricks of
    /// the (2k − 1)³ around it are free; beyond the volume everything is.
    pub fn reaches(&self, limit: u8, free: &[bool]) -> Vec<u8> {
        // That cube is the union of the cubes of edge k along the eight octants.
        (0..8_usize)
            .into_par_iter()
            .map(|octant| self.octant_strides(octant, limit, free))
            .reduce_with(|a, b| a.into_iter().zip(b).map(|(a, b)| a.min(b)).collect())
            .unwrap_or_default()
    }

    /// A cube of edge k + 1 is free when the cubes of edge k that start at its seven other corners' neighbours are:
    /// one sweep against the octant's direction.
    fn octant_strides(&self, octant: usize, limit: u8, free: &[bool]) -> Vec<u8> {
        let [nx, ny, nz] = self.counts;
        let mut strides = vec![0_u8; free.len()];
        // Visits an axis from where its rays end.
        let visit = |k: usize, n: usize, bit: usize| if octant & bit != 0 { n - 1 - k } else { k };
        let ahead = |i: usize, n: usize, bit: usize| {
            if octant & bit != 0 { (i + 1 < n).then_some(i + 1) } else { i.checked_sub(1) }
        };
        for index in 0..free.len() {
            let x = visit(index % nx, nx, 1);
            let y = visit(index / nx % ny, ny, 2);
            let z = visit(index / (nx * ny), nz, 4);
            let here = (z * ny + y) * nx + x;
            if !free[here] {
                continue;
            }
            let mut least = limit - 1;
            for corner in 1..8_usize {
                let next = |i: usize, n: usize, bit: usize| {
                    if corner & bit != 0 { ahead(i, n, bit) } else { Some(i) }
                };
                // Beyond the volume everything is free.
                if let (Some(u), Some(v), Some(w)) = (next(x, nx, 1), next(y, ny, 2), next(z, nz, 4)) {
                    least = least.min(strides[(w * ny + v) * nx + u]);
                }
            }
            strides[here] = least + 1;
        }
        strides
    }
}

/// A volume with its window: everything that does not depend on the method.
pub struct Grid<'a> {
    pub(super) volume: &'a Volume,
    pub(super) window: StoredWindow,
    device_window: StoredWindow,
    pub(super) frame: LocalFrame,
}

/// Runs `$body` with `$voxels` bound to the typed slice of the volume's voxels.
macro_rules! with_voxels {
    ($volume:expr, $voxels:ident => $body:expr) => {
        match &$volume.voxels {
            Voxels::U8(values) => {
                let $voxels: &[u8] = values;
                $body
            }
            Voxels::I8(values) => {
                let $voxels: &[i8] = values;
                $body
            }
            Voxels::U16(values) => {
                let $voxels: &[u16] = values;
                $body
            }
            Voxels::I16(values) => {
                let $voxels: &[i16] = values;
                $body
            }
            Voxels::F32(values) => {
                let $voxels: &[f32] = values;
                $body
            }
        }
    };
}
pub(super) use with_voxels;

/// What the device needs of a voxel type.
pub(super) trait Voxel: Pod + Into<f32> + Sync + Send {
    /// The voxel as uploaded.
    fn on_device(self, window: &StoredWindow) -> Self;
}

macro_rules! integer_voxel {
    ($($type:ty),*) => { $(impl Voxel for $type { fn on_device(self, _: &StoredWindow) -> Self { self } })* };
}
integer_voxel!(u8, i8, u16, i16);

/// Floats become window values: kernels compute in float32, which holds neither a small variation on a large offset
/// nor the squares of very small or large numbers.
impl Voxel for f32 {
    fn on_device(self, window: &StoredWindow) -> Self {
        window.value(f64::from(window.clean(self))).clamp(-FARTHEST, FARTHEST) as f32
    }
}

impl<'a> Grid<'a> {
    /// A grid placed by `frame` and seen through a window in stored values.
    pub fn new(volume: &'a Volume, window: StoredWindow, frame: LocalFrame) -> Self {
        let device_window = match &volume.voxels {
            Voxels::F32(_) => StoredWindow { zero: 0.0, one: 1.0 },
            _ => window,
        };
        Self { volume, window, device_window, frame }
    }

    /// The window in values on the device: stored values, of floats window values.
    pub fn device_window(&self) -> &StoredWindow {
        &self.device_window
    }

    /// The kernel's values per value on the device, when a window value of 1 is `value_units`.
    pub(super) fn value_scale(&self, value_units: f64) -> f32 {
        (value_units / (self.device_window.one - self.device_window.zero)) as f32
    }

    /// The kernel's value of a value on the device, computed as the kernel does.
    pub fn kernel_value(&self, device_value: f32, value_units: f64) -> f64 {
        f64::from((device_value - self.device_window.zero as f32) * self.value_scale(value_units))
    }

    /// The OpenCL C type of a voxel.
    pub fn device_type(&self) -> &'static str {
        match &self.volume.voxels {
            Voxels::U8(_) => "uchar",
            Voxels::I8(_) => "char",
            Voxels::U16(_) => "ushort",
            Voxels::I16(_) => "short",
            Voxels::F32(_) => "float",
        }
    }

    fn padded(&self) -> [usize; 3] {
        self.volume.dims.map(|n| n + 2 * PAD)
    }

    /// Voxels in the padded device buffer, and bytes of each.
    pub fn device_voxels(&self) -> (u64, usize) {
        (self.padded().iter().map(|&n| n as u64).product(), self.volume.voxels.voxel_type().bytes())
    }

    /// The grid's description for kernels that use `bricks` and in which a window value of 1 is `value_units`.
    pub fn describe(&self, bricks: &BrickRanges, value_units: f64) -> DeviceVolume {
        let [nx, ny, _] = self.padded();
        let [x, y, z] = self.volume.dims.map(|n| n as i32);
        let [bx, by, bz] = bricks.counts.map(|n| n as i32);
        DeviceVolume {
            scale: float4(1.0 / self.frame.spacing, 0.0),
            dims: [x, y, z, 0],
            bricks: [1, bx, bx * by, bricks.shift as i32],
            brick_counts: [bx, by, bz, 0],
            octant: bx * by * bz,
            pad_0: 0,
            pad_1: 0,
            pad_2: 0,
            row: nx as u32,
            slice: (nx * ny) as u32,
            value_scale: self.value_scale(value_units),
            value_zero: self.device_window.zero as f32,
        }
    }

    /// Copies the voxels to the device, slab by slab, with the border repeated as kernels expect, voxels that are
    /// not finite replaced, and floats as window values.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device has no room or fails.
    pub fn upload(&self, device: &Device) -> Result<Buffer<u8>> {
        with_voxels!(self.volume, voxels => self.upload_typed(device, voxels))
    }

    fn upload_typed<T: Voxel>(&self, device: &Device, voxels: &[T]) -> Result<Buffer<u8>> {
        let [nx, ny, nz] = self.padded();
        let slice_bytes = nx * ny * size_of::<T>();
        let buffer = Buffer::<u8>::uninitialised(device, slice_bytes * nz)?;
        let slices = (SLAB_BYTES / slice_bytes).clamp(1, nz);
        let mut slab = vec![T::zeroed(); slices * nx * ny];
        for first in (0..nz).step_by(slices) {
            let count = slices.min(nz - first);
            let part = &mut slab[..count * nx * ny];
            part.par_chunks_mut(nx).enumerate().for_each(|(row, target)| {
                self.pad_row(voxels, row % ny, first + row / ny, target);
            });
            buffer.write(device, first * slice_bytes, bytemuck::cast_slice(part))?;
        }
        Ok(buffer)
    }

    /// Fills a row of the padded grid.
    fn pad_row<T: Voxel>(&self, voxels: &[T], y: usize, z: usize, target: &mut [T]) {
        let [nx, ny, nz] = self.volume.dims;
        let inside = |i: usize, n: usize| i.saturating_sub(PAD).min(n - 1);
        let start = (inside(z, nz) * ny + inside(y, ny)) * nx;
        let source = &voxels[start..start + nx];
        for (value, voxel) in target[PAD..PAD + nx].iter_mut().zip(source) {
            *value = voxel.on_device(&self.window);
        }
        let (first, last) = (target[PAD], target[PAD + nx - 1]);
        target[..PAD].fill(first);
        target[PAD + nx..].fill(last);
    }

    /// Bounds of the field in bricks of 2^`shift` cells per edge.
    ///
    /// A brick's cells reach one voxel beyond it on the high side, so neighbours overlap by one voxel: the bounds
    /// hold for every interpolated value, not only at voxels.
    pub fn brick_ranges(&self, shift: u32) -> BrickRanges {
        with_voxels!(self.volume, voxels => self.brick_ranges_typed(voxels, shift))
    }

    fn brick_ranges_typed<T: Voxel>(&self, voxels: &[T], shift: u32) -> BrickRanges {
        let dims = self.volume.dims;
        // Cells are numbered like the padded voxels at their low corner: PAD - 1 ..= PAD + n - 1.
        let counts = dims.map(|n| ((PAD + n - 1) >> shift) + 1);
        let extent = |brick: usize, n: usize| {
            let low = (brick << shift).saturating_sub(PAD).min(n - 1);
            let high = ((brick + 1) << shift).saturating_sub(PAD).min(n - 1);
            low..high + 1
        };
        let ranges = (0..counts.iter().product())
            .into_par_iter()
            .map(|index: usize| {
                let brick =
                    [index % counts[0], index / counts[0] % counts[1], index / (counts[0] * counts[1])];
                let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
                for z in extent(brick[2], dims[2]) {
                    for y in extent(brick[1], dims[1]) {
                        let row = (z * dims[1] + y) * dims[0];
                        for x in extent(brick[0], dims[0]) {
                            let value: f32 = voxels[row + x].on_device(&self.window).into();
                            low = low.min(value);
                            high = high.max(value);
                        }
                    }
                }
                [low, high]
            })
            .collect();
        BrickRanges { counts, shift, ranges }
    }
}
