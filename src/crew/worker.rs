//! A device of a crew at work, on a thread of its own.

use super::fold::Folder;
use super::queue::Sample;
use super::shared::{LightOrder, Order, Shared};
use crate::device::{Device, Pacer};
use crate::render::{Plan, Session};
use crate::{Error, Result};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Pieces of work aim at this length: copies to and fro take little of it, and all devices end nearly together.
const PIECE: Duration = Duration::from_millis(250);

/// Works for `shared` until the end, or until the device fails.
pub(super) fn run(shared: &Shared<'_>, plan: &Plan<'_>, device: Device, me: usize) {
    // A panic of one thread must not keep the others waiting.
    let work = std::panic::AssertUnwindSafe(|| serve(shared, plan, device, me));
    let ended = std::panic::catch_unwind(work)
        .unwrap_or_else(|_| Err(Error::Failed("its thread panicked: a mistake of this program".into())));
    if let Err(error) = ended {
        shared.lose(me, &error);
    }
}

fn serve(shared: &Shared<'_>, plan: &Plan<'_>, device: Device, me: usize) -> Result<()> {
    let Some(light) = shared.light_order(me) else { return Ok(()) };
    let given = if let LightOrder::Given(data) = &light { Some(&**data) } else { None };
    super::Crew::memory(plan).check(device.info())?;
    let mut session = Session::lit(device, plan, given)?;
    session.interrupt_by(Arc::clone(&shared.closing));
    if let LightOrder::Compute = light {
        compute_light(shared, &mut session, me)?;
    }
    let mut folder = None;
    if plan.method.caustics.is_some() {
        let pixels = plan.scene.image.width as usize * plan.scene.image.height as usize;
        folder = Some(Folder::new(session.device(), pixels)?);
    }
    let folding = folder.as_ref().map_or(Duration::ZERO, |folder| folder.build_time);
    shared.built(session.build_time + folding, session.build_cached);
    let go_on = || shared.go_on(me);
    let mut pacer = Pacer::new(PIECE);
    loop {
        let begun = session.progress().launches;
        match shared.order(me, pacer.next(64)) {
            Order::Leave => return Ok(()),
            Order::Add => add_samples(shared, &session, folder.as_mut(), 0)?,
            Order::Rows(unit, mut rows) => {
                let start = Instant::now();
                if session.compute(&mut rows, unit.first_sample + unit.samples, &go_on)? {
                    let elapsed = start.elapsed();
                    pacer.measured(u64::from(rows.tiles) * u64::from(unit.samples), elapsed);
                    shared.rows_done(me, &unit, &rows, elapsed, session.progress().launches - begun);
                }
            }
            Order::Pass(number) => {
                let start = Instant::now();
                if let Some((film, photons)) = session.compute_pass(number, &go_on)? {
                    let facts = session.pass_facts().copied();
                    shared.pass_done(me, number, Sample::new(&film, photons), facts, start.elapsed());
                    let launches = session.progress().launches - begun;
                    add_samples(shared, &session, folder.as_mut(), launches)?;
                }
            }
        }
    }
}

/// Computes the light for all members.
fn compute_light(shared: &Shared<'_>, session: &mut Session, me: usize) -> Result<()> {
    let start = Instant::now();
    while session.progress().light < 1.0 {
        if shared.closing.load(Ordering::Relaxed) {
            return Err(Error::Interrupted);
        }
        session.advance_light()?;
        shared.light_progress(me, session.progress().light);
    }
    let data = session.light()?.ok_or_else(|| Error::Failed("there is no light volume to share".into()))?;
    let facts = session.light_facts().cloned();
    shared.light_done(data, facts, session.progress().launches, start.elapsed());
    Ok(())
}

/// Adds those samples to the film whose turn it is, unless another member does.
fn add_samples(
    shared: &Shared<'_>,
    session: &Session,
    folder: Option<&mut Folder>,
    mut launches: u64,
) -> Result<()> {
    let Some(folder) = folder else { return Ok(()) };
    while let Some((film, number, sample)) = shared.begin_adding() {
        let film = folder.add(session.device(), &film, number, &sample.film());
        shared.end_adding(sample, film, launches + 1)?;
        launches = 0;
    }
    Ok(())
}
