//! Light volumes: the light in every cell of a grid over the volume, whatever the camera (Zhang & Ma 2013; Lesar, Bohak
//! and Marolt's hybrid diffusion).
//!
//! Direct light comes first, then what the medium scatters; the cameras project the sum. Fluences are in W/m² of the
//! scene's lights, as irradiances and π-less radiances integrated over directions; lengths are local units.
//!
//! - `carried`, `convection`: direct light by upwind convection, in steps or at once
//! - `grid`: the cells
//! - `medium`: the medium and its lights on the device, as the kernels of scattering read them
//! - `spreading`: scattered light by explicit diffusion
//! - `cells`: averages of the medium over cells
//! - `direct`: direct light by tracking towards the lights
//! - `direct_light`: direct light, however it was computed

mod carried;
mod cells;
mod convection;
mod direct;
mod direct_light;
mod grid;
mod medium;
mod spreading;

pub use carried::{CarriedLight, check_courant, crossing_steps, largest_courant, refusal, unlit_by};
pub use cells::Cells;
pub use convection::{Carrying, Convection, SteadyLight, steady_light, steady_memory};
pub use direct::{Direct, DirectCost, DirectCounts, DirectParameters, STRATA};
pub use direct_light::DirectLight;
pub use grid::{DeviceLightGrid, LightGrid};
pub use medium::LitMedium;
pub use spreading::{Spreading, check_diffusion, largest_diffusion};
