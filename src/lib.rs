//! svetlo renders volumes on any OpenCL device: a scene in TOML goes in, a progressive EXR image comes out.
//!
//! Dependencies point one way: `config` (TOML with spans) → `scene` (validated) → `device`
//! (the only place that knows OpenCL) → `render` → `film` → `picture` (EXR, PNG).

pub mod bench;
pub mod caustics;
pub mod cli;
pub mod cluster;
pub mod config;
pub mod crew;
pub mod device;
pub mod diffusion;
pub mod error;
pub mod film;
mod host_memory;
mod input;
pub mod irradiance;
pub mod metrics;
pub mod picture;
pub mod post;
pub mod reference;
pub mod render;
pub mod report;
pub mod scene;
pub mod selftest;
pub mod sort;
pub mod surfaces;
pub mod transfer;
pub mod volume;

pub use error::{Error, Result};
