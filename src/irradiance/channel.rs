//! The equation of one channel of colour, flux-limited by Picard's iteration.
//!
//! The limited diffusivity depends on the solution. Each update moves its logarithm part of the way to what the limiter
//! wants for the fluence so far; one or two iterations of the linear solver follow from there. In near vacuum fluence
//! and flux determine each other, and whole steps would overshoot.

use super::Limiter;
use super::kernels::ScatterKernels;
use super::scattered::{ChannelFacts, ScatterSettings};
use crate::Result;
use crate::device::{Buffer, Device};
use crate::diffusion::{Coefficients, Outcome, Settings, Solver};
use std::ops::ControlFlow;

/// Share of the way that an update moves the logarithm of the diffusivity.
const RELAXATION: f64 = 0.7;
/// Nonlinear residual at which the updates end.
const NONLINEAR: f64 = 1e-4;
/// Updates after which they end anyway.
const MOST_UPDATES: usize = 200;
/// A linear solve between two updates ends at this times the nonlinear residual.
const PART: f64 = 0.1;
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
        let mut mean = self.flux_and_mean()?;
        if limited && mean > 0.0 {
            self.kernels.limit(self.device, self.phi, self.fields, FAINT * mean, 1.0)?;
        }
        let first = if limited { tolerance.max(PART * PART) } else { tolerance };
        let mut last = self.linear(first, 0, watch)?;
        let (limited_cells, mut iterations) = (last.limited_cells, last.iterations);
        mean = self.flux_and_mean()?;
        // Without a source there is nothing to limit.
        let mut nonlinear = if limited && mean > 0.0 { 1.0 } else { 0.0 };
        let mut outer = 0;
        while nonlinear > NONLINEAR && outer < MOST_UPDATES {
            self.kernels.limit(self.device, self.phi, self.fields, FAINT * mean, RELAXATION)?;
            outer += 1;
            last = self.linear(tolerance.max(PART * nonlinear), outer, watch)?;
            iterations += last.iterations;
            // To first order, the whole step would have left as much more as it is longer.
            nonlinear = last.history.first().map_or(0.0, |(_, residual)| residual / RELAXATION);
            mean = self.flux_and_mean()?;
        }
        if limited && last.residual > tolerance {
            last = self.linear(tolerance, outer, watch)?;
            iterations += last.iterations;
            mean = self.flux_and_mean()?;
        }
        Ok(ChannelFacts {
            iterations,
            residual: last.residual,
            imbalance: last.imbalance,
            outer,
            nonlinear,
            converged: last.converged && nonlinear <= NONLINEAR,
            limited_cells,
            largest_flux: self.kernels.measure(self.device, self.phi, self.fields, FAINT * mean)?[1],
        })
    }

    /// Finds the flux; the mean fluence.
    fn flux_and_mean(&mut self) -> Result<f64> {
        self.kernels.flux(self.device, self.phi, self.fields)?;
        Ok(self.kernels.measure(self.device, self.phi, self.fields, 0.0)?[0])
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
