//! Caustics: photons from the lights over mirrors and glass to diffuse surfaces, and what is gathered of them there
//! (Jensen 2001; Bogolepov, Sopin and Turlapov's voxel structure). The kernels are `cl/caustics/`.

mod emission;
mod ledger;
mod photon;
mod photons;
mod spectrum;
mod target;

pub use emission::{Emission, EmissionSettings, Emitter, TargetRectangle, emitters};
pub use ledger::{PhotonAccount, PhotonLedger};
pub use photon::Photon;
pub use photons::{PhotonFrame, PhotonSettings, PhotonTracer};
pub use spectrum::{WAVELENGTHS, color_of, mean_color};
