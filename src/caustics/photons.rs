//! Tracing photons: `cl/caustics/photons.cl` and `cl/caustics/bounces.cl` on a device.

use super::emission::{EmissionSettings, Emitter, emitters};
use super::ledger::{BouncedLedger, PhotonAccount, PhotonLedger};
use super::medium::{PhotonMedium, begin_before};
use super::photon::Photon;
use super::roles::guide;
use super::spectrum::mean_color;
use crate::device::{Arg, Buffer, Device, Kernel, MemoryPlan, Program, ProgramSpec};
use crate::render::local::LocalFrame;
use crate::scene::Light;
use crate::surfaces::{Bounds, SurfaceArrays, SurfaceBuffers};
use crate::{Error, Result, device_struct};
use bytemuck::Zeroable;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Photons of a launch, and accounts: enough to fill a device. Photon i is entered in account i modulo this.
const ACCOUNTS: usize = 1 << 16;

device_struct! {
    "types/emission.cl",
    /// What all photons of a render share; see `cl/types/emission.cl`.
    pub struct PhotonFrame {
        /// Per channel, over the mean of all wavelengths.
        pub white: [f32; 4],
        /// A ball to which diffuse surfaces send half of the photons.
        pub guide: [f32; 4],
        /// Low half of the seed.
        pub seed_low: u32,
        /// High half of the seed.
        pub seed_high: u32,
        /// Number of emitters.
        pub emitters: u32,
        /// Reflections and refractions, at most.
        pub depth: u32,
        /// Planes among the shapes.
        pub plane_count: u32,
        /// Nodes of the hierarchy.
        pub node_count: u32,
        /// Diffuse reflections, at most.
        pub bounces: u32,
        /// Padding.
        pub pad_0: u32,
    }
}

/// How photons are traced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhotonSettings {
    /// How many, and where to.
    pub emission: EmissionSettings,
    /// Reflections and refractions that a photon goes through at most, besides diffuse reflections.
    pub depth: u32,
    /// Diffuse reflections that a photon goes through at most; those of `emission.bounces` need some.
    pub bounces: u32,
    /// Of the random numbers.
    pub seed: u64,
    /// Whether photons are stored, too, that meet a diffuse surface first. Cameras see their light by other means.
    pub store_direct: bool,
}

/// Photons of a scene on a device, pass by pass.
///
/// A pass is a pure function of scene, settings and its number, to the last bit on one device: however its launches are
/// cut, and whichever passes came before.
pub struct PhotonTracer {
    kernel: Kernel,
    /// For the photons from the first that diffuse surfaces reflect, with accounts of their own.
    bounce: Option<(u32, Kernel, Buffer<PhotonAccount>)>,
    frame: Buffer<PhotonFrame>,
    emitters: Buffer<Emitter>,
    surfaces: Arc<SurfaceBuffers>,
    medium: Option<PhotonMedium>,
    photons: Buffer<Photon>,
    accounts: Buffer<PhotonAccount>,
    capacity: u32,
    unit: f64,
    /// Time to build the kernels, or to load them.
    pub build_time: Duration,
}

/// Where photons of a light begin: a box around these places, local units; `None` for parallel light, which begins outside
/// of everything.
fn light_places(light: &Light, frame: &LocalFrame) -> Option<Bounds> {
    match *light {
        Light::Point { position, .. } => Bounds::of([frame.point(position)]),
        Light::Directional { .. } => None,
        Light::Rectangle { centre, edge_u, edge_v, .. } => {
            let half = 0.5 * (edge_u.abs() + edge_v.abs());
            Bounds::of([frame.point(centre - half), frame.point(centre + half)])
        }
    }
}

impl PhotonTracer {
    /// Makes the tracing of `lights` onto `surfaces` (also uploaded, as `buffers`) ready.
    ///
    /// # Errors
    /// As [`emitters`], and [`Error::Failed`] when the device lacks memory or does not build the kernel.
    pub fn new(
        device: &Device,
        lights: &[Light],
        surfaces: &SurfaceArrays,
        buffers: Arc<SurfaceBuffers>,
        frame: &LocalFrame,
        settings: &PhotonSettings,
    ) -> Result<Self> {
        Self::within(device, lights, surfaces, buffers, frame, settings, None)
    }

    /// The same in a medium, if there is one: that of `frame`'s box.
    ///
    /// # Errors
    /// As [`PhotonTracer::new`].
    pub fn within(
        device: &Device,
        lights: &[Light],
        surfaces: &SurfaceArrays,
        buffers: Arc<SurfaceBuffers>,
        frame: &LocalFrame,
        settings: &PhotonSettings,
        medium: Option<PhotonMedium>,
    ) -> Result<Self> {
        let mut emitters = emitters(lights, surfaces, frame, &settings.emission)?;
        if medium.is_some() {
            begin_before(&mut emitters, frame);
        }
        let capacity = emitters.iter().map(|emitter| emitter.count).sum();
        let bounced = emitters.iter().find(|emitter| emitter.is_bounced()).map(|emitter| emitter.first);
        let mut plan = MemoryPlan::default();
        Self::memory(&mut plan, capacity);
        plan.check(device.info())?;
        let spec = Self::program(surfaces, settings, bounced.is_some());
        let within = |light| {
            light_places(light, frame).is_some_and(|box_| surfaces.may_begin_within(&box_, medium.is_some()))
        };
        let spec = spec.feature("BEGINS_WITHIN", lights.iter().any(within));
        let program =
            Program::build(device, &medium.iter().fold(spec, |spec, medium| medium.specialise(spec)))?;
        let bounce = bounced.map(|first| {
            let kernel = program.kernel(device, "photons_bounce")?;
            Ok::<_, Error>((first, kernel, Buffer::zeroed(device, ACCOUNTS)?))
        });
        let [seed_low, seed_high] = [settings.seed as u32, (settings.seed >> 32) as u32];
        let [r, g, b] = mean_color().map(|mean| (1.0 / mean) as f32);
        let parameters = PhotonFrame {
            white: [r, g, b, 0.0],
            guide: guide(surfaces),
            seed_low,
            seed_high,
            emitters: emitters.len() as u32,
            depth: settings.depth,
            plane_count: buffers.plane_count,
            node_count: buffers.node_count,
            bounces: settings.bounces,
            pad_0: 0,
        };
        // No kernel takes an empty buffer.
        let listed = if emitters.is_empty() { vec![Emitter::zeroed()] } else { emitters };
        Ok(Self {
            kernel: program.kernel(device, "photons_trace")?,
            bounce: bounce.transpose()?,
            frame: Buffer::from_slice(device, &[parameters])?,
            emitters: Buffer::from_slice(device, &listed)?,
            surfaces: buffers,
            medium,
            photons: Buffer::uninitialised(device, capacity as usize)?,
            accounts: Buffer::zeroed(device, ACCOUNTS)?,
            capacity,
            unit: frame.unit,
            build_time: program.build_time,
        })
    }

    /// The program for these surfaces, and for photons that diffuse ones reflect if there are any.
    pub fn program(surfaces: &SurfaceArrays, settings: &PhotonSettings, bounces: bool) -> ProgramSpec {
        let entry = if bounces { "caustics/bounces.cl" } else { "caustics/photons.cl" };
        surfaces
            .specialise(ProgramSpec::new(entry))
            .feature("DISPERSION", surfaces.disperses())
            .feature("STORE_DIRECT", settings.store_direct)
    }

    /// Adds what so many photons take on the device.
    pub fn memory(plan: &mut MemoryPlan, photons: u32) {
        plan.add("photons", photons.into(), size_of::<Photon>());
        plan.add("accounts of photons", 2 * ACCOUNTS as u64, size_of::<PhotonAccount>());
    }

    /// Traces photons [`first`, `first` + `count`) of a pass into their slots; waits.
    ///
    /// # Errors
    /// [`Error::Failed`] when there are fewer photons in a pass, or the device fails.
    pub fn trace(&mut self, device: &Device, pass: u32, first: u32, count: u32) -> Result<Duration> {
        let start = Instant::now();
        let end = first.checked_add(count).filter(|end| *end <= self.capacity).ok_or_else(|| {
            Error::Failed(format!(
                "there are no {count} photons from {first} on: a pass has {}",
                self.capacity
            ))
        })?;
        let Self { kernel, bounce, frame, emitters, surfaces, medium, photons, accounts, .. } = self;
        let launch = |kernel: &mut Kernel, accounts: &Buffer<PhotonAccount>, range: Range<u32>| {
            for from in range.clone().step_by(ACCOUNTS) {
                let part = (range.end - from).min(ACCOUNTS as u32);
                let mut arguments = vec![Arg::from(&*frame), (&*emitters).into()];
                arguments.extend(surfaces.arguments());
                arguments.extend([(&*photons).into(), accounts.into()]);
                arguments.extend(medium.iter().flat_map(PhotonMedium::arguments));
                arguments.extend([ACCOUNTS as u32, pass, from, part].map(Arg::from));
                kernel.enqueue(device, &arguments, [part as usize, 1, 1])?;
            }
            Ok::<_, Error>(())
        };
        let bounced = bounce.as_ref().map_or(end, |(first, ..)| *first).clamp(first, end);
        launch(kernel, accounts, first..bounced)?;
        if let Some((_, kernel, accounts)) = bounce {
            launch(kernel, accounts, bounced..end)?;
        }
        device.finish()?;
        Ok(start.elapsed())
    }

    /// The slots of a pass's photons.
    pub fn photons(&self) -> &Buffer<Photon> {
        &self.photons
    }

    /// Which of them are photons that diffuse surfaces reflect: the last ones, or none.
    pub fn bounced_slots(&self) -> Range<usize> {
        let first = self.bounce.as_ref().map_or(self.capacity, |(first, ..)| *first);
        first as usize..self.capacity as usize
    }

    /// Photons in a pass: as many as the settings say, or none where no light has any to send.
    pub fn capacity(&self) -> u32 {
        self.capacity
    }

    /// Where the flux of all photons that diffuse surfaces reflect went so far, scene units.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device fails.
    pub fn bounced(&self, device: &Device) -> Result<BouncedLedger> {
        let Some((_, _, accounts)) = &self.bounce else { return Ok(BouncedLedger::default()) };
        Ok(BouncedLedger::of(&accounts.read(device)?, self.unit))
    }

    /// Where the flux of all other photons traced so far went, scene units.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device fails.
    pub fn ledger(&self, device: &Device) -> Result<PhotonLedger> {
        Ok(PhotonLedger::of(&self.accounts.read(device)?, self.unit))
    }
}
