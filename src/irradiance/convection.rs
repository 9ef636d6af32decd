//! Direct light by upwind convection, one box per light (Zhang & Ma 2013, equation 8): the kernels are
//! `cl/irradiance/convection.cl`.
//!
//! What is carried is the share of a light's own light that reaches a cell, 1 where nothing lies between; the fluence is
//! that times the irradiance, or times I/r² of a point light, so that light spreads as it travels without being carried
//! by a diverging flow. [`Convection`] takes explicit steps from darkness, as the paper; [`steady_light`] gives at once
//! what steps tend to, but for the first order in the extinction of a step. Both are of first order in the cells, and
//! both smear the edges of shadows: light that goes n cells is spread by about the root of n.

use super::carried::{CarriedLight, check_courant};
use super::{Cells, DeviceLightGrid, DirectLight, LightGrid};
use crate::Result;
use crate::device::{Arg, Buffer, Device, Kernel, MemoryPlan, Program, ProgramSpec};
use crate::render::local::LocalFrame;
use crate::scene::{Light, Phase, Scene};

/// What of the medium matters to convection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Carrying {
    /// Whether the extinction differs between the channels.
    pub chromatic: bool,
    /// Mean cosine of the phase function.
    pub mean_cosine: f64,
    /// Whether the phase function has directions at all: then the direct light's mean direction is kept.
    pub directed: bool,
}

impl Carrying {
    /// What a scene's medium has.
    pub fn of(scene: &Scene) -> Self {
        Self {
            chromatic: scene.scattering.extinction_color.is_some(),
            mean_cosine: scene.phase.mean_cosine(),
            directed: scene.phase != Phase::Isotropic,
        }
    }
}

/// Explicit steps of every light.
pub struct Convection {
    base: Base,
    kernels: Kernels,
    carried: Vec<Carried>,
    decay: Buffer<f32>,
    /// The way of light in a step, local units.
    time: f64,
    directed: bool,
    direct: DirectLight,
    steps: u64,
}

impl Convection {
    /// Darkness, before the first step of `courant`: the way of light over the smallest edge of a cell. Rectangles are
    /// not carried: see [`refusal`](super::refusal).
    ///
    /// # Errors
    /// [`crate::Error::Input`] when `courant` is unstable, [`crate::Error::Failed`] when the device lacks memory.
    pub fn new(
        device: &Device,
        grid: &LightGrid,
        cells: &Cells,
        lights: &[Light],
        local: &LocalFrame,
        carrying: Carrying,
        courant: f64,
    ) -> Result<Self> {
        check_courant(courant, lights, grid, local)?;
        let mut kernels = Kernels::build(device, carrying.chromatic)?;
        let base = Base::new(device, grid)?;
        let time = courant * grid.cell.min_element();
        let decay = Buffer::uninitialised(device, kernels.channels * grid.cells())?;
        let arguments = [
            (&decay).into(),
            (&cells.scattering).into(),
            (&cells.absorption).into(),
            (&base.grid).into(),
            (time as f32).into(),
        ];
        kernels.decay.enqueue(device, &arguments, grid.dims)?;
        let carried = lights
            .iter()
            .filter_map(|light| CarriedLight::new(light, grid, local))
            .map(|light| Carried::new(device, &base, &mut kernels, cells, light))
            .collect::<Result<_>>()?;
        let directed = carrying.directed;
        let direct = base.dark(device, directed, false)?;
        Ok(Self { base, kernels, carried, decay, time, directed, direct, steps: 0 })
    }

    /// Takes steps; waits for none of them.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device fails.
    pub fn advance(&mut self, device: &Device, steps: u32) -> Result<()> {
        for _ in 0..steps {
            for carried in &mut self.carried {
                carried.step(device, &self.base, &mut self.kernels, &self.decay, self.time)?;
            }
        }
        self.steps += u64::from(steps);
        Ok(())
    }

    /// Steps taken.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The fluence of all lights after the steps taken so far; `reduced` is left out, whatever the phase function: what
    /// goes on forward is not known to steps with the whole extinction.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device fails.
    pub fn direct(&mut self, device: &Device) -> Result<&DirectLight> {
        let flow = self.direct.flow.as_ref().filter(|_| self.directed);
        for (number, carried) in self.carried.iter().enumerate() {
            let add = Addition { fluence: &self.direct.fluence, flow, first: number == 0 };
            self.kernels.add(device, &self.base, &carried.shares[carried.now], &carried.light, &add)?;
        }
        if let Some(flow) = flow {
            self.kernels.flow.enqueue(
                device,
                &[flow.into(), (&self.base.grid).into()],
                self.base.host.dims,
            )?;
        }
        Ok(&self.direct)
    }

    /// What [`Convection::direct`] gave last, for good.
    pub fn into_direct(self) -> DirectLight {
        self.direct
    }

    /// What it takes on the device.
    pub fn memory(grid: &LightGrid, lights: usize, carrying: Carrying) -> MemoryPlan {
        let mut plan = MemoryPlan::default();
        let channels = channels(carrying.chromatic) as u64;
        for light in 0..lights {
            for half in ["now", "next"] {
                plan.add(
                    &format!("share of light {light}, {half}"),
                    channels * padded(grid),
                    size_of::<f32>(),
                );
            }
        }
        plan.add("extinction of a step", channels * grid.cells() as u64, size_of::<f32>());
        add_direct(&mut plan, grid, carrying.directed, false);
        plan
    }
}

/// Steady light and what it took.
pub struct SteadyLight {
    /// The fluence of all lights.
    pub direct: DirectLight,
    /// Launches of the sweeps, over all lights: one for each level of cells.
    pub launches: u32,
}

/// The steady state of convection, by one sweep for each light, and a second one with the reduced extinction where
/// the phase function's mean cosine is not 0. Rectangles are not carried: see [`refusal`](super::refusal).
///
/// # Errors
/// [`crate::Error::Failed`] when the device lacks memory or fails.
pub fn steady_light(
    device: &Device,
    grid: &LightGrid,
    cells: &Cells,
    lights: &[Light],
    local: &LocalFrame,
    carrying: Carrying,
) -> Result<SteadyLight> {
    let base = Base::new(device, grid)?;
    let reduces = carrying.mean_cosine != 0.0;
    let direct = base.dark(device, carrying.directed, reduces)?;
    let lights: Vec<CarriedLight> =
        lights.iter().filter_map(|light| CarriedLight::new(light, grid, local)).collect();
    let mut launches = 0;
    let mut sweeps =
        |coloured: bool, counted: f64, fluence: &Buffer<[f32; 4]>, flow: Option<_>| -> Result<()> {
            let mut kernels = Kernels::build(device, coloured)?;
            let shares = kernels.darkness(device, &base)?;
            for (number, light) in lights.iter().enumerate() {
                let buffer = Buffer::from_slice(device, &[*light])?;
                launches += kernels.settle(device, &base, cells, (light, &buffer), counted, &shares)?;
                let add = Addition { fluence, flow, first: number == 0 };
                kernels.add(device, &base, &shares, &buffer, &add)?;
            }
            if let Some(flow) = flow {
                kernels.flow.enqueue(device, &[flow.into(), (&base.grid).into()], grid.dims)?;
            }
            Ok(())
        };
    sweeps(carrying.chromatic, 1.0, &direct.fluence, direct.flow.as_ref())?;
    if let Some(reduced) = &direct.reduced {
        // What absorbs and what scatters differ by the albedo's colour.
        sweeps(true, 1.0 - carrying.mean_cosine, reduced, None)?;
    }
    Ok(SteadyLight { direct, launches })
}

/// What [`steady_light`] takes on the device.
pub fn steady_memory(grid: &LightGrid, carrying: Carrying) -> MemoryPlan {
    let mut plan = MemoryPlan::default();
    let reduces = carrying.mean_cosine != 0.0;
    let mut shares = vec![("share of a light", carrying.chromatic)];
    if reduces {
        shares.push(("reduced share of a light", true));
    }
    for (name, coloured) in shares {
        plan.add(name, channels(coloured) as u64 * padded(grid), size_of::<f32>());
    }
    add_direct(&mut plan, grid, carrying.directed, reduces);
    plan
}

fn add_direct(plan: &mut MemoryPlan, grid: &LightGrid, directed: bool, reduces: bool) {
    let fields = [("direct fluence", true), ("direction of light", directed), ("reduced fluence", reduces)];
    for (name, _) in fields.into_iter().filter(|(_, wanted)| *wanted) {
        plan.add(name, grid.cells() as u64, size_of::<[f32; 4]>());
    }
}

fn channels(coloured: bool) -> usize {
    if coloured { 4 } else { 1 }
}

/// Elements of a box with padding.
pub(super) fn padded(grid: &LightGrid) -> u64 {
    padded_dims(grid).into_iter().map(|n| n as u64).product()
}

/// Cells of a box with padding, per axis.
pub(super) fn padded_dims(grid: &LightGrid) -> [usize; 3] {
    grid.dims.map(|n| n + 2)
}

/// The grid, on both sides.
struct Base {
    host: LightGrid,
    grid: Buffer<DeviceLightGrid>,
}

impl Base {
    fn new(device: &Device, grid: &LightGrid) -> Result<Self> {
        Ok(Self { host: *grid, grid: Buffer::from_slice(device, &[grid.device()])? })
    }

    fn dark(&self, device: &Device, directed: bool, reduces: bool) -> Result<DirectLight> {
        let field = || Buffer::zeroed(device, self.host.cells());
        Ok(DirectLight {
            fluence: field()?,
            reduced: reduces.then(field).transpose()?,
            flow: directed.then(field).transpose()?,
            extent: None,
        })
    }
}

/// A light on its way.
struct Carried {
    host: CarriedLight,
    light: Buffer<CarriedLight>,
    shares: [Buffer<f32>; 2],
    /// Which of the two is the present.
    now: usize,
}

impl Carried {
    fn new(
        device: &Device,
        base: &Base,
        kernels: &mut Kernels,
        cells: &Cells,
        host: CarriedLight,
    ) -> Result<Self> {
        let shares = [kernels.darkness(device, base)?, kernels.darkness(device, base)?];
        let light = Buffer::from_slice(device, &[host])?;
        for shares in &shares {
            kernels.hold(device, base, cells, (&host, &light), 1.0, shares)?;
        }
        Ok(Self { host, light, shares, now: 0 })
    }

    fn step(
        &mut self,
        device: &Device,
        base: &Base,
        kernels: &mut Kernels,
        decay: &Buffer<f32>,
        time: f64,
    ) -> Result<()> {
        let (now, next) = (&self.shares[self.now], &self.shares[1 - self.now]);
        self.now = 1 - self.now;
        let dims = base.host.dims;
        let mut arguments: Vec<Arg<'_>> = vec![next.into(), now.into(), decay.into(), (&base.grid).into()];
        if self.host.is_point() {
            let CarriedLight { place, cell: [x, y, z, _], .. } = self.host;
            arguments.push((time as f32).into());
            arguments.extend(place.map(Arg::from));
            arguments.extend([x, y, z].map(|source| Arg::from(source as u32)));
            arguments.extend(base.host.cell.to_array().map(|edge| Arg::from(edge as f32)));
            return kernels.step_point.enqueue(device, &arguments, dims);
        }
        let edges = base.host.cell.to_array();
        let strides = [1, dims[0] + 2, (dims[0] + 2) * (dims[1] + 2)];
        arguments.extend((0..3).map(|a| {
            let moved = f64::from(self.host.place[a].abs()) * time / edges[a];
            (moved as f32).into()
        }));
        // Of two's complement.
        let behind =
            |a: usize| if self.host.place[a] < 0.0 { strides[a] as i32 } else { -(strides[a] as i32) };
        arguments.extend((0..3).map(|a| (behind(a) as u32).into()));
        kernels.step.enqueue(device, &arguments, dims)
    }
}

/// Where a light's fluence goes.
struct Addition<'a> {
    fluence: &'a Buffer<[f32; 4]>,
    flow: Option<&'a Buffer<[f32; 4]>>,
    /// Whether what was there before is overwritten.
    first: bool,
}

/// The kernels for shares of one channel or of four.
struct Kernels {
    begin: Kernel,
    decay: Kernel,
    step: Kernel,
    step_point: Kernel,
    settle: Kernel,
    hold: Kernel,
    add: Kernel,
    add_flux: Kernel,
    flow: Kernel,
    channels: usize,
}

impl Kernels {
    fn build(device: &Device, coloured: bool) -> Result<Self> {
        let spec = ProgramSpec::new("irradiance/convection.cl").feature("COLOURED", coloured);
        let program = Program::build(device, &spec)?;
        Ok(Self {
            begin: program.kernel(device, "convection_begin")?,
            decay: program.kernel(device, "convection_decay")?,
            step: program.kernel(device, "convection_step")?,
            step_point: program.kernel(device, "convection_step_point")?,
            settle: program.kernel(device, "convection_settle")?,
            hold: program.kernel(device, "convection_hold")?,
            add: program.kernel(device, "convection_add")?,
            add_flux: program.kernel(device, "convection_add_flux")?,
            flow: program.kernel(device, "convection_flow")?,
            channels: channels(coloured),
        })
    }

    /// A new box of darkness, with light all around.
    fn darkness(&mut self, device: &Device, base: &Base) -> Result<Buffer<f32>> {
        let shares = Buffer::uninitialised(device, self.channels * padded(&base.host) as usize)?;
        let arguments = [(&shares).into(), (&base.grid).into()];
        self.begin.enqueue(device, &arguments, padded_dims(&base.host))?;
        Ok(shares)
    }

    /// Gives the cells about a point light in the box what they keep.
    fn hold(
        &mut self,
        device: &Device,
        base: &Base,
        cells: &Cells,
        (host, light): (&CarriedLight, &Buffer<CarriedLight>),
        counted: f64,
        shares: &Buffer<f32>,
    ) -> Result<()> {
        if !host.holds() {
            return Ok(());
        }
        let arguments = [
            shares.into(),
            (&cells.scattering).into(),
            (&cells.absorption).into(),
            (&base.grid).into(),
            light.into(),
            (counted as f32).into(),
        ];
        self.hold.enqueue(device, &arguments, base.host.dims)
    }

    /// One sweep; returns its launches.
    fn settle(
        &mut self,
        device: &Device,
        base: &Base,
        cells: &Cells,
        (host, light): (&CarriedLight, &Buffer<CarriedLight>),
        counted: f64,
        shares: &Buffer<f32>,
    ) -> Result<u32> {
        self.hold(device, base, cells, (host, light), counted, shares)?;
        let [first, last] = host.levels(&base.host);
        let sides = 1 + usize::from(host.within_x(&base.host));
        for level in first..=last {
            let arguments = [
                shares.into(),
                (&cells.scattering).into(),
                (&cells.absorption).into(),
                (&base.grid).into(),
                light.into(),
                (counted as f32).into(),
                level.into(),
            ];
            self.settle.enqueue(device, &arguments, [base.host.dims[1], base.host.dims[2], sides])?;
        }
        Ok(last - first + 1)
    }

    /// Adds what a light brings.
    fn add<'a>(
        &mut self,
        device: &Device,
        base: &'a Base,
        shares: &'a Buffer<f32>,
        light: &'a Buffer<CarriedLight>,
        to: &Addition<'a>,
    ) -> Result<()> {
        let arguments = |target: &'a Buffer<[f32; 4]>| -> [Arg<'a>; 5] {
            [target.into(), shares.into(), (&base.grid).into(), light.into(), u32::from(to.first).into()]
        };
        self.add.enqueue(device, &arguments(to.fluence), base.host.dims)?;
        match to.flow {
            Some(flow) => self.add_flux.enqueue(device, &arguments(flow), base.host.dims),
            None => Ok(()),
        }
    }
}
