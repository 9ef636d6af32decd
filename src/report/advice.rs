//! What to use: for an error that one can live with, the case that gets there first.

use super::view::{Member, View};
use crate::bench::results::{Case, FindingKind};

/// When a case reaches an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// Wall time.
    pub seconds: f64,
    /// Whether it lies between checkpoints, else it follows from the n^−1/2 law.
    pub measured: bool,
}

/// The first to reach a range of errors.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The largest and the smallest relative error of the range.
    pub errors: [f64; 2],
    /// The place among the results of the case that comes first; `None` where none arrives.
    pub first: Option<usize>,
    /// When it reaches the smallest error of the range.
    pub arrival: Option<Arrival>,
    /// The next one, at the smallest error.
    pub next: Option<Next>,
}

/// The second to arrive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Next {
    /// Its place among the results.
    pub index: usize,
    /// How many times longer it takes.
    pub ratio: f64,
    /// Whether it is slower for certain: the quartiles of the times do not overlap.
    pub certain: bool,
}

/// Relative errors whose times are known for any case, the largest first.
pub fn levels<'a>(cases: impl Iterator<Item = &'a Case>) -> Vec<f64> {
    let times = cases.flat_map(|case| &case.summary.time_to_error);
    let mut levels: Vec<f64> =
        times.map(|time| time.relative_error).filter(|level| level.is_finite()).collect();
    levels.sort_unstable_by(|a, b| b.total_cmp(a));
    levels.dedup();
    levels
}

/// When a case reaches a relative error. Its own bias is part of the error that was measured, but a biased case cannot
/// be followed beyond what was measured.
pub fn arrival(view: &View<'_>, case: &Case, level: f64) -> Option<Arrival> {
    if !is_trusted(view, case) {
        return None;
    }
    let points = &case.summary.points;
    let exact = |error: f64| error <= 0.0;
    if let Some(first) =
        points.first().filter(|first| first.relative_rmse.is_some_and(|rmse| exact(rmse.value)))
    {
        return Some(Arrival { seconds: first.seconds.median, measured: true });
    }
    let time = case.summary.time_to_error.iter().find(|time| time.relative_error == level)?;
    let followed = time.measured || !view.has(case, FindingKind::Bias);
    let arrival = Arrival { seconds: time.seconds, measured: time.measured };
    Some(arrival).filter(|arrival| followed && arrival.seconds.is_finite())
}

/// Whether the numbers of a case mean anything.
pub fn is_trusted(view: &View<'_>, case: &Case) -> bool {
    let wrong = [FindingKind::Selftest, FindingKind::Rejected];
    case.device.selftest != Some(false) && !wrong.into_iter().any(|kind| view.has(case, kind))
}

/// The first of `target` for each of `levels`, neighbours of the same first taken together.
pub fn choices(view: &View<'_>, target: &[&Member<'_>], levels: &[f64]) -> Vec<Choice> {
    let mut choices: Vec<Choice> = Vec::new();
    for &level in levels {
        let choice = choice(view, target, level);
        match choices.last_mut() {
            Some(last) if last.first == choice.first => {
                let largest = last.errors[0];
                *last = Choice { errors: [largest, level], ..choice };
            }
            _ => choices.push(choice),
        }
    }
    choices
}

fn choice<'m, 'a>(view: &View<'_>, target: &[&'m Member<'a>], level: f64) -> Choice {
    let arrives = |member: &&'m Member<'a>| Some((*member, arrival(view, member.case, level)?));
    let mut arrivals: Vec<(&Member<'_>, Arrival)> = target.iter().filter_map(arrives).collect();
    arrivals.sort_by(|(_, a), (_, b)| a.seconds.total_cmp(&b.seconds));
    let first = arrivals.first().copied();
    let next = first.zip(arrivals.get(1)).map(|((winner, a), (second, b))| Next {
        index: second.index,
        ratio: b.seconds / a.seconds,
        certain: b.seconds * quartiles(second.case)[0] > a.seconds * quartiles(winner.case)[1],
    });
    Choice {
        errors: [level, level],
        first: first.map(|(winner, _)| winner.index),
        arrival: first.map(|(_, arrival)| arrival),
        next: next.filter(|next| next.ratio.is_finite()),
    }
}

/// First and third quartile of the last checkpoint's time, over the median.
fn quartiles(case: &Case) -> [f64; 2] {
    let last = case.summary.points.last().map(|point| point.seconds);
    last.map_or([1.0, 1.0], |times| [times.low / times.median, times.high / times.median])
}
