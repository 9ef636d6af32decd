//! The device layer: the only place that names OpenCL.
//!
//! - [`catalog`]: what platforms and devices exist, and the selectors that pick one
//! - [`context`]: one opened device with its context and queue
//! - [`buffer`], [`program`], [`kernel`]: memory, specialised programs, checked launches
//! - [`faults`]: calls that fail on demand, for tests
//! - [`layout`]: structs shared with kernels, and the probe that proves their layout
//! - [`memory`]: the memory plan and its pre-flight
//! - [`pacing`]: launch sizes from measured time
//!
//! One context, queue and program per device. Nothing outside this module holds an OpenCL handle.
#![allow(unsafe_code)]

mod api;
pub mod buffer;
mod cache;
pub mod catalog;
pub mod context;
pub mod faults;
pub mod kernel;
pub mod layout;
pub mod memory;
pub mod pacing;
pub mod program;
mod source;

pub use buffer::Buffer;
pub use catalog::{Catalog, DeviceInfo, DeviceKind, DeviceName};
pub use context::Device;
pub use faults::{Call, Faults};
pub use kernel::{Arg, Kernel};
pub use memory::MemoryPlan;
pub use pacing::{LAUNCH_TARGET, Pacer};
pub use program::{Program, ProgramSpec};
pub use source::sources_hash;
