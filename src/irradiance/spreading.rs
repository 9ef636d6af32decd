//! Scattered light by explicit diffusion (Zhang & Ma 2013, equation 9; the paper's model): the kernel is
//! `cl/irradiance/spreading.cl`.
//!
//! ρ_s' = ρ_s + Σ_v w_v ((ρ + ρ_s)_v − (ρ + ρ_s)) over the six neighbours v, with the direct fluence ρ and
//! w_v = diffusion · (h_min/h_a)² · σ_s(v) / max σ_t per channel: the diffusivity κ of the neighbour, from the transfer
//! function. Outside is dark, and as ready to scatter as the cell inside.
//!
//! The equation has no loss: scattering takes from the direct light what it spreads, until all of it has left through the
//! box's sides. Its steady state has no direct light left, so the number of steps is part of the picture. Nor is light
//! kept where weights differ: what a cell gives is weighted by its neighbours, what they get of it by the cell. What is
//! kept, for weights that add up to 1 at most, is the range: ρ + ρ_s is then a mean of what it was in the cell, in its
//! neighbours and outside, so it is never below 0 nor above its largest value. ρ_s alone is below 0 where more direct
//! light is taken away than light comes.

use super::convection::{padded, padded_dims};
use super::{Cells, DeviceLightGrid, DirectLight, LightGrid};
use crate::device::{Buffer, Device, Kernel, MemoryPlan, Program, ProgramSpec};
use crate::{Error, Result};

/// Work-items of the search for the largest extinction.
const SHARES: usize = 4096;

/// Scattered light and the steps that spread it.
pub struct Spreading {
    grid: LightGrid,
    device_grid: Buffer<DeviceLightGrid>,
    join: Kernel,
    part: Kernel,
    step: Kernel,
    /// With padding.
    weights: Buffer<[f32; 4]>,
    /// All light, before and after a step, with padding.
    light: [Buffer<[f32; 4]>; 2],
    scattered: Buffer<[f32; 4]>,
    steps: u64,
}

impl Spreading {
    /// Nothing scattered yet. `diffusion`: the weight of neighbours along the shortest edge of a cell where the medium is
    /// densest and scatters all.
    ///
    /// # Errors
    /// [`Error::Input`] when `diffusion` is unstable, [`Error::Failed`] when the device lacks memory.
    pub fn new(device: &Device, grid: &LightGrid, cells: &Cells, diffusion: f64) -> Result<Self> {
        check_diffusion(diffusion, grid)?;
        let program = Program::build(device, &ProgramSpec::new("irradiance/spreading.cl"))?;
        let kernel = |name| program.kernel(device, name);
        let device_grid = Buffer::from_slice(device, &[grid.device()])?;
        let most = largest(device, kernel("spreading_largest")?, cells, grid.cells())?;
        let scale = if most > 0.0 { diffusion / f64::from(most) } else { 0.0 };
        let count = padded(grid) as usize;
        let weights = Buffer::uninitialised(device, count)?;
        let arguments =
            [(&weights).into(), (&cells.scattering).into(), (&device_grid).into(), (scale as f32).into()];
        kernel("spreading_weigh")?.enqueue(device, &arguments, padded_dims(grid))?;
        Ok(Self {
            grid: *grid,
            device_grid,
            join: kernel("spreading_join")?,
            part: kernel("spreading_part")?,
            step: kernel("spreading_step")?,
            weights,
            light: [Buffer::zeroed(device, count)?, Buffer::zeroed(device, count)?],
            scattered: Buffer::zeroed(device, grid.cells())?,
            steps: 0,
        })
    }

    /// Takes steps with this direct light; waits for none of them. Where direct light has become less since the last
    /// steps than what they took from it, all light there is 0 before the first.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device fails.
    pub fn advance(&mut self, device: &Device, direct: &DirectLight, steps: u32) -> Result<()> {
        if steps == 0 {
            return Ok(());
        }
        let dims = self.grid.dims;
        let join = [
            (&self.light[0]).into(),
            (&direct.fluence).into(),
            (&self.scattered).into(),
            (&self.device_grid).into(),
        ];
        self.join.enqueue(device, &join, dims)?;
        let nearest = self.grid.cell.min_element();
        let along = (nearest / self.grid.cell).to_array().map(|ratio| (ratio * ratio) as f32);
        for _ in 0..steps {
            let [now, next] = &self.light;
            let [x, y, z] = along.map(Into::into);
            let arguments =
                [next.into(), now.into(), (&self.weights).into(), (&self.device_grid).into(), x, y, z];
            self.step.enqueue(device, &arguments, dims)?;
            self.light.swap(0, 1);
        }
        let part = [
            (&self.scattered).into(),
            (&self.light[0]).into(),
            (&direct.fluence).into(),
            (&self.device_grid).into(),
        ];
        self.part.enqueue(device, &part, dims)?;
        self.steps += u64::from(steps);
        Ok(())
    }

    /// What scattering adds to the direct fluence of the last steps, rgb: below 0 where it takes more than it brings,
    /// but never below minus the direct fluence.
    pub fn fluence(&self) -> &Buffer<[f32; 4]> {
        &self.scattered
    }

    /// The same, for good.
    pub fn into_fluence(self) -> Buffer<[f32; 4]> {
        self.scattered
    }

    /// Steps taken.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// What it takes on the device.
    pub fn memory(grid: &LightGrid) -> MemoryPlan {
        let mut plan = MemoryPlan::default();
        for name in ["weights of scattering", "all light, now", "all light, next"] {
            plan.add(name, padded(grid), size_of::<[f32; 4]>());
        }
        plan.add("scattered fluence", grid.cells() as u64, size_of::<[f32; 4]>());
        plan
    }
}

fn largest(device: &Device, mut kernel: Kernel, cells: &Cells, count: usize) -> Result<f32> {
    let shares = Buffer::<f32>::uninitialised(device, SHARES)?;
    let arguments = [
        (&shares).into(),
        (&cells.scattering).into(),
        (&cells.absorption).into(),
        (count as u32).into(),
        (SHARES as u32).into(),
    ];
    kernel.enqueue(device, &arguments, [SHARES, 1, 1])?;
    Ok(shares.read(device)?.into_iter().fold(0.0, f32::max))
}

/// The largest `diffusion` with which steps are stable and keep light from falling below 0: 1/6 for cubes.
pub fn largest_diffusion(grid: &LightGrid) -> f64 {
    let ratio = grid.cell.min_element() / grid.cell;
    0.5 / ratio.length_squared()
}

/// Refuses a `diffusion` that is unstable.
///
/// # Errors
/// [`Error::Input`] with the largest that is allowed.
pub fn check_diffusion(diffusion: f64, grid: &LightGrid) -> Result<()> {
    let largest = largest_diffusion(grid);
    if (0.0..=largest).contains(&diffusion) {
        return Ok(());
    }
    // Rounded down, to a number that passes.
    let shown = (largest * 1e4).floor() / 1e4;
    Err(Error::Input(if diffusion > largest {
        format!(
            "`method.spreading` = {diffusion} is too large: a cell would give its neighbours more light than it has, which is \
             unstable; with this volume's cells it must be at most {shown:.4}"
        )
    } else {
        format!(
            "`method.spreading` = {diffusion} must not be below 0; with this volume's cells at most {shown:.4}"
        )
    }))
}
