//! Surfaces: what rays and photons meet besides the volume, as arrays for the device. The kernels are `cl/surfaces/`.
//!
//! [`load`] reads the meshes of a scene, [`SurfaceArrays`] is everything in the frame of a render.

mod arrays;
mod bounds;
mod buffers;
mod bvh;
mod mesh;
mod types;
mod within;

pub use arrays::SurfaceArrays;
pub use bounds::Bounds;
pub use buffers::SurfaceBuffers;
pub use mesh::{Mesh, Meshes, load};
pub use types::{DeviceBall, DeviceMaterial, DeviceNode, DeviceShape};

use crate::scene::Surface;

/// The box around those surfaces of a kind that have bounds (all but planes), in scene units.
pub fn bounds_of(surfaces: &[Surface], meshes: &Meshes, wanted: impl Fn(&Surface) -> bool) -> Option<Bounds> {
    let wanted = surfaces.iter().enumerate().filter(|(_, surface)| wanted(surface));
    Bounds::around(wanted.filter_map(|(index, surface)| bounds_of_one(index, surface, meshes)))
}

/// Those of the surface with this number, if it has any.
pub fn bounds_of_one(index: usize, surface: &Surface, meshes: &Meshes) -> Option<Bounds> {
    match meshes.of(index) {
        Some(mesh) => mesh.bounds(),
        None => arrays::shape_bounds(&surface.shape),
    }
}
