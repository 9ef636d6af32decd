//! A member's place at the board of a crew.

use super::board::Unit;
use super::desk::{Desk, LightOrder, Order};
use super::queue::Sample;
use super::shared::Shared;
use super::state::{Held, LONG, Light, Member, State, Work, slow_rows};
use crate::caustics::PassFacts;
use crate::film::FilmPixel;
use crate::irradiance::{LightData, LightFacts};
use crate::render::Rows;
use crate::{Error, Result};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

/// Pieces of work aim at this length: copies to and fro take little of it, and all members end nearly together.
const PIECE: Duration = Duration::from_millis(250);
/// Samples that rows get at once in another process, if they can: as often are they sent to and fro the less.
const FAR_DEPTH: u32 = 16;

/// The place of one member.
pub(super) struct Seat<'s> {
    shared: Arc<Shared<'s>>,
    me: usize,
    /// Whether its device is in another process.
    away: bool,
}

impl<'s> Seat<'s> {
    pub fn new(shared: &Arc<Shared<'s>>, me: usize) -> Self {
        let away = shared.lock().members[me].away;
        Self { shared: Arc::clone(shared), me, away }
    }

    /// The next work of those that are in hand, if there is some.
    fn next(&self, state: &mut State, pace: u64) -> Option<Order> {
        let (members, goal, here) = (state.members_left(), state.goal, state.is_anybody_here());
        match &mut state.work {
            Work::Rows(board) => {
                let depth = if self.away { FAR_DEPTH } else { 1 };
                let fresh = board.take(self.me, pace, members, goal, depth);
                let unit = fresh.or_else(|| slow_rows(&state.members))?;
                state.members[self.me].held = Held::Rows(unit.clone(), Instant::now());
                let rows = self.rows(state, &unit);
                Some(Order::Rows(unit, Box::new(rows)))
            }
            Work::Passes(queue) => {
                if queue.has_next() && !(self.away && here) {
                    return Some(Order::Add);
                }
                let sample = queue.take(self.me, members, goal)?;
                state.members[self.me].held = Held::Pass(sample);
                Some(Order::Pass(sample))
            }
        }
    }

    fn rows(&self, state: &State, unit: &Unit) -> Rows {
        let mut rows = Rows::of(unit.rows.clone(), self.shared.plan);
        rows.film = state.film[rows.pixels.clone()].to_vec();
        if let Some(all) = &state.auxiliary {
            rows.auxiliary = all[rows.pixels.clone()].to_vec();
        }
        rows
    }
}

impl Desk for Seat<'_> {
    fn closing(&self) -> &Arc<AtomicBool> {
        &self.shared.closing
    }

    fn piece(&self) -> Duration {
        PIECE
    }

    fn light(&self) -> Result<Option<LightOrder>> {
        let mut state = self.shared.lock();
        loop {
            if self.shared.is_closing() {
                return Ok(None);
            }
            match &state.light {
                Light::None => return Ok(Some(LightOrder::None)),
                Light::Done(data) => return Ok(Some(LightOrder::Given(Arc::clone(data)))),
                // It would have to come here first.
                light if light.waits() && !(self.away && state.is_anybody_here()) => {
                    state.light = Light::Computing(self.me, 0.0, Instant::now());
                    return Ok(Some(LightOrder::Compute));
                }
                Light::Wanted | Light::Computing(..) => {
                    let waited = self.shared.work.wait_timeout(state, LONG);
                    state = waited.unwrap_or_else(PoisonError::into_inner).0;
                }
            }
        }
    }

    fn light_progress(&self, share: f32) -> Result<()> {
        let mut state = self.shared.lock();
        // Who stood still may go on when another one has begun, or is done.
        if matches!(state.light, Light::Computing(who, ..) if who == self.me) {
            state.light = Light::Computing(self.me, share, Instant::now());
        }
        self.shared.news.notify_all();
        Ok(())
    }

    fn light_done(
        &self,
        data: LightData,
        facts: Option<LightFacts>,
        launches: u64,
        elapsed: Duration,
    ) -> Result<()> {
        let hash = data.hash();
        let mut state = self.shared.lock();
        if state.light.is_settled() {
            // Another one was first.
            return Ok(());
        }
        state.light = Light::Done(Arc::new(data));
        state.known.light_facts = facts;
        state.known.light_hash = Some(hash);
        state.launches += launches;
        state.device_time += elapsed;
        self.shared.work.notify_all();
        self.shared.news.notify_all();
        Ok(())
    }

    fn built(&self, time: Duration, cached: bool) -> Result<()> {
        let known = &mut self.shared.lock().known;
        known.build_time += time;
        known.build_cached &= cached;
        Ok(())
    }

    fn order(&self, pace: u64) -> Result<Order> {
        let mut state = self.shared.lock();
        loop {
            if self.shared.is_closing() {
                return Ok(Order::Leave);
            }
            if let Some(order) = self.next(&mut state, pace) {
                return Ok(order);
            }
            let waited = self.shared.work.wait_timeout(state, LONG / 4);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    fn go_on(&self) -> bool {
        !self.shared.is_closing() && !matches!(self.shared.lock().members[self.me].held, Held::Nothing)
    }

    fn rows_done(&self, unit: &Unit, rows: &Rows, elapsed: Duration, launches: u64) -> Result<()> {
        let mut state = self.shared.lock();
        if matches!(state.members[self.me].held, Held::Nothing) {
            // Another one was first.
            return Ok(());
        }
        for member in &mut state.members {
            if matches!(&member.held, Held::Rows(other, _) if other == unit) {
                member.held = Held::Nothing;
            }
        }
        state.film[rows.pixels.clone()].copy_from_slice(&rows.film);
        if let Some(all) = &mut state.auxiliary {
            all[rows.pixels.clone()].copy_from_slice(&rows.auxiliary);
        }
        if let Some(paths) = &mut state.paths {
            *paths = paths.plus(&rows.paths);
        }
        if let Work::Rows(board) = &mut state.work {
            board.done(unit);
        }
        state.enter(self.me, rows.film.len() as u64 * u64::from(unit.samples), elapsed, launches);
        self.shared.work.notify_all();
        self.shared.news.notify_all();
        Ok(())
    }

    fn pass_done(
        &self,
        number: u32,
        sample: Sample,
        facts: Option<PassFacts>,
        elapsed: Duration,
    ) -> Result<()> {
        let mut state = self.shared.lock();
        let pixels = state.film.len() as u64;
        state.members[self.me].passes = facts;
        let Work::Passes(queue) = &mut state.work else { return Ok(()) };
        queue.release(number, self.me);
        let fresh = queue.deliver(number, sample);
        state.enter(self.me, if fresh { pixels } else { 0 }, elapsed, 0);
        if self.away {
            // Who delivers adds, but for those that are away.
            self.shared.work.notify_all();
        }
        Ok(())
    }

    fn begin_adding(&self) -> Result<Option<(Vec<FilmPixel>, u32, Sample)>> {
        let mut state = self.shared.lock();
        if self.away && state.is_anybody_here() {
            return Ok(None);
        }
        let Work::Passes(queue) = &mut state.work else { return Ok(None) };
        let number = queue.added();
        let sample = queue.begin_adding();
        Ok(sample.map(|sample| (state.film.clone(), number, sample)))
    }

    fn end_adding(&self, sample: Sample, film: Result<Vec<FilmPixel>>, launches: u64) -> Result<()> {
        let mut state = self.shared.lock();
        let Work::Passes(queue) = &mut state.work else { return Ok(()) };
        let film = match film {
            Ok(film) => film,
            Err(error) => {
                queue.put_back(sample);
                self.shared.work.notify_all();
                return Err(error);
            }
        };
        queue.added_one();
        let passes = queue.added();
        state.film = film;
        // A render that was stopped within a sample may know its photons.
        if let Some(ledger) = state.photons.as_mut().filter(|ledger| ledger.passes < passes) {
            ledger.flux = ledger.flux.plus(&sample.photons.flux);
            ledger.bounced = ledger.bounced.plus(&sample.photons.bounced);
            ledger.passes = passes;
        }
        state.launches += launches;
        self.shared.work.notify_all();
        self.shared.news.notify_all();
        Ok(())
    }

    fn lose(&self, error: &Error) {
        let mut state = self.shared.lock();
        let held = std::mem::replace(&mut state.members[self.me].held, Held::Nothing);
        let held_by_others = |unit: &Unit, members: &[Member]| {
            members.iter().any(|member| matches!(&member.held, Held::Rows(other, _) if other == unit))
        };
        let state = &mut *state;
        match (&mut state.work, held) {
            (Work::Rows(board), Held::Rows(unit, _)) if !held_by_others(&unit, &state.members) => {
                board.give_back(&unit);
            }
            (Work::Passes(queue), Held::Pass(sample)) => queue.release(sample, self.me),
            _ => {}
        }
        if matches!(state.light, Light::Computing(who, ..) if who == self.me) {
            state.light = Light::Wanted;
        }
        if !matches!(error, Error::Interrupted) {
            let member = &mut state.members[self.me];
            member.lost = Some(error.to_string());
            let (name, selector) = (&member.name, &member.selector);
            let note = format!("{name} ({selector}) is left out from now on: {error}");
            if state.members_left() > 0 {
                state.notes.push(note);
            }
        }
        self.shared.work.notify_all();
        self.shared.news.notify_all();
    }
}
