//! Voxels in memory or in a mapped file, in one of five types.

use super::mapped::Mapped;
use bytemuck::Pod;
use rayon::prelude::*;
use std::fmt;
use std::ops::Deref;

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

/// A read-only run of voxels: a vector, or a slice of a memory-mapped file. It derefs to `[T]`.
pub struct Store<T>(Backing<T>);

enum Backing<T> {
    Owned(Vec<T>),
    Mapped(Mapped<T>),
}

impl<T> Store<T> {
    pub(super) fn mapped(slice: Mapped<T>) -> Self {
        Self(Backing::Mapped(slice))
    }

    /// Whether the voxels lie in a mapped file. That file must not change while this exists.
    pub fn is_mapped(&self) -> bool {
        matches!(self.0, Backing::Mapped(_))
    }
}

impl<T> From<Vec<T>> for Store<T> {
    fn from(values: Vec<T>) -> Self {
        Self(Backing::Owned(values))
    }
}

impl<T: Pod> Deref for Store<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        match &self.0 {
            Backing::Owned(values) => values,
            Backing::Mapped(slice) => slice,
        }
    }
}

impl<T: Pod> fmt::Debug for Store<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = if self.is_mapped() { "mapped" } else { "owned" };
        write!(f, "[{} {place} elements]", self.len())
    }
}

/// The voxels of a volume, x fastest.
#[derive(Debug)]
pub enum Voxels {
    /// Unsigned 8-bit integers.
    U8(Store<u8>),
    /// Signed 8-bit integers.
    I8(Store<i8>),
    /// Unsigned 16-bit integers.
    U16(Store<u16>),
    /// Signed 16-bit integers.
    I16(Store<i16>),
    /// IEEE binary32, NaN and infinities included.
    F32(Store<f32>),
}

/// Runs `$body` with `$store` bound to the store of whichever type `$voxels` holds.
macro_rules! each {
    ($voxels:expr, $store:ident => $body:expr) => {
        match $voxels {
            Voxels::U8($store) => $body,
            Voxels::I8($store) => $body,
            Voxels::U16($store) => $body,
            Voxels::I16($store) => $body,
            Voxels::F32($store) => $body,
        }
    };
}

impl Voxels {
    /// Number of voxels.
    pub fn len(&self) -> usize {
        each!(self, store => store.len())
    }

    /// Whether there is no voxel at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The stored value at an index; `None` beyond the end.
    pub fn get(&self, index: usize) -> Option<f64> {
        each!(self, store => store.get(index).map(|&v| f64::from(v)))
    }

    /// The voxels as bytes in native byte order, ready for a device buffer.
    pub fn as_bytes(&self) -> &[u8] {
        each!(self, store => bytemuck::cast_slice(store))
    }

    /// Whether the voxels lie in a mapped file. That file must not change while this exists.
    pub fn is_mapped(&self) -> bool {
        each!(self, store => store.is_mapped())
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
        each!(self, store => range(store).map(|(low, high)| (f64::from(low), f64::from(high))))
    }

    /// How many voxels are NaN, and how many infinite.
    pub(super) fn count_non_finite(&self) -> (u64, u64) {
        let Self::F32(store) = self else { return (0, 0) };
        let count = |block: &[f32]| {
            block.iter().fold((0, 0), |(nan, infinite), v| {
                (nan + u64::from(v.is_nan()), infinite + u64::from(v.is_infinite()))
            })
        };
        store.par_chunks(BLOCK).map(count).reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1))
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
    fn voxels(store: Store<Self>) -> Voxels;
}

macro_rules! voxel {
    ($($type:ty, $variant:ident, $floor:expr, $ceiling:expr, $finite:expr;)+) => {$(
        impl Voxel for $type {
            const FLOOR: Self = $floor;
            const CEILING: Self = $ceiling;

            fn finite(self) -> bool {
                $finite(self)
            }

            fn voxels(store: Store<Self>) -> Voxels {
                Voxels::$variant(store)
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
