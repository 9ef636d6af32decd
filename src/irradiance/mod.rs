//! Light volumes: the light in every cell of a grid over the volume, whatever the camera (Zhang & Ma 2013; Lesar, Bohak
//! and Marolt's hybrid diffusion).
//!
//! Direct light comes first, then what the medium scatters; the cameras project the sum. Fluences are in W/m² of the
//! scene's lights, as irradiances and π-less radiances integrated over directions; lengths are local units.
//!
//! - `grid`: the cells
//! - `medium`: the medium and its lights on the device, as the kernels of scattering read them
//! - `direct_light`: unscattered light
//! - `light`, `file`: what cameras project, on the device, as numbers, and in files
//! - `lighting`: how it comes to be, step by step

mod direct_light;
mod file;
mod grid;
mod light;
mod lighting;
mod medium;

pub use direct_light::DirectLight;
pub use grid::{DeviceLightGrid, LightGrid};
pub use light::{Directions, LightBuffers, LightData};
pub use lighting::{LightFacts, Lighting, ScatteredLight};
pub use medium::LitMedium;
