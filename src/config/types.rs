//! The scene file as it is written: one struct per table, one field per key.
//!
//! These types are the single source of the scene language: `serde` reads them, `schemars` turns them
//! and their comments into the JSON Schema, and the checker takes every rule and suggestion from that
//! schema. What is valid by itself but wrong together is checked in [`crate::scene`].

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use super::types_caustics::{
    AccelerationConfig, DirectConfig, EmissionConfig, FillConfig, FluxConfig, GatherConfig, KernelConfig,
    SortConfig, TargetConfig, WeightsConfig,
};
pub use super::types_medium::{MediumConfig, PhaseConfig};
pub use super::types_method::{
    Compositing, DiffusionSolver, Domain, FluxLimiter, LightModel, MethodConfig, QuadratureConfig,
    SteadyConfig, Transmittance,
};
pub use super::types_surface::{DispersionConfig, MaterialConfig, MetaballConfig, SurfaceConfig};
pub use super::types_transfer::{ColorMap, Outline, PointConfig, ShapeConfig, TransferConfig};
pub use super::types_volume::{
    Axis, Endian, FieldConfig, SheppLoganRotation, VolumeConfig, VoxelKind, WindowConfig,
};
use super::values::{ErrorTarget, Radiance, TimeLimit};

/// A scene of svetlo: what is rendered, from where, by which method, and when to stop. Lengths are in
/// scene units, colours in linear sRGB, paths relative to the scene file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "svetlo scene")]
pub struct SceneConfig {
    /// Seed of the random numbers: the same scene and seed give the same image.
    #[serde(default = "one")]
    pub seed: u64,
    /// Size of the image and how a pixel is sampled.
    #[serde(default)]
    pub image: ImageConfig,
    /// The camera. Image right is forward × up (right-handed).
    pub camera: CameraConfig,
    /// The volume: a file or a procedural field, and where it lies in the scene. Only caustics do without.
    pub volume: Option<VolumeConfig>,
    /// How the opacity of the transfer function becomes extinction, and what of it scatters.
    #[serde(default)]
    pub medium: MediumConfig,
    /// Into which directions the medium scatters (scattering methods only). Default: into all alike.
    #[serde(default)]
    pub phase: PhaseConfig,
    /// The transfer function: data value to colour and opacity. Default: white, opacity = value.
    #[serde(default)]
    pub transfer: TransferConfig,
    /// What rays see that leave the volume. Default: black.
    #[serde(default)]
    pub background: BackgroundConfig,
    /// The lights, one `[[light]]` table each.
    #[serde(default)]
    pub light: Vec<LightConfig>,
    /// What surfaces are made of, one `[[material]]` table each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub material: Vec<MaterialConfig>,
    /// The surfaces, one `[[surface]]` table each (caustics only).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub surface: Vec<SurfaceConfig>,
    /// The rendering method and its parameters.
    pub method: MethodConfig,
    /// How the PNG preview is made, and what else the EXR image, always linear float32, holds.
    #[serde(default)]
    pub film: FilmConfig,
    /// When to stop: whichever limit is reached first. Default: 16 samples.
    #[serde(default)]
    pub stop: StopConfig,
}

/// Size of the image and how a pixel is sampled.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ImageConfig {
    /// Width in pixels; width × height is at most 2^28.
    #[schemars(range(min = 1, max = 65536))]
    pub width: u32,
    /// Height in pixels; width × height is at most 2^28.
    #[schemars(range(min = 1, max = 65536))]
    pub height: u32,
    /// Which points of a pixel the rays go through.
    pub filter: Filter,
}

impl Default for ImageConfig {
    fn default() -> Self {
        Self { width: 512, height: 512, filter: Filter::Box }
    }
}

/// Which points of a pixel the rays go through.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Filter {
    /// The mean over the pixel's area.
    #[default]
    Box,
    /// The ray through the pixel's centre.
    Point,
}

/// The camera: `kind = "perspective"` (default) or `"orthographic"`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
#[schemars(transform = super::schema::default_kind_first)]
pub enum CameraConfig {
    /// A pinhole, or a thin lens when `aperture` is more than 0.
    Perspective {
        /// Where the camera stands, [x, y, z] in scene units.
        position: [f64; 3],
        /// The point in the middle of the image, [x, y, z] in scene units; not `position`.
        target: [f64; 3],
        /// The direction that is up in the image, any length; not parallel to the view.
        #[serde(default = "y_axis")]
        up: [f64; 3],
        /// Vertical field of view in degrees.
        #[serde(default = "forty")]
        #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 180.0))]
        fov: f64,
        /// Radius of the lens in scene units; 0 is a pinhole.
        #[serde(default)]
        #[schemars(range(min = 0.0))]
        aperture: f64,
        /// Distance of the plane in focus along the view axis, scene units. Default: the distance to `target`.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        focus: Option<f64>,
        /// More pictures, from a turn about `target`. Not together with `views`.
        #[serde(skip_serializing_if = "Option::is_none")]
        turntable: Option<TurntableConfig>,
        /// More pictures, one per `[[camera.views]]` table: what each names replaces the camera's.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        views: Vec<ViewConfig>,
    },
    /// Parallel rays.
    Orthographic {
        /// Where the camera stands, [x, y, z] in scene units.
        position: [f64; 3],
        /// The point in the middle of the image, [x, y, z] in scene units; not `position`.
        target: [f64; 3],
        /// The direction that is up in the image, any length; not parallel to the view.
        #[serde(default = "y_axis")]
        up: [f64; 3],
        /// Vertical extent of the image in scene units.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        height: f64,
        /// More pictures, from a turn about `target`. Not together with `views`.
        #[serde(skip_serializing_if = "Option::is_none")]
        turntable: Option<TurntableConfig>,
        /// More pictures, one per `[[camera.views]]` table: what each names replaces the camera's.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        views: Vec<ViewConfig>,
    },
}

/// Pictures from around the target.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TurntableConfig {
    /// How many pictures.
    #[schemars(range(min = 1, max = 100_000))]
    pub frames: u32,
    /// How far the camera turns in all, in degrees, counterclockwise as seen from `axis`. The last picture lies a step
    /// before that, so that a whole turn is a loop.
    #[serde(default = "whole_turn")]
    #[schemars(range(min = -36000.0, max = 36000.0))]
    pub angle: f64,
    /// The direction about which it turns, any length; not zero. Default: the camera's `up`.
    pub axis: Option<[f64; 3]>,
}

/// A picture from elsewhere.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ViewConfig {
    /// Where the camera stands, [x, y, z] in scene units.
    pub position: Option<[f64; 3]>,
    /// The point in the middle of the image, [x, y, z] in scene units; not `position`.
    pub target: Option<[f64; 3]>,
    /// The direction that is up in the image, any length; not parallel to the view.
    pub up: Option<[f64; 3]>,
}

/// What rays see that leave the volume: a constant colour or an environment map. Default: black.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BackgroundConfig {
    /// Constant radiance. Not together with `environment`.
    pub color: Option<Radiance>,
    /// Path of a latitude-longitude map (EXR), relative to the scene file.
    pub environment: Option<String>,
    /// Factor on the environment's radiance.
    #[schemars(range(min = 0.0), extend("default" = 1.0))]
    pub intensity: Option<f64>,
    /// Rotation of the environment about +y in degrees.
    #[schemars(extend("default" = 0.0))]
    pub rotation: Option<f64>,
    /// How the scattering methods find the environment's light.
    #[schemars(extend("default" = "auto"))]
    pub sampling: Option<EnvironmentSampling>,
}

/// How the scattering methods find the environment's light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum EnvironmentSampling {
    /// The renderer's choice.
    #[default]
    Auto,
    /// Only by the rays that leave the volume.
    Escape,
    /// By directions chosen by their brightness, together with the rays that leave the volume.
    Importance,
}

/// A light: `kind = "point"`, `"directional"` or `"rectangle"`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub enum LightConfig {
    /// A point that shines equally in all directions.
    Point {
        /// Where it is, [x, y, z] in scene units.
        position: [f64; 3],
        /// Radiant intensity per channel, W/sr.
        intensity: Radiance,
    },
    /// Parallel light from infinitely far away.
    Directional {
        /// The direction in which the light travels, any length; not zero.
        direction: [f64; 3],
        /// Irradiance on a plane perpendicular to `direction`, W/m².
        irradiance: Radiance,
    },
    /// A rectangle that shines to one side, edge_u × edge_v, and stands in nobody's way (scattering methods only).
    Rectangle {
        /// Its middle, [x, y, z] in scene units.
        centre: [f64; 3],
        /// One edge from end to end, [x, y, z] in scene units; not zero.
        edge_u: [f64; 3],
        /// The other edge from end to end, [x, y, z] in scene units; neither zero nor parallel to `edge_u`.
        edge_v: [f64; 3],
        /// Radiance of its front, the same in every direction, W/(m² sr).
        radiance: Radiance,
    },
}

/// How the PNG preview is made, and what else the EXR image, always linear float32, holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FilmConfig {
    /// How radiance is mapped to 0..1.
    pub tonemap: Tonemap,
    /// Factor on the radiance before tone mapping.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub exposure: f64,
    /// Exponent of a pure power curve. Default: the sRGB curve instead.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub gamma: Option<f64>,
    /// Adds channels that denoisers use: albedo, normal, depth and transmittance (scattering methods only).
    pub auxiliary: bool,
}

impl Default for FilmConfig {
    fn default() -> Self {
        Self { tonemap: Tonemap::Reinhard, exposure: 1.0, gamma: None, auxiliary: false }
    }
}

/// How radiance is mapped to 0..1 for the preview.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Tonemap {
    /// x / (1 + x).
    #[default]
    Reinhard,
    /// A filmic curve with toe and shoulder.
    Filmic,
    /// Clipped at 1.
    Linear,
}

/// When to stop: whichever limit is reached first. Default: 16 samples.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StopConfig {
    /// Samples per pixel. Default: 16 when no other limit is given, else no limit.
    #[schemars(range(min = 1, max = 1_000_000_000), extend("default" = 16))]
    pub samples: Option<u64>,
    /// Rendering time.
    pub time: Option<TimeLimit>,
    /// Estimated relative root-mean-square error.
    pub error: Option<ErrorTarget>,
}

fn one() -> u64 {
    1
}

fn forty() -> f64 {
    40.0
}

fn whole_turn() -> f64 {
    360.0
}

fn y_axis() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}
