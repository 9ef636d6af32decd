//! Light volumes: the light in every cell of a grid over the volume, whatever the camera (Zhang & Ma 2013; Lesar, Bohak
//! and Marolt's hybrid diffusion).
//!
//! Direct light comes first, then what the medium scatters; the cameras project the sum. Fluences are in W/m² of the
//! scene's lights, as irradiances and π-less radiances integrated over directions; lengths are local units.
//!
//! - `grid`: the cells
//! - `medium`: the medium and its lights on the device, as the kernels of scattering read them
//! - `direct`, `direct_setup`: direct light by tracking towards the lights
//! - `direct_light`: direct light, however it was computed

mod direct;
mod direct_light;
mod direct_setup;
mod grid;
mod medium;

pub use direct::{Direct, DirectCost, DirectCounts, STRATA};
pub use direct_light::DirectLight;
pub use direct_setup::DirectParameters;
pub use grid::{DeviceLightGrid, LightGrid};
pub use medium::LitMedium;
