//! Raw types of `[transfer]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::types_method::Domain;
use super::values::{Albedo, Radiance};

/// The transfer function: `kind = "1d"` (default) over the value, or `"2d"` over value and gradient.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", deny_unknown_fields)]
#[schemars(transform = super::schema::default_kind_first)]
pub enum TransferConfig {
    /// Colour and opacity by value: points joined by straight lines, constant beyond the ends.
    #[serde(rename = "1d")]
    OneD {
        /// Whether the points' values are in 0..1 of the volume's window or in data units.
        #[serde(default)]
        domain: Domain,
        /// Colours of the points that have none of their own. Default: white.
        colormap: Option<ColorMap>,
        /// The points, by strictly increasing value. Default: opacity = value.
        #[schemars(length(min = 1))]
        points: Option<Vec<PointConfig>>,
        /// Number of entries of the lookup table.
        #[serde(default = "default_entries")]
        #[schemars(range(min = 2, max = 65536))]
        resolution: u32,
    },
    /// Colour and opacity by value and gradient magnitude: a picture or a list of shapes.
    #[serde(rename = "2d")]
    TwoD {
        /// Path of a picture (PNG or EXR), relative to the scene file: value from left to right, gradient from
        /// bottom to top. Exactly one of `table` and `shapes`.
        table: Option<String>,
        /// Shapes painted over each other in this order. Exactly one of `table` and `shapes`.
        #[schemars(length(min = 1))]
        shapes: Option<Vec<ShapeConfig>>,
        /// Entries [value, gradient] of the table that the shapes are painted into.
        #[schemars(inner(range(min = 2, max = 4096)), extend("default" = [256, 256]))]
        resolution: Option<[u32; 2]>,
        /// The gradient that maps to the top of the table: change of the windowed value (0..1) per smallest spacing.
        #[serde(default = "one")]
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        gradient_max: f64,
    },
}

impl Default for TransferConfig {
    fn default() -> Self {
        Self::OneD { domain: Domain::Normalized, colormap: None, points: None, resolution: default_entries() }
    }
}

/// One point of a one-dimensional transfer function.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointConfig {
    /// The value, in the unit of `domain`.
    pub value: f64,
    /// The opacity, 0..1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub opacity: f64,
    /// The colour. Default: from `colormap`, else white.
    pub color: Option<Albedo>,
    /// Radiance of the medium's glow: it emits this times its absorption (scattering methods only).
    #[serde(default = "dark")]
    pub emission: Radiance,
}

/// A shape painted into a two-dimensional transfer function; x is the value, y the gradient, both 0..1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShapeConfig {
    /// The outline.
    pub shape: Outline,
    /// The middle of the box around the shape, [value, gradient].
    pub centre: [f64; 2],
    /// Full extent of that box, [value, gradient], each more than 0.
    pub size: [f64; 2],
    /// The colour.
    #[serde(default = "white")]
    pub color: Albedo,
    /// The opacity in the middle, 0..1.
    #[serde(default = "one")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub opacity: f64,
    /// The part of the way from the edge to the centroid over which the opacity rises smoothly: 0 is a hard edge.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub softness: f64,
    /// Radiance of the medium's glow: it emits this times its absorption (scattering methods only).
    #[serde(default = "dark")]
    pub emission: Radiance,
}

/// The outline of a shape in a two-dimensional transfer function.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Outline {
    /// An axis-parallel rectangle.
    Rectangle,
    /// An axis-parallel ellipse.
    Ellipse,
    /// A triangle with its apex at the bottom centre of its box and its base at the top.
    Triangle,
}

/// A named colour map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ColorMap {
    /// Black to white, linear in radiance.
    Grey,
    /// Black, red, yellow, white.
    Hot,
    /// matplotlib's viridis.
    Viridis,
    /// matplotlib's inferno.
    Inferno,
    /// matplotlib's magma.
    Magma,
    /// matplotlib's plasma.
    Plasma,
    /// Google's Turbo rainbow.
    Turbo,
    /// Moreland's diverging blue to red.
    Coolwarm,
    /// Grey with a tinge of blue.
    Bone,
    /// Air black, soft tissue red to pink, bone ivory, for windows from air to bone.
    Ct,
}

/// Four intervals per value of 8-bit data, so that those and multiples of 1/20 fall on entries.
fn default_entries() -> u32 {
    1021
}

fn one() -> f64 {
    1.0
}

fn white() -> Albedo {
    crate::config::values::Color([1.0; 3])
}

fn dark() -> Radiance {
    crate::config::values::Color([0.0; 3])
}
