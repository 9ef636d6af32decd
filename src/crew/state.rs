//! What the members of a crew have in hand, and how far they have come.

use super::board::{Board, Unit};
use super::queue::Queue;
use crate::caustics::{PassFacts, PassLedger};
use crate::film::FilmPixel;
use crate::irradiance::{LightData, LightFacts};
use crate::render::{Auxiliary, PathLedger, Progress};
use std::sync::Arc;
use std::time::{Duration, Instant};

pub(super) enum Light {
    /// The method has none.
    None,
    /// Nobody computes it yet.
    Wanted,
    /// A member does, has come so far, and said so then.
    Computing(usize, f32, Instant),
    Done(Arc<LightData>),
}

/// Who has not moved on with the light for so long stands still: another one computes it from the beginning.
const STANDSTILL: Duration = Duration::from_secs(60);

impl Light {
    /// Whether nobody has to compute it any more.
    pub fn is_settled(&self) -> bool {
        matches!(self, Self::None | Self::Done(_))
    }

    /// Whether somebody has to begin.
    pub fn waits(&self) -> bool {
        match self {
            Self::Wanted => true,
            Self::Computing(_, _, then) => then.elapsed() > STANDSTILL,
            Self::None | Self::Done(_) => false,
        }
    }
}

pub(super) enum Work {
    Rows(Board),
    Passes(Queue),
}

/// What a member holds that others would have to do again.
pub(super) enum Held {
    Nothing,
    /// Rows, and since when.
    Rows(Unit, Instant),
    Pass(u32),
}

/// Who has held rows for longer is slow: others that have nothing else to do take them, too, and the first result counts.
pub(super) const LONG: Duration = Duration::from_secs(1);

pub(super) struct Member {
    pub selector: String,
    pub name: String,
    /// Whether its device is in another process.
    pub away: bool,
    pub held: Held,
    pub samples: u64,
    pub seconds: f64,
    pub passes: Option<PassFacts>,
    pub lost: Option<String>,
}

pub(super) struct State {
    pub goal: u32,
    pub work: Work,
    pub film: Vec<FilmPixel>,
    pub auxiliary: Option<Vec<Auxiliary>>,
    pub paths: Option<PathLedger>,
    pub photons: Option<PassLedger>,
    pub light: Light,
    pub members: Vec<Member>,
    pub notes: Vec<String>,
    pub launches: u64,
    pub device_time: Duration,
    /// What the members have found since the render began.
    pub known: Known,
}

/// What is known of how it is computed.
#[derive(Clone, Debug, Default)]
pub(super) struct Known {
    pub light_facts: Option<LightFacts>,
    pub light_hash: Option<String>,
    pub passes: Option<PassFacts>,
    pub build_time: Duration,
    pub build_cached: bool,
}

/// What goes with a film: of the same moment, or a render that goes on from there would count some of it twice.
pub(super) struct Moment {
    pub progress: Progress,
    pub auxiliary: Option<Vec<Auxiliary>>,
    pub paths: Option<PathLedger>,
    pub photons: Option<PassLedger>,
}

impl State {
    pub fn moment(&self) -> Moment {
        let (auxiliary, paths, photons) = (self.auxiliary.clone(), self.paths, self.photons);
        Moment { progress: self.progress(), auxiliary, paths, photons }
    }

    pub fn progress(&self) -> Progress {
        let (samples, tiles) = match &self.work {
            Work::Rows(board) => board.standing(),
            Work::Passes(queue) => (queue.added(), 0),
        };
        let light = match self.light {
            Light::None | Light::Done(_) => 1.0,
            Light::Computing(_, share, _) => share,
            Light::Wanted => 0.0,
        };
        Progress { samples, tiles, launches: self.launches, device_time: self.device_time, light }
    }

    pub fn members_left(&self) -> usize {
        self.members.iter().filter(|member| member.lost.is_none()).count()
    }

    /// Whether a member that can still work is of this process.
    pub fn is_anybody_here(&self) -> bool {
        self.members.iter().any(|member| !member.away && member.lost.is_none())
    }

    pub fn enter(&mut self, member: usize, samples: u64, elapsed: Duration, launches: u64) {
        self.members[member].held = Held::Nothing;
        self.members[member].samples += samples;
        self.members[member].seconds += elapsed.as_secs_f64();
        self.device_time += elapsed;
        self.launches += launches;
    }
}

/// Rows that one member alone has held for long.
pub(super) fn slow_rows(members: &[Member]) -> Option<Unit> {
    let held = members.iter().filter_map(|member| match &member.held {
        Held::Rows(unit, since) => Some((unit, since)),
        _ => None,
    });
    let alone = |unit: &Unit| held.clone().filter(|(other, _)| *other == unit).count() == 1;
    let slow = held.clone().filter(|(unit, since)| since.elapsed() > LONG && alone(unit));
    slow.min_by_key(|(_, since)| **since).map(|(unit, _)| unit.clone())
}
