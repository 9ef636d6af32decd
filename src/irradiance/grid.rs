//! The cells of a light volume.

use crate::device_struct;
use crate::render::local::LocalFrame;
use glam::DVec3;

device_struct! {
    "types/irradiance.cl",
    /// The grid of a light volume; see `cl/types/irradiance.cl`.
    pub struct DeviceLightGrid {
        /// Size of a cell per axis, local units.
        pub cell: [f32; 4],
        /// Cells per axis.
        pub dims: [i32; 4],
    }
}

/// The volume's box in equal cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightGrid {
    /// Cells per axis, x fastest in memory.
    pub dims: [usize; 3],
    /// Size of a cell per axis, local units.
    pub cell: DVec3,
}

impl LightGrid {
    /// A cell per `coarsening` voxels along each axis, rounded up: with 1, the voxels themselves.
    pub fn new(local: &LocalFrame, coarsening: usize) -> Self {
        let dims = local.dims.map(|n| n.div_ceil(coarsening));
        Self { dims, cell: local.size() / DVec3::from_array(dims.map(|n| n as f64)) }
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.dims.iter().product()
    }

    /// As kernels read it.
    pub fn device(&self) -> DeviceLightGrid {
        let [x, y, z] = self.cell.to_array().map(|size| size as f32);
        let [nx, ny, nz] = self.dims.map(|n| n as i32);
        DeviceLightGrid { cell: [x, y, z, 0.0], dims: [nx, ny, nz, 0] }
    }
}
