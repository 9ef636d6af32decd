//! The map of photons: photons in an order in which those near a point are found.
//!
//! In: slots of photons as they were stored, some of them empty; the radius. Out: what the kernels that gather take
//! (`cl/caustics/gather.cl`), all in local units. Whatever the order of the launches' work-items, the map is the same bit for
//! bit.

use super::map_cells::{Cells, Focus};
use super::map_types::{Acceleration, MapFrame, MapSettings};
use super::photon::Photon;
use super::receivers::{Receiver, number_planes};
use crate::device::{Arg, Buffer, Device, DeviceInfo, Kernel, MemoryPlan, Program, ProgramSpec};
use crate::sort::{CellRanges, Sorter};
use crate::{Error, Result};
use std::ops::Range;
use std::time::{Duration, Instant};

/// Work-items that look for the photons' bounds.
const SHARES: usize = 1024;
/// Arrays of the map, a number of each photon in each: place, flux, direction, surface.
const ARRAYS: usize = 8;
/// Photons of which kernels look at once, at most: what arrays have behind their end.
const BATCH: usize = 8;
/// Photons that a loop of 65535 turns goes through.
const LONG_LOOP: usize = 65_535 * BATCH;
/// Most photons: their arrays' elements are numbered in 32 bits.
pub const MOST_PHOTONS: usize = (1 << 29) - BATCH;

/// What building a map found and took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MapFacts {
    /// Photons in the map.
    pub valid: usize,
    /// Cells along x, y, z; 0 where the map has none.
    pub cells: [u32; 3],
    /// Whether each cell has its range in the table.
    pub tabled: bool,
    /// Kernel launches.
    pub launches: u32,
    /// Time to find bounds and keys.
    pub keys: Duration,
    /// Time to sort.
    pub sort: Duration,
    /// Time to find the ranges of cells.
    pub fill: Duration,
    /// Time to put the photons in order.
    pub order: Duration,
}

/// Photons in an order in which those near a point are found.
pub struct PhotonMap {
    settings: MapSettings,
    capacity: usize,
    kernels: Kernels,
    sorter: Option<Sorter<u32>>,
    ranges: Option<CellRanges>,
    planes: u32,
    focus: Option<Focus>,
    keys: Buffer<u32>,
    corners: [Buffer<[f32; 4]>; 2],
    frame: Buffer<MapFrame>,
    photons: Buffer<f32>,
    receivers: Buffer<Receiver>,
    /// Stand in for what is not there.
    no_keys: Buffer<u32>,
    no_ranges: Buffer<[u32; 2]>,
}

struct Kernels {
    bounds: Kernel,
    keys: Kernel,
    order: Kernel,
    copy: Kernel,
}

impl PhotonMap {
    /// A map of up to `capacity` slots of photons, gathered on surfaces of which `receivers` has one each.
    ///
    /// # Errors
    /// [`Error::Failed`] when the kernels do not build, the device has no room, or nothing can number so many photons.
    pub fn new(
        device: &Device,
        settings: MapSettings,
        receivers: &[Receiver],
        capacity: usize,
    ) -> Result<Self> {
        if capacity > MOST_PHOTONS {
            return Err(Error::Failed(format!(
                "a map of {capacity} photons is too large: it can have up to {MOST_PHOTONS}"
            )));
        }
        let spec = settings.define_cells(ProgramSpec::new("caustics/map.cl"));
        let spec = if device.info().can_force_inlining() { spec } else { spec.define("INLINE", "inline") };
        let program = Program::build(device, &spec)?;
        let kernels = Kernels {
            bounds: program.kernel(device, "map_bounds")?,
            keys: program.kernel(device, "map_keys")?,
            order: program.kernel(device, "map_order")?,
            copy: program.kernel(device, "map_copy")?,
        };
        let mut receivers = receivers.to_vec();
        let planes = number_planes(&mut receivers);
        let (sorted, cells) = (settings.sorts(), settings.has_cells());
        let sorter = sorted.then(|| Sorter::new(device, settings.sort, capacity)).transpose()?;
        let ranges = || CellRanges::new(device, settings.table_cells, settings.fill, capacity);
        let corners = || Buffer::uninitialised(device, SHARES);
        Ok(Self {
            settings,
            capacity,
            kernels,
            sorter,
            ranges: cells.then(ranges).transpose()?,
            planes,
            focus: None,
            keys: Buffer::uninitialised(device, if sorted { capacity } else { 0 })?,
            corners: [corners()?, corners()?],
            frame: Buffer::from_slice(device, &[bytemuck::Zeroable::zeroed()])?,
            photons: Buffer::uninitialised(device, ARRAYS * stride(capacity))?,
            receivers: Buffer::from_slice(device, &receivers)?,
            no_keys: Buffer::zeroed(device, 1)?,
            no_ranges: Buffer::zeroed(device, 1)?,
        })
    }

    /// The same with cells about a focus, where there would be too many for the table.
    #[must_use]
    pub fn focused(self, focus: Focus) -> Self {
        Self { focus: Some(focus), ..self }
    }

    /// What a map takes of a device.
    pub fn memory(info: &DeviceInfo, settings: &MapSettings, capacity: usize) -> MemoryPlan {
        let mut plan = MemoryPlan::default();
        plan.add("photons in order", (ARRAYS * stride(capacity)) as u64, size_of::<f32>());
        if settings.sorts() {
            plan.add("keys of photons", capacity as u64, size_of::<u32>());
            plan.items.extend(Sorter::<u32>::memory(info, settings.sort, capacity).items);
        }
        if settings.has_cells() {
            plan.items.extend(CellRanges::memory(settings.table_cells, capacity).items);
        }
        plan
    }

    /// How its photons are gathered.
    pub fn settings(&self) -> &MapSettings {
        &self.settings
    }

    /// Makes the map of these slots, to be gathered within `radius` (local units) of points.
    ///
    /// # Errors
    /// [`Error::Failed`] when there are more slots than the capacity or than there are, the radius is none, photons lie on
    /// surfaces that have no plane where cells do, or the device fails.
    pub fn build(
        &mut self,
        device: &Device,
        photons: &Buffer<Photon>,
        slots: Range<usize>,
        radius: f32,
    ) -> Result<MapFacts> {
        self.check(device, photons, &slots, radius)?;
        if self.settings.sorts() {
            self.sort(device, photons, slots, radius)
        } else {
            self.copy(device, photons, slots, radius)
        }
    }

    /// Frame, photons, keys, ranges, receivers: as `PHOTON_MAP_ARGUMENTS` of `cl/caustics/gather.cl`.
    pub fn arguments(&self) -> [Arg<'_>; 5] {
        let keys = self.sorter.as_ref().map_or(&self.no_keys, |sorter| sorter.sorted().keys);
        let ranges = self.ranges.as_ref().map_or(&self.no_ranges, CellRanges::ranges);
        [(&self.frame).into(), (&self.photons).into(), keys.into(), ranges.into(), (&self.receivers).into()]
    }

    fn check(
        &self,
        device: &Device,
        photons: &Buffer<Photon>,
        slots: &Range<usize>,
        radius: f32,
    ) -> Result<()> {
        let count = slots.len();
        let most = self.capacity.min(photons.len().saturating_sub(slots.start));
        if count > most {
            return Err(Error::Failed(format!("cannot map {count} photons: there is room for {most}")));
        }
        if !(radius > 0.0 && (radius * radius).is_normal() && (1.0 / (radius * radius)).is_normal()) {
            return Err(Error::Failed(format!(
                "photons cannot be gathered within a radius of {radius}: it must be positive, and float32 must hold its square"
            )));
        }
        if self.settings.acceleration == Acceleration::BruteForce
            && device.info().ends_long_loops()
            && count > LONG_LOOP
        {
            return Err(Error::Failed(format!(
                "{} leaves loops after 65535 turns: by brute force it can gather {LONG_LOOP} photons, not {count}",
                device.info().name
            )));
        }
        Ok(())
    }

    /// Keeps the photons in the order in which they are stored.
    fn copy(
        &mut self,
        device: &Device,
        photons: &Buffer<Photon>,
        slots: Range<usize>,
        radius: f32,
    ) -> Result<MapFacts> {
        let mut watch = Watch { device, start: Instant::now() };
        let count = slots.len();
        self.write_frame(device, radius, count, None)?;
        let [from, many] = numbers(&slots);
        let arguments = [photons.into(), (&self.photons).into(), self.stride(), from, many];
        self.kernels.copy.enqueue(device, &arguments, [count, 1, 1])?;
        let valid = self.bounds(device, photons, &slots)?.valid;
        Ok(MapFacts { valid, launches: 2, order: watch.lap()?, ..MapFacts::default() })
    }

    fn sort(
        &mut self,
        device: &Device,
        photons: &Buffer<Photon>,
        slots: Range<usize>,
        radius: f32,
    ) -> Result<MapFacts> {
        let mut facts = MapFacts::default();
        let mut watch = Watch { device, start: Instant::now() };
        let Bounds { low, high, valid } = self.bounds(device, photons, &slots)?;
        facts.valid = valid;
        let planar = self.settings.acceleration == Acceleration::Planar;
        let cells = (self.settings.has_cells() && valid > 0).then(|| {
            let planes = planar.then_some(self.planes);
            // Planes have coordinates of their own.
            let focus = self.focus.filter(|_| !planar);
            Cells::around(low, high, radius.into(), planes, focus, self.settings.table_cells)
        });
        self.write_frame(device, radius, valid, cells.as_ref())?;
        facts.launches = 1;
        if valid == 0 {
            facts.keys = watch.lap()?;
            return Ok(facts);
        }
        let (count, [from, many]) = (slots.len(), numbers(&slots));
        let arguments =
            [photons.into(), (&self.receivers).into(), (&self.frame).into(), (&self.keys).into(), from, many];
        self.kernels.keys.enqueue(device, &arguments, [count, 1, 1])?;
        facts.keys = watch.lap()?;

        let stride = self.stride();
        let sorter = self.sorter.as_mut().expect("what sorts has a sorter");
        let bits = cells.map_or(u32::BITS, |cells| cells.key_bits());
        let sorted = sorter.sort(device, &self.keys, count, bits)?;
        facts.sort = watch.lap()?;
        facts.launches += 2 + sorted.work.launches;
        if let (Some(ranges), Some(cells)) = (&mut self.ranges, cells) {
            facts.cells = cells.dims;
            facts.tabled = cells.fit_table(&self.settings);
            if facts.tabled {
                facts.launches += ranges.fill(device, &sorted)?.launches;
                facts.fill = watch.lap()?;
            }
        }
        let [from, _] = numbers(&slots);
        let valid_ = Arg::from(valid as u32);
        let arguments = [photons.into(), sorted.indices.into(), (&self.photons).into(), stride, from, valid_];
        self.kernels.order.enqueue(device, &arguments, [valid, 1, 1])?;
        facts.order = watch.lap()?;
        Ok(facts)
    }

    fn stride(&self) -> Arg<'static> {
        (stride(self.capacity) as u32).into()
    }

    fn bounds(&mut self, device: &Device, photons: &Buffer<Photon>, slots: &Range<usize>) -> Result<Bounds> {
        let (count, [from, many]) = (slots.len(), numbers(slots));
        let share = count.div_ceil(SHARES).max(1);
        let items = count.div_ceil(share);
        let arguments = [
            photons.into(),
            (&self.receivers).into(),
            (&self.corners[0]).into(),
            (&self.corners[1]).into(),
            from,
            many,
            (share as u32).into(),
            (items as u32).into(),
        ];
        self.kernels.bounds.enqueue(device, &arguments, [items, 1, 1])?;
        let [lows, highs] = [self.corners[0].read(device)?, self.corners[1].read(device)?];
        let mut bounds = Bounds { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3], valid: 0 };
        let mut stray = 0;
        for (low, high) in lows.iter().zip(&highs).take(items) {
            for axis in 0..3 {
                bounds.low[axis] = bounds.low[axis].min(low[axis]);
                bounds.high[axis] = bounds.high[axis].max(high[axis]);
            }
            bounds.valid += low[3].to_bits() as usize;
            stray += high[3].to_bits();
        }
        if stray > 0 {
            return Err(Error::Failed(format!(
                "{stray} photons lie on surfaces that are no planes, parallelograms or disks: cells in planes cannot hold them, voxels can"
            )));
        }
        Ok(bounds)
    }

    fn write_frame(&self, device: &Device, radius: f32, count: usize, cells: Option<&Cells>) -> Result<()> {
        let none = Cells { low: [0.0; 3], scale: 0.0, dims: [0; 3], clamped: false };
        let Cells { low: [x, y, z], scale, dims: [nx, ny, nz], clamped } = cells.copied().unwrap_or(none);
        let MapSettings { weighting, paper_weights, .. } = self.settings;
        // Of tiny radii, within which no photons lie: finite all the same.
        let norm =
            |integral: f64| if paper_weights { 1.0 } else { (1.0 / integral).min(f32::MAX.into()) as f32 };
        let wide = f64::from(radius);
        let frame = MapFrame {
            low: [x, y, z, scale],
            scale: [
                norm(weighting.area() * wide.powi(2)),
                norm(weighting.volume() * wide.powi(3)),
                (1.0 / wide) as f32,
                radius * radius,
            ],
            nx,
            ny,
            nz,
            count: count as u32,
            stride: stride(self.capacity) as u32,
            tabled: cells.is_some_and(|cells| cells.fit_table(&self.settings)).into(),
            radius,
            margin: if clamped { 0.0 } else { 2.0 },
        };
        self.frame.write(device, 0, &[frame])
    }
}

/// The first of the slots, and how many.
fn numbers(slots: &Range<usize>) -> [Arg<'static>; 2] {
    [slots.start as u32, slots.len() as u32].map(Arg::from)
}

/// Elements of an array, with what a batch may read behind the last photon.
fn stride(capacity: usize) -> usize {
    (capacity + BATCH).next_multiple_of(BATCH)
}

/// Where photons lie, in the space of the cells, and how many.
struct Bounds {
    low: [f32; 3],
    high: [f32; 3],
    valid: usize,
}

/// Times what was asked of the device since the last lap.
struct Watch<'a> {
    device: &'a Device,
    start: Instant,
}

impl Watch<'_> {
    fn lap(&mut self) -> Result<Duration> {
        self.device.finish()?;
        let lap = self.start.elapsed();
        self.start = Instant::now();
        Ok(lap)
    }
}
