//! Several devices on one picture.
//!
//! The film is the host's. Rows of tiles go to whichever device is free, come back with more samples, and go out again;
//! what a device adds to a pixel is what any other, or one alone, would have added, so the picture does not depend on
//! how the work fell. Where each sample has photons of its own (caustics), devices take whole samples instead, which are
//! added in their order. A device that fails is left out from then on, and others do again what it had in hand.
//!
//! A member gets its work at a desk (`desk`): that of its seat at the board (`seat`), or, in another process, one that
//! writes letters (`far`), which somebody here takes to the member's seat (`attend`).

mod attend;
mod board;
mod desk;
mod far;
mod fold;
mod message;
mod queue;
mod seat;
mod shared;
mod state;
mod worker;

use crate::device::{Device, DeviceName, MemoryPlan};
use crate::film::FilmPixel;
use crate::irradiance::{LightData, LightFacts};
use crate::post::Line;
use crate::render::{Auxiliary, Facts, PathLedger, Plan, Progress, Rendering, SavedFilm, Shift};
use crate::{Error, Result};
use far::Far;
use seat::Seat;
use shared::Shared;
use state::Moment;
use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread::Scope;
use std::time::Duration;

/// How long a step waits for news, at most: between steps interrupts are answered and pictures written.
const PATIENCE: Duration = Duration::from_millis(50);

/// A device of another process, where [`join`] works with it.
pub struct Colleague<'a> {
    /// What people call it.
    pub name: DeviceName,
    /// The line to it.
    pub line: Line<'a>,
}

/// Who works together.
pub struct Team<'a> {
    /// The devices of this process.
    pub devices: Vec<Device>,
    /// Those of others.
    pub colleagues: Vec<Colleague<'a>>,
}

impl From<Vec<Device>> for Team<'_> {
    fn from(devices: Vec<Device>) -> Self {
        Self { devices, colleagues: Vec::new() }
    }
}

impl Team<'_> {
    /// The devices, those of this process first.
    pub fn names(&self) -> Vec<DeviceName> {
        let here = self.devices.iter().map(|device| device.info().names());
        here.chain(self.colleagues.iter().map(|colleague| colleague.name.clone())).collect()
    }
}

/// Works with `device` for the crew at the other end of `line`, which has the same plan, until that has no more work, the
/// device fails, or `closing` is set.
pub fn join(line: Line<'_>, plan: &Plan<'_>, device: Device, closing: Arc<AtomicBool>) {
    worker::run(&Far::new(line, plan, closing), plan, device);
}

/// A render on several devices.
pub struct Crew<'s> {
    shared: Arc<Shared<'s>>,
    names: Vec<DeviceName>,
    /// Taken from the workers when they are asked for.
    light_facts: Option<LightFacts>,
    light_hash: Option<String>,
    light_from_file: bool,
    /// All that goes with the film that was read last, until the next step.
    moment: RefCell<Option<Moment>>,
    build_time: Duration,
    build_cached: bool,
    spent_building: Duration,
}

impl<'s> Crew<'s> {
    /// Sets `team` to work on `plan`, each member served by a thread of `scope`; `light`: a light volume that was computed
    /// before, for methods that project one; `saved`: a film of the same plan to continue.
    ///
    /// # Errors
    /// [`Error::Failed`] where there is no device.
    pub fn start(
        scope: &'s Scope<'s, '_>,
        plan: &'s Plan<'s>,
        team: impl Into<Team<'s>>,
        light: Option<&LightData>,
        saved: Option<SavedFilm>,
    ) -> Result<Self> {
        let Team { devices, colleagues } = team.into();
        let here: Vec<DeviceName> = devices.iter().map(|device| device.info().names()).collect();
        let away: Vec<DeviceName> = colleagues.iter().map(|colleague| colleague.name.clone()).collect();
        if here.is_empty() && away.is_empty() {
            return Err(Error::Failed("a render needs one device at least".into()));
        }
        let spent_building = saved.as_ref().map_or(Duration::ZERO, |saved| saved.spent.build);
        let shared = Arc::new(Shared::new(plan, &here, &away, light, saved));
        for (me, device) in devices.into_iter().enumerate() {
            let seat = Seat::new(&shared, me);
            scope.spawn(move || worker::run(&seat, plan, device));
        }
        for (me, colleague) in (here.len()..).zip(colleagues) {
            let seat = Seat::new(&shared, me);
            scope.spawn(move || attend::attend(&seat, plan, &colleague.line));
        }
        let names = [here, away].concat();
        let mut crew = Self {
            shared,
            names,
            light_facts: None,
            light_hash: light.map(LightData::hash),
            light_from_file: false,
            moment: RefCell::new(None),
            build_time: spent_building,
            build_cached: false,
            spent_building,
        };
        crew.refresh();
        Ok(crew)
    }

    /// What each device needs beside a render of its own.
    pub fn memory(plan: &Plan<'_>) -> MemoryPlan {
        let mut memory = plan.memory();
        if plan.method.caustics.is_some() {
            let image = &plan.scene.image;
            let pixels = u64::from(image.width) * u64::from(image.height);
            memory.add("film to which samples are added", pixels, size_of::<FilmPixel>());
        }
        memory
    }

    /// Notes whether the light volume was read from a file.
    pub fn set_light_from_file(&mut self, from_file: bool) {
        self.light_from_file = from_file;
    }

    fn refresh(&mut self) {
        let known = self.shared.known();
        self.light_facts = known.light_facts;
        if known.light_hash.is_some() {
            self.light_hash = known.light_hash;
        }
        self.build_time = self.spent_building + known.build_time;
        self.build_cached = known.build_cached;
    }
}

impl Drop for Crew<'_> {
    fn drop(&mut self) {
        self.shared.close();
    }
}

impl Rendering for Crew<'_> {
    fn step(&mut self, target: u32) -> Result<()> {
        self.moment.replace(None);
        self.shared.aim_at(target);
        let waited = self.shared.wait(PATIENCE);
        self.refresh();
        waited
    }

    fn progress(&self) -> Progress {
        self.moment.borrow().as_ref().map_or_else(|| self.shared.progress(), |moment| moment.progress)
    }

    fn film(&self) -> Result<Vec<FilmPixel>> {
        let (film, moment) = self.shared.film();
        self.moment.replace(Some(moment));
        Ok(film)
    }

    fn auxiliary(&self) -> Result<Option<Vec<Auxiliary>>> {
        let kept = self.moment.borrow();
        Ok(kept.as_ref().map_or_else(|| self.shared.moment().auxiliary, |moment| moment.auxiliary.clone()))
    }

    fn ledger(&self) -> Result<Option<PathLedger>> {
        let kept = self.moment.borrow();
        Ok(kept.as_ref().map_or_else(|| self.shared.moment().paths, |moment| moment.paths))
    }

    fn light(&self) -> Result<Option<LightData>> {
        Ok(self.shared.light().map(|data| (*data).clone()))
    }

    fn compute_light(&mut self, go_on: &dyn Fn() -> bool) -> Result<()> {
        while !self.shared.is_light_settled() {
            if !go_on() {
                return Err(Error::Interrupted);
            }
            self.shared.wait(PATIENCE)?;
        }
        self.refresh();
        Ok(())
    }

    /// The film is the host's, and only whole shares come to it.
    fn outlives_devices(&self) -> bool {
        true
    }

    fn shifts(&self) -> Vec<Shift> {
        self.shared.shifts()
    }

    fn facts(&self) -> Facts<'_> {
        let kept = self.moment.borrow();
        let photons = kept.as_ref().map_or_else(|| self.shared.photons(), |moment| moment.photons);
        Facts {
            devices: self.names.clone(),
            build_time: self.build_time,
            build_cached: self.build_cached,
            light: self.light_facts.as_ref(),
            light_hash: self.light_hash.as_deref(),
            light_from_file: self.light_from_file,
            passes: self.shared.known().passes,
            photons,
        }
    }

    fn take_notes(&mut self) -> Vec<String> {
        self.shared.take_notes()
    }
}
