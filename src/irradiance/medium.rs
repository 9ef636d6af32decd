//! The medium and its lights on the device.

use crate::Result;
use crate::device::{Arg, Buffer, Device, Program, ProgramSpec};
use crate::render::Plan;
use crate::render::method::MethodSetup;
use std::sync::Arc;

/// The medium and its lights as the kernels of scattering read them; see `cl/render/scattering.cl`.
pub struct LitMedium {
    /// `struct Frame`.
    pub frame: Buffer<u8>,
    /// `struct Volume`.
    pub volume: Buffer<u8>,
    /// `struct Scattering`.
    pub method: Buffer<u8>,
    /// The voxels.
    pub voxels: Arc<Buffer<u8>>,
    /// Majorants, extinction, albedo and emission tables, lights, the environment's probabilities: in the order in which
    /// `render_scattering` takes them.
    pub tables: Vec<Buffer<u8>>,
    /// The environment map.
    pub environment: Buffer<u8>,
    spec: ProgramSpec,
}

/// Tables of the scattering methods that do not depend on the camera: all but the last.
const TABLES: usize = 6;

impl LitMedium {
    /// Uploads what `transport`, the scattering method's setup for the plan's scene, reads.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device lacks memory.
    pub fn new(device: &Device, plan: &Plan<'_>, transport: &MethodSetup) -> Result<Self> {
        Self::around(device, plan, transport, Arc::new(plan.volume()?.grid.upload(device)?))
    }

    /// The same with the plan's voxels, which are on the device already.
    ///
    /// # Errors
    /// As [`LitMedium::new`].
    pub fn around(
        device: &Device,
        plan: &Plan<'_>,
        transport: &MethodSetup,
        voxels: Arc<Buffer<u8>>,
    ) -> Result<Self> {
        let planned = plan.volume()?;
        let upload = |bytes: &[u8]| Buffer::from_slice(device, bytes);
        let tables =
            transport.tables[..TABLES].iter().map(|table| upload(&table.bytes)).collect::<Result<_>>()?;
        let spec = transport
            .spec
            .clone()
            .define("VOXEL", planned.grid.device_type())
            .feature("ENVIRONMENT", plan.frame.environment_width > 0);
        Ok(Self {
            frame: upload(bytemuck::bytes_of(&plan.frame))?,
            volume: upload(bytemuck::bytes_of(&planned.device))?,
            method: upload(&transport.parameters.bytes)?,
            voxels,
            tables,
            environment: upload(&plan.environment.bytes)?,
            spec,
        })
    }

    /// Whether kernels are specialised by this definition.
    pub fn has(&self, feature: &str) -> bool {
        self.spec.defines.iter().any(|(name, _)| *name == feature)
    }

    /// Voxels of the padded buffer.
    pub fn voxel_count(&self) -> u64 {
        let bytes = match self.spec.defines.iter().find(|(name, _)| *name == "VOXEL") {
            Some((_, kind)) if kind.ends_with("char") => 1,
            Some((_, kind)) if kind.ends_with("short") => 2,
            _ => 4,
        };
        self.voxels.len() as u64 / bytes
    }

    /// The program of `entry`, a file below `cl/`, specialised for this medium; `adapt` adds what is its own.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] with the build log.
    pub fn program(
        &self,
        device: &Device,
        entry: &'static str,
        adapt: impl FnOnce(ProgramSpec) -> ProgramSpec,
    ) -> Result<Program> {
        let mut spec = self.spec.clone();
        spec.entry = entry;
        Program::build(device, &adapt(spec))
    }

    /// Frame, volume, method, voxels, then the first `tables` tables: how kernels of light volumes begin.
    pub fn arguments(&self, tables: usize) -> Vec<Arg<'_>> {
        [&self.frame, &self.volume, &self.method, &self.voxels]
            .into_iter()
            .chain(&self.tables[..tables])
            .map(Arg::from)
            .collect()
    }
}
