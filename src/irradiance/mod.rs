//! Light volumes: the light in every cell of a grid over the volume, whatever the camera (Zhang & Ma 2013; Lesar, Bohak
//! and Marolt's hybrid diffusion).
//!
//! Direct light comes first, then what the medium scatters; the cameras project the sum. Fluences are in W/m² of the
//! scene's lights, as irradiances and π-less radiances integrated over directions; lengths are local units.
//!
//! - `grid`: the cells
//! - `medium`: the medium and its lights on the device, as the kernels of scattering read them
//! - `cells`: averages of the medium over cells

mod cells;
mod grid;
mod medium;

pub use cells::Cells;
pub use grid::{DeviceLightGrid, LightGrid};
pub use medium::LitMedium;
