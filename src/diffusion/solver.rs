//! The solver: its levels, and a solve from the caller's boxes to the caller's box.

use super::coarsest::Coarsest;
use super::fields::{Finest, Level, memory};
use super::grid::Grid;
use super::launch::{Kernels, Queue};
use super::multigrid::Hierarchy;
use super::settings::{Boundary, Coefficients, Method, Observer, Outcome, Settings, Solution};
use crate::device::{Arg, Buffer, Device, MemoryPlan, ProgramSpec};
use crate::{Error, Result};
use glam::DVec3;
use std::f64::consts::PI;
use std::ops::ControlFlow;

/// Imbalance over the tolerance: a residual spread over many cells may be small beside a source in few, and yet be much
/// of its power.
const BALANCE: f64 = 10.0;

/// A solver for boxes of one shape on one device, for any number of media and sources.
pub struct Solver {
    dims: [usize; 3],
    spacing: DVec3,
    boundary: Boundary,
    kernels: Kernels,
    levels: Vec<Level>,
    finest: Finest,
}

impl Solver {
    /// What [`Solver::new`] would allocate on the device.
    pub fn memory(dims: [usize; 3], spacing: DVec3) -> MemoryPlan {
        memory(&Grid::hierarchy(dims, spacing))
    }

    /// A solver for `dims` cells of `spacing` (any unit of length; coefficients are in the same).
    ///
    /// # Errors
    /// [`Error::Input`] when there are no cells, or a length or the boundary makes no sense; [`Error::Failed`] when
    /// the device has no room or does not build the kernels.
    pub fn new(device: &Device, dims: [usize; 3], spacing: DVec3, boundary: Boundary) -> Result<Self> {
        Self::altered(device, dims, spacing, boundary, |spec| spec)
    }

    /// The same with a program that `alter` has changed, which shows what a check of it finds.
    ///
    /// # Errors
    /// As [`Solver::new`].
    pub fn altered(
        device: &Device,
        dims: [usize; 3],
        spacing: DVec3,
        boundary: Boundary,
        alter: fn(ProgramSpec) -> ProgramSpec,
    ) -> Result<Self> {
        let input = |what: String| Err(Error::Input(format!("diffusion: {what}")));
        if dims.contains(&0)
            || dims.iter().try_fold(1_usize, |n, &k| n.checked_mul(k)).is_none_or(|n| n >> 30 > 0)
        {
            return input(format!(
                "{dims:?} cells: each axis needs at least 1, all together at most 2^30 − 1"
            ));
        }
        if !spacing.to_array().iter().all(|h| h.is_finite() && *h > 0.0) {
            return input(format!("cells of {spacing} are not a size: lengths are finite and above 0"));
        }
        if !boundary.reflection.iter().all(|a| *a >= 0.0) {
            return input(format!("boundary factors {:?} are not 0 or more", boundary.reflection));
        }
        let grids = Grid::hierarchy(dims, spacing);
        memory(&grids).check(device.info())?;
        let kernels = Kernels::build(device, alter)?;
        let levels = grids.into_iter().map(|grid| Level::new(device, grid)).collect::<Result<Vec<_>>>()?;
        let finest = Finest::new(device, &levels[0].grid)?;
        Ok(Self { dims, spacing, boundary, kernels, levels, finest })
    }

    /// Solves for one medium and one source (power per volume, one number per cell, 0 or more).
    ///
    /// # Errors
    /// [`Error::Input`] when a number makes no sense or light has no steady state; [`Error::Failed`] when the device
    /// or the iteration fails. A solve that ends at the limit of iterations is no error: see [`Outcome::converged`].
    pub fn solve(
        &mut self,
        device: &Device,
        coefficients: &Coefficients<'_>,
        source: &Buffer<f32>,
        settings: &Settings,
    ) -> Result<Solution> {
        let phi = Buffer::zeroed(device, self.dims.iter().product())?;
        let mut patient = |_, _| ControlFlow::Continue(());
        let outcome = self.improve(device, coefficients, source, &phi, settings, &mut patient)?;
        Ok(Solution { phi, outcome })
    }

    /// As [`Solver::solve`], from the fluence `phi` on, which may be that of another medium or source: it becomes the
    /// solution. A start that is worse than darkness is not used.
    ///
    /// # Errors
    /// As [`Solver::solve`], and [`Error::Interrupted`] when the observer breaks; `phi` is then what it was.
    pub fn improve(
        &mut self,
        device: &Device,
        coefficients: &Coefficients<'_>,
        source: &Buffer<f32>,
        phi: &Buffer<f32>,
        settings: &Settings,
        observer: &mut Observer<'_>,
    ) -> Result<Outcome> {
        let cells = self.dims.iter().product::<usize>();
        for (name, field) in [
            ("absorption", coefficients.absorption),
            ("diffusivity", coefficients.diffusivity),
            ("source", source),
            ("fluence to start from", phi),
        ] {
            if field.len() != cells {
                return Err(Error::Input(format!(
                    "diffusion: the {name} has {} numbers, the box has {cells} cells",
                    field.len()
                )));
            }
        }
        let mut queue = Queue { device, kernels: &mut self.kernels };
        let limit = largest_diffusivity(self.dims, self.spacing, settings)?;
        let floor_cells = inspect(&mut queue, coefficients, limit, &self.boundary)?;
        let largest_source = inspect_one(&mut queue, "source", source)?;
        let largest_start = inspect_one(&mut queue, "fluence to start from", phi)?;
        for level in &self.levels {
            level.device_grid.write(device, 0, &[level.grid.device(&self.boundary, limit)])?;
        }
        let unit = self.spacing.min_element();
        assemble(&mut queue, &self.levels, coefficients, unit as f32)?;
        let (inverse, elements) = coarsest(device, &self.levels[self.levels.len() - 1])?;
        let hierarchy = Hierarchy { levels: &self.levels, inverse: &inverse, elements: &elements };
        let mut iteration = Iteration::new(queue, hierarchy, &self.finest, settings, observer);
        let scale = f64::from(largest_source) * unit;
        if largest_source > 0.0 {
            iteration.load(source, 1.0 / largest_source)?;
            // Squares of the fluence must stay inside float32.
            if largest_start > 0.0 && f64::from(largest_start) < scale * 1e15 {
                iteration.start_from(phi, (1.0 / scale) as f32)?;
            }
            iteration.run(self.dims)?;
        }
        iteration.store(phi, scale as f32)?;
        Ok(Outcome { floor_cells, ..iteration.outcome })
    }
}

/// D at which the longest edge has the least optical thickness.
fn largest_diffusivity(dims: [usize; 3], spacing: DVec3, settings: &Settings) -> Result<f64> {
    let Settings { tolerance, floor, method, .. } = *settings;
    let input = |what: String| Err(Error::Input(format!("diffusion: {what}")));
    if !(tolerance.is_finite() && tolerance > 0.0) {
        return input(format!("tolerance {tolerance} is not a number above 0"));
    }
    if !(floor.is_finite() && floor > 0.0) {
        return input(format!("floor {floor} of the optical thickness is not a number above 0"));
    }
    if let Method::OverRelaxation { factor: Some(factor) } = method
        && !(factor > 0.0 && factor < 2.0)
    {
        return input(format!("over-relaxation by {factor} diverges: the factor is between 0 and 2"));
    }
    let longest = (spacing * DVec3::from_array(dims.map(|n| n as f64))).max_element();
    Ok(longest / (3.0 * floor))
}

/// Checks the medium; how many cells are beyond the largest diffusivity.
fn inspect(
    queue: &mut Queue<'_>,
    coefficients: &Coefficients<'_>,
    limit: f64,
    boundary: &Boundary,
) -> Result<u64> {
    let absorption = inspect_one(queue, "absorption", coefficients.absorption)?;
    let found = queue.inspect(coefficients.diffusivity, limit as f32)?;
    let wrong = found.wrong + found.zero;
    if wrong > 0 {
        return Err(Error::Input(format!(
            "diffusion: {wrong} cells have a diffusivity that is not above 0 (infinite is fine: vacuum)"
        )));
    }
    if absorption == 0.0 && boundary.reflection.iter().all(|a| a.is_infinite()) {
        return Err(Error::Input(
            "diffusion: nothing is absorbed and all sides are mirrors, so light has no steady state; open a boundary \
             or let the medium absorb"
                .into(),
        ));
    }
    Ok(found.above)
}

/// Checks that numbers are finite and 0 or more; the largest.
fn inspect_one(queue: &mut Queue<'_>, name: &str, field: &Buffer<f32>) -> Result<f32> {
    let found = queue.inspect(field, f32::MAX)?;
    match found.wrong + found.above {
        0 => Ok(found.largest),
        wrong => Err(Error::Input(format!(
            "diffusion: the {name} of {wrong} cells is not a finite number, 0 or more"
        ))),
    }
}

/// A level's coefficients as arguments.
fn stencil(level: &Level) -> Vec<Arg<'_>> {
    level.conductance.iter().chain([&level.loss]).map(Arg::from).collect()
}

/// The coefficients of all levels.
fn assemble(
    queue: &mut Queue<'_>,
    levels: &[Level],
    coefficients: &Coefficients<'_>,
    unit: f32,
) -> Result<()> {
    for (number, level) in levels.iter().enumerate() {
        let mut arguments: Vec<Arg<'_>> = Vec::new();
        if number == 0 {
            arguments.push((&level.device_grid).into());
            arguments.extend([coefficients.diffusivity, coefficients.absorption].map(Arg::from));
            arguments.extend(stencil(level));
            arguments.push(unit.into());
            queue.cells("diffusion_assemble", level, &arguments)?;
        } else {
            let fine = &levels[number - 1];
            arguments.extend([&fine.device_grid, &level.device_grid].map(Arg::from));
            arguments.extend(stencil(fine));
            arguments.extend(stencil(level));
            queue.cells("diffusion_coarsen", level, &arguments)?;
        }
        let mut arguments = vec![(&level.device_grid).into()];
        arguments.extend(stencil(level));
        arguments.push((&level.inverse).into());
        queue.cells("diffusion_invert", level, &arguments)?;
    }
    Ok(())
}

/// The inverse of the coarsest level's matrix and its cells' elements.
fn coarsest(device: &Device, level: &Level) -> Result<(Buffer<f32>, Buffer<u32>)> {
    let [x, y, z] = &level.conductance;
    let conductance = [x.read(device)?, y.read(device)?, z.read(device)?];
    let coarsest = Coarsest { grid: &level.grid, conductance, loss: level.loss.read(device)? };
    let inverse = Buffer::from_slice(device, &coarsest.inverse()?)?;
    Ok((inverse, Buffer::from_slice(device, &coarsest.elements())?))
}

/// A solve under way.
pub(super) struct Iteration<'a> {
    pub queue: Queue<'a>,
    pub hierarchy: Hierarchy<'a>,
    pub finest: &'a Finest,
    pub settings: &'a Settings,
    pub outcome: Outcome,
    observer: &'a mut Observer<'a>,
    /// Norm and sum of the source.
    norm: f64,
    sum: f64,
}

impl<'a> Iteration<'a> {
    fn new(
        queue: Queue<'a>,
        hierarchy: Hierarchy<'a>,
        finest: &'a Finest,
        settings: &'a Settings,
        observer: &'a mut Observer<'a>,
    ) -> Self {
        let outcome = Outcome { converged: true, ..Outcome::default() };
        Self { queue, hierarchy, finest, settings, outcome, observer, norm: 0.0, sum: 0.0 }
    }

    /// The finest level.
    pub fn level(&self) -> &'a Level {
        &self.hierarchy.levels[0]
    }

    /// Starts from darkness.
    fn load(&mut self, source: &Buffer<f32>, scale: f32) -> Result<()> {
        let level = self.level();
        let arguments =
            [(&level.device_grid).into(), source.into(), (&self.finest.source).into(), scale.into()];
        self.queue.cells("diffusion_load", level, &arguments)?;
        for field in [&self.finest.direction, &self.finest.leaving] {
            self.queue.vector("diffusion_zero", &[field], &[], field.len())?;
        }
        [self.norm, self.sum] = self.queue.sums(&self.finest.source)?;
        self.outcome.converged = false;
        self.outcome.history.push((0, 1.0));
        self.darken()
    }

    fn darken(&mut self) -> Result<()> {
        for field in [&self.finest.phi, &self.finest.phi_low] {
            self.queue.vector("diffusion_zero", &[field], &[], field.len())?;
        }
        self.true_residual()
    }

    /// Starts from a fluence, if that is nearer to the solution than darkness.
    fn start_from(&mut self, phi: &Buffer<f32>, scale: f32) -> Result<()> {
        let level = self.level();
        let arguments = [(&level.device_grid).into(), phi.into(), (&self.finest.phi).into(), scale.into()];
        self.queue.cells("diffusion_load", level, &arguments)?;
        self.true_residual()?;
        if self.outcome.residual >= 1.0 {
            return self.darken();
        }
        self.check()
    }

    fn store(&mut self, phi: &Buffer<f32>, scale: f32) -> Result<()> {
        let level = self.level();
        if self.norm == 0.0 {
            let field = &self.finest.phi;
            self.queue.vector("diffusion_zero", &[field], &[], field.len())?;
        }
        let arguments = [(&level.device_grid).into(), (&self.finest.phi).into(), phi.into(), scale.into()];
        self.queue.cells("diffusion_store", level, &arguments)?;
        self.queue.device.finish()
    }

    fn run(&mut self, dims: [usize; 3]) -> Result<()> {
        match self.settings.method {
            Method::Explicit => self.explicit(),
            Method::OverRelaxation { factor } => {
                let longest = dims.into_iter().max().unwrap_or(1) as f64;
                self.overrelaxation(factor.unwrap_or(2.0 / (1.0 + (PI / (longest + 1.0)).sin())))
            }
            Method::ConjugateGradients | Method::Multigrid => self.conjugate_gradients(),
        }?;
        if !self.outcome.converged {
            self.clamp()?;
        }
        Ok(())
    }

    /// Whether to stop.
    pub fn done(&self) -> bool {
        self.outcome.converged || self.outcome.iterations >= self.settings.max_iterations
    }

    /// At most as many more iterations as the settings allow.
    pub fn at_most(&self, iterations: usize) -> usize {
        iterations.min(self.settings.max_iterations - self.outcome.iterations)
    }

    /// Adds iterations after which the residual's norm is estimated.
    pub fn count(&mut self, iterations: usize, norm: f64) {
        self.outcome.iterations += iterations;
        self.outcome.residual = norm / self.norm;
        self.outcome.history.push((self.outcome.iterations, self.outcome.residual));
    }

    /// Shows the observer where the solve stands.
    pub fn show(&mut self) -> Result<()> {
        match (self.observer)(self.outcome.iterations, self.outcome.residual) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Error::Interrupted),
        }
    }

    /// Computes the residual afresh, of a solution without negative values if that is within the tolerance.
    pub fn check(&mut self) -> Result<()> {
        self.true_residual()?;
        if self.outcome.residual <= self.settings.tolerance {
            self.clamp()?;
        }
        Ok(())
    }

    /// Makes negative values 0: the solution has none, so that brings each of them closer to it.
    fn clamp(&mut self) -> Result<()> {
        let finest = self.finest;
        self.queue.vector("diffusion_clamp", &[&finest.phi, &finest.phi_low], &[], finest.phi.len())?;
        self.true_residual()?;
        let tolerance = self.settings.tolerance;
        self.outcome.converged =
            self.outcome.residual <= tolerance && self.outcome.imbalance <= BALANCE * tolerance;
        Ok(())
    }

    /// The level's source becomes the true residual.
    fn true_residual(&mut self) -> Result<()> {
        let (level, finest) = (self.level(), self.finest);
        let [x, y, z] = &level.conductance;
        let fields = [&level.source, &finest.phi, &finest.phi_low, &finest.source, x, y, z, &level.loss];
        self.queue.sweep_both("diffusion_residual", level, &fields)?;
        let [norm, sum] = self.queue.sums(&level.source)?;
        (self.outcome.residual, self.outcome.imbalance) = (norm / self.norm, (sum / self.sum).abs());
        if !self.outcome.residual.is_finite() {
            return Err(Error::Failed(format!(
                "diffusion: the solution overflows after {} iterations; the coefficients may differ by too much",
                self.outcome.iterations
            )));
        }
        if let Some(last) = self.outcome.history.last_mut() {
            last.1 = self.outcome.residual;
        }
        Ok(())
    }
}
