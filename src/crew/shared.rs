//! What the devices of a crew share: the film, the work that is left, and what has become of each of them.

use super::board::{Board, Unit};
use super::queue::{Queue, Sample};
use super::state::{Held, Known, LONG, Light, Member, State, Work, slow_rows};
use crate::caustics::PassFacts;
use crate::device::DeviceInfo;
use crate::film::FilmPixel;
use crate::irradiance::{LightData, LightFacts};
use crate::render::{Auxiliary, PathLedger, Plan, Progress, Rows, SavedFilm, Shift, TILE, extent_of_rows};
use crate::{Error, Result};
use bytemuck::Zeroable;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// What a device is to do next.
pub(super) enum Order {
    /// These rows, from their state on.
    Rows(Unit, Box<Rows>),
    /// This sample of all pixels.
    Pass(u32),
    /// To add what has come in to the film.
    Add,
    /// Nothing more.
    Leave,
}

/// What a device that can start needs to know of light in the volume.
pub(super) enum LightOrder {
    /// There is none.
    None,
    /// It computes it.
    Compute,
    /// It is computed.
    Given(Arc<LightData>),
}

/// The board on which the members of a crew meet.
pub(super) struct Shared<'s> {
    plan: &'s Plan<'s>,
    state: Mutex<State>,
    /// Told when there is work, or none any more.
    work: Condvar,
    /// Told when something has come in.
    news: Condvar,
    /// Set at the end.
    pub closing: Arc<AtomicBool>,
}

impl<'s> Shared<'s> {
    pub fn new(
        plan: &'s Plan<'s>,
        infos: &[DeviceInfo],
        light: Option<&LightData>,
        saved: Option<SavedFilm>,
    ) -> Self {
        let (width, height) = (plan.scene.image.width, plan.scene.image.height);
        let pixels = width as usize * height as usize;
        let saved = saved.unwrap_or_else(|| SavedFilm::empty(plan));
        let begun = saved.spent.progress;
        let (tiles, rows) = (width.div_ceil(TILE), height.div_ceil(TILE));
        let caustics = plan.method.caustics.is_some();
        let work = if caustics {
            Work::Passes(Queue::new(begun.samples))
        } else {
            let had = |row: u32| {
                let (_, extent) = extent_of_rows(row..row + 1, width, height);
                saved.pixels[extent].iter().map(FilmPixel::tried).min().unwrap_or(0)
            };
            Work::Rows(Board::new((0..rows).map(had), tiles))
        };
        let member = |info: &DeviceInfo| Member {
            selector: info.selector.clone(),
            name: info.name.clone(),
            held: Held::Nothing,
            samples: 0,
            seconds: 0.0,
            passes: None,
            lost: None,
        };
        let auxiliary = plan.has_auxiliary().then(|| vec![Auxiliary::zeroed(); pixels]);
        let state = State {
            goal: 0,
            work,
            film: saved.pixels,
            auxiliary: saved.auxiliary.or(auxiliary),
            paths: plan.method.paths.then(|| saved.paths.unwrap_or_default()),
            photons: caustics.then(|| saved.photons.unwrap_or_default()),
            light: match (&plan.method.light, light) {
                (None, _) => Light::None,
                (Some(_), Some(data)) => Light::Done(Arc::new(data.clone())),
                (Some(_), None) => Light::Wanted,
            },
            members: infos.iter().map(member).collect(),
            notes: Vec::new(),
            launches: begun.launches,
            device_time: begun.device_time,
            known: Known { build_cached: true, ..Known::default() },
        };
        Self {
            plan,
            state: Mutex::new(state),
            work: Condvar::new(),
            news: Condvar::new(),
            closing: Arc::new(AtomicBool::new(false)),
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // A thread that panicked has left the film whole: it is changed by whole shares alone.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_closing(&self) -> bool {
        self.closing.load(Ordering::Relaxed)
    }

    fn extent(&self, rows: Range<u32>) -> (Range<u32>, Range<usize>) {
        extent_of_rows(rows, self.plan.scene.image.width, self.plan.scene.image.height)
    }
}

/// For who waits.
impl Shared<'_> {
    /// Sets how many samples every pixel is to get.
    pub fn aim_at(&self, goal: u32) {
        let mut state = self.lock();
        if state.goal != goal {
            state.goal = goal;
            self.work.notify_all();
        }
    }

    /// Waits for news, at most so long.
    ///
    /// # Errors
    /// [`Error::Failed`] when no member is left.
    pub fn wait(&self, patience: Duration) -> Result<()> {
        let state = self.lock();
        let at_goal =
            state.progress().samples >= state.goal && matches!(state.light, Light::None | Light::Done(_));
        let state = if at_goal {
            state
        } else {
            self.news.wait_timeout(state, patience).unwrap_or_else(PoisonError::into_inner).0
        };
        let lost = |member: &Member| Some(format!("{}: {}", member.name, member.lost.as_ref()?));
        match state.members.iter().map(lost).collect::<Option<Vec<String>>>() {
            Some(reasons) => {
                Err(Error::Failed(format!("no device is left that works: {}", reasons.join("; "))))
            }
            None => Ok(()),
        }
    }

    /// Tells all members to leave.
    pub fn close(&self) {
        self.closing.store(true, Ordering::Relaxed);
        // Who is about to wait has not looked yet, or holds the lock.
        drop(self.lock());
        self.work.notify_all();
    }

    pub fn progress(&self) -> Progress {
        self.lock().progress()
    }

    pub fn film(&self) -> Vec<FilmPixel> {
        self.lock().film.clone()
    }

    pub fn auxiliary(&self) -> Option<Vec<Auxiliary>> {
        self.lock().auxiliary.clone()
    }

    pub fn paths(&self) -> Option<PathLedger> {
        self.lock().paths
    }

    pub fn light(&self) -> Option<Arc<LightData>> {
        match &self.lock().light {
            Light::Done(data) => Some(Arc::clone(data)),
            _ => None,
        }
    }

    pub fn take_notes(&self) -> Vec<String> {
        std::mem::take(&mut self.lock().notes)
    }

    pub fn known(&self) -> Known {
        let state = self.lock();
        let passes = state.members.iter().filter_map(|member| member.passes.as_ref());
        let passes = passes.copied().reduce(|sum, facts| sum.plus(&facts));
        Known { passes, photons: state.photons, ..state.known.clone() }
    }

    pub fn shifts(&self) -> Vec<Shift> {
        let shift = |member: &Member| Shift {
            selector: member.selector.clone(),
            name: member.name.clone(),
            samples: member.samples,
            seconds: member.seconds,
            lost: member.lost.clone(),
        };
        self.lock().members.iter().map(shift).collect()
    }
}

/// For the members.
impl Shared<'_> {
    /// What `me` needs of the light; waits while another member computes it. `None` at the end.
    pub fn light_order(&self, me: usize) -> Option<LightOrder> {
        let mut state = self.lock();
        loop {
            if self.is_closing() {
                return None;
            }
            match &state.light {
                Light::None => return Some(LightOrder::None),
                Light::Done(data) => return Some(LightOrder::Given(Arc::clone(data))),
                Light::Wanted => {
                    state.light = Light::Computing(me, 0.0);
                    return Some(LightOrder::Compute);
                }
                Light::Computing(..) => {
                    state = self.work.wait(state).unwrap_or_else(PoisonError::into_inner);
                }
            }
        }
    }

    /// `me` has computed so much of the light.
    pub fn light_progress(&self, me: usize, share: f32) {
        self.lock().light = Light::Computing(me, share);
        self.news.notify_all();
    }

    /// The light is computed.
    pub fn light_done(&self, data: LightData, facts: Option<LightFacts>, launches: u64, elapsed: Duration) {
        let hash = data.hash();
        let mut state = self.lock();
        state.light = Light::Done(Arc::new(data));
        state.known.light_facts = facts;
        state.known.light_hash = Some(hash);
        state.launches += launches;
        state.device_time += elapsed;
        self.work.notify_all();
        self.news.notify_all();
    }

    /// A member has built its programs.
    pub fn built(&self, time: Duration, cached: bool) {
        let known = &mut self.lock().known;
        known.build_time += time;
        known.build_cached &= cached;
    }

    /// What `me` does next, `pace` being the tile-samples that it does in a piece; waits where there is nothing to do.
    pub fn order(&self, me: usize, pace: u64) -> Order {
        let mut state = self.lock();
        loop {
            if self.is_closing() {
                return Order::Leave;
            }
            let (members, goal) = (state.members_left(), state.goal);
            match &mut state.work {
                Work::Rows(board) => {
                    if let Some(unit) = board.take(pace, members, goal).or_else(|| slow_rows(&state.members))
                    {
                        state.members[me].held = Held::Rows(unit.clone(), Instant::now());
                        let rows = self.rows(&state, &unit);
                        return Order::Rows(unit, Box::new(rows));
                    }
                }
                Work::Passes(queue) => {
                    if queue.has_next() {
                        return Order::Add;
                    }
                    if let Some(sample) = queue.take(me, members, goal) {
                        state.members[me].held = Held::Pass(sample);
                        return Order::Pass(sample);
                    }
                }
            }
            state = self.work.wait_timeout(state, LONG / 4).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Whether what `me` has in hand is still wanted.
    pub fn go_on(&self, me: usize) -> bool {
        !self.is_closing() && !matches!(self.lock().members[me].held, Held::Nothing)
    }

    fn rows(&self, state: &State, unit: &Unit) -> Rows {
        let (tiles, pixels) = self.extent(unit.rows.clone());
        Rows {
            first_tile: tiles.start,
            tiles: tiles.end - tiles.start,
            width: self.plan.scene.image.width,
            film: state.film[pixels.clone()].to_vec(),
            auxiliary: state.auxiliary.as_ref().map_or(Vec::new(), |all| all[pixels.clone()].to_vec()),
            paths: PathLedger::default(),
            pixels,
        }
    }

    /// `me` has done these rows.
    pub fn rows_done(&self, me: usize, unit: &Unit, rows: &Rows, elapsed: Duration, launches: u64) {
        let mut state = self.lock();
        if matches!(state.members[me].held, Held::Nothing) {
            // Another one was first.
            return;
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
        state.enter(me, rows.film.len() as u64 * u64::from(unit.samples), elapsed, launches);
        self.work.notify_all();
        self.news.notify_all();
    }

    /// `me` has rendered a sample of all pixels.
    pub fn pass_done(
        &self,
        me: usize,
        number: u32,
        sample: Sample,
        facts: Option<PassFacts>,
        elapsed: Duration,
    ) {
        let mut state = self.lock();
        let pixels = state.film.len() as u64;
        state.members[me].passes = facts;
        let Work::Passes(queue) = &mut state.work else { return };
        queue.release(number, me);
        let fresh = queue.deliver(number, sample);
        state.enter(me, if fresh { pixels } else { 0 }, elapsed, 0);
    }

    /// A film and the sample that is to be added to it, where it is the turn of one that has come in.
    pub fn begin_adding(&self) -> Option<(Vec<FilmPixel>, u32, Sample)> {
        let mut state = self.lock();
        let Work::Passes(queue) = &mut state.work else { return None };
        let (number, sample) = (queue.added(), queue.begin_adding()?);
        Some((state.film.clone(), number, sample))
    }

    /// The film with that sample added, or the sample, as it could not be.
    pub fn end_adding(&self, sample: Sample, film: Result<Vec<FilmPixel>>, launches: u64) -> Result<()> {
        let mut state = self.lock();
        let Work::Passes(queue) = &mut state.work else { return Ok(()) };
        let film = match film {
            Ok(film) => film,
            Err(error) => {
                queue.put_back(sample);
                self.work.notify_all();
                return Err(error);
            }
        };
        queue.added_one();
        let passes = queue.added();
        state.film = film;
        if let Some(ledger) = &mut state.photons {
            ledger.flux = ledger.flux.plus(&sample.photons.flux);
            ledger.bounced = ledger.bounced.plus(&sample.photons.bounced);
            ledger.passes = passes;
        }
        state.launches += launches;
        self.work.notify_all();
        self.news.notify_all();
        Ok(())
    }

    /// `me` does no more; what it had in hand is for others.
    pub fn lose(&self, me: usize, error: &Error) {
        let mut state = self.lock();
        let held = std::mem::replace(&mut state.members[me].held, Held::Nothing);
        let held_by_others = |unit: &Unit, members: &[Member]| {
            members.iter().any(|member| matches!(&member.held, Held::Rows(other, _) if other == unit))
        };
        let state = &mut *state;
        match (&mut state.work, held) {
            (Work::Rows(board), Held::Rows(unit, _)) if !held_by_others(&unit, &state.members) => {
                board.give_back(&unit);
            }
            (Work::Passes(queue), Held::Pass(sample)) => queue.release(sample, me),
            _ => {}
        }
        if matches!(state.light, Light::Computing(who, _) if who == me) {
            state.light = Light::Wanted;
        }
        if !matches!(error, Error::Interrupted) {
            let member = &mut state.members[me];
            member.lost = Some(error.to_string());
            let (name, selector) = (&member.name, &member.selector);
            let note = format!("{name} ({selector}) is left out from now on: {error}");
            if state.members_left() > 0 {
                state.notes.push(note);
            }
        }
        self.work.notify_all();
        self.news.notify_all();
    }
}
