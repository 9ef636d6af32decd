//! Passes: photons from the lights, and the maps in which they are gathered; new ones for each sample.
//!
//! A pass is a function of its number and the scene alone, so a render may be cut, stopped and resumed anywhere.

use super::{
    BouncedLedger, Focus, MapFacts, MapSettings, PassLedger, PhotonLedger, PhotonMap, PhotonMedium,
    PhotonTracer, Receiver, pass_radius, photon_settings,
};
use crate::Result;
use crate::device::{Arg, Buffer, Device, LAUNCH_TARGET, Pacer};
use crate::render::caustics::{BouncedSetup, CausticsSetup};
use crate::render::{Plan, Share};
use crate::surfaces::SurfaceBuffers;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

/// What the passes of a session did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PassFacts {
    /// Passes traced and mapped in this session.
    pub passes: u32,
    /// Photons of a pass.
    pub photons: u32,
    /// Those that the last map holds.
    pub mapped: usize,
    /// Cells of the last map along x, y, z; 0 where it has none.
    pub cells: [u32; 3],
    /// The radius of the last pass, scene units.
    pub radius: f64,
    /// Photons that diffuse surfaces reflect in the last map of these, which are not in the other.
    pub bounced_mapped: usize,
    /// Its cells.
    pub bounced_cells: [u32; 3],
    /// Its radius, scene units; 0 where there is none.
    pub bounce_radius: f64,
    /// Seconds of all passes to trace photons; these and the others are of both maps.
    pub trace_seconds: f64,
    /// ... to find their bounds and keys.
    pub key_seconds: f64,
    /// ... to sort them.
    pub sort_seconds: f64,
    /// ... to find the ranges of cells.
    pub fill_seconds: f64,
    /// ... to put photons in order.
    pub order_seconds: f64,
}

impl PassFacts {
    /// Both together, of devices that share the passes.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            passes: self.passes + other.passes,
            trace_seconds: self.trace_seconds + other.trace_seconds,
            key_seconds: self.key_seconds + other.key_seconds,
            sort_seconds: self.sort_seconds + other.sort_seconds,
            fill_seconds: self.fill_seconds + other.fill_seconds,
            order_seconds: self.order_seconds + other.order_seconds,
            ..*if self.passes > 0 && self.radius < other.radius { self } else { other }
        }
    }

    fn add_times(&mut self, map: &MapFacts) {
        self.key_seconds += map.keys.as_secs_f64();
        self.sort_seconds += map.sort.as_secs_f64();
        self.fill_seconds += map.fill.as_secs_f64();
        self.order_seconds += map.order.as_secs_f64();
    }
}

/// The map of some of the photons.
struct Gathered {
    map: PhotonMap,
    slots: Range<usize>,
    /// Of the first pass, local units.
    radius: f64,
}

impl Gathered {
    fn new(
        device: &Device,
        tracer: &PhotonTracer,
        slots: Range<usize>,
        settings: MapSettings,
        receivers: &[Receiver],
        (radius, focus): (f64, Option<Focus>),
    ) -> Result<Self> {
        let mut map = PhotonMap::new(device, settings, receivers, slots.len())?;
        if let Some(focus) = focus {
            map = map.focused(focus);
        }
        // Kernels take a map, be it an empty one.
        map.build(device, tracer.photons(), 0..0, radius as f32)?;
        Ok(Self { map, slots, radius })
    }

    /// The map of a pass, and its radius.
    fn build(
        &mut self,
        device: &Device,
        tracer: &PhotonTracer,
        alpha: f64,
        pass: u32,
    ) -> Result<(MapFacts, f64)> {
        let radius = pass_radius(self.radius, alpha, pass);
        Ok((self.map.build(device, tracer.photons(), self.slots.clone(), radius as f32)?, radius))
    }
}

/// The photons of one sample after another. Passes are counted from 0; in a part of a picture, they are those of its
/// samples.
pub struct Passes {
    share: Share,
    surfaces: Arc<SurfaceBuffers>,
    tracer: PhotonTracer,
    /// Photons that end at the first diffuse surface.
    caustics: Gathered,
    /// Those that go on from there.
    bounced: Option<Gathered>,
    alpha: f64,
    unit: f64,
    /// The pass that is being traced, and its photons so far.
    traced: (u32, u32),
    /// The pass that the maps hold.
    mapped: Option<u32>,
    pacer: Pacer,
    /// Of the first passes.
    ledger: PassLedger,
    /// What the tracer has entered up to the pass before.
    entered: (PhotonLedger, BouncedLedger),
    facts: PassFacts,
    /// Time to build the kernels, or to load them.
    pub build_time: Duration,
}

impl Passes {
    /// Makes the passes of `plan` ready; `voxels`: those of its volume, if it has one.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device lacks memory or does not build a kernel.
    pub fn new(
        device: &Device,
        plan: &Plan<'_>,
        setup: &CausticsSetup,
        voxels: Option<&Arc<Buffer<u8>>>,
    ) -> Result<Self> {
        let surfaces = Arc::new(SurfaceBuffers::new(device, &setup.surfaces)?);
        let lights = &plan.scene.lights;
        let settings = photon_settings(&setup.settings, plan.scene.seed);
        let medium = setup
            .medium
            .as_ref()
            .zip(voxels)
            .map(|(medium, voxels)| PhotonMedium::new(device, plan, medium, Arc::clone(voxels)));
        let tracer = PhotonTracer::within(
            device,
            lights,
            &setup.surfaces,
            Arc::clone(&surfaces),
            &plan.local,
            &settings,
            medium.transpose()?,
        )?;
        let focus = setup.surfaces.bounds.map(|bounds| Focus {
            centre: plan.local.point(bounds.centre()).as_vec3().to_array(),
            reach: (0.5 * bounds.size().max_element() / plan.local.unit) as f32,
        });
        let bounced_slots = tracer.bounced_slots();
        let caustic_slots = 0..bounced_slots.start;
        let (map, receivers) = (setup.map, &setup.receivers);
        let caustics = Gathered::new(device, &tracer, caustic_slots, map, receivers, (setup.radius, focus))?;
        let bounced = setup.bounced.as_ref().map(|bounced| {
            let BouncedSetup { map, receivers, radius, .. } = bounced;
            Gathered::new(device, &tracer, bounced_slots, *map, receivers, (*radius, focus))
        });
        Ok(Self {
            build_time: tracer.build_time,
            surfaces,
            caustics,
            bounced: bounced.transpose()?,
            alpha: setup.settings.alpha,
            unit: plan.local.unit,
            traced: (0, 0),
            mapped: None,
            pacer: Pacer::new(LAUNCH_TARGET),
            ledger: PassLedger::default(),
            entered: Default::default(),
            facts: PassFacts { photons: tracer.capacity(), ..PassFacts::default() },
            tracer,
            share: plan.share(),
        })
    }

    /// Whether the maps hold the photons of this pass.
    pub fn is_ready(&self, pass: u32) -> bool {
        self.mapped == Some(pass) || !self.has_photons()
    }

    /// Whether passes have any photons.
    pub fn has_photons(&self) -> bool {
        self.tracer.capacity() > 0
    }

    /// One launch towards the maps of `pass`.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device fails.
    pub fn step(&mut self, device: &Device, pass: u32) -> Result<()> {
        if self.traced.0 != pass {
            self.traced = (pass, 0);
        }
        let (_, done) = self.traced;
        let number = self.share.sample(pass);
        let left = self.tracer.capacity() - done;
        if left > 0 {
            let count = u32::try_from(self.pacer.next(1 << 14)).unwrap_or(u32::MAX).min(left);
            let elapsed = self.tracer.trace(device, number, done, count)?;
            self.pacer.measured(u64::from(count), elapsed);
            self.facts.trace_seconds += elapsed.as_secs_f64();
            self.traced.1 += count;
            return Ok(());
        }
        self.map(device, number)?;
        self.mapped = Some(pass);
        let entered = (self.tracer.ledger(device)?, self.tracer.bounced(device)?);
        // A pass that an earlier run began is there already.
        if pass >= self.ledger.passes {
            let flux = self.ledger.flux.plus(&entered.0.minus(&self.entered.0));
            let bounced = self.ledger.bounced.plus(&entered.1.minus(&self.entered.1));
            self.ledger = PassLedger { passes: pass + 1, flux, bounced };
        }
        self.entered = entered;
        Ok(())
    }

    /// Makes the maps of the photons of a sample.
    fn map(&mut self, device: &Device, number: u32) -> Result<()> {
        let Self { caustics, bounced, tracer, alpha, unit, facts, .. } = self;
        let (map, radius) = caustics.build(device, tracer, *alpha, number)?;
        facts.passes += 1;
        facts.add_times(&map);
        (facts.mapped, facts.cells, facts.radius) = (map.valid, map.cells, radius * *unit);
        if let Some(bounced) = bounced {
            let (map, radius) = bounced.build(device, tracer, *alpha, number)?;
            facts.add_times(&map);
            (facts.bounced_mapped, facts.bounced_cells) = (map.valid, map.cells);
            facts.bounce_radius = radius * *unit;
        }
        Ok(())
    }

    /// The surfaces and the maps, as `render_caustics` takes them.
    pub fn arguments(&self) -> impl Iterator<Item = Arg<'_>> {
        let maps = [Some(&self.caustics), self.bounced.as_ref()].into_iter().flatten();
        let maps = maps.flat_map(|gathered| gathered.map.arguments());
        self.surfaces.arguments().into_iter().chain(maps)
    }

    /// What the passes of this session did.
    pub fn facts(&self) -> &PassFacts {
        &self.facts
    }

    /// Where the flux of all photons in the picture went, of earlier runs, too.
    pub fn ledger(&self) -> &PassLedger {
        &self.ledger
    }

    /// Continues a render of which the passes of `ledger` were traced.
    pub fn restore(&mut self, ledger: PassLedger) {
        self.ledger = ledger;
    }

    /// Starts anew.
    pub fn reset(&mut self) {
        (self.mapped, self.traced) = (None, (0, 0));
        self.ledger = PassLedger::default();
        self.facts = PassFacts { photons: self.facts.photons, ..PassFacts::default() };
    }
}
