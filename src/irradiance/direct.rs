//! Direct light by null-collision tracking from every cell towards the lights; kernels: `cl/irradiance/direct.cl`.

use super::cells::TABLES;
use super::direct_setup::{BLOCK_SHIFT, DirectParameters, Wanted, block_shifts, parameters};
use super::{DirectLight, LightGrid, LitMedium};
use crate::device::{Arg, Buffer, Device, Kernel, LAUNCH_TARGET, MemoryPlan, Pacer};
use crate::scene::Phase;
use crate::{Error, Result, device_struct};
use serde::{Deserialize, Serialize};

device_struct! {
    "types/irradiance.cl",
    /// What rays cost, a share of it; see `cl/types/irradiance.cl`.
    pub struct DirectCounts {
        /// Look-ups of the medium, low half.
        pub lookups_low: u32,
        /// High half.
        pub lookups_high: u32,
        /// Those outside the bounds of their bricks.
        pub above: u32,
        /// Passes that were not followed to their ends.
        pub unfinished: u32,
    }
}

/// Passes that are stratified together, a power of two up to 64. The groups are independent, and their spread tells the
/// variance.
pub const STRATA: u32 = 16;
/// Counters that work-items share.
const COUNTS: usize = 1024;

/// What the rays of all passes cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DirectCost {
    /// Rays: one per cell and pass towards the lights, one into the background where it is not among them.
    pub rays: u64,
    /// Look-ups of the medium on their ways.
    pub lookups: u64,
    /// Look-ups that found an extinction outside its bounds. Anything but 0 is a mistake of this program.
    pub above_majorant: u64,
}

/// The direct light of all cells, pass by pass: bit for bit the same however launches are cut.
pub struct Direct {
    programs: Option<Programs>,
    grid: LightGrid,
    grid_buffer: Buffer<u8>,
    parameters: Buffer<DirectParameters>,
    /// Of which part of each cell its light is the mean; `None` where centres stand for all cells.
    extents: Option<Buffer<[f32; 2]>>,
    state: State,
    counts: Buffer<DirectCounts>,
    wanted: Wanted,
    lanes: u32,
    blocks: u64,
    pacer: Pacer,
    launch_limit: u64,
    passes: u32,
    /// Blocks of the next pass that are done.
    ahead: u64,
}

/// Kernels; there are none in the dark.
struct Programs {
    pass: Kernel,
    means: Kernel,
    /// Stands in for the extents of cells.
    no_extents: Buffer<[f32; 2]>,
}

/// Running means, as sums of two floats; what is not asked for is one unused element.
struct State {
    fluence: Buffer<TwoFloat4>,
    group: Buffer<f32>,
    reduced: Buffer<TwoFloat4>,
    flow: Buffer<TwoFloat4>,
    /// Where in their cells light is scattered.
    moment: Buffer<[f32; 4]>,
}

/// Mirrors `struct TwoFloat4` of the kernels, which alone look into it.
type TwoFloat4 = [[f32; 4]; 2];

impl Direct {
    /// Makes the direct light of `grid`'s cells ready, for a medium with this phase function.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device lacks memory, or building fails.
    pub fn new(device: &Device, medium: &LitMedium, grid: &LightGrid, phase: &Phase) -> Result<Self> {
        Self::with_lanes(device, medium, grid, phase, device.info().lanes(medium.voxel_count()))
    }

    /// As [`Direct::new`], with so many rays side by side in a work-item: 1, 4, 8 or 16.
    ///
    /// # Errors
    /// As [`Direct::new`].
    pub fn with_lanes(
        device: &Device,
        medium: &LitMedium,
        grid: &LightGrid,
        phase: &Phase,
        lanes: u32,
    ) -> Result<Self> {
        let mut wanted = Wanted::new(device, medium, phase)?;
        let shifts = block_shifts(grid.dims);
        let parameters = parameters(device, medium, phase, shifts)?;
        let dark = !wanted.lights && !wanted.sky;
        let extents = if dark { None } else { extents(device, medium, grid)? };
        wanted.exact &= extents.is_none();
        let spread = extents.is_some();
        let programs =
            if dark { None } else { Some(Programs::build(device, medium, wanted, spread, lanes)?) };
        let cells = grid.cells();
        let only = |is: bool| if is { cells } else { 1 };
        let blocks = (0..3).map(|axis| grid.dims[axis].div_ceil(1 << shifts[axis]) as u64).product();
        Ok(Self {
            programs,
            grid: *grid,
            grid_buffer: Buffer::from_slice(device, bytemuck::bytes_of(&grid.device()))?,
            parameters: Buffer::from_slice(device, &[parameters])?,
            extents,
            state: State {
                fluence: Buffer::zeroed(device, cells)?,
                group: Buffer::zeroed(device, cells)?,
                reduced: Buffer::zeroed(device, only(wanted.reduced))?,
                flow: Buffer::zeroed(device, only(wanted.flow))?,
                moment: Buffer::zeroed(device, only(spread))?,
            },
            counts: Buffer::zeroed(device, COUNTS)?,
            wanted,
            lanes,
            blocks,
            pacer: Pacer::new(LAUNCH_TARGET),
            launch_limit: u64::MAX,
            passes: 0,
            ahead: 0,
        })
    }

    /// Device memory that the direct light of a grid takes, at most: the state and one [`DirectLight`].
    pub fn memory(grid: &LightGrid, phase: &Phase) -> MemoryPlan {
        let mut plan = MemoryPlan::default();
        let cells = grid.cells() as u64;
        let mut add = |name: &str| {
            plan.add(&format!("{name}, so far"), cells, size_of::<TwoFloat4>());
            plan.add(name, cells, size_of::<[f32; 4]>());
        };
        add("direct light");
        if phase.mean_cosine() != 0.0 {
            add("reduced direct light");
        }
        if !phase.is_isotropic() {
            add("flow of direct light");
        }
        plan.add("spread of direct light", cells, size_of::<f32>());
        plan.add("extents of direct light", cells, size_of::<[f32; 2]>());
        plan.add("places of direct light, so far", cells, size_of::<[f32; 4]>());
        plan.add("places of direct light", cells, size_of::<[f32; 4]>());
        plan
    }

    /// Caps launches at so many passes of a block of cells; the result does not depend on it.
    pub fn limit_launches(&mut self, blocks: u64) {
        self.launch_limit = blocks.max(1);
    }

    /// Passes that every cell has.
    pub fn passes(&self) -> u32 {
        self.passes
    }

    /// Whether every pass is the same: then one is enough.
    pub fn is_exact(&self) -> bool {
        self.wanted.exact
    }

    /// Whether every cell has `target` passes, or all that it needs.
    pub fn is_done(&self, target: u32) -> bool {
        self.passes >= if self.wanted.exact { target.min(1) } else { target }
    }

    /// Runs one launch towards `target` passes, unless that [is done](Self::is_done): whole passes where they are short,
    /// else a part of one.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device fails.
    pub fn step(&mut self, device: &Device, medium: &LitMedium, target: u32) -> Result<()> {
        if self.is_done(target) {
            return Ok(());
        }
        let left = if self.wanted.exact { 1 } else { target - self.passes };
        let units = self.pacer.next(self.blocks.min(16)).min(self.launch_limit);
        let (count, passes) = if self.ahead == 0 && units >= self.blocks {
            let passes = u32::try_from(units / self.blocks).unwrap_or(u32::MAX);
            (self.blocks, passes.min(left).min(device.info().samples_per_launch()))
        } else {
            (units.min(self.blocks - self.ahead), 1)
        };
        self.launch(device, medium, count, passes)?;
        self.ahead += count;
        if self.ahead == self.blocks {
            self.ahead = 0;
            self.passes += passes;
        }
        Ok(())
    }

    fn launch(&mut self, device: &Device, medium: &LitMedium, count: u64, passes: u32) -> Result<()> {
        let Some(programs) = &mut self.programs else { return Ok(()) };
        let extents = self.extents.as_ref().unwrap_or(&programs.no_extents);
        let mut arguments = medium.arguments(6);
        arguments.extend([
            Arg::from(&medium.environment),
            (&self.grid_buffer).into(),
            (&self.parameters).into(),
            extents.into(),
            (&self.state.fluence).into(),
            (&self.state.group).into(),
            (&self.state.reduced).into(),
            (&self.state.flow).into(),
            (&self.state.moment).into(),
            (&self.counts).into(),
        ]);
        let numbers = [COUNTS as u32, self.ahead as u32, count as u32, self.passes, passes];
        arguments.extend(numbers.map(Arg::from));
        let items = if self.lanes > 1 { count as usize } else { (count as usize) << BLOCK_SHIFT };
        let elapsed = programs.pass.run(device, &arguments, items)?;
        self.pacer.measured(count * u64::from(passes), elapsed);
        Ok(())
    }

    /// The light as the passes so far have it.
    ///
    /// # Errors
    /// [`Error::Failed`] before the first pass, or when the device fails or lacks memory.
    pub fn means(&mut self, device: &Device) -> Result<DirectLight> {
        if self.passes == 0 {
            return Err(Error::Failed("direct light: no pass is done yet; run one first".into()));
        }
        self.check_finished(device)?;
        let cells = self.grid.cells();
        let Wanted { reduced, flow, .. } = self.wanted;
        let fluence = Buffer::zeroed(device, cells)?;
        let output = |is: bool| Buffer::zeroed(device, if is { cells } else { 1 });
        let (reduced_out, flow_out, extent) =
            (output(reduced)?, output(flow)?, output(self.extents.is_some())?);
        if let Some(programs) = &mut self.programs {
            let extents = self.extents.as_ref().unwrap_or(&programs.no_extents);
            let arguments = [
                (&self.state.fluence).into(),
                (&self.state.reduced).into(),
                (&self.state.flow).into(),
                (&self.state.moment).into(),
                extents.into(),
                (&fluence).into(),
                (&reduced_out).into(),
                (&flow_out).into(),
                (&extent).into(),
                (cells as u32).into(),
                self.passes.into(),
                (self.passes / STRATA).into(),
            ];
            programs.means.run(device, &arguments, cells)?;
        }
        Ok(DirectLight {
            fluence,
            reduced: reduced.then_some(reduced_out),
            flow: flow.then_some(flow_out),
            extent: self.extents.is_some().then_some(extent),
        })
    }

    /// What the rays of all launches cost.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device fails.
    pub fn cost(&self, device: &Device) -> Result<DirectCost> {
        let mut cost = DirectCost {
            rays: self.grid.cells() as u64
                * u64::from(self.passes)
                * (u64::from(self.wanted.lights) + u64::from(self.wanted.sky)),
            ..DirectCost::default()
        };
        for counts in self.counts.read(device)? {
            cost.lookups += u64::from(counts.lookups_high) << 32 | u64::from(counts.lookups_low);
            cost.above_majorant += u64::from(counts.above);
        }
        Ok(cost)
    }

    fn check_finished(&self, device: &Device) -> Result<()> {
        let unfinished: u64 =
            self.counts.read(device)?.iter().map(|counts| u64::from(counts.unfinished)).sum();
        if unfinished == 0 {
            return Ok(());
        }
        Err(Error::Failed(format!(
            "{}: the device left {unfinished} passes of direct light before their ends; another device, or a coarser light \
             volume, would do",
            device.info().name
        )))
    }
}

impl Programs {
    fn build(device: &Device, medium: &LitMedium, wanted: Wanted, spread: bool, lanes: u32) -> Result<Self> {
        let program = medium.program(device, "irradiance/direct.cl", |spec| {
            let spec = spec
                .define("CONTROLLED", 1)
                .define("WIDTH", lanes)
                .define("STRATA", format!("{STRATA}u"))
                .feature("SKY", wanted.sky)
                .feature("REDUCED", wanted.reduced)
                .feature("FLOW", wanted.flow)
                .feature("SPREAD", spread)
                .feature("EXACT", wanted.exact);
            if lanes > 1 { spec.define("CELLS", 1 << BLOCK_SHIFT) } else { spec }
        })?;
        let mut pass = program.kernel(device, "irradiance_direct")?;
        if lanes > 1 {
            // A block is work enough for a work-group, and whole groups go to the cores.
            pass.limit_work_group(1);
        }
        Ok(Self {
            pass,
            means: program.kernel(device, "irradiance_direct_means")?,
            no_extents: Buffer::zeroed(device, 1)?,
        })
    }
}

/// Of which part of each cell its light has to be the mean; `None` where the centre stands for each of them.
fn extents(device: &Device, medium: &LitMedium, grid: &LightGrid) -> Result<Option<Buffer<[f32; 2]>>> {
    let extents = Buffer::<[f32; 2]>::uninitialised(device, grid.cells())?;
    let device_grid = Buffer::from_slice(device, &[grid.device()])?;
    let program = medium.program(device, "irradiance/cells.cl", |spec| spec)?;
    let mut arguments = medium.arguments(TABLES + 1);
    arguments.extend([Arg::from(&device_grid), (&extents).into()]);
    program.kernel(device, "irradiance_extents")?.run(device, &arguments, grid.cells())?;
    let any = extents.read(device)?.iter().any(|[share, _]| *share > 0.0);
    Ok(any.then_some(extents))
}
