//! Rendering: from a validated scene to a film.
//!
//! A [`Plan`] makes everything ready on the host; a [`Session`] runs it on a device. Each method is one file here
//! and one kernel of the same name under `cl/render/`.

mod auxiliary;
mod bricks;
mod camera;
pub mod caustics;
mod caustics_notes;
pub mod emission_absorption;
mod extrema;
mod fingerprint;
pub mod grid;
pub mod isosurface;
mod kept;
mod ledger;
pub mod light_volume;
pub mod lights;
mod load;
pub mod local;
pub mod majorants;
pub mod medium;
mod merge;
mod merge_header;
pub mod method;
pub mod mip;
mod output;
mod parts;
mod plan;
mod planned_volume;
mod progressive;
mod rendering;
mod resume;
mod rows;
pub mod scattering;
mod session;
mod session_light;
mod share;
mod silhouette;
mod state;
mod tiles;
pub mod variants;

pub use auxiliary::Auxiliary;
pub use camera::DeviceCamera;
pub(crate) use fingerprint::Fingerprint;
pub use fingerprint::data_hash;
pub use ledger::PathLedger;
pub(crate) use ledger::number;
pub use load::{DataRef, SceneData, announced_memory};
pub use merge::{Merged, merge};
pub use output::{Snapshot, method_name, preview_tonemap};
pub use parts::{Held, Parts, in_words as parts_in_words};
pub use plan::{BRICK_SHIFT, Plan};
pub use planned_volume::PlannedVolume;
pub use progressive::{Ended, Observer, Status, run};
pub use rendering::{Facts, Rendering, Shift, of_devices};
pub use resume::{Origin, Saved, SavedFilm, Spent};
pub use rows::{Rows, extent_of_rows};
pub use session::{Progress, Session};
pub use share::Share;
pub use tiles::{Lag, TILE};

use crate::device::layout::StructLayout;

/// Every struct shared with kernels, for the layout probe.
pub const LAYOUTS: &[StructLayout] = &[
    DeviceCamera::LAYOUT,
    grid::DeviceVolume::LAYOUT,
    method::DeviceFrame::LAYOUT,
    crate::film::FilmPixel::LAYOUT,
    emission_absorption::EmissionAbsorption::LAYOUT,
    isosurface::Isosurface::LAYOUT,
    lights::DeviceLight::LAYOUT,
    mip::Mip::LAYOUT,
    scattering::Scattering::LAYOUT,
    ledger::Ledger::LAYOUT,
    auxiliary::Auxiliary::LAYOUT,
    crate::irradiance::DeviceLightGrid::LAYOUT,
    crate::irradiance::CarriedLight::LAYOUT,
    crate::irradiance::DirectParameters::LAYOUT,
    crate::irradiance::DirectCounts::LAYOUT,
    crate::diffusion::DeviceDiffusionGrid::LAYOUT,
    crate::surfaces::DeviceShape::LAYOUT,
    crate::surfaces::DeviceBall::LAYOUT,
    crate::surfaces::DeviceNode::LAYOUT,
    crate::surfaces::DeviceMaterial::LAYOUT,
    crate::caustics::Photon::LAYOUT,
    crate::caustics::PhotonAccount::LAYOUT,
    crate::caustics::Emitter::LAYOUT,
    crate::caustics::PhotonFrame::LAYOUT,
    crate::caustics::MapFrame::LAYOUT,
    crate::caustics::Receiver::LAYOUT,
    caustics::DeviceCaustics::LAYOUT,
];
