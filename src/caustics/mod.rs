//! Caustics: photons from the lights over mirrors and glass to diffuse surfaces, and what is gathered of them there
//! (Jensen 2001; Bogolepov, Sopin and Turlapov's voxel structure). The kernels are `cl/caustics/`.

mod map;
mod map_cells;
mod map_types;
mod photon;
mod radius;
mod receivers;

pub use map::{MapFacts, PhotonMap};
pub use map_types::{Acceleration, MapFrame, MapSettings, Weighting};
pub use photon::Photon;
pub use radius::pass_radius;
pub use receivers::Receiver;
