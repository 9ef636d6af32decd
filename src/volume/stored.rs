//! Voxel types as files store them, and how each becomes a voxel in memory.

use super::voxels::Voxel;

/// Byte order of multi-byte voxels in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Endian {
    /// Least significant byte first.
    #[default]
    Little,
    /// Most significant byte first.
    Big,
}

impl Endian {
    /// The byte order of this machine.
    pub const NATIVE: Self = if cfg!(target_endian = "little") { Self::Little } else { Self::Big };
}

/// A voxel type that files may store.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StoredType {
    /// Unsigned 8-bit integer, `uint8`.
    U8,
    /// Signed 8-bit integer, `int8`.
    I8,
    /// Unsigned 16-bit integer, `uint16`.
    U16,
    /// Signed 16-bit integer, `int16`.
    I16,
    /// IEEE binary32, `float32`.
    F32,
    /// IEEE binary64, `float64`; held as [`F32`](Self::F32) in memory.
    F64,
}

impl StoredType {
    /// All types, in the order messages list them.
    pub const ALL: [Self; 6] = [Self::U8, Self::I8, Self::U16, Self::I16, Self::F32, Self::F64];

    /// The name in scene files and in the names of headerless raw files, such as `uint8`.
    pub fn name(self) -> &'static str {
        match self {
            Self::U8 => "uint8",
            Self::I8 => "int8",
            Self::U16 => "uint16",
            Self::I16 => "int16",
            Self::F32 => "float32",
            Self::F64 => "float64",
        }
    }

    /// The type of that [`name`](Self::name).
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// Bytes of one voxel in the file.
    pub fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// `uint8, int8, …`: what a message offers instead of an unsupported type.
pub(super) fn supported_types() -> String {
    StoredType::ALL.map(StoredType::name).join(", ")
}

/// A number in a file, and the voxel it becomes.
pub(super) trait Stored: Sized {
    /// The type in memory.
    type Kept: Voxel;
    /// Bytes in the file.
    const BYTES: usize;

    /// The voxel in the first [`BYTES`](Self::BYTES) of `bytes`; `None` when there are fewer.
    fn decode(bytes: &[u8], order: Endian) -> Option<Self::Kept>;

    /// The voxel for a number written as text; `None` when it is not one or is out of range.
    fn parse(token: &str) -> Option<Self::Kept>;
}

macro_rules! stored {
    ($($file:ty => $kept:ty),+) => {$(
        impl Stored for $file {
            type Kept = $kept;
            const BYTES: usize = size_of::<$file>();

            fn decode(bytes: &[u8], order: Endian) -> Option<$kept> {
                let bytes = *bytes.first_chunk()?;
                let number = match order {
                    Endian::Little => <$file>::from_le_bytes(bytes),
                    Endian::Big => <$file>::from_be_bytes(bytes),
                };
                Some(number as $kept)
            }

            fn parse(token: &str) -> Option<$kept> {
                token.parse::<$file>().ok().map(|number| number as $kept)
            }
        }
    )+};
}

stored!(u8 => u8, i8 => i8, u16 => u16, i16 => i16, f32 => f32, f64 => f32);

/// Runs `$body` with `$T` standing for the Rust type that a [`StoredType`] names.
macro_rules! with_stored {
    ($kind:expr, $T:ident => $body:expr) => {
        match $kind {
            $crate::volume::StoredType::U8 => {
                type $T = u8;
                $body
            }
            $crate::volume::StoredType::I8 => {
                type $T = i8;
                $body
            }
            $crate::volume::StoredType::U16 => {
                type $T = u16;
                $body
            }
            $crate::volume::StoredType::I16 => {
                type $T = i16;
                $body
            }
            $crate::volume::StoredType::F32 => {
                type $T = f32;
                $body
            }
            $crate::volume::StoredType::F64 => {
                type $T = f64;
                $body
            }
        }
    };
}
pub(super) use with_stored;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip() {
        for kind in StoredType::ALL {
            assert_eq!(StoredType::from_name(kind.name()), Some(kind));
            assert_eq!(with_stored!(kind, T => T::BYTES), kind.bytes());
        }
        assert_eq!(StoredType::from_name("int32"), None);
    }

    #[test]
    fn both_byte_orders_decode() {
        assert_eq!(i16::decode(&[0xfe, 0xff], Endian::Little), Some(-2));
        assert_eq!(i16::decode(&[0xff, 0xfe], Endian::Big), Some(-2));
        assert_eq!(f64::decode(&1.5f64.to_be_bytes(), Endian::Big), Some(1.5f32));
        assert_eq!(f64::decode(&1e300f64.to_le_bytes(), Endian::Little), Some(f32::INFINITY));
        assert_eq!(f32::decode(&[0; 3], Endian::Little), None);
    }
}
