//! Raw types of `[method]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::types_caustics::{DirectConfig, EmissionConfig, GatherConfig};
use super::types_transfer::ColorMap;
use super::values::Albedo;

/// The rendering method and its parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum MethodConfig {
    /// The volume glows and absorbs (Max 1995).
    EmissionAbsorption {
        /// Radiance that the transfer function's colours are scaled by.
        #[serde(default = "one")]
        #[schemars(range(min = 0.0))]
        radiance: f64,
        /// How the integral along a ray is computed.
        #[serde(default)]
        quadrature: QuadratureConfig,
        /// Step in units of the smallest spacing (quadrature "step" only).
        #[schemars(range(max = 64.0), extend("exclusiveMinimum" = 0.0, "default" = 0.5))]
        step: Option<f64>,
        /// A random phase of the steps per ray (quadrature "step" only).
        #[schemars(extend("default" = true))]
        jitter: Option<bool>,
        /// How extinction and step become opacity (quadrature "step" only).
        #[schemars(extend("default" = "exponential"))]
        compositing: Option<Compositing>,
        /// A ray stops when less than this part of the light gets through; 0 is never.
        #[serde(default = "default_termination")]
        #[schemars(range(min = 0.0), extend("exclusiveMaximum" = 1.0))]
        termination: f64,
    },
    /// Maximum intensity projection: the largest value along each ray.
    Mip {
        /// Colour of the value 1. Not together with `colormap`. Default: white.
        color: Option<Albedo>,
        /// Colours of the values 0..1.
        colormap: Option<ColorMap>,
    },
    /// The first surface of constant value along each ray, shaded locally.
    Isosurface {
        /// The value of the surface, in the unit of `domain`.
        value: f64,
        /// Whether `value` is in 0..1 of the volume's window or in data units.
        #[serde(default)]
        domain: Domain,
        /// Colour of the surface.
        #[serde(default = "light_grey")]
        color: Albedo,
        /// Factor of the constant term.
        #[serde(default = "tenth")]
        #[schemars(range(min = 0.0))]
        ambient: f64,
        /// Factor of the Lambertian term.
        #[serde(default = "nine_tenths")]
        #[schemars(range(min = 0.0))]
        diffuse: f64,
        /// Factor of the Blinn-Phong term.
        #[serde(default = "fifth")]
        #[schemars(range(min = 0.0))]
        specular: f64,
        /// Exponent of the Blinn-Phong term.
        #[serde(default = "thirty_two")]
        #[schemars(range(min = 0.0))]
        shininess: f64,
    },
    /// Light that is scattered at most once in the volume.
    SingleScattering {
        /// How the transmittance between two points is estimated.
        #[serde(default)]
        transmittance: Transmittance,
        /// Factor on the bounds of the extinction: less noise of transmittance "ratio" for more look-ups.
        #[serde(default = "one")]
        #[schemars(range(min = 1.0, max = 64.0))]
        majorant_scale: f64,
        /// Paths per sample, stratified together. Default: chosen by the renderer.
        #[schemars(range(min = 1, max = 64))]
        paths: Option<u32>,
    },
    /// Light that is scattered any number of times in the volume.
    MultipleScattering {
        /// Most times that a path scatters; what longer paths would carry is reported. Default: no limit.
        #[schemars(range(min = 1, max = 1_000_000))]
        max_order: Option<u32>,
        /// How the transmittance between two points is estimated.
        #[serde(default)]
        transmittance: Transmittance,
        /// Factor on the bounds of the extinction: less noise of transmittance "ratio" for more look-ups.
        #[serde(default = "one")]
        #[schemars(range(min = 1.0, max = 64.0))]
        majorant_scale: f64,
        /// Paths per sample, stratified together. Default: chosen by the renderer.
        #[schemars(range(min = 1, max = 64))]
        paths: Option<u32>,
    },
    /// Light computed in the volume, then projected: direct light carried upwind from cell to cell, scattered light by
    /// diffusion (Zhang & Ma 2013). Directional and point lights only.
    ConvectionDiffusion {
        /// Steps in time as published, or the state without time.
        #[serde(default = "published")]
        model: LightModel,
        /// Steps in time (model "paper" only). Default: as many as light takes to cross the volume.
        #[schemars(range(min = 1, max = 1_000_000))]
        iterations: Option<u32>,
        /// How far light moves in a step, in cells (model "paper" only); what is stable depends on the lights.
        #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0.0, "default" = 0.5))]
        courant: Option<f64>,
        /// Share of its light that a cell of the largest extinction gives to each neighbour in a step (model "paper"
        /// only); at most 1/6 is stable on cubic cells.
        #[schemars(range(min = 0.0, max = 0.5), extend("default" = 0.1))]
        spreading: Option<f64>,
        /// Voxels per cell of the light volume along each axis.
        #[serde(default = "one_voxel")]
        #[schemars(range(min = 1, max = 8))]
        coarsening: u32,
        /// The same for direct light (model "steady" only), at most `coarsening`.
        #[schemars(range(min = 1, max = 8), extend("default" = 1))]
        direct_coarsening: Option<u32>,
        /// How the diffusion equation is solved (model "steady" only).
        steady: Option<SteadyConfig>,
        /// A view ray stops when less than this part of the light gets through; 0 is never.
        #[serde(default = "default_termination")]
        #[schemars(range(min = 0.0), extend("exclusiveMaximum" = 1.0))]
        termination: f64,
    },
    /// Light computed in the volume, then projected: direct light by null-collision tracking from every cell towards
    /// the lights, scattered light by diffusion (Lesar, Bohak and Marolt).
    HybridDiffusion {
        /// The diffusion equation without time, or steps in time as published.
        #[serde(default)]
        model: LightModel,
        /// Estimates of each cell's direct light; with model "paper" each is followed by a step of diffusion.
        #[serde(default = "thirty_two_estimates")]
        #[schemars(range(min = 1, max = 1_000_000))]
        iterations: u32,
        /// Share of its light that a cell of the largest extinction gives to each neighbour in a step (model "paper"
        /// only); at most 1/6 is stable on cubic cells.
        #[schemars(range(min = 0.0, max = 0.5), extend("default" = 0.1))]
        spreading: Option<f64>,
        /// Voxels per cell of the light volume along each axis.
        #[serde(default = "one_voxel")]
        #[schemars(range(min = 1, max = 8))]
        coarsening: u32,
        /// The same for direct light (model "steady" only), at most `coarsening`.
        #[schemars(range(min = 1, max = 8), extend("default" = 1))]
        direct_coarsening: Option<u32>,
        /// How the diffusion equation is solved (model "steady" only).
        steady: Option<SteadyConfig>,
        /// A view ray stops when less than this part of the light gets through; 0 is never.
        #[serde(default = "default_termination")]
        #[schemars(range(min = 0.0), extend("exclusiveMaximum" = 1.0))]
        termination: f64,
    },
    /// Caustics of mirrors and glass on diffuse surfaces: photons from the lights, gathered where camera rays end
    /// (Bogolepov, Sopin and Turlapov). Each sample is a pass of new photons, gathered from less and less far.
    Caustics {
        /// Photons per pass, of all lights together.
        #[serde(default = "quarter_million")]
        #[schemars(range(max = 2_147_483_647))]
        photons: u32,
        /// Radius of gathering in the first pass, scene units. Default: a hundredth of what mirrors and glass extend.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        radius: Option<f64>,
        /// How the radius shrinks: its square times (i + alpha) / (i + 1) after pass i (Knaus and Zwicker 2011); 1 keeps it.
        #[serde(default = "two_thirds")]
        #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0.0))]
        alpha: f64,
        /// Most times that light is reflected by mirrors or glass, or refracted, by photons and by camera rays.
        #[serde(default = "sixteen")]
        #[schemars(range(min = 1, max = 1000))]
        depth: u32,
        /// Most times that photons are reflected by diffuse surfaces; 0: as published, they end at the first. Default: 4, or
        /// 0 with direct "none" or weights "paper". What diffuse surfaces send each other is gathered as caustics are, within
        /// a radius of its own.
        #[schemars(range(max = 1000))]
        bounces: Option<u32>,
        /// Radius of gathering in the first pass of what diffuse surfaces send each other, scene units; it shrinks as the
        /// other one, and is less on curved surfaces. Default: 16 times `radius`, but from 0.08 to 0.2 of
        /// the scene's size: of what has bounds, or of the way to the camera's target, whichever is less.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        bounce_radius: Option<f64>,
        /// How the light that arrives without a mirror or glass in its way comes into the picture.
        #[serde(default)]
        direct: DirectConfig,
        /// From where photons start, and with how much light each.
        #[serde(default)]
        emission: EmissionConfig,
        /// How their light is gathered.
        #[serde(default)]
        gather: GatherConfig,
    },
}

/// How light spreads in the volume.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum LightModel {
    /// Without time: direct light as it arrives, scattered light by the steady diffusion equation.
    #[default]
    Steady,
    /// Steps in time, whose number is part of the picture, as published.
    Paper,
}

/// How the steady diffusion equation is solved.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SteadyConfig {
    /// The method.
    pub solver: DiffusionSolver,
    /// Largest residual relative to the source at which to stop.
    #[schemars(range(min = 1e-12, max = 0.1))]
    pub tolerance: f64,
    /// How fluxes larger than fluences are avoided where the medium is thin.
    pub limiter: FluxLimiter,
    /// Largest residual, with the diffusivity that the limiter asks for, at which its updates stop.
    #[schemars(range(min = 1e-5, max = 1.0))]
    pub limiter_tolerance: f64,
    /// Least optical thickness (reduced) of the box's longest edge: where the medium is thinner than that, light
    /// diffuses as if it were not.
    #[schemars(range(min = 1e-6, max = 1.0))]
    pub floor: f64,
}

impl Default for SteadyConfig {
    fn default() -> Self {
        Self {
            solver: DiffusionSolver::Multigrid,
            tolerance: 1e-5,
            limiter: FluxLimiter::LevermorePomraning,
            limiter_tolerance: 0.05,
            floor: 0.01,
        }
    }
}

/// A solver of the diffusion equation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DiffusionSolver {
    /// Conjugate gradients, preconditioned by a multigrid cycle.
    Multigrid,
    /// Conjugate gradients, preconditioned by the diagonal.
    ConjugateGradients,
    /// Red-black successive over-relaxation.
    OverRelaxation,
    /// Explicit steps in time.
    Explicit,
}

/// How the diffusivity falls where fluences change within a mean free path (Levermore & Pomraning 1981).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FluxLimiter {
    /// Not at all: classical diffusion.
    None,
    /// 1 / (3 + R).
    Sum,
    /// 1 / max(3, R).
    Max,
    /// 2 / (3 + sqrt(9 + 4 R²)) (Kershaw).
    Kershaw,
    /// (coth R - 1/R) / R.
    LevermorePomraning,
    /// (2 + R) / (6 + 3 R + R²).
    Rational,
}

/// How the scattering methods estimate the transmittance between two points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Transmittance {
    /// Chosen by the renderer.
    #[default]
    Auto,
    /// Delta tracking: 0 or 1 (Woodcock and others 1965).
    Analog,
    /// Ratio tracking: the product of the ratios of null collisions (Novák and others 2014).
    Ratio,
    /// Residual ratio tracking: a control extinction exactly, the rest by ratios (Novák and others 2014).
    ResidualRatio,
    /// Unbiased ray marching: a random power series of evenly spaced estimates of the optical depth (Kettunen and others
    /// 2021).
    RayMarching,
}

/// The unit of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Domain {
    /// 0..1 of the volume's window.
    #[default]
    Normalized,
    /// Data units, for example Hounsfield units.
    Data,
}

/// How the emission-absorption integral along a ray is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum QuadratureConfig {
    /// Cell by cell of the trilinear field, cut at the kinks of the transfer function: no step to choose.
    #[default]
    Cell,
    /// Midpoint rule at a fixed step.
    Step,
}

/// How extinction and step become the opacity of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Compositing {
    /// 1 - exp(-extinction · step).
    #[default]
    Exponential,
    /// min(extinction · step, 1), for comparison with renderers that do so.
    Linear,
}

fn one() -> f64 {
    1.0
}

fn quarter_million() -> u32 {
    1 << 18
}

fn two_thirds() -> f64 {
    2.0 / 3.0
}

fn sixteen() -> u32 {
    16
}

fn one_voxel() -> u32 {
    1
}

fn thirty_two_estimates() -> u32 {
    32
}

fn published() -> LightModel {
    LightModel::Paper
}

fn tenth() -> f64 {
    0.1
}

fn fifth() -> f64 {
    0.2
}

fn nine_tenths() -> f64 {
    0.9
}

fn thirty_two() -> f64 {
    32.0
}

fn default_termination() -> f64 {
    1.0 / 1024.0
}

fn light_grey() -> Albedo {
    crate::config::values::Color([0.8; 3])
}
