//! Raw types of `[volume]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::values::{Origin, Spacing};

/// The volume: exactly one of `file` and `field`, and where it lies in the scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VolumeConfig {
    /// Path of the volume's file, relative to the scene file.
    pub file: Option<String>,
    /// A procedural field, sampled at the voxel centres; needs `dims`.
    pub field: Option<FieldConfig>,
    /// Number of voxels [x, y, z]: of a procedural field, or of a headerless raw file.
    #[schemars(inner(range(min = 1, max = 65536)))]
    pub dims: Option<[u32; 3]>,
    /// Voxel type of a headerless raw file.
    #[serde(rename = "type")]
    pub voxel_type: Option<VoxelKind>,
    /// Byte order of a headerless raw file.
    #[schemars(extend("default" = "little"))]
    pub endian: Option<Endian>,
    /// Bytes to skip at the start of a headerless raw file.
    #[schemars(extend("default" = 0))]
    pub offset: Option<u64>,
    /// Size of a voxel in scene units. Default: the file's, else 1.
    pub spacing: Option<Spacing>,
    /// Low corner of the box in scene units, or "centre" for a box centred on 0.
    #[serde(default = "zero_corner")]
    pub origin: Origin,
    /// The data values that map to 0 and 1. Default: 0..255 for uint8, -128..127 for int8, else the finite
    /// minimum and maximum of the data.
    pub window: Option<WindowConfig>,
}

/// The data values that map to 0 and 1, after the file's own slope and intercept.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, deny_unknown_fields)]
pub enum WindowConfig {
    /// By its ends.
    Ends {
        /// The data value that maps to 0.
        lo: f64,
        /// The data value that maps to 1; more than `lo`.
        hi: f64,
    },
    /// By its middle and width, as in radiology.
    Level {
        /// The data value that maps to 0.5.
        centre: f64,
        /// The distance between the data values that map to 0 and 1.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        width: f64,
    },
}

/// Voxel type of a headerless raw file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum VoxelKind {
    /// Signed 8-bit integer.
    Int8,
    /// Unsigned 8-bit integer.
    Uint8,
    /// Signed 16-bit integer.
    Int16,
    /// Unsigned 16-bit integer.
    Uint16,
    /// 32-bit IEEE 754.
    Float32,
    /// 64-bit IEEE 754.
    Float64,
}

/// Byte order of a headerless raw file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Endian {
    /// Least significant byte first.
    #[default]
    Little,
    /// Most significant byte first.
    Big,
}

/// One of the three axes of the volume.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// First axis, the fastest in memory.
    X,
    /// Second axis.
    Y,
    /// Third axis, the slowest in memory.
    #[default]
    Z,
}

/// How the ellipsoids of the Shepp-Logan phantom are rotated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SheppLoganRotation {
    /// About the origin, so that the centres rotate too (Schabel).
    #[default]
    Schabel,
    /// About the axes of each ellipsoid; the centres stay.
    OwnAxis,
}

/// A procedural field on p in [0, 1]³ of the volume's box (some on [-1, 1]³, as their definition has it).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum FieldConfig {
    /// The same value everywhere.
    Constant {
        /// The value.
        #[serde(default = "one")]
        value: f64,
    },
    /// Linear along one axis: from + (to - from) · p.
    Ramp {
        /// The value at the low face of the box.
        #[serde(default)]
        from: f64,
        /// The value at the high face of the box.
        #[serde(default = "one")]
        to: f64,
        /// The axis along which the value changes.
        #[serde(default)]
        axis: Axis,
    },
    /// Signed distance to a sphere, positive inside: radius - |p - centre|, in fractions of the box's largest extent.
    Sphere {
        /// The centre, a point of [0, 1]³.
        #[serde(default = "middle")]
        centre: [f64; 3],
        /// The radius in fractions of the box's largest extent.
        #[serde(default = "three_tenths")]
        #[schemars(range(max = 1e6), extend("exclusiveMinimum" = 0.0))]
        radius: f64,
    },
    /// The test signal of Marschner and Lobb (1994) on [-1, 1]³.
    MarschnerLobb {
        /// Frequency of the radial modulation.
        #[serde(default = "six")]
        #[schemars(range(max = 1e6), extend("exclusiveMinimum" = 0.0))]
        frequency: f64,
        /// Depth of the modulation.
        #[serde(default = "quarter")]
        #[schemars(range(min = 0.0, max = 1e6))]
        alpha: f64,
    },
    /// The Shepp-Logan head phantom in three dimensions on [-1, 1]³.
    SheppLogan {
        /// How the ellipsoids are rotated.
        #[serde(default)]
        rotation: SheppLoganRotation,
    },
    /// Probability density of an electron in hydrogen, scaled to a maximum of 1.
    Hydrogen {
        /// Principal quantum number.
        #[schemars(range(min = 1, max = 10))]
        n: u32,
        /// Orbital quantum number, less than `n`.
        #[schemars(range(min = 0, max = 9))]
        l: u32,
        /// Magnetic quantum number, from -l to l.
        #[serde(default)]
        #[schemars(range(min = -9, max = 9))]
        m: i32,
        /// Half the largest extent of the box in Bohr radii. Default: 2n(n + 2).
        #[schemars(range(max = 1e6), extend("exclusiveMinimum" = 0.0))]
        extent: Option<f64>,
    },
    /// A smooth ball with sinusoidal structure, values 0..1.
    Cloud {},
}

fn zero_corner() -> Origin {
    Origin::Corner([0.0; 3])
}

fn one() -> f64 {
    1.0
}

fn six() -> f64 {
    6.0
}

fn quarter() -> f64 {
    0.25
}

fn three_tenths() -> f64 {
    0.3
}

fn middle() -> [f64; 3] {
    [0.5; 3]
}
