//! What a rendering method is to the rest: a program, and the data its kernel reads.

use super::caustics::CausticsSetup;
use super::grid::{BrickRanges, Grid};
use super::light_volume::LightSetup;
use super::local::LocalFrame;
use super::{emission_absorption, isosurface, light_volume, mip, scattering};
use crate::device::ProgramSpec;
use crate::picture::Environment;
use crate::scene::{Method, Scene};
use crate::{Error, Result, device_struct};

device_struct! {
    "types/frame.cl",
    /// What does not change between the launches of one render; see `cl/types/frame.cl`.
    pub struct DeviceFrame {
        /// Radiance behind everything, or the factor of the environment map.
        pub background: [f32; 4],
        /// Low half of the seed.
        pub seed_low: u32,
        /// High half of the seed.
        pub seed_high: u32,
        /// Environment map width in texels.
        pub environment_width: u32,
        /// Environment map height in texels.
        pub environment_height: u32,
        /// Rotation of the environment map about +y, in turns.
        pub environment_turn: f32,
        /// Number of lights.
        pub light_count: u32,
        /// Entries of the transfer function's table.
        pub table_size: u32,
        /// Rows of a 2-D table, 1 otherwise.
        pub table_rows: u32,
        /// Row of the table per gradient of the value (in entries) per local unit.
        pub gradient_scale: f32,
        /// Number of lights that are rectangles, the first ones.
        pub rectangle_count: u32,
        /// Probability with which the environment map is picked for a sample.
        pub environment_pick: f32,
        /// Number of the render's first sample in the whole picture.
        pub sample_first: u32,
        /// ... and from each sample to the next.
        pub sample_stride: u32,
        /// Padding.
        pub pad_0: u32,
        /// Padding.
        pub pad_1: u32,
        /// Padding.
        pub pad_2: u32,
    }
}

/// Bytes that a kernel reads, in the kernel's argument order.
pub struct HostBuffer {
    /// What it is, for the memory plan.
    pub name: &'static str,
    /// The bytes.
    pub bytes: Vec<u8>,
}

impl HostBuffer {
    /// A buffer of device values.
    pub fn new<T: bytemuck::Pod>(name: &'static str, values: &[T]) -> Self {
        Self { name, bytes: bytemuck::cast_slice(values).to_vec() }
    }
}

/// A method made ready for one scene, still on the host.
pub struct MethodSetup {
    /// The program and the definitions this method adds.
    pub spec: ProgramSpec,
    /// The kernel.
    pub kernel: &'static str,
    /// The method's parameter struct.
    pub parameters: HostBuffer,
    /// What the kernel reads between the voxels and the environment map, in argument order.
    pub tables: Vec<HostBuffer>,
    /// The kernel's unit of values per window value: 1, or the intervals of its table.
    pub value_units: f64,
    /// Whether a ray's result depends on random numbers of the method's own.
    pub random: bool,
    /// Whether the kernel has a form that works on eight samples at a time (`LANES`).
    pub lanes: bool,
    /// Whether the kernel follows paths: many side by side on CPUs, with a ledger and auxiliary images.
    pub paths: bool,
    /// Whether the method measures a depth.
    pub has_depth: bool,
    /// What the user should know, one sentence each.
    pub notes: Vec<String>,
    /// How the method goes about it, one sentence each: for `check` alone.
    pub details: Vec<String>,
    /// What computes the light in the volume, for methods that project it.
    pub light: Option<Box<LightSetup>>,
    /// What traces and gathers photons, for caustics.
    pub caustics: Option<Box<CausticsSetup>>,
}

/// What a method is made ready from.
pub struct MethodInput<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The voxels and their window.
    pub grid: &'a Grid<'a>,
    /// Bounds of the field.
    pub bricks: &'a BrickRanges,
    /// Local units.
    pub local: &'a LocalFrame,
    /// The window in data units.
    pub window: (f64, f64),
    /// The environment map, where the scene has one.
    pub environment: Option<&'a Environment>,
}

/// Makes the scene's method ready; fills what it knows of `frame`.
///
/// # Errors
/// [`crate::Error::Input`] when a file it needs cannot be read.
pub fn prepare(input: &MethodInput<'_>, frame: &mut DeviceFrame) -> Result<MethodSetup> {
    match &input.scene.method {
        Method::Mip { color } => Ok(mip::prepare(input, color)),
        Method::Isosurface { value, domain, material } => {
            Ok(isosurface::prepare(input, *value, *domain, material, frame))
        }
        &Method::EmissionAbsorption { radiance, quadrature, termination } => {
            let settings = emission_absorption::Settings { radiance, quadrature, termination };
            emission_absorption::prepare(input, settings, frame)
        }
        &Method::Scattering(settings) => scattering::prepare(input, settings, frame),
        &Method::LightVolume(settings) => light_volume::prepare(input, settings, frame),
        Method::Caustics(_) => Err(Error::Input("caustics are of surfaces, not of a volume".into())),
    }
}
