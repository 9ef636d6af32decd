//! Mirror of `cl/types/photon.cl`.

use crate::device_struct;

device_struct! {
    "types/photon.cl",
    /// A photon where it met a diffuse surface, or where the medium scattered it, in local units.
    pub struct Photon {
        /// Where; as bits: the direction of travel.
        pub position: [f32; 4],
        /// Flux per channel over the square of the local unit; as bits: the surface + 1, or
        /// [`Photon::IN_MEDIUM`]; 0 when nothing is stored.
        pub flux: [f32; 4],
    }
}

impl Photon {
    /// The surface + 1 of photons in the medium.
    pub const IN_MEDIUM: u32 = 0x4000_0000;
}
