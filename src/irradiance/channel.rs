//! The equation of one channel of colour, with a limited flux if asked for.

use super::Limiter;
use super::kernels::ScatterKernels;
use super::limiter::Measured;
use super::scattered::{ChannelFacts, ScatterSettings};
use crate::Result;
use crate::device::{Buffer, Device};
use crate::diffusion::{Coefficients, Outcome, Settings, Solver};
use std::ops::ControlFlow;

/// Updates after which they end anyway.
const MOST_UPDATES: usize = 100;
/// A linear solve between two updates ends at this times the nonlinear residual.
const PART: f64 = 0.03;
/// Of the mean fluence: below this the limiter lets go, because there rounding makes the gradient.
const FAINT: f64 = 1e-6;

/// What the equation of one channel is made of, one number per cell.
pub(super) struct ChannelFields {
    pub absorption: Buffer<f32>,
    /// σ_tr.
    pub transport: Buffer<f32>,
    pub diffusivity: Buffer<f32>,
    /// The source.
    pub power: Buffer<f32>,
    /// Vector flux of the solution; w: see `cl/irradiance/scattered.cl`.
    pub flux: Buffer<[f32; 4]>,
}

impl ChannelFields {
    pub fn new(device: &Device, cells: usize) -> Result<Self> {
        let field = || Buffer::uninitialised(device, cells);
        Ok(Self {
            absorption: field()?,
            transport: field()?,
            diffusivity: field()?,
            power: field()?,
            flux: Buffer::uninitialised(device, cells)?,
        })
    }
}

/// Where the solve of a channel stands.
pub(super) struct Stage {
    pub outer: usize,
    pub iterations: usize,
    pub residual: f64,
}

/// The equation and what solves it.
pub(super) struct Channel<'a> {
    pub device: &'a Device,
    pub kernels: &'a mut ScatterKernels,
    pub solver: &'a mut Solver,
    pub fields: &'a ChannelFields,
    /// Where to start from, then the solution.
    pub phi: &'a Buffer<f32>,
    pub settings: &'a ScatterSettings,
}

impl Channel<'_> {
    /// Solves; `fields` has the last diffusivity and flux then.
    pub fn solve(&mut self, watch: &mut dyn FnMut(Stage) -> ControlFlow<()>) -> Result<ChannelFacts> {
        let tolerance = self.settings.tolerance;
        let limited = self.settings.limiter != Limiter::None;
        self.kernels.limiter.restart();
        let mut state = self.measure(0.0)?;
        if limited && state.mean > 0.0 {
            self.update(state.mean)?;
        }
        let mut last = self.linear(if limited { tolerance.max(PART) } else { tolerance }, 0, watch)?;
        let mut iterations = last.iterations;
        state = self.measure(state.mean)?;
        // Without a source there is nothing to limit.
        let mut nonlinear = if limited && state.mean > 0.0 { 1.0 } else { 0.0 };
        let mut outer = 0;
        // The residual does not feel light that is faint beside the source: the flux does.
        let enough = self.settings.nonlinear;
        // A solve is as far from the limited equation as its own residual leaves it.
        let fine = if limited { tolerance.min(PART * enough) } else { tolerance };
        let unlimited = |nonlinear, flux| nonlinear > enough || (limited && flux > 1.0 + enough);
        while unlimited(nonlinear, state.flux) && outer < MOST_UPDATES {
            self.update(state.mean)?;
            outer += 1;
            last = self.linear(fine.max(PART * nonlinear.min(1.0)), outer, watch)?;
            iterations += last.iterations;
            nonlinear = last.history.first().map_or(0.0, |(_, residual)| *residual);
            state = self.measure(state.mean)?;
        }
        if limited && last.residual > tolerance {
            last = self.linear(tolerance, outer, watch)?;
            iterations += last.iterations;
        }
        state = self.measure(state.mean)?;
        let largest_flux = if limited { self.cut()?.min(state.flux) } else { state.flux };
        Ok(ChannelFacts {
            iterations,
            residual: last.residual,
            imbalance: last.imbalance,
            outer,
            nonlinear,
            // The last solve may move the flux a little beyond what the last update left.
            converged: last.converged && (outer < MOST_UPDATES || !unlimited(nonlinear, state.flux)),
            floor_cells: state.below,
            solved_flux: state.flux,
            largest_flux,
        })
    }

    /// Moves the diffusivity towards what the limiter wants.
    fn update(&mut self, mean: f64) -> Result<()> {
        let ScatterKernels { grids, limiter, .. } = &mut *self.kernels;
        limiter.update(self.device, grids, self.phi, self.fields, FAINT * mean)
    }

    /// Finds the flux, and measures it; `mean`: the fluence's, roughly.
    fn measure(&mut self, mean: f64) -> Result<Measured> {
        let ScatterKernels { grids, limiter, .. } = &mut *self.kernels;
        limiter.flux(self.device, grids, self.phi, self.fields)?;
        limiter.measure(self.device, self.phi, self.fields, FAINT * mean)
    }

    /// Cuts what is left of fluxes beyond the fluence; the largest ratio of both then.
    fn cut(&mut self) -> Result<f64> {
        let limiter = &mut self.kernels.limiter;
        limiter.cut(self.device, self.phi, self.fields)?;
        Ok(limiter.measure(self.device, self.phi, self.fields, 0.0)?.flux)
    }

    /// Solves with the diffusivity as it is.
    fn linear(
        &mut self,
        tolerance: f64,
        outer: usize,
        watch: &mut dyn FnMut(Stage) -> ControlFlow<()>,
    ) -> Result<Outcome> {
        let ScatterSettings { method, floor, .. } = *self.settings;
        let settings = Settings { tolerance, floor, ..Settings::new(method) };
        let ChannelFields { absorption, diffusivity, power, .. } = self.fields;
        let coefficients = Coefficients { absorption, diffusivity };
        let mut observer = |iterations, residual| watch(Stage { outer, iterations, residual });
        self.solver.improve(self.device, &coefficients, power, self.phi, &settings, &mut observer)
    }
}
