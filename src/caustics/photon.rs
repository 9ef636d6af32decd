//! Mirror of `cl/types/photon.cl`.

use crate::device_struct;

device_struct! {
    "types/photon.cl",
    /// A photon where it met a diffuse surface, in local units.
    pub struct Photon {
        /// Where; as bits: the direction of travel.
        pub position: [f32; 4],
        /// Flux per channel over the square of the local unit; as bits: the surface + 1, 0 when nothing is stored.
        pub flux: [f32; 4],
    }
}
