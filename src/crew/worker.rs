//! A device of a crew at work, on a thread of its own.

use super::desk::{Desk, LightOrder, Order};
use super::fold::Folder;
use super::queue::Sample;
use crate::device::{Device, Pacer};
use crate::render::{Plan, Session};
use crate::{Error, Result};
use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Works for a crew until the end, or until the device fails.
pub(super) fn run(desk: &dyn Desk, plan: &Plan<'_>, device: Device) {
    // A panic of one thread must not keep the others waiting.
    let work = std::panic::AssertUnwindSafe(|| serve(desk, plan, device));
    let ended = std::panic::catch_unwind(work)
        .unwrap_or_else(|_| Err(Error::Failed("its thread panicked: a mistake of this program".into())));
    if let Err(error) = ended {
        desk.lose(&error);
    }
}

fn serve(desk: &dyn Desk, plan: &Plan<'_>, device: Device) -> Result<()> {
    let Some(light) = desk.light()? else { return Ok(()) };
    let given = if let LightOrder::Given(data) = &light { Some(&**data) } else { None };
    super::Crew::memory(plan).check(device.info())?;
    let mut session = Session::lit(device.clone(), plan, given)?;
    session.interrupt_by(Arc::clone(desk.closing()));
    if let LightOrder::Compute = light {
        compute_light(desk, &mut session)?;
    }
    let adder = Adder::new(desk, plan, device)?;
    desk.built(session.build_time + adder.build_time(), session.build_cached)?;
    // Samples of members that are elsewhere come in at any time.
    let go_on = || adder.add_samples(0) && desk.go_on();
    let mut pacer = Pacer::new(desk.piece());
    loop {
        let begun = session.progress().launches;
        match desk.order(pacer.next(64))? {
            Order::Leave => return Ok(()),
            Order::Add => _ = adder.add_samples(0),
            Order::Rows(unit, mut rows) => {
                let start = Instant::now();
                if session.compute(&mut rows, unit.first_sample + unit.samples, &|| desk.go_on())? {
                    let elapsed = start.elapsed();
                    pacer.measured(u64::from(rows.tiles) * u64::from(unit.samples), elapsed);
                    desk.rows_done(&unit, &rows, elapsed, session.progress().launches - begun)?;
                }
            }
            Order::Pass(number) => {
                let start = Instant::now();
                if let Some((film, photons)) = session.compute_pass(number, &go_on)? {
                    let facts = session.pass_facts().copied();
                    desk.pass_done(number, Sample::new(&film, photons), facts, start.elapsed())?;
                    adder.add_samples(session.progress().launches - begun);
                }
            }
        }
        adder.check()?;
    }
}

/// Computes the light for all members.
fn compute_light(desk: &dyn Desk, session: &mut Session) -> Result<()> {
    let start = Instant::now();
    while session.progress().light < 1.0 {
        if desk.closing().load(Ordering::Relaxed) {
            return Err(Error::Interrupted);
        }
        session.advance_light()?;
        desk.light_progress(session.progress().light)?;
    }
    let data = session.light()?.ok_or_else(|| Error::Failed("there is no light volume to share".into()))?;
    let facts = session.light_facts().cloned();
    desk.light_done(data, facts, session.progress().launches, start.elapsed())
}

/// Adds samples to the film, for methods that render whole ones.
struct Adder<'a> {
    desk: &'a dyn Desk,
    device: Device,
    folder: RefCell<Option<Folder>>,
    failure: RefCell<Option<Error>>,
}

impl<'a> Adder<'a> {
    fn new(desk: &'a dyn Desk, plan: &Plan<'_>, device: Device) -> Result<Self> {
        let pixels = plan.scene.image.width as usize * plan.scene.image.height as usize;
        let folder = plan.method.caustics.is_some().then(|| Folder::new(&device, pixels)).transpose()?;
        Ok(Self { desk, device, folder: RefCell::new(folder), failure: RefCell::new(None) })
    }

    fn build_time(&self) -> Duration {
        self.folder.borrow().as_ref().map_or(Duration::ZERO, |folder| folder.build_time)
    }

    /// Adds those samples to the film whose turn it is, unless another member does; `launches`: those that the first of
    /// them took. `false` when that fails, for the reason that [`Adder::check`] has.
    fn add_samples(&self, mut launches: u64) -> bool {
        let mut add = || -> Result<()> {
            let mut folder = self.folder.borrow_mut();
            let Some(folder) = folder.as_mut() else { return Ok(()) };
            while let Some((film, number, sample)) = self.desk.begin_adding()? {
                let film = folder.add(&self.device, &film, number, &sample.film());
                self.desk.end_adding(sample, film, launches + 1)?;
                launches = 0;
            }
            Ok(())
        };
        let failure = add().err();
        let added = failure.is_none();
        if !added {
            self.failure.replace(failure);
        }
        added
    }

    /// Why adding has failed, if it has.
    fn check(&self) -> Result<()> {
        self.failure.take().map_or(Ok(()), Err)
    }
}
