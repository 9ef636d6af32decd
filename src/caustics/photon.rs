//! Mirror of `cl/types/photon.cl`.

use crate::device_struct;

device_struct! {
    "types/photon.cl",
    /// A photon where it met a diffuse surface, or where the medium scattered it, in local units.
    pub struct Photon {
        /// Where; as bits: the direction of travel.
        pub position: [f32; 4],
        /// Flux per channel over the square of the local unit; as bits: the mark of the surface, its side and the way it
        /// faces (`cl/caustics/marks.cl`), or [`Photon::IN_MEDIUM`]; 0 when nothing is stored.
        pub flux: [f32; 4],
    }
}

impl Photon {
    /// The mark of photons in the medium.
    pub const IN_MEDIUM: u32 = 0x4000_0000;
    /// The bits of a mark that hold the surface + 1.
    const MARK_SURFACE: u32 = (1 << 18) - 1;
    /// The bit of a mark that says that the photon came from behind the surface.
    const MARK_INSIDE: u32 = 1 << 18;
    /// Surfaces that marks can tell apart.
    pub const MOST_SURFACES: usize = Self::MARK_SURFACE as usize;

    /// The surface that it lies on.
    pub fn surface(&self) -> Option<u32> {
        (self.flux[3].to_bits() & Self::MARK_SURFACE).checked_sub(1)
    }

    /// Whether it came from behind its surface.
    pub fn is_inside(&self) -> bool {
        self.flux[3].to_bits() & Self::MARK_INSIDE != 0
    }
}
