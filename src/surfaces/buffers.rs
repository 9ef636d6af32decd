//! Surfaces on the device.

use super::{DeviceBall, DeviceMaterial, DeviceNode, DeviceShape, SurfaceArrays};
use crate::Result;
use crate::device::{Arg, Buffer, Device};
use bytemuck::{Pod, Zeroable};

/// [`SurfaceArrays`] in device memory, as `struct Surfaces` of `cl/surfaces/intersect.cl` takes them.
pub struct SurfaceBuffers {
    shapes: Buffer<DeviceShape>,
    nodes: Buffer<DeviceNode>,
    balls: Buffer<DeviceBall>,
    normals: Buffer<[f32; 4]>,
    materials_of: Buffer<u32>,
    materials: Buffer<DeviceMaterial>,
    /// Planes among the shapes.
    pub plane_count: u32,
    /// Nodes of the hierarchy.
    pub node_count: u32,
}

impl SurfaceBuffers {
    /// Uploads the arrays.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device lacks memory.
    pub fn new(device: &Device, arrays: &SurfaceArrays) -> Result<Self> {
        Ok(Self {
            shapes: upload(device, &arrays.shapes)?,
            nodes: upload(device, &arrays.nodes)?,
            balls: upload(device, &arrays.balls)?,
            normals: upload(device, &arrays.normals)?,
            materials_of: upload(device, &arrays.materials_of)?,
            materials: upload(device, &arrays.materials)?,
            plane_count: arrays.plane_count as u32,
            node_count: arrays.nodes.len() as u32,
        })
    }

    /// Shapes, nodes, balls, normals, materials of surfaces, materials: as kernels take them.
    pub fn arguments(&self) -> [Arg<'_>; 6] {
        [
            (&self.shapes).into(),
            (&self.nodes).into(),
            (&self.balls).into(),
            (&self.normals).into(),
            (&self.materials_of).into(),
            (&self.materials).into(),
        ]
    }
}

/// One unused element where there is none, as kernels take no empty buffers.
fn upload<T: Pod + Zeroable>(device: &Device, data: &[T]) -> Result<Buffer<T>> {
    if data.is_empty() { Buffer::zeroed(device, 1) } else { Buffer::from_slice(device, data) }
}
