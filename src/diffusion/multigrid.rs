//! One symmetric multigrid cycle: the preconditioner.
//!
//! Cells are joined by twos along each axis; corrections are constant over the cells joined. Smoothing is red–black
//! Gauss–Seidel, in the opposite order after the coarse correction, which keeps the cycle symmetric. After a sweep
//! that ends with colour 1 those cells are in balance: only colour 0 has a residual, and only colour 0 needs the
//! coarse correction, since colour 1 is swept next.

use super::fields::Level;
use super::launch::Queue;
use crate::Result;
use crate::device::Buffer;

/// Red–black sweeps before and after the coarse correction. Three, because in media that differ from cell to cell
/// the iterations fall as fast as a cycle's cost rises, and their number grows less with the size.
const SWEEPS: usize = 3;

/// The levels, finest first, and the coarsest one's inverse.
pub(super) struct Hierarchy<'a> {
    pub levels: &'a [Level],
    pub inverse: &'a Buffer<f32>,
    pub elements: &'a Buffer<u32>,
}

impl Hierarchy<'_> {
    /// The finest level's `phi` from its `source`.
    pub fn cycle(&self, queue: &mut Queue<'_>) -> Result<()> {
        self.cycle_from(queue, 0)
    }

    fn cycle_from(&self, queue: &mut Queue<'_>, number: usize) -> Result<()> {
        let fine = &self.levels[number];
        let Some(coarse) = self.levels.get(number + 1) else {
            return queue.coarsest(fine, self.inverse, self.elements);
        };
        queue.sweep("diffusion_begin", fine, 0, &[&fine.phi, &fine.source, &fine.inverse], &[])?;
        balance(queue, fine, 1)?;
        for _ in 1..SWEEPS {
            balance(queue, fine, 0)?;
            balance(queue, fine, 1)?;
        }
        let [x, y, z] = &fine.conductance;
        let fields = [&fine.residual, &fine.phi, &fine.source, x, y, z, &fine.loss];
        queue.sweep("diffusion_imbalance", fine, 0, &fields, &[])?;
        let grids = || [(&fine.device_grid).into(), (&coarse.device_grid).into()];
        let [first, second] = grids();
        let arguments = [first, second, (&fine.residual).into(), (&coarse.source).into()];
        queue.cells("diffusion_restrict", coarse, &arguments)?;
        self.cycle_from(queue, number + 1)?;
        let [first, second] = grids();
        let arguments = [first, second, (&coarse.phi).into(), (&fine.phi).into()];
        queue.cells("diffusion_prolong", coarse, &arguments)?;
        for _ in 0..SWEEPS {
            balance(queue, fine, 1)?;
            balance(queue, fine, 0)?;
        }
        Ok(())
    }
}

/// One Gauss–Seidel sweep over a colour.
fn balance(queue: &mut Queue<'_>, level: &Level, colour: u32) -> Result<()> {
    let [x, y, z] = &level.conductance;
    let fields = [&level.phi, &level.source, x, y, z, &level.inverse];
    queue.sweep("diffusion_balance", level, colour, &fields, &[])
}
