//! What gathering knows of surfaces: which are flat, and where their edges are.

use crate::device_struct;
use glam::DVec3;

device_struct! {
    "types/photon_map.cl",
    /// A surface that photons are gathered on, in local units.
    pub struct Receiver {
        /// By `kind`.
        pub origin: [f32; 4],
        /// By `kind`.
        pub u: [f32; 4],
        /// By `kind`.
        pub v: [f32; 4],
        /// Which kind of surface.
        pub kind: u32,
        /// Its number among the flat ones.
        pub plane: u32,
        /// No photons farther than this count, whatever the radius; may be infinite.
        pub reach: f32,
        /// Padding.
        pub pad_1: u32,
    }
}

/// The number of a surface that is not flat.
const NO_PLANE: u32 = u32::MAX;

impl Receiver {
    /// Triangles, whose edges are not known.
    pub fn mesh() -> Self {
        Self { kind: 5, ..Self::curved() }
    }

    /// A surface that is curved and closed.
    pub fn curved() -> Self {
        let none = [0.0; 4];
        Self { origin: none, u: none, v: none, kind: 0, plane: NO_PLANE, reach: f32::INFINITY, pad_1: 0 }
    }

    /// A plane without edges.
    pub fn plane(point: DVec3, normal: DVec3) -> Self {
        let u = normal.normalize().any_orthonormal_vector();
        Self::flat(1, point, 0.0, u, 0.0, normal.normalize().cross(u), 0.0)
    }

    /// A parallelogram.
    pub fn parallelogram(corner: DVec3, edge_u: DVec3, edge_v: DVec3) -> Self {
        let u = edge_u.normalize();
        let slant = edge_v.dot(u);
        let across = edge_v - slant * u;
        Self::flat(2, corner, edge_u.length(), u, slant, across.normalize(), across.length())
    }

    /// A disk.
    pub fn disk(centre: DVec3, normal: DVec3, radius: f64) -> Self {
        let plane = Self::plane(centre, normal);
        Self { origin: float4(centre, radius), kind: 3, ..plane }
    }

    /// A box, axis-aligned.
    pub fn cuboid(low: DVec3, high: DVec3) -> Self {
        Self { origin: float4(low, 0.0), u: float4(high - low, 0.0), kind: 4, ..Self::curved() }
    }

    fn flat(kind: u32, origin: DVec3, of_origin: f64, u: DVec3, of_u: f64, v: DVec3, of_v: f64) -> Self {
        let [origin, u, v] = [float4(origin, of_origin), float4(u, of_u), float4(v, of_v)];
        Self { origin, u, v, kind, plane: 0, reach: f32::INFINITY, pad_1: 0 }
    }

    /// Whether it lies in one plane.
    pub fn is_flat(&self) -> bool {
        self.plane != NO_PLANE
    }
}

fn float4(v: DVec3, w: f64) -> [f32; 4] {
    [v.x as f32, v.y as f32, v.z as f32, w as f32]
}

/// Gives each flat surface its own number; how many there are.
pub(super) fn number_planes(receivers: &mut [Receiver]) -> u32 {
    let mut planes = 0;
    for receiver in receivers.iter_mut().filter(|receiver| receiver.is_flat()) {
        receiver.plane = planes;
        planes += 1;
    }
    planes
}
