//! Local units: the frame in which kernels compute.
//!
//! The origin is the low corner of the volume's box and the unit is the smallest voxel spacing, so that the numbers
//! on the device are the same whatever the scene's units and wherever it lies. The change of frame is in f64.

use glam::DVec3;

/// The change from scene units to local units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalFrame {
    /// Low corner of the volume's box, scene units.
    pub origin: DVec3,
    /// Scene units per local unit.
    pub unit: f64,
    /// Voxels per axis.
    pub dims: [usize; 3],
    /// Voxel spacing in local units (1 on the finest axis).
    pub spacing: DVec3,
}

impl LocalFrame {
    /// The frame of a grid of `dims` voxels of `spacing` (scene units) whose box starts at `origin`.
    pub fn new(origin: DVec3, spacing: DVec3, dims: [usize; 3]) -> Self {
        let unit = spacing.min_element();
        Self { origin, unit, dims, spacing: spacing / unit }
    }

    /// A point in local units.
    pub fn point(&self, p: DVec3) -> DVec3 {
        (p - self.origin) / self.unit
    }

    /// Extent of the box in local units.
    pub fn size(&self) -> DVec3 {
        self.spacing * DVec3::from_array(self.dims.map(|n| n as f64))
    }
}

/// `xyz` and `w` as the four floats of the device.
pub(super) fn float4(v: DVec3, w: f64) -> [f32; 4] {
    [v.x as f32, v.y as f32, v.z as f32, w as f32]
}
