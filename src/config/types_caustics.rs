//! Raw types of `[method]` for caustics.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the light that arrives without a mirror or glass in its way comes into the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum DirectConfig {
    /// By shadow rays, for which mirrors and glass are opaque.
    #[default]
    Rays,
    /// By photons, like the rest.
    Photons,
    /// Not at all: caustics alone.
    None,
}

/// From where photons start, and with how much light each.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EmissionConfig {
    /// How much light a photon carries.
    pub flux: FluxConfig,
    /// The rectangle that photons are sent to, one per cell of a grid on it. Default: for each light what mirrors and
    /// glass cover as seen from it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<TargetConfig>,
}

/// How much light a photon carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FluxConfig {
    /// What the light sends through the photon's cell of the grid.
    #[default]
    Exact,
    /// The same for all photons of a light, as published; right only where all cells get the same.
    Equal,
}

/// The rectangle that photons are sent to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TargetConfig {
    /// Its middle, [x, y, z] in scene units.
    pub centre: [f64; 3],
    /// One edge from end to end, [x, y, z] in scene units; not zero.
    pub edge_u: [f64; 3],
    /// The other edge from end to end, [x, y, z] in scene units; not zero, perpendicular to `edge_u`.
    pub edge_v: [f64; 3],
}

/// How the light of photons is gathered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GatherConfig {
    /// How a photon's share falls with its distance.
    pub kernel: KernelConfig,
    /// Normalised, or as published.
    pub weights: WeightsConfig,
    /// Irradiance that a photon adds at its place (weights "paper" only), W/m².
    #[schemars(range(min = 0.0))]
    pub intensity: Option<f64>,
    /// Whether photons near the edges of rectangles, disks and boxes count for what the kernel loses beyond.
    pub edge_correction: bool,
    /// How the photons near a point are found; the picture is the same but for rounding.
    pub acceleration: AccelerationConfig,
    /// How they are sorted for that.
    pub sort: SortConfig,
    /// How the first and the last photon of each voxel are found.
    pub fill: FillConfig,
}

impl Default for GatherConfig {
    fn default() -> Self {
        Self {
            kernel: KernelConfig::default(),
            weights: WeightsConfig::default(),
            intensity: None,
            edge_correction: true,
            acceleration: AccelerationConfig::default(),
            sort: SortConfig::default(),
            fill: FillConfig::default(),
        }
    }
}

/// How a photon's share falls with its distance t in units of the radius.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum KernelConfig {
    /// Not at all: 1.
    Constant,
    /// Linearly: 1 - t.
    #[default]
    Cone,
    /// 1 - 3t² + 2t³.
    Smoothstep,
}

/// The scale of the weights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum WeightsConfig {
    /// Those whose integral is 1: the sum is an irradiance.
    #[default]
    Normalised,
    /// 1 at the photon, times `intensity`, as published: brightness depends on the radius and the number of photons.
    Paper,
}

/// How the photons near a point are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AccelerationConfig {
    /// In the 27 voxels around it.
    #[default]
    Voxels,
    /// In the nine cells around it on its plane; for receivers that are all plane.
    Planar,
    /// Within the radius along x, by binary search.
    Lexicographic,
    /// Among all.
    BruteForce,
}

/// How photons are sorted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum SortConfig {
    /// Digit by digit, in linear time.
    #[default]
    Radix,
    /// Batcher's bitonic network, as published.
    Bitonic,
}

/// How the first and the last photon of each voxel are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FillConfig {
    /// In one pass over the photons.
    #[default]
    OnePass,
    /// In a pass for the first and one for the last, as published.
    TwoPass,
}
