//! Conjugate gradients.
//!
//! Flexible (Polak–Ribière): the preconditioner is symmetric only up to rounding, and the residual is replaced by the
//! true one now and then, because in float32 the one that is carried along drifts.

use super::settings::Method;
use super::solver::Iteration;
use crate::{Error, Result};

/// Iterations after which the residual is computed afresh.
const REPLACE_EVERY: usize = 10;
/// True residual over the one that was carried along, above which the directions so far are worth nothing.
const DRIFTED: f64 = 2.0;

impl Iteration<'_> {
    /// Iterates until the true residual is within the tolerance.
    pub(super) fn conjugate_gradients(&mut self) -> Result<()> {
        let count = self.level().grid.elements();
        // The last direction's step and its numerator; none at a start.
        let mut last = None;
        while !self.done() {
            self.precondition()?;
            let (level, finest) = (self.level(), self.finest);
            let [numerator, change] = self.queue.dots(&level.source, &level.phi, &finest.leaving)?;
            let turn = last.map_or(0.0, |(step, before): (f64, f64)| (-step * change / before).max(0.0));
            self.queue.vector("diffusion_turn", &[&finest.direction, &level.phi], &[turn as f32], count)?;
            let [x, y, z] = &level.conductance;
            let fields = [&finest.leaving, &finest.direction, x, y, z, &level.loss];
            self.queue.sweep_both("diffusion_apply", level, &fields)?;
            let [curvature, _] = self.queue.dots(&finest.direction, &finest.leaving, &finest.leaving)?;
            let step = numerator / curvature;
            if !(numerator > 0.0 && curvature > 0.0 && step.is_finite()) {
                if last.take().is_some() {
                    // Rounding has spoilt the direction: start again from where we are.
                    self.check()?;
                    continue;
                }
                return Err(Error::Failed(format!(
                    "diffusion: conjugate gradients broke down after {} iterations at a relative residual of {:.1e}; \
                     another method of solution may do",
                    self.outcome.iterations, self.outcome.residual
                )));
            }
            let fields = [&finest.phi, &finest.phi_low, &level.source, &finest.direction, &finest.leaving];
            self.queue.vector("diffusion_step", &fields, &[step as f32], count)?;
            last = Some((step, numerator));
            let [norm, _] = self.queue.sums(&level.source)?;
            self.count(1, norm);
            if self.outcome.residual <= self.settings.tolerance
                || self.outcome.iterations.is_multiple_of(REPLACE_EVERY)
            {
                let estimate = self.outcome.residual;
                self.check()?;
                if self.outcome.residual > DRIFTED * estimate {
                    last = None;
                }
            }
            self.show()?;
        }
        Ok(())
    }

    /// The level's `phi` from its `source`, roughly.
    fn precondition(&mut self) -> Result<()> {
        if self.settings.method == Method::Multigrid {
            return self.hierarchy.cycle(&mut self.queue);
        }
        let level = self.level();
        let fields = [&level.phi, &level.source, &level.inverse];
        self.queue.vector("diffusion_multiply", &fields, &[], level.grid.elements())
    }
}
