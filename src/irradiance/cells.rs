//! The medium in the cells of a light volume: the kernel is `cl/irradiance/cells.cl`.

use super::{LightGrid, LitMedium};
use crate::Result;
use crate::device::{Buffer, Device, MemoryPlan};

/// Volume averages over the cells, one rgb per cell (the fourth number is 0), x fastest, per local unit.
///
/// The transfer function is looked up at two points per voxel and axis, never applied to averages of values.
pub struct Cells {
    /// Scattering σ_s.
    pub scattering: Buffer<[f32; 4]>,
    /// Absorption σ_a.
    pub absorption: Buffer<[f32; 4]>,
    /// 4π σ_a L_e, the power that a volume emits; none where nothing glows.
    pub glow: Option<Buffer<[f32; 4]>>,
}

/// Tables that the kernel takes: up to the emission table.
pub(super) const TABLES: usize = 4;

impl Cells {
    /// Averages the medium over the cells of `grid`.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device lacks memory or fails.
    pub fn new(device: &Device, medium: &LitMedium, grid: &LightGrid) -> Result<Self> {
        let cells = grid.cells();
        let field = || Buffer::uninitialised(device, cells);
        let (scattering, absorption) = (field()?, field()?);
        let glows = medium.has("EMISSION");
        let glow = Buffer::uninitialised(device, if glows { cells } else { 1 })?;
        let device_grid = Buffer::from_slice(device, &[grid.device()])?;
        let program = medium.program(device, "irradiance/cells.cl", |spec| spec)?;
        let mut arguments = medium.arguments(TABLES);
        arguments.push((&device_grid).into());
        arguments.extend([&scattering, &absorption, &glow].map(crate::device::Arg::from));
        program.kernel(device, "irradiance_cells")?.run(device, &arguments, cells)?;
        Ok(Self { scattering, absorption, glow: glows.then_some(glow) })
    }

    /// What [`Cells::new`] would allocate on the device.
    pub fn memory(medium: &LitMedium, grid: &LightGrid) -> MemoryPlan {
        let mut plan = MemoryPlan::default();
        let glow = medium.has("EMISSION").then_some("emitted power of cells");
        for name in ["scattering of cells", "absorption of cells"].into_iter().chain(glow) {
            plan.add(name, grid.cells() as u64, size_of::<[f32; 4]>());
        }
        plan
    }
}
