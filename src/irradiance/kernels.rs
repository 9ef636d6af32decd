//! The kernels of scattered light and how each of them is launched.

use super::cells::TABLES;
use super::channel::ChannelFields;
use super::limiter::LimiterKernels;
use super::scattered::ScatterSettings;
use super::{Cells, DeviceLightGrid, LightGrid, Limiter, LitMedium};
use crate::Result;
use crate::device::{Arg, Buffer, Device, Kernel, Program, ProgramSpec};
use glam::DVec3;

/// The grids as kernels take them, and what bounds the equation on them.
pub(super) struct Grids {
    /// Of the equation.
    pub grid: Buffer<DeviceLightGrid>,
    /// Of the direct light.
    pub fine: Buffer<DeviceLightGrid>,
    /// 2A of the sides per axis, negative at mirrors; the largest diffusivity.
    pub limits: Buffer<[f32; 4]>,
}

/// The built kernels, and the grids that they take.
pub(super) struct ScatterKernels {
    source: Kernel,
    channel: Kernel,
    border: Kernel,
    add_flux: Kernel,
    prolong: Kernel,
    drift: Kernel,
    coarse: LightGrid,
    direct_grid: LightGrid,
    pub grids: Grids,
    pub limiter: LimiterKernels,
    /// Largest diffusivity to begin with.
    most: f32,
    /// Stands in for what a medium does not have.
    nothing: Buffer<[f32; 4]>,
    /// Where in its cell light is scattered; one unused element until direct light tells.
    places: Buffer<[f32; 4]>,
    /// Whether it does.
    spread: bool,
}

impl ScatterKernels {
    pub fn build(
        device: &Device,
        medium: &LitMedium,
        coarse: &LightGrid,
        direct_grid: &LightGrid,
        settings: &ScatterSettings,
    ) -> Result<Self> {
        let source = medium.program(device, "irradiance/source.cl", |spec| spec)?;
        let program = Program::build(device, &ProgramSpec::new("irradiance/scattered.cl"))?;
        let kernel = |name| program.kernel(device, name);
        let longest = (coarse.cell * DVec3::from_array(coarse.dims.map(|n| n as f64))).max_element();
        let least = settings.floor / longest;
        let [x, y, z] =
            settings.reflection.map(|a| if a.is_finite() { 2.0 * a } else { -1.0 }).map(|a| a as f32);
        Ok(Self {
            source: source.kernel(device, "irradiance_source")?,
            channel: kernel("irradiance_channel")?,
            border: kernel("irradiance_border")?,
            add_flux: kernel("irradiance_add_flux")?,
            prolong: kernel("irradiance_prolong")?,
            drift: kernel("irradiance_drift")?,
            coarse: *coarse,
            direct_grid: *direct_grid,
            grids: Grids {
                grid: Buffer::from_slice(device, &[coarse.device()])?,
                fine: Buffer::from_slice(device, &[direct_grid.device()])?,
                limits: Buffer::from_slice(device, &[[x, y, z, (1.0 / (3.0 * least)) as f32]])?,
            },
            limiter: LimiterKernels::build(device, &program, settings.limiter, least, coarse.cells())?,
            // Streaming light has a diffusivity of about the length over which it spreads: from there less updates are
            // needed than from the floor's.
            most: if settings.limiter == Limiter::None { f64::INFINITY } else { longest / 3.0 } as f32,
            nothing: Buffer::zeroed(device, 1)?,
            places: Buffer::zeroed(device, 1)?,
            spread: false,
        })
    }

    fn cells(&self) -> [usize; 3] {
        [self.coarse.cells(), 1, 1]
    }

    fn count(&self) -> Arg<'static> {
        (self.coarse.cells() as u32).into()
    }

    /// The source of diffuse light.
    pub fn source(
        &mut self,
        device: &Device,
        medium: &LitMedium,
        (direct, extent): (&Buffer<[f32; 4]>, Option<&Buffer<[f32; 4]>>),
        cells: &Cells,
        source: &Buffer<[f32; 4]>,
        forward: f32,
    ) -> Result<()> {
        let items = self.cells();
        let mut arguments = medium.arguments(TABLES);
        arguments.extend([&self.grids.grid, &self.grids.fine].map(Arg::from));
        self.spread = extent.is_some();
        if self.spread && self.places.len() != self.coarse.cells() {
            self.places = Buffer::zeroed(device, self.coarse.cells())?;
        }
        arguments.extend([direct, cells.glow.as_ref().unwrap_or(&self.nothing)].map(Arg::from));
        arguments.extend([extent.unwrap_or(&self.nothing), source, &self.places].map(Arg::from));
        arguments.extend([forward.into(), u32::from(self.spread).into()]);
        self.source.enqueue(device, &arguments, items)
    }

    /// The equation of a channel, with its source times `scale`.
    pub fn channel(
        &mut self,
        device: &Device,
        cells: &Cells,
        source: &Buffer<[f32; 4]>,
        fields: &ChannelFields,
        (forward, scale): (f32, f32),
        channel: usize,
    ) -> Result<()> {
        let items = self.cells();
        let mut arguments = vec![(&self.grids.grid).into()];
        arguments.extend([&cells.scattering, &cells.absorption, source, &self.places].map(Arg::from));
        arguments.push((&self.grids.limits).into());
        let ChannelFields { absorption, transport, diffusivity, power, .. } = fields;
        arguments.extend([absorption, transport, diffusivity, power].map(Arg::from));
        arguments.extend([forward.into(), self.most.into(), scale.into()]);
        arguments.extend([channel as u32, u32::from(self.spread)].map(Arg::from));
        self.channel.enqueue(device, &arguments, items)
    }

    /// A channel of so many, times `scale`, into the fluence with a border; a single one into all three.
    pub fn border(
        &mut self,
        device: &Device,
        phi: &Buffer<f32>,
        fields: &ChannelFields,
        bordered: &Buffer<[f32; 4]>,
        scale: f32,
        [channel, channels]: [usize; 2],
    ) -> Result<()> {
        let copies = if channels == 1 { 3_u32 } else { 1 };
        let arguments = [
            (&self.grids.grid).into(),
            (&self.grids.limits).into(),
            phi.into(),
            (&fields.diffusivity).into(),
            bordered.into(),
            scale.into(),
            (channel as u32).into(),
            copies.into(),
        ];
        self.border.enqueue(device, &arguments, self.coarse.dims.map(|n| n + 2))
    }

    /// Adds a share of a flux to another.
    pub fn add_flux(
        &mut self,
        device: &Device,
        flux: &Buffer<[f32; 4]>,
        total: &Buffer<[f32; 4]>,
        share: f32,
    ) -> Result<()> {
        let arguments = [flux.into(), total.into(), share.into(), self.count()];
        let items = self.cells();
        self.add_flux.enqueue(device, &arguments, items)
    }

    /// The bordered fluence on the direct light's grid.
    pub fn prolong(
        &mut self,
        device: &Device,
        bordered: &Buffer<[f32; 4]>,
        fluence: &Buffer<[f32; 4]>,
    ) -> Result<()> {
        let arguments =
            [(&self.grids.grid).into(), (&self.grids.fine).into(), bordered.into(), fluence.into()];
        self.prolong.enqueue(device, &arguments, [self.direct_grid.cells(), 1, 1])
    }

    /// The drift from diffuse flux, diffuse fluence, direct light, the same reduced, and its flow.
    pub fn drift(&mut self, device: &Device, lights: [&Buffer<[f32; 4]>; 6]) -> Result<()> {
        let grids = [&self.grids.grid, &self.grids.fine].map(Arg::from);
        let arguments: Vec<Arg<'_>> = grids.into_iter().chain(lights.map(Arg::from)).collect();
        self.drift.enqueue(device, &arguments, [self.direct_grid.cells(), 1, 1])
    }
}
