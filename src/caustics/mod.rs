//! Caustics: photons from the lights over mirrors and glass to diffuse surfaces, and what is gathered of them there
//! (Jensen 2001; Bogolepov, Sopin and Turlapov's voxel structure). The kernels are `cl/caustics/`.
//!
//! - `emission`, `target`, `spectrum`: what leaves the lights, and where to
//! - `roles`: which paths are whose photons
//! - `photons`, `ledger`: photons on their way, and where their flux went
//! - `medium`: the volume between the surfaces
//! - `map`, `map_cells`, `map_types`, `receivers`: photons in an order in which those near a point are found
//! - `radius`: how far they are gathered from, pass by pass
//! - `settings`: what of this a scene says
//! - `passes`, `pass_ledger`: the photons of one sample after another

mod emission;
mod ledger;
mod map;
mod map_cells;
mod map_types;
mod medium;
pub(crate) mod pass_ledger;
mod passes;
mod photon;
mod photons;
mod radius;
mod receivers;
mod roles;
mod settings;
mod spectrum;
mod target;

pub use emission::{Emission, EmissionSettings, Emitter, TargetRectangle, emitters};
pub use ledger::{BouncedLedger, PhotonAccount, PhotonLedger};
pub use map::{MOST_PHOTONS, MapFacts, PhotonMap};
pub use map_cells::Focus;
pub use map_types::{Acceleration, MapFrame, MapSettings, Weighting};
pub use medium::{PhotonMedium, medium_setup, specialise_medium};
pub use pass_ledger::PassLedger;
pub use passes::{PassFacts, Passes};
pub use photon::Photon;
pub use photons::{PhotonFrame, PhotonSettings, PhotonTracer};
pub use radius::pass_radius;
pub use receivers::Receiver;
pub use roles::diffuse_light_returns;
pub use settings::{map_settings, photon_settings, reach, receiver};
pub use spectrum::{WAVELENGTHS, color_of, mean_color};
