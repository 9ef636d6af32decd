//! Voxels in memory, in one of five types.

use bytemuck::Pod;
use rayon::prelude::*;
use std::fmt;

/// Elements a thread takes at a time in the reductions: large enough to hide the cost of a task.
const BLOCK: usize = 1 << 16;

/// The type of the voxels of a [`Volume`](super::Volume).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VoxelType {
    /// Unsigned 8-bit integer.
    U8,
    /// Signed 8-bit integer.
    I8,
    /// Unsigned 16-bit integer.
    U16,
    /// Signed 16-bit integer.
    I16,
    /// IEEE binary32.
    F32,
}

impl VoxelType {
    /// The name in scene files and messages, such as `uint8`.
    pub fn name(self) -> &'static str {
        match self {
            Self::U8 => "uint8",
            Self::I8 => "int8",
            Self::U16 => "uint16",
            Self::I16 => "int16",
            Self::F32 => "float32",
        }
    }

    /// Bytes of one voxel.
    pub fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::F32 => 4,
        }
    }
}

/// The voxels of a volume, x fastest.
pub enum Voxels {
    /// Unsigned 8-bit integers.
    U8(Vec<u8>),
    /// Signed 8-bit integers.
    I8(Vec<i8>),
    /// Unsigned 16-bit integers.
    U16(Vec<u16>),
    /// Signed 16-bit integers.
    I16(Vec<i16>),
    /// IEEE binary32, NaN and infinities included.
    F32(Vec<f32>),
}

/// Runs `$body` with `$values` bound to the vector of whichever type `$voxels` holds.
macro_rules! each {
    ($voxels:expr, $values:ident => $body:expr) => {
        match $voxels {
            Voxels::U8($values) => $body,
            Voxels::I8($values) => $body,
            Voxels::U16($values) => $body,
            Voxels::I16($values) => $body,
            Voxels::F32($values) => $body,
        }
    };
}

impl Voxels {
    /// Number of voxels.
    pub fn len(&self) -> usize {
        each!(self, values => values.len())
    }

    /// Whether there is no voxel at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The stored value at an index; `None` beyond the end.
    pub fn get(&self, index: usize) -> Option<f64> {
        each!(self, values => values.get(index).map(|&v| f64::from(v)))
    }

    /// The voxels as bytes in native byte order, ready for a device buffer.
    pub fn as_bytes(&self) -> &[u8] {
        each!(self, values => bytemuck::cast_slice(values))
    }

    /// The type of the voxels.
    pub fn voxel_type(&self) -> VoxelType {
        match self {
            Self::U8(_) => VoxelType::U8,
            Self::I8(_) => VoxelType::I8,
            Self::U16(_) => VoxelType::U16,
            Self::I16(_) => VoxelType::I16,
            Self::F32(_) => VoxelType::F32,
        }
    }

    /// The smallest and largest finite stored value; `None` when there is none.
    pub fn finite_range(&self) -> Option<(f64, f64)> {
        each!(self, values => range(values).map(|(low, high)| (f64::from(low), f64::from(high))))
    }

    /// How many voxels are NaN, and how many infinite.
    pub(super) fn count_non_finite(&self) -> (u64, u64) {
        let Self::F32(values) = self else { return (0, 0) };
        let count = |block: &[f32]| {
            block.iter().fold((0, 0), |(nan, infinite), v| {
                (nan + u64::from(v.is_nan()), infinite + u64::from(v.is_infinite()))
            })
        };
        values.par_chunks(BLOCK).map(count).reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1))
    }
}

impl fmt::Debug for Voxels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "[{} {}]", self.len(), self.voxel_type().name())
    }
}

/// A voxel type in memory.
pub(super) trait Voxel: Pod + Send + Sync + PartialOrd {
    /// No value is below; where a minimum starts is [`CEILING`](Self::CEILING).
    const FLOOR: Self;
    /// No value is above.
    const CEILING: Self;

    /// Whether the value takes part in a range.
    fn finite(self) -> bool;

    /// Voxels of this type.
    fn voxels(values: Vec<Self>) -> Voxels;
}

macro_rules! voxel {
    ($($type:ty, $variant:ident, $floor:expr, $ceiling:expr, $finite:expr;)+) => {$(
        impl Voxel for $type {
            const FLOOR: Self = $floor;
            const CEILING: Self = $ceiling;

            fn finite(self) -> bool {
                $finite(self)
            }

            fn voxels(values: Vec<Self>) -> Voxels {
                Voxels::$variant(values)
            }
        }
    )+};
}

voxel! {
    u8, U8, u8::MIN, u8::MAX, |_| true;
    i8, I8, i8::MIN, i8::MAX, |_| true;
    u16, U16, u16::MIN, u16::MAX, |_| true;
    i16, I16, i16::MIN, i16::MAX, |_| true;
    f32, F32, f32::NEG_INFINITY, f32::INFINITY, f32::is_finite;
}

fn range<T: Voxel>(values: &[T]) -> Option<(T, T)> {
    let empty = (T::CEILING, T::FLOOR);
    let widen = |(low, high): (T, T), value: T| {
        (if value < low { value } else { low }, if value > high { value } else { high })
    };
    let block = |values: &[T]| values.iter().copied().filter(|v| v.finite()).fold(empty, widen);
    let join = |a: (T, T), b: (T, T)| (if b.0 < a.0 { b.0 } else { a.0 }, if b.1 > a.1 { b.1 } else { a.1 });
    let (low, high) = values.par_chunks(BLOCK).map(block).reduce(|| empty, join);
    (low <= high).then_some((low, high))
}
