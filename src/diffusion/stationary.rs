//! Explicit steps and over-relaxation.
//!
//! Both act on the correction for the true residual, from 0, and are stopped after a few sweeps to add it to the
//! solution and to compute the residual afresh. They have no memory but the solution, so that changes nothing but the
//! rounding: corrections are small, and float32 is enough for them.

use super::solver::Iteration;
use crate::Result;
use crate::device::Buffer;

/// Sweeps between two looks at the residual.
const SWEEPS: usize = 20;

impl Iteration<'_> {
    /// Explicit steps until the true residual is within the tolerance.
    pub(super) fn explicit(&mut self) -> Result<()> {
        while !self.done() {
            let (level, finest, sweeps) = (self.level(), self.finest, self.at_most(SWEEPS));
            let [x, y, z] = &level.conductance;
            let begin = [&level.phi, &level.source, &level.inverse];
            self.queue.sweep_both("diffusion_begin", level, &begin)?;
            let (mut now, mut next) = (&level.phi, &finest.direction);
            for _ in 1..sweeps {
                let fields = [next, now, &level.source, x, y, z, &level.inverse];
                self.queue.sweep_both("diffusion_explicit", level, &fields)?;
                (now, next) = (next, now);
            }
            self.correct(now, sweeps)?;
        }
        Ok(())
    }

    /// Over-relaxation by `factor` until the true residual is within the tolerance.
    pub(super) fn overrelaxation(&mut self, factor: f64) -> Result<()> {
        while !self.done() {
            let (level, sweeps) = (self.level(), self.at_most(SWEEPS));
            let [x, y, z] = &level.conductance;
            self.queue.vector("diffusion_zero", &[&level.phi], &[], level.grid.elements())?;
            for _ in 0..sweeps {
                for colour in 0..2 {
                    let fields = [&level.phi, &level.source, x, y, z, &level.inverse];
                    self.queue.sweep("diffusion_overrelax", level, colour, &fields, &[factor as f32])?;
                }
            }
            self.correct(&level.phi, sweeps)?;
        }
        Ok(())
    }

    fn correct(&mut self, correction: &Buffer<f32>, sweeps: usize) -> Result<()> {
        let fields = [&self.finest.phi, &self.finest.phi_low, correction];
        self.queue.vector("diffusion_correct", &fields, &[], correction.len())?;
        self.count(sweeps, f64::NAN);
        self.check()?;
        self.show()
    }
}
