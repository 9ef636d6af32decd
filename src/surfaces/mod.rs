//! Surfaces: what rays and photons meet besides the volume, as arrays for the device. The kernels are `cl/surfaces/`.

mod types;

pub use types::{DeviceBall, DeviceMaterial, DeviceNode, DeviceShape};
