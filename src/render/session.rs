//! A session: one render on one device, from upload to film.

use super::auxiliary::Auxiliary;
use super::ledger::{Ledger, PathLedger};
use super::plan::Plan;
use super::resume::SavedFilm;
use super::session_light::SessionLight;
use super::tiles::{Lag, TILE};
use crate::caustics::{MapSettings, PassFacts, PassLedger, Passes};
use crate::device::{
    Arg, Buffer, Device, DeviceInfo, DeviceKind, Kernel, LAUNCH_TARGET, Pacer, Program, ProgramSpec,
};
use crate::film::FilmPixel;
use crate::irradiance::{LightData, LightFacts};
use crate::{Error, Result};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// The plan's program as this device runs it best.
///
/// CPUs get the form of the kernel that works on eight samples at a time where there is one: their compilers do not
/// vectorise divergent loops over work-items. It indexes voxels in 32 bits.
fn specialise(plan: &Plan<'_>, device: &DeviceInfo) -> ProgramSpec {
    if plan.method.caustics.is_some() {
        return MapSettings::define_lanes(plan.spec.clone(), device);
    }
    let lanes = plan.method.lanes && device.kind == DeviceKind::Cpu && plan.voxels() < 1 << 31;
    let mut spec = plan.spec.clone().feature("LANES", lanes);
    if plan.method.paths {
        let width = path_lanes(plan, device);
        spec = spec.define("WIDTH", width.to_string());
        if width > 1 {
            spec = spec.define("PIXELS", (TILE * TILE).to_string());
        }
    }
    spec
}

/// Paths that a work-item follows side by side; with more than one it takes a whole tile.
fn path_lanes(plan: &Plan<'_>, device: &DeviceInfo) -> u32 {
    device.lanes(plan.voxels())
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
    /// Share of the light volume that is computed, 0 to 1; 1 for methods without.
    pub light: f32,
}

/// What paths keep besides the film.
pub(super) struct PathBuffers {
    pub ledgers: Buffer<Ledger>,
    /// Of every pixel, or a single unused one.
    pub auxiliary: Buffer<Auxiliary>,
    /// What the runs before this one did.
    earlier: PathLedger,
    /// Whether a work-item renders a tile.
    pub tile_items: bool,
}

/// A render on a device. Samples are added launch by launch; the film is bit for bit the same however they are cut.
pub struct Session {
    pub(super) device: Device,
    kernel: Kernel,
    inputs: Vec<Arc<Buffer<u8>>>,
    voxels: Option<Arc<Buffer<u8>>>,
    pub(super) film: Buffer<FilmPixel>,
    pub(super) paths: Option<PathBuffers>,
    light: SessionLight,
    pub(super) passes: Option<Box<Passes>>,
    has_auxiliary: bool,
    pub(super) tiles: u32,
    /// Tiles that have fewer samples than others, in a film of several devices that is continued.
    lag: Vec<Lag>,
    pub(super) pacer: Pacer,
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
        Self::lit(device, plan, None)
    }

    /// The same with a light volume that was computed before, for methods that project one.
    ///
    /// # Errors
    /// As [`Session::new`].
    pub fn lit(device: Device, plan: &Plan<'_>, light: Option<&LightData>) -> Result<Self> {
        plan.memory().check(device.info())?;
        let program = Program::build(&device, &specialise(plan, device.info()))?;
        let mut kernel = program.kernel(&device, plan.method.kernel)?;
        let mut inputs = Vec::new();
        let mut add = |bytes: &[u8]| -> Result<()> {
            inputs.push(Arc::new(Buffer::from_slice(&device, bytes)?));
            Ok(())
        };
        add(bytemuck::bytes_of(&plan.frame))?;
        add(bytemuck::bytes_of(&plan.camera))?;
        if let Some(volume) = &plan.volume {
            add(bytemuck::bytes_of(&volume.device))?;
        }
        add(&plan.method.parameters.bytes)?;
        let voxels =
            plan.volume.as_ref().map(|volume| volume.grid.upload(&device).map(Arc::new)).transpose()?;
        inputs.extend(voxels.clone());
        for table in plan.method.tables.iter().chain([&plan.environment]) {
            inputs.push(Arc::new(Buffer::from_slice(&device, &table.bytes)?));
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
        let light = SessionLight::new(&device, plan, light, voxels.as_ref())?;
        let traced = |setup| Passes::new(&device, plan, setup, voxels.as_ref()).map(Box::new);
        let passes = plan.method.caustics.as_deref().map(traced);
        let passes = passes.transpose()?;
        let build_time =
            program.build_time + passes.as_ref().map_or(Duration::ZERO, |passes| passes.build_time);
        Ok(Self {
            kernel,
            inputs,
            voxels,
            film,
            paths,
            light,
            passes,
            has_auxiliary: plan.has_auxiliary(),
            tiles,
            lag: Vec::new(),
            pacer: Pacer::new(LAUNCH_TARGET),
            launch_limit: None,
            progress: Progress::default(),
            build_time,
            build_cached: program.cached,
            device,
        })
    }

    /// Caps launches at `units` tile-samples; the picture does not depend on it.
    pub fn limit_launches(&mut self, units: u64) {
        self.launch_limit = Some(units.max(1));
    }

    /// Watches this flag where a single step may take long; [`Error::Interrupted`] is what the step then ends with.
    pub fn interrupt_by(&mut self, flag: Arc<AtomicBool>) {
        self.light.interrupt = Some(flag);
    }

    /// How far it has come.
    pub fn progress(&self) -> Progress {
        Progress { light: self.light.share(), ..self.progress }
    }

    /// The light volume, once it is computed, of methods that project one.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device fails.
    pub fn light(&self) -> Result<Option<LightData>> {
        self.light.read(&self.device)
    }

    /// What the computation of the light volume did, once it is done in this session.
    pub fn light_facts(&self) -> Option<&LightFacts> {
        self.light.facts.as_ref()
    }

    /// What the passes of this session did, for caustics.
    pub fn pass_facts(&self) -> Option<&PassFacts> {
        self.passes.as_ref().map(|passes| passes.facts())
    }

    /// Where the flux of the photons of all runs went, for caustics.
    pub fn photons(&self) -> Option<&PassLedger> {
        self.passes.as_ref().map(|passes| passes.ledger())
    }

    /// The hash of the light volume, once there is one.
    pub fn light_hash(&self) -> Option<&str> {
        self.light.hash.as_deref()
    }

    /// Notes whether the light volume was read from a file.
    pub fn set_light_from_file(&mut self, from_file: bool) {
        self.light.from_file = from_file;
    }

    /// Whether the light volume was read from a file.
    pub fn is_light_from_file(&self) -> bool {
        self.light.from_file
    }

    /// Computes the light volume, if there is one to compute and it is not done, as long as `go_on` says so.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device fails, [`Error::Interrupted`] after an interrupt.
    pub fn compute_light(&mut self, go_on: &dyn Fn() -> bool) -> Result<()> {
        while self.light.is_wanted() {
            if !go_on() {
                return Err(Error::Interrupted);
            }
            self.step_light()?;
        }
        Ok(())
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
        if self.light.is_wanted() {
            return self.step_light();
        }
        if let Some(lag) = self.lag.pop() {
            return self.catch_up(lag);
        }
        let mut most_samples = self.most_samples();
        if let Some(passes) = &mut self.passes {
            let pass = self.progress.samples;
            if !passes.is_ready(pass) {
                let start = Instant::now();
                passes.step(&self.device, pass)?;
                self.progress.launches += 1;
                self.progress.device_time += start.elapsed();
                return Ok(());
            }
            // Each sample has photons of its own.
            if passes.has_photons() {
                most_samples = 1;
            }
        }
        let units = self.next_units();
        let tiles = u64::from(self.tiles);
        let (first_tile, tile_count, samples) = if self.progress.tiles == 0 && units >= tiles {
            let samples = u32::try_from(units / tiles).unwrap_or(u32::MAX);
            (0, self.tiles, samples.min(left).min(most_samples))
        } else {
            let remaining = self.tiles - self.progress.tiles;
            (self.progress.tiles, u32::try_from(units).unwrap_or(u32::MAX).min(remaining), 1)
        };
        self.launch(first_tile, tile_count, self.progress.samples, samples)?;
        self.progress.tiles += tile_count;
        if self.progress.tiles == self.tiles {
            self.progress.tiles = 0;
            self.progress.samples += samples;
        }
        Ok(())
    }

    /// Tile-samples of the next launch.
    pub(super) fn next_units(&self) -> u64 {
        self.pacer.next(u64::from(self.tiles).min(64)).min(self.launch_limit.unwrap_or(u64::MAX))
    }

    /// Samples that a launch may add to a pixel.
    pub(super) fn most_samples(&self) -> u32 {
        self.device.info().samples_per_launch()
    }

    /// One launch for tiles that are behind others; those that still are come again.
    fn catch_up(&mut self, mut lag: Lag) -> Result<()> {
        let (tiles, samples) = lag.launch(self.next_units(), self.most_samples());
        self.launch(lag.first_tile, tiles, lag.samples, samples)?;
        self.lag.extend(lag.after(tiles, samples));
        if self.lag.is_empty() {
            (self.progress.samples, self.progress.tiles) = (lag.goal, 0);
        }
        Ok(())
    }

    /// One step of the light volume, if there is one to compute and it is not done.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device fails, [`Error::Interrupted`] after an interrupt.
    pub fn advance_light(&mut self) -> Result<()> {
        if self.light.is_wanted() { self.step_light() } else { Ok(()) }
    }

    /// One step of the light volume, which comes before the first sample.
    fn step_light(&mut self) -> Result<()> {
        let elapsed = self.light.step(&self.device)?;
        self.progress.launches += 1;
        self.progress.device_time += elapsed;
        Ok(())
    }

    /// Adds `samples` samples from `first_sample` on to tiles.
    pub(super) fn launch(
        &mut self,
        first_tile: u32,
        tile_count: u32,
        first_sample: u32,
        samples: u32,
    ) -> Result<()> {
        let mut arguments: Vec<Arg<'_>> = self.inputs.iter().map(|input| Arg::from(&**input)).collect();
        arguments.extend(self.light.arguments());
        if let Some(passes) = &self.passes {
            arguments.extend(passes.arguments());
        }
        arguments.push((&self.film).into());
        let mut items = tile_count as usize * (TILE * TILE) as usize;
        if let Some(paths) = &self.paths {
            arguments.extend([Arg::from(&paths.ledgers), Arg::from(&paths.auxiliary)]);
            if paths.tile_items {
                items = tile_count as usize;
            }
        }
        arguments.extend([first_tile, tile_count, first_sample, samples].map(Arg::from));
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

    /// Starts anew, the light volume with it; what launches have taught about their times stays.
    ///
    /// # Errors
    /// As [`Session::new`].
    pub fn restart(&mut self, plan: &Plan<'_>) -> Result<()> {
        self.light.restart(&self.device, plan, self.voxels.as_ref())?;
        self.reset()
    }

    /// Empties the film; the next sample is the first again. A light volume that is computed stays.
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
        if let Some(passes) = &mut self.passes {
            passes.reset();
        }
        self.lag.clear();
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
        self.lag = saved.lag.clone();
        if let (Some(passes), Some(ledger)) = (&mut self.passes, saved.photons) {
            passes.restore(ledger);
        }
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
