//! The methods that compute light in the volume and project it.

use super::context::Context;
use crate::config::types::{DiffusionSolver, FluxLimiter, LightModel, MethodConfig, SteadyConfig};

/// Light in the cells of a grid over the volume, and its projection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightVolume {
    /// How unscattered light is found.
    pub direct: DirectLight,
    /// How scattered light is found.
    pub scattered: ScatteredLight,
    /// Voxels per cell along each axis, 1..=8.
    pub coarsening: usize,
    /// The same for direct light, 1..=`coarsening`.
    pub direct_coarsening: usize,
    /// A view ray stops when its transmittance is below this, 0..1 exclusive of 1; 0 is never.
    pub termination: f64,
}

/// How unscattered light is found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DirectLight {
    /// By null-collision tracking towards the lights, this many times per cell, ≥ 1.
    Tracking {
        /// Estimates per cell.
        estimates: u32,
    },
    /// Carried upwind from cell to cell, per light.
    Convection,
}

/// How scattered light is found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ScatteredLight {
    /// By the steady diffusion equation.
    Steady(Steady),
    /// By steps in time together with direct light.
    Steps {
        /// How many; as many as light takes to cross the volume if `None`.
        count: Option<u32>,
        /// How far convected light moves in a step, in cells, 0 < courant ≤ 1.
        courant: f64,
        /// Share that a cell of the largest extinction gives to each neighbour, 0..=0.5.
        spreading: f64,
    },
}

/// How the steady diffusion equation is solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steady {
    /// The method.
    pub solver: DiffusionSolver,
    /// Largest residual relative to the source at which to stop.
    pub tolerance: f64,
    /// How the flux is limited.
    pub limiter: FluxLimiter,
    /// Residual at which the limiter's updates stop.
    pub limiter_tolerance: f64,
    /// Least optical thickness (reduced) of the box's longest edge.
    pub floor: f64,
}

impl Steady {
    fn new(config: Option<&SteadyConfig>) -> Self {
        let SteadyConfig { solver, tolerance, limiter, limiter_tolerance, floor } =
            config.cloned().unwrap_or_default();
        Self { solver, tolerance, limiter, limiter_tolerance, floor }
    }
}

pub(super) fn light_volume(config: &MethodConfig, cx: &mut Context<'_>) -> LightVolume {
    match *config {
        MethodConfig::ConvectionDiffusion {
            model,
            iterations,
            courant,
            spreading,
            coarsening,
            direct_coarsening,
            ref steady,
            termination,
        } => {
            without_use(model, &["iterations", "courant", "spreading"], cx);
            let scattered = match model {
                LightModel::Steady => ScatteredLight::Steady(Steady::new(steady.as_ref())),
                LightModel::Paper => ScatteredLight::Steps {
                    count: iterations,
                    courant: courant.unwrap_or(0.5),
                    spreading: spreading.unwrap_or(0.1),
                },
            };
            let direct_coarsening = fine(model, coarsening, direct_coarsening, cx);
            let (direct, coarsening) = (DirectLight::Convection, coarsening as usize);
            LightVolume { direct, scattered, coarsening, direct_coarsening, termination }
        }
        MethodConfig::HybridDiffusion {
            model,
            iterations,
            spreading,
            coarsening,
            direct_coarsening,
            ref steady,
            termination,
        } => {
            without_use(model, &["spreading"], cx);
            let scattered = match model {
                LightModel::Steady => ScatteredLight::Steady(Steady::new(steady.as_ref())),
                LightModel::Paper => ScatteredLight::Steps {
                    count: Some(iterations),
                    courant: 0.5,
                    spreading: spreading.unwrap_or(0.1),
                },
            };
            let direct_coarsening = fine(model, coarsening, direct_coarsening, cx);
            let direct = DirectLight::Tracking { estimates: iterations };
            LightVolume { direct, scattered, coarsening: coarsening as usize, direct_coarsening, termination }
        }
        _ => unreachable!("only methods of light volumes come here"),
    }
}

/// Reports keys that the model does not read; `steps`: those of steps in time.
fn without_use(model: LightModel, steps: &[&str], cx: &mut Context<'_>) {
    match model {
        LightModel::Steady => {
            for key in steps {
                let path = format!("method.{key}");
                cx.useless(&path, "needs `method.model = \"paper\"`", "the steady model has no steps");
            }
        }
        LightModel::Paper => {
            for path in ["method.steady", "method.direct_coarsening"] {
                cx.useless(path, "needs `method.model = \"steady\"`", "steps in time do not read it");
            }
        }
    }
}

/// Voxels per cell of direct light.
fn fine(model: LightModel, coarsening: u32, direct: Option<u32>, cx: &mut Context<'_>) -> usize {
    if model == LightModel::Paper {
        return coarsening as usize;
    }
    let direct = direct.unwrap_or(1);
    if direct > coarsening {
        cx.wrong(
            "method.direct_coarsening",
            "`method.direct_coarsening` must not exceed `method.coarsening`",
            format!("scattered light has {coarsening} voxels per cell"),
        );
    }
    direct as usize
}
