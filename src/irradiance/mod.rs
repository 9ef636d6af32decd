//! Light volumes: the light in every cell of a grid over the volume, whatever the camera (Zhang & Ma 2013; Lesar, Bohak
//! and Marolt's hybrid diffusion).
//!
//! Direct light comes first, then what the medium scatters; the cameras project the sum. Fluences are in W/m² of the
//! scene's lights, as irradiances and π-less radiances integrated over directions; lengths are local units.
//!
//! - `grid`: the cells
//! - `medium`, `cells`: the medium and its lights on the device, as kernels of scattering read them, and its averages
//! - `direct_light`: unscattered light, however it was computed
//! - `direct`, `direct_setup`: by tracking towards the lights
//! - `carried`, `convection`: by upwind convection, in steps or at once
//! - `spreading`: scattered light by explicit diffusion
//! - `scattered`, `channel`, `limiter`, `kernels`: scattered light by the steady diffusion equation
//! - `lighting`: how a light volume comes to be, step by step
//! - `light`, `file`: what cameras project, on the device, as numbers, and in files

mod carried;
mod cells;
mod channel;
mod convection;
mod direct;
mod direct_light;
mod direct_setup;
mod file;
mod grid;
mod kernels;
mod light;
mod lighting;
mod limiter;
mod medium;
mod scattered;
mod spreading;

pub use carried::{CarriedLight, check_courant, crossing_steps, largest_courant, refusal, unlit_by};
pub use cells::Cells;
pub use convection::{Carrying, Convection, SteadyLight, steady_light, steady_memory};
pub use direct::{Direct, DirectCost, DirectCounts, STRATA};
pub use direct_light::DirectLight;
pub use direct_setup::DirectParameters;
pub use grid::{DeviceLightGrid, LightGrid};
pub use light::{Directions, LightBuffers, LightData};
pub use lighting::{LightFacts, Lighting, memory, memory_of};
pub use limiter::Limiter;
pub use medium::LitMedium;
pub use scattered::{
    ChannelFacts, ScatterObserver, ScatterProgress, ScatterSettings, ScatterSolver, ScatteredLight, solve,
};
pub use spreading::{Spreading, check_diffusion, largest_diffusion};
