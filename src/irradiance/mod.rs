//! Light volumes: the light in every cell of a grid over the volume, whatever the camera (Zhang & Ma 2013; Lesar, Bohak
//! and Marolt's hybrid diffusion).
//!
//! Direct light comes first, then what the medium scatters; the cameras project the sum. Fluences are in W/m² of the
//! scene's lights, as irradiances and π-less radiances integrated over directions; lengths are local units.
//!
//! - `grid`: the cells
//! - `medium`: the medium and its lights on the device, as the kernels of scattering read them
//! - `cells`: averages of the medium over cells
//! - `direct_light`: what reaches the cells unscattered
//! - `scattered`, `channel`, `limiter`, `kernels`: what the medium scatters

mod cells;
mod channel;
mod direct_light;
mod grid;
mod kernels;
mod limiter;
mod medium;
mod scattered;

pub use cells::Cells;
pub use direct_light::DirectLight;
pub use grid::{DeviceLightGrid, LightGrid};
pub use limiter::Limiter;
pub use medium::LitMedium;
pub use scattered::{
    ChannelFacts, ScatterObserver, ScatterProgress, ScatterSettings, ScatterSolver, ScatteredLight, solve,
};
