//! What the devices of a crew share: the film, the work that is left, and what has become of each of them.

use super::board::Board;
use super::queue::Queue;
use super::state::{Held, Known, Light, Member, Moment, State, Work};
use crate::caustics::PassLedger;
use crate::device::DeviceName;
use crate::film::FilmPixel;
use crate::irradiance::LightData;
use crate::render::{Auxiliary, Plan, Progress, SavedFilm, Shift, TILE, extent_of_rows};
use crate::{Error, Result};
use bytemuck::Zeroable;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// The board on which the members of a crew meet.
pub(super) struct Shared<'s> {
    pub plan: &'s Plan<'s>,
    state: Mutex<State>,
    /// Told when there is work, or none any more.
    pub work: Condvar,
    /// Told when something has come in.
    pub news: Condvar,
    /// Set at the end.
    pub closing: Arc<AtomicBool>,
}

impl<'s> Shared<'s> {
    pub fn new(
        plan: &'s Plan<'s>,
        here: &[DeviceName],
        away: &[DeviceName],
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
        let member = |(name, away): (&DeviceName, bool)| Member {
            selector: name.selector.clone(),
            name: name.name.clone(),
            away,
            held: Held::Nothing,
            samples: 0,
            seconds: 0.0,
            passes: None,
            lost: None,
        };
        let who = std::iter::repeat_n(false, here.len()).chain(std::iter::repeat_n(true, away.len()));
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
            members: here.iter().chain(away).zip(who).map(member).collect(),
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

    pub fn lock(&self) -> MutexGuard<'_, State> {
        // A thread that panicked has left the film whole: it is changed by whole shares alone.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn is_closing(&self) -> bool {
        self.closing.load(Ordering::Relaxed)
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
        let at_goal = state.progress().samples >= state.goal && state.light.is_settled();
        let state = if at_goal {
            state
        } else {
            self.news.wait_timeout(state, patience).unwrap_or_else(PoisonError::into_inner).0
        };
        let lost = |member: &Member| Some(format!("{}: {}", member.selector, member.lost.as_ref()?));
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

    /// The film, and what goes with it.
    pub fn film(&self) -> (Vec<FilmPixel>, Moment) {
        let state = self.lock();
        (state.film.clone(), state.moment())
    }

    pub fn moment(&self) -> Moment {
        self.lock().moment()
    }

    pub fn photons(&self) -> Option<PassLedger> {
        self.lock().photons
    }

    pub fn light(&self) -> Option<Arc<LightData>> {
        match &self.lock().light {
            Light::Done(data) => Some(Arc::clone(data)),
            _ => None,
        }
    }

    /// Whether nobody has to compute light any more.
    pub fn is_light_settled(&self) -> bool {
        self.lock().light.is_settled()
    }

    pub fn take_notes(&self) -> Vec<String> {
        std::mem::take(&mut self.lock().notes)
    }

    pub fn known(&self) -> Known {
        let state = self.lock();
        let passes = state.members.iter().filter_map(|member| member.passes.as_ref());
        let passes = passes.copied().reduce(|sum, facts| sum.plus(&facts));
        Known { passes, ..state.known.clone() }
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
