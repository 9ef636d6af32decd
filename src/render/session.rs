//! A session: one render on one device, from upload to film.

use super::auxiliary::Auxiliary;
use super::ledger::{Ledger, PathLedger};
use super::plan::Plan;
use super::resume::SavedFilm;
use crate::device::{
    Arg, Buffer, Device, DeviceInfo, DeviceKind, Kernel, LAUNCH_TARGET, Pacer, Program, ProgramSpec,
};
use crate::film::FilmPixel;
use crate::{Error, Result};
use std::time::Duration;

/// Pixels per edge of a tile: mirrors `TILE_SHIFT` in `cl/render/frame.cl`.
pub(super) const TILE: u32 = 8;

/// The plan's program as this device runs it best.
///
/// CPUs get the form of the kernel that works on eight samples at a time where there is one: their compilers do not
/// vectorise divergent loops over work-items. It indexes voxels in 32 bits.
fn specialise(plan: &Plan<'_>, device: &DeviceInfo) -> ProgramSpec {
    let lanes = plan.method.lanes && device.kind == DeviceKind::Cpu && plan.grid.device_voxels().0 < 1 << 31;
    let mut spec = plan.spec.clone().feature("LANES", lanes);
    if plan.method.paths {
        let width = path_lanes(plan, device);
        spec = spec.define("WIDTH", width.to_string());
        if width > 1 {
            spec = spec.define("PIXELS", (TILE * TILE).to_string());
        }
    }
    if device.can_force_inlining() { spec } else { spec.define("INLINE", "inline") }
}

/// Paths that a work-item follows side by side; with more than one it takes a whole tile.
fn path_lanes(plan: &Plan<'_>, device: &DeviceInfo) -> u32 {
    device.lanes(plan.grid.device_voxels().0)
}

/// How far a session has come.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Samples that every pixel has.
    pub samples: u32,
    /// Tiles of the next sample that are done.
    pub tiles: u32,
    /// Kernel launches so far.
    pub launches: u64,
    /// Time spent in them.
    pub device_time: Duration,
}

/// What paths keep besides the film.
struct PathBuffers {
    ledgers: Buffer<Ledger>,
    /// Of every pixel, or a single unused one.
    auxiliary: Buffer<Auxiliary>,
    /// What the runs before this one did.
    earlier: PathLedger,
    /// Whether a work-item renders a tile.
    tile_items: bool,
}

/// A render on a device. Samples are added launch by launch; the film is bit for bit the same however they are cut.
pub struct Session {
    device: Device,
    kernel: Kernel,
    inputs: Vec<Buffer<u8>>,
    film: Buffer<FilmPixel>,
    paths: Option<PathBuffers>,
    has_auxiliary: bool,
    tiles: u32,
    pacer: Pacer,
    launch_limit: Option<u64>,
    progress: Progress,
    /// Time to build the program, or to load it from the cache; with that of the runs it continues.
    pub build_time: Duration,
    /// Whether the program came from the binary cache.
    pub build_cached: bool,
}

impl Session {
    /// Builds the program and uploads the plan's data.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device lacks memory, or building or copying fails.
    pub fn new(device: Device, plan: &Plan<'_>) -> Result<Self> {
        plan.memory().check(device.info())?;
        let program = Program::build(&device, &specialise(plan, device.info()))?;
        let mut kernel = program.kernel(&device, plan.method.kernel)?;
        let mut inputs = Vec::new();
        let mut add = |bytes: &[u8]| -> Result<()> {
            inputs.push(Buffer::from_slice(&device, bytes)?);
            Ok(())
        };
        add(bytemuck::bytes_of(&plan.frame))?;
        add(bytemuck::bytes_of(&plan.camera))?;
        add(bytemuck::bytes_of(&plan.volume))?;
        add(&plan.method.parameters.bytes)?;
        inputs.push(plan.grid.upload(&device)?);
        for table in plan.method.tables.iter().chain([&plan.environment]) {
            inputs.push(Buffer::from_slice(&device, &table.bytes)?);
        }
        let image = &plan.scene.image;
        let film = Buffer::zeroed(&device, image.width as usize * image.height as usize)?;
        let tiles = image.width.div_ceil(TILE) * image.height.div_ceil(TILE);
        let paths = if plan.method.paths {
            let tile_items = path_lanes(plan, device.info()) > 1;
            if tile_items {
                // A tile is work enough for a work-group, and whole groups go to the cores.
                kernel.limit_work_group(1);
            }
            let accounts = if tile_items { tiles as usize } else { (tiles * TILE * TILE) as usize };
            let pixels = if plan.has_auxiliary() { film.len() } else { 1 };
            Some(PathBuffers {
                ledgers: Buffer::zeroed(&device, accounts)?,
                auxiliary: Buffer::zeroed(&device, pixels)?,
                earlier: PathLedger::default(),
                tile_items,
            })
        } else {
            None
        };
        Ok(Self {
            kernel,
            inputs,
            film,
            paths,
            has_auxiliary: plan.has_auxiliary(),
            tiles,
            pacer: Pacer::new(LAUNCH_TARGET),
            launch_limit: None,
            progress: Progress::default(),
            build_time: program.build_time,
            build_cached: program.cached,
            device,
        })
    }

    /// Caps launches at `units` tile-samples; the picture does not depend on it.
    pub fn limit_launches(&mut self, units: u64) {
        self.launch_limit = Some(units.max(1));
    }

    /// How far it has come.
    pub fn progress(&self) -> Progress {
        self.progress
    }

    /// The device it runs on.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Runs one launch towards `target` samples per pixel: whole samples when they are short, else part of one.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device fails.
    pub fn step(&mut self, target: u32) -> Result<()> {
        let left = target.saturating_sub(self.progress.samples);
        if left == 0 {
            return Ok(());
        }
        let units = self.pacer.next(u64::from(self.tiles).min(64)).min(self.launch_limit.unwrap_or(u64::MAX));
        let tiles = u64::from(self.tiles);
        let (first_tile, tile_count, samples) = if self.progress.tiles == 0 && units >= tiles {
            let samples = u32::try_from(units / tiles).unwrap_or(u32::MAX);
            (0, self.tiles, samples.min(left).min(self.device.info().samples_per_launch()))
        } else {
            let remaining = self.tiles - self.progress.tiles;
            (self.progress.tiles, u32::try_from(units).unwrap_or(u32::MAX).min(remaining), 1)
        };
        self.launch(first_tile, tile_count, samples)?;
        self.progress.tiles += tile_count;
        if self.progress.tiles == self.tiles {
            self.progress.tiles = 0;
            self.progress.samples += samples;
        }
        Ok(())
    }

    fn launch(&mut self, first_tile: u32, tile_count: u32, samples: u32) -> Result<()> {
        let mut arguments: Vec<Arg<'_>> = self.inputs.iter().map(Arg::from).collect();
        arguments.push((&self.film).into());
        let mut items = tile_count as usize * (TILE * TILE) as usize;
        if let Some(paths) = &self.paths {
            arguments.extend([Arg::from(&paths.ledgers), Arg::from(&paths.auxiliary)]);
            if paths.tile_items {
                items = tile_count as usize;
            }
        }
        arguments.extend([first_tile, tile_count, self.progress.samples, samples].map(Arg::from));
        let elapsed = self.kernel.run(&self.device, &arguments, items)?;
        self.pacer.measured(u64::from(tile_count) * u64::from(samples), elapsed);
        self.progress.launches += 1;
        self.progress.device_time += elapsed;
        Ok(())
    }

    /// Renders until every pixel has `samples` samples.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device fails.
    pub fn render(&mut self, samples: u32) -> Result<()> {
        while self.progress.samples < samples {
            self.step(samples)?;
        }
        Ok(())
    }

    /// Empties the film; the next sample is the first again.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device fails.
    pub fn reset(&mut self) -> Result<()> {
        self.film = Buffer::zeroed(&self.device, self.film.len())?;
        if let Some(paths) = &mut self.paths {
            paths.ledgers = Buffer::zeroed(&self.device, paths.ledgers.len())?;
            paths.auxiliary = Buffer::zeroed(&self.device, paths.auxiliary.len())?;
            paths.earlier = PathLedger::default();
        }
        self.progress = Progress { launches: self.progress.launches, ..Progress::default() };
        Ok(())
    }

    /// What the paths of all runs did, when the method follows paths.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device fails.
    pub fn ledger(&self) -> Result<Option<PathLedger>> {
        let Some(paths) = &self.paths else { return Ok(None) };
        Ok(Some(PathLedger::of(&paths.ledgers.read(&self.device)?).plus(&paths.earlier)))
    }

    /// The auxiliary images, row by row from the top, when the scene asks for them and the method makes them.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device fails.
    pub fn auxiliary(&self) -> Result<Option<Vec<Auxiliary>>> {
        let Some(paths) = self.paths.as_ref().filter(|_| self.has_auxiliary) else { return Ok(None) };
        Ok(Some(paths.auxiliary.read(&self.device)?))
    }

    /// Continues from a film that a session of the same plan left.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device fails.
    pub fn restore(&mut self, saved: &SavedFilm) -> Result<()> {
        self.film.write(&self.device, 0, &saved.pixels)?;
        if let Some(paths) = &mut self.paths {
            paths.earlier = saved.paths.unwrap_or_default();
            if let Some(pixels) = &saved.auxiliary {
                paths.auxiliary.write(&self.device, 0, pixels)?;
            }
        }
        self.progress = saved.spent.progress;
        self.build_time += saved.spent.build;
        Ok(())
    }

    /// The film, row by row from the top.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device fails.
    pub fn film(&self) -> Result<Vec<FilmPixel>> {
        self.film.read(&self.device).map_err(|error| Error::Failed(format!("reading the film: {error}")))
    }
}
