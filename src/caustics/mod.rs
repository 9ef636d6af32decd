//! Caustics: photons from the lights over mirrors and glass to diffuse surfaces, and what is gathered of them there
//! (Jensen 2001; Bogolepov, Sopin and Turlapov's voxel structure). The kernels are `cl/caustics/`.

mod photon;

pub use photon::Photon;
