//! Scattered light: from the medium and its direct light to the fluence of light that was scattered, by the steady
//! diffusion equation. The kernels are `cl/irradiance/source.cl` and `cl/irradiance/scattered.cl`.
//!
//! Each channel of colour is an equation of its own: absorption and scattering differ, and with them how deep light
//! gets (Stam 1995; Jensen et al. 2001). Anisotropic scattering is reduced to isotropic by similarity: σ_s (1 − g), and
//! direct light that is attenuated by as much less.

use super::channel::{Channel, ChannelFields, Stage};
use super::kernels::ScatterKernels;
use super::limiter::LimiterKernels;
use super::{Cells, DirectLight, LightGrid, Limiter, LitMedium};
use crate::device::{Buffer, Device, MemoryPlan};
use crate::diffusion::{Boundary, Method, Solver};
use crate::render::scattering::Scattering;
use crate::{Error, Result};
use bytemuck::Zeroable;
use serde::{Deserialize, Deserializer, Serialize};
use std::ops::ControlFlow;

/// How scattered light is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScatterSettings {
    /// How linear equations are solved.
    pub method: Method,
    /// Relative residual of the solution, as [`crate::diffusion::Settings::tolerance`].
    pub tolerance: f64,
    /// What keeps light from flowing faster than it can.
    pub limiter: Limiter,
    /// The limiter's updates of the diffusivity end at this relative residual with an updated one, and at fluxes that
    /// exceed the fluence by this share. Measured on a cloud and on a ball in a vacuum: at 1e-2 the fluence in the medium is
    /// within 10⁻³ of the converged one (rms), where the first is off by 0.06 and 0.2.
    pub nonlinear: f64,
    /// Least optical thickness (reduced) of the box's longest edge.
    pub floor: f64,
    /// What the sides across each axis reflect, as [`Boundary::reflection`].
    pub reflection: [f64; 3],
}

impl ScatterSettings {
    /// The usual ones for a method.
    pub fn new(method: Method) -> Self {
        Self {
            method,
            tolerance: 1e-5,
            limiter: Limiter::LevermorePomraning,
            nonlinear: 5e-3,
            floor: 1e-2,
            reflection: Boundary::OPEN.reflection,
        }
    }
}

/// Where a solve stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScatterProgress {
    /// The channel, from 0, and how many there are.
    pub channel: [usize; 2],
    /// Updates of the limited diffusivity so far.
    pub outer: usize,
    /// Iterations of the linear solver since the last of them.
    pub iterations: usize,
    /// Relative residual of the linear equation.
    pub residual: f64,
}

/// Who watches: a break ends the solve.
pub type ScatterObserver<'a> = dyn FnMut(&ScatterProgress) -> ControlFlow<()> + 'a;

/// How the solve of a channel went.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChannelFacts {
    /// Iterations of the linear solver, all together.
    pub iterations: usize,
    /// True relative residual of the linear equation with the last diffusivity.
    #[serde(deserialize_with = "null_is_nan")]
    pub residual: f64,
    /// |ΣQ − Σσ_aφ − what leaves| / ΣQ.
    #[serde(deserialize_with = "null_is_nan")]
    pub imbalance: f64,
    /// Updates of the limited diffusivity.
    pub outer: usize,
    /// Relative residual with the diffusivity that the limiter wants for the solution; 0 without a limiter.
    #[serde(deserialize_with = "null_is_nan")]
    pub nonlinear: f64,
    /// Whether all residuals are within what was asked for.
    pub converged: bool,
    /// Cells that the floor of the optical thickness changes.
    pub floor_cells: u64,
    /// Largest |F| / φ of a cell in the solution of the equation: above 1 is unphysical.
    #[serde(deserialize_with = "null_is_nan")]
    pub solved_flux: f64,
    /// The same of the flux that is used: with a limiter, it is cut to φ where updates left more.
    #[serde(deserialize_with = "null_is_nan")]
    pub largest_flux: f64,
}

/// JSON has no numbers that are not finite.
fn null_is_nan<'de, D: Deserializer<'de>>(number: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(number)?.unwrap_or(f64::NAN))
}

/// Scattered light on the direct light's grid.
pub struct ScatteredLight {
    /// Fluence of diffuse light φ_m ≥ 0, rgb. With the reduced direct light it makes the whole fluence: what is not
    /// scattered once only is this, and reduced − unreduced direct light.
    pub fluence: Buffer<[f32; 4]>,
    /// Vector flux over fluence of what is not scattered once only, of the channels' mean, |drift| ≤ 1; there when
    /// direct light has a flow.
    pub drift: Option<Buffer<[f32; 4]>>,
    /// Each channel that was solved: one when nothing has a colour, else three.
    pub channels: Vec<ChannelFacts>,
}

/// A solver of scattered light for one medium, which can follow direct light that gets better: it goes on from the last
/// solution.
pub struct ScatterSolver {
    direct_cells: usize,
    settings: ScatterSettings,
    /// Mean cosine of the phase function.
    forward: f32,
    cells: Cells,
    kernels: ScatterKernels,
    solver: Solver,
    fields: ChannelFields,
    /// Fluence of each channel.
    phi: Vec<Buffer<f32>>,
    source: Buffer<[f32; 4]>,
    bordered: Buffer<[f32; 4]>,
    flux: Buffer<[f32; 4]>,
    /// Whether every channel has a solution to go on from.
    solved: bool,
}

impl ScatterSolver {
    /// Makes the equations of `medium` ready on the cells of `coarse`, for direct light on the cells of `direct_grid`.
    ///
    /// # Errors
    /// [`Error::Input`] when a setting makes no sense; [`Error::Failed`] when the device lacks memory or fails.
    pub fn new(
        device: &Device,
        medium: &LitMedium,
        coarse: &LightGrid,
        direct_grid: &LightGrid,
        settings: &ScatterSettings,
    ) -> Result<Self> {
        let boundary = Boundary { reflection: settings.reflection };
        Self::memory(medium, coarse, direct_grid, settings.limiter).check(device.info())?;
        let method = medium.method.read(device)?;
        let Scattering { phase: [first, second, weight, _], .. } =
            method.first_chunk().map_or_else(Scattering::zeroed, |bytes: &[u8; size_of::<Scattering>()]| {
                bytemuck::pod_read_unaligned(bytes)
            });
        let cells = coarse.cells();
        let field = |count| Buffer::uninitialised(device, count);
        Ok(Self {
            direct_cells: direct_grid.cells(),
            settings: *settings,
            forward: weight * first + (1.0 - weight) * second,
            cells: Cells::new(device, medium, coarse)?,
            kernels: ScatterKernels::build(device, medium, coarse, direct_grid, settings)?,
            solver: Solver::new(device, coarse.dims, coarse.cell, boundary)?,
            fields: ChannelFields::new(device, cells)?,
            phi: (0..channels(medium)).map(|_| Buffer::zeroed(device, cells)).collect::<Result<_>>()?,
            source: field(cells)?,
            bordered: Buffer::zeroed(device, coarse.dims.iter().map(|n| n + 2).product())?,
            flux: field(cells)?,
            solved: false,
        })
    }

    /// What [`ScatterSolver::new`] and a solve would allocate on the device.
    pub fn memory(
        medium: &LitMedium,
        coarse: &LightGrid,
        direct_grid: &LightGrid,
        limiter: Limiter,
    ) -> MemoryPlan {
        let mut plan = Cells::memory(medium, coarse);
        plan.items.extend(Solver::memory(coarse.dims, coarse.cell).items);
        plan.items.extend(LimiterKernels::memory(limiter, coarse.cells()).items);
        let cells = coarse.cells() as u64;
        for name in ["absorption", "transport coefficient", "diffusivity", "power"] {
            plan.add(&format!("{name} of a channel"), cells, size_of::<f32>());
        }
        for channel in 0..channels(medium) {
            plan.add(&format!("diffuse fluence of channel {channel}"), cells, size_of::<f32>());
        }
        let bordered = coarse.dims.iter().map(|&n| n as u64 + 2).product();
        for (name, count) in [
            ("source of diffuse light", cells),
            ("flux of a channel", cells),
            ("flux of diffuse light", cells),
            ("diffuse fluence with a border", bordered),
            ("scattered light", direct_grid.cells() as u64),
            ("drift of scattered light", direct_grid.cells() as u64),
            ("places of direct light", cells),
        ] {
            plan.add(name, count, size_of::<[f32; 4]>());
        }
        plan
    }

    /// The light that the medium scatters of `direct` (and of what it emits).
    ///
    /// # Errors
    /// [`Error::Input`] when direct light is not a number or has no steady state in the medium, [`Error::Interrupted`]
    /// when the observer breaks, [`Error::Failed`] when the device or an iteration fails. A solve that ends at the limit
    /// of iterations is no error: see [`ChannelFacts::converged`].
    pub fn solve(
        &mut self,
        device: &Device,
        medium: &LitMedium,
        direct: &DirectLight,
        observer: &mut ScatterObserver<'_>,
    ) -> Result<ScatteredLight> {
        let count = self.direct_cells;
        let fields =
            [Some(&direct.fluence), direct.reduced.as_ref(), direct.flow.as_ref(), direct.extent.as_ref()];
        if let Some(wrong) = fields.into_iter().flatten().find(|field| field.len() != count) {
            return Err(Error::Failed(format!(
                "scattered light: direct light has {} cells, its grid {count}",
                wrong.len()
            )));
        }
        let reduced = direct.reduced.as_ref().unwrap_or(&direct.fluence);
        let light = (reduced, direct.extent.as_ref());
        self.kernels.source(device, medium, light, &self.cells, &self.source, self.forward)?;
        let mut facts = Vec::new();
        let scales = scales(&self.source.read(device)?);
        let channels = self.phi.len();
        if direct.flow.is_some() {
            self.flux.write(device, 0, &vec![[0.0; 4]; self.flux.len()])?;
        }
        for (channel, scale) in scales.into_iter().enumerate().take(channels) {
            if channel > 0 && !self.solved {
                // Colours differ by less than light and dark do.
                let nearest = self.phi[channel - 1].read(device)?;
                self.phi[channel].write(device, 0, &nearest)?;
            }
            let factors = (self.forward, 1.0 / scale);
            self.kernels.channel(device, &self.cells, &self.source, &self.fields, factors, channel)?;
            let mut watch = |stage: Stage| {
                let Stage { outer, iterations, residual } = stage;
                observer(&ScatterProgress { channel: [channel, channels], outer, iterations, residual })
            };
            let mut equation = Channel {
                device,
                kernels: &mut self.kernels,
                solver: &mut self.solver,
                fields: &self.fields,
                phi: &self.phi[channel],
                settings: &self.settings,
            };
            facts.push(equation.solve(&mut watch)?);
            self.kernels.border(
                device,
                &self.phi[channel],
                &self.fields,
                &self.bordered,
                scale,
                [channel, channels],
            )?;
            if direct.flow.is_some() {
                let share = scale / channels as f32;
                self.kernels.add_flux(device, &self.fields.flux, &self.flux, share)?;
            }
        }
        self.solved = true;
        let fluence = Buffer::uninitialised(device, count)?;
        self.kernels.prolong(device, &self.bordered, &fluence)?;
        let drift = match &direct.flow {
            None => None,
            Some(flow) => {
                let drift = Buffer::uninitialised(device, count)?;
                let lights = [&self.flux, &fluence, &direct.fluence, reduced, flow, &drift];
                self.kernels.drift(device, lights)?;
                Some(drift)
            }
        };
        device.finish()?;
        Ok(ScatteredLight { fluence, drift, channels: facts })
    }
}

/// What the source of each channel is divided by: the power of two next below its largest number. Equations of light have
/// no unit, but squares of float32 numbers do; and a power of two rounds nothing.
fn scales(source: &[[f32; 4]]) -> [f32; 3] {
    std::array::from_fn(|c| {
        let largest = source.iter().fold(0.0, |most: f32, cell| most.max(cell[c]));
        let usual = largest.is_normal() && (1e-36..1e36).contains(&largest);
        if usual { largest.log2().floor().exp2() } else { 1.0 }
    })
}

/// One channel when nothing has a colour.
fn channels(medium: &LitMedium) -> usize {
    if medium.has("GREY") { 1 } else { 3 }
}

/// The scattered light of one medium and its direct light; a [`ScatterSolver`] for several.
///
/// # Errors
/// As [`ScatterSolver::new`] and [`ScatterSolver::solve`].
pub fn solve(
    device: &Device,
    medium: &LitMedium,
    coarse: &LightGrid,
    direct_grid: &LightGrid,
    direct: &DirectLight,
    settings: &ScatterSettings,
    observer: &mut ScatterObserver<'_>,
) -> Result<ScatteredLight> {
    ScatterSolver::new(device, medium, coarse, direct_grid, settings)?.solve(device, medium, direct, observer)
}
