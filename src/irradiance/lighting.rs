//! How a light volume comes to be, in steps short enough to be shown and interrupted.

use super::{
    Carrying, Cells, ChannelFacts, Convection, Direct, DirectCost, DirectLight, LightBuffers, LightGrid,
    Limiter, LitMedium, ScatterProgress, ScatterSettings, Spreading, crossing_steps, solve, steady_light,
    steady_memory,
};
use crate::Result;
use crate::device::{Buffer, Device, MemoryPlan};
use crate::diffusion::{Method, Solver};
use crate::render::Plan;
use crate::render::light_volume::LightSetup;
use crate::render::local::LocalFrame;
use crate::scene::{self, DiffusionSolver, FluxLimiter, Light, Phase, ScatteredLight as Scattering, Steady};
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use std::sync::Arc;

/// Steps in time between two looks at the clock.
const STEPS_AT_ONCE: u32 = 8;

/// What the computation of a light volume did.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LightFacts {
    /// Time, with everything.
    pub seconds: f64,
    /// Estimates of each cell's direct light, where it was tracked.
    pub estimates: Option<u32>,
    /// What they cost.
    pub cost: Option<DirectCost>,
    /// Relative RMS error of the direct light: what of its noise is in every picture of it.
    pub relative_error: Option<f64>,
    /// How the diffusion equation of each channel was solved: one where nothing has a colour.
    pub channels: Vec<ChannelFacts>,
    /// Steps in time of the paper's model.
    pub steps: Option<u32>,
    /// Cells of scattered light, of which [`ChannelFacts::floor_cells`] are a part; `None` with steps in time.
    pub cells: Option<usize>,
    /// The least optical thickness of the box's longest edge, of which the thinner parts are taken to be.
    pub floor: Option<f64>,
}

/// A light volume on its way.
pub struct Lighting {
    medium: LitMedium,
    setup: Setup,
    stage: Stage,
    facts: LightFacts,
}

/// What of the plan is needed on the way.
struct Setup {
    lights: Vec<Light>,
    local: LocalFrame,
    settings: scene::LightVolume,
    phase: Phase,
    direct_grid: LightGrid,
    scattered_grid: LightGrid,
    carrying: Carrying,
}

/// Where it stands.
enum Stage {
    /// Nothing is done yet.
    Start,
    /// Steps in time of convected light.
    Convecting { convection: Box<Convection>, spreading: Box<Spreading>, done: u32, count: u32 },
    /// Estimates of unscattered light.
    Tracking { direct: Box<Direct>, target: u32 },
    /// The same, each followed by a step of diffusion.
    Spreading { direct: Box<Direct>, spreading: Box<Spreading>, done: u32, target: u32 },
    /// Unscattered light is known.
    Direct(DirectLight),
    /// All is known, and given away.
    Finished,
}

impl Lighting {
    /// Makes everything ready; `voxels`: the plan's, on the device.
    ///
    /// # Errors
    /// [`crate::Error::Input`] when the scene's lights or steps are not what the method can do,
    /// [`crate::Error::Failed`] when the device lacks memory.
    pub fn new(
        device: &Device,
        plan: &Plan<'_>,
        light: &LightSetup,
        voxels: Arc<Buffer<u8>>,
    ) -> Result<Self> {
        let medium = LitMedium::around(device, plan, &light.transport, voxels)?;
        let carrying = Carrying {
            chromatic: medium.has("CHROMATIC"),
            mean_cosine: light.phase.mean_cosine(),
            directed: light.is_directed(),
        };
        let setup = Setup {
            lights: plan.scene.lights.clone(),
            local: plan.local,
            settings: light.settings,
            phase: light.phase,
            direct_grid: light.direct_grid,
            scattered_grid: light.scattered_grid,
            carrying,
        };
        Ok(Self { medium, setup, stage: Stage::Start, facts: LightFacts::default() })
    }

    /// Share that is done, 0 to 1, roughly.
    pub fn share(&self) -> f32 {
        match &self.stage {
            Stage::Start => 0.0,
            Stage::Convecting { done, count, .. } => *done as f32 / *count as f32,
            Stage::Tracking { direct, target } => 0.9 * direct.passes() as f32 / *target as f32,
            Stage::Spreading { done, target, .. } => *done as f32 / *target as f32,
            Stage::Direct(_) => 0.9,
            Stage::Finished => 1.0,
        }
    }

    /// One step; the light volume and what it took once it is done. `interrupted`: whether to leave off, asked where a step
    /// takes long.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device fails, [`crate::Error::Interrupted`] after an interrupt.
    pub fn step(
        &mut self,
        device: &Device,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Option<(LightBuffers, LightFacts)>> {
        let stage = std::mem::replace(&mut self.stage, Stage::Finished);
        self.stage = match stage {
            Stage::Start => self.start(device)?,
            Stage::Convecting { mut convection, mut spreading, mut done, count } => {
                let steps = STEPS_AT_ONCE.min(count - done);
                for _ in 0..steps {
                    convection.advance(device, 1)?;
                    spreading.advance(device, convection.direct(device)?, 1)?;
                }
                device.finish()?;
                done += steps;
                if done == count {
                    self.facts.steps = Some(count);
                    return self.finish(device, convection.into_direct(), spreading.into_fluence(), None);
                }
                Stage::Convecting { convection, spreading, done, count }
            }
            Stage::Tracking { mut direct, target } => {
                direct.step(device, &self.medium, target)?;
                if direct.is_done(target) {
                    self.note_direct(device, &direct)?;
                    Stage::Direct(direct.means(device)?)
                } else {
                    Stage::Tracking { direct, target }
                }
            }
            Stage::Spreading { mut direct, mut spreading, mut done, target } => {
                direct.step(device, &self.medium, done + 1)?;
                if direct.is_done(done + 1) {
                    let light = direct.means(device)?;
                    spreading.advance(device, &light, 1)?;
                    done += 1;
                    if done == target {
                        self.note_direct(device, &direct)?;
                        self.facts.steps = Some(target);
                        return self.finish(device, light, spreading.into_fluence(), None);
                    }
                }
                Stage::Spreading { direct, spreading, done, target }
            }
            Stage::Direct(direct) => return self.scatter(device, direct, interrupted),
            Stage::Finished => Stage::Finished,
        };
        Ok(None)
    }

    fn start(&mut self, device: &Device) -> Result<Stage> {
        let Setup { lights, local, settings, phase, direct_grid: grid, carrying, .. } = &self.setup;
        let cells = Cells::new(device, &self.medium, grid)?;
        match (settings.direct, settings.scattered) {
            (scene::DirectLight::Convection, Scattering::Steps { count, courant, spreading }) => {
                let convection = Convection::new(device, grid, &cells, lights, local, *carrying, courant)?;
                let spreading = Spreading::new(device, grid, &cells, spreading)?;
                let count = count.unwrap_or_else(|| crossing_steps(grid, courant));
                Ok(Stage::Convecting {
                    convection: convection.into(),
                    spreading: spreading.into(),
                    done: 0,
                    count,
                })
            }
            (scene::DirectLight::Convection, Scattering::Steady(_)) => {
                let light = steady_light(device, grid, &cells, lights, local, *carrying)?;
                device.finish()?;
                Ok(Stage::Direct(light.direct))
            }
            (scene::DirectLight::Tracking { estimates: target }, scattered) => {
                let direct = Box::new(Direct::new(device, &self.medium, grid, phase)?);
                Ok(match scattered {
                    Scattering::Steady(_) => Stage::Tracking { direct, target },
                    Scattering::Steps { spreading, .. } => {
                        let spreading = Spreading::new(device, grid, &cells, spreading)?;
                        Stage::Spreading { direct, spreading: spreading.into(), done: 0, target }
                    }
                })
            }
        }
    }

    /// Solves the diffusion equation.
    fn scatter(
        &mut self,
        device: &Device,
        direct: DirectLight,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Option<(LightBuffers, LightFacts)>> {
        let Setup { settings, scattered_grid, direct_grid, .. } = &self.setup;
        let Scattering::Steady(steady) = settings.scattered else { return Ok(None) };
        self.facts.relative_error = Some(direct.relative_error(device)?);
        let mut watch = |_: &ScatterProgress| match interrupted() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let scattered = solve(
            device,
            &self.medium,
            scattered_grid,
            direct_grid,
            &direct,
            &scatter_settings(steady),
            &mut watch,
        )?;
        self.facts.channels = scattered.channels;
        self.facts.cells = Some(scattered_grid.cells());
        self.facts.floor = Some(steady.floor);
        self.finish(device, direct, scattered.fluence, scattered.drift)
    }

    fn note_direct(&mut self, device: &Device, direct: &Direct) -> Result<()> {
        self.facts.estimates = Some(direct.passes());
        self.facts.cost = Some(direct.cost(device)?);
        Ok(())
    }

    fn finish(
        &mut self,
        device: &Device,
        direct: DirectLight,
        scattered: Buffer<[f32; 4]>,
        drift: Option<Buffer<[f32; 4]>>,
    ) -> Result<Option<(LightBuffers, LightFacts)>> {
        let buffers = LightBuffers::new(device, self.setup.direct_grid, direct, scattered, drift)?;
        Ok(Some((buffers, self.facts.clone())))
    }
}

/// The scene's words as the solver's.
fn scatter_settings(steady: Steady) -> ScatterSettings {
    let method = match steady.solver {
        DiffusionSolver::Multigrid => Method::Multigrid,
        DiffusionSolver::ConjugateGradients => Method::ConjugateGradients,
        DiffusionSolver::OverRelaxation => Method::OverRelaxation { factor: None },
        DiffusionSolver::Explicit => Method::Explicit,
    };
    let limiter = match steady.limiter {
        FluxLimiter::None => Limiter::None,
        FluxLimiter::Sum => Limiter::Sum,
        FluxLimiter::Max => Limiter::Max,
        FluxLimiter::Kershaw => Limiter::Kershaw,
        FluxLimiter::LevermorePomraning => Limiter::LevermorePomraning,
        FluxLimiter::Rational => Limiter::Rational,
    };
    ScatterSettings {
        limiter,
        nonlinear: steady.limiter_tolerance,
        tolerance: steady.tolerance,
        floor: steady.floor,
        ..ScatterSettings::new(method)
    }
}

/// What a light volume takes on the device, at most, beside what a render takes anyway.
pub fn memory(light: &LightSetup, lights: usize) -> MemoryPlan {
    memory_of(&light.settings, &light.phase, [&light.direct_grid, &light.scattered_grid], lights)
}

/// The same on grids of direct and of scattered light.
pub fn memory_of(
    settings: &scene::LightVolume,
    phase: &Phase,
    [direct, scattered]: [&LightGrid; 2],
    lights: usize,
) -> MemoryPlan {
    let directed = !phase.is_isotropic();
    let (cells, fine) = (scattered.cells() as u64, direct.cells() as u64);
    let float4 = size_of::<[f32; 4]>();
    let carrying = Carrying { chromatic: true, mean_cosine: phase.mean_cosine(), directed };
    let mut plan = match (settings.direct, settings.scattered) {
        (scene::DirectLight::Tracking { .. }, _) => Direct::memory(direct, phase),
        (_, Scattering::Steady(_)) => steady_memory(direct, carrying),
        (_, Scattering::Steps { .. }) => Convection::memory(direct, lights, carrying),
    };
    for name in ["scattering", "absorption", "emission"] {
        plan.add(&format!("{name} per cell"), cells.max(fine), float4);
    }
    match settings.scattered {
        Scattering::Steps { .. } => plan.items.extend(Spreading::memory(direct).items),
        Scattering::Steady(_) => {
            plan.items.extend(Solver::memory(scattered.dims, scattered.cell).items);
            for name in ["source", "its places", "flux", "flux of a channel", "fluence with a border"] {
                plan.add(&format!("diffuse light, {name}"), cells, float4);
            }
            for name in ["equations", "fluences"] {
                plan.add(&format!("diffuse light, {name}"), 4 * cells, size_of::<f32>());
            }
            plan.add("scattered light", fine, float4);
            if directed {
                plan.add("direction of scattered light", fine, float4);
            }
        }
    }
    plan
}
