//! The plots of a report.

use super::{
    numbers,
    plot::{Bar, Bars, Curve, CurvePoint, Curves, Level, Plot},
    view::{Group, Member},
};
use crate::bench::results::{Interval, Point};

/// A plot with the end of its files' names.
pub struct Figure {
    /// Such as `error-time`.
    pub name: &'static str,
    /// What to draw.
    pub plot: Plot,
}

/// The plots of a group: those that have something to show.
pub fn figures(group: &Group<'_>) -> Vec<Figure> {
    let figure = |name, plot: Option<Plot>| plot.map(|plot| Figure { name, plot });
    [
        figure("error-time", curves(error_against_time(group))),
        figure("error-samples", curves(error_against_samples(group))),
        figure("time", time_per_sample(group).map(Plot::Bars)),
        figure("efficiency", efficiency(group).map(Plot::Bars)),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn curves(curves: Curves) -> Option<Plot> {
    (!curves.is_empty()).then_some(Plot::Curves(curves))
}

/// Errors of a group in one unit: relative, unless a reference is black.
struct Errors {
    relative: bool,
}

impl Errors {
    fn of(group: &Group<'_>) -> Self {
        let points = group.members.iter().flat_map(|member| &member.case.summary.points);
        Self {
            relative: points.filter(|point| point.rmse.is_some()).all(|point| point.relative_rmse.is_some()),
        }
    }

    fn title(&self) -> &'static str {
        if self.relative { "RMSE / mean of the reference (%)" } else { "RMSE (linear radiance)" }
    }

    fn at(&self, point: &Point) -> Option<Interval> {
        let scaled = |of: Interval| Interval {
            value: 100.0 * of.value,
            low: of.low.map(|low| 100.0 * low),
            high: of.high.map(|high| 100.0 * high),
        };
        if self.relative { point.relative_rmse.map(scaled) } else { point.rmse }
    }

    fn say(&self, value: f64) -> String {
        let number = numbers::significant(value, 3);
        if self.relative { format!("{number} %") } else { number }
    }

    /// A line at the noise of the reference, where the group has only one.
    fn levels(&self, group: &Group<'_>) -> Vec<Level> {
        let [target] = &group.targets()[..] else { return Vec::new() };
        let noise = target[0].case.reference.relative_error.filter(|_| self.relative);
        let level =
            |noise: f64| Level { y: 100.0 * noise, label: "the reference's own noise, taken out".into() };
        noise.map(level).into_iter().collect()
    }
}

fn error_against_time(group: &Group<'_>) -> Curves {
    let errors = Errors::of(group);
    let curve = |members: &Vec<&Member<'_>>| {
        let mut points = points_of(members);
        points.sort_by(|(_, a), (_, b)| a.seconds.median.total_cmp(&b.seconds.median));
        let note = points.last().map(|(_, last)| {
            let error = errors.at(last).map_or("below the noise".into(), |error| errors.say(error.value));
            format!("{error} after {}", numbers::seconds(last.seconds.median))
        });
        let note = note.unwrap_or_else(|| "not measured".into());
        let points = points.into_iter().map(|(member, point)| {
            let range = (point.seconds.count > 1).then_some([point.seconds.low, point.seconds.high]);
            curve_point(member, point, &errors, point.seconds.median, range)
        });
        let first = members[0];
        Curve { series: first.series, name: name_of(first), note, points: points.collect(), slope: None }
    };
    Curves {
        title: format!("{}: error against time", group.name),
        x_title: "wall time (s)".into(),
        y_title: errors.title().into(),
        curves: group.curves().iter().map(curve).collect(),
        guide: Some("the same efficiency all along".into()),
        levels: errors.levels(group),
    }
}

/// The name of a curve, with the device where the labels have it.
fn name_of(member: &Member<'_>) -> String {
    let Some(curve) = &member.case.curve else { return member.label.clone() };
    let device = member.label.strip_prefix(&member.case.name).unwrap_or_default();
    format!("{curve}{device}")
}

/// Every checkpoint of a case that is alone in its curve, else the last one of each.
fn points_of<'m, 'a>(members: &[&'m Member<'a>]) -> Vec<(&'m Member<'a>, &'a Point)> {
    if let [only] = members {
        return only.case.summary.points.iter().map(|point| (*only, point)).collect();
    }
    members.iter().filter_map(|member| Some((*member, member.case.summary.points.last()?))).collect()
}

fn error_against_samples(group: &Group<'_>) -> Curves {
    let errors = Errors::of(group);
    // Samples are not what the points of a joined curve differ by.
    let falls = |member: &&Member<'_>| !member.case.deterministic && member.case.curve.is_none();
    let random: Vec<&Member<'_>> = group.members.iter().filter(falls).collect();
    let curve = |member: &Member<'_>| {
        let summary = &member.case.summary;
        let slope = summary.slope.filter(|slope| slope.value.is_finite());
        let note = slope.map(|slope| {
            format!("slope {}", numbers::interval(&slope, |value| numbers::significant(value, 3)))
        });
        let points =
            summary.points.iter().map(|point| curve_point(member, point, &errors, point.samples, None));
        Curve {
            series: member.series,
            name: member.label.clone(),
            note: note.unwrap_or_default(),
            points: points.collect(),
            slope: slope.map(|slope| slope.value),
        }
    };
    Curves {
        title: format!("{}: error against samples", group.name),
        x_title: "samples per pixel".into(),
        y_title: errors.title().into(),
        curves: random.into_iter().map(curve).collect(),
        guide: Some("the law of independent samples".into()),
        levels: errors.levels(group),
    }
}

fn curve_point(
    member: &Member<'_>,
    point: &Point,
    errors: &Errors,
    x: f64,
    x_range: Option<[f64; 2]>,
) -> CurvePoint {
    let error = errors.at(point);
    let said = error.map_or("below the reference's noise".into(), |error| {
        format!("RMSE {}", numbers::interval(&error, |value| errors.say(value)))
    });
    let (samples, time) = (numbers::count(point.samples), numbers::seconds(point.seconds.median));
    CurvePoint {
        x,
        x_range,
        y: error.map(|error| error.value),
        low: error.and_then(|error| error.low),
        high: error.and_then(|error| error.high),
        plain: false,
        hint: format!("{}: {samples} samples, {time}, {said}", member.label),
    }
}

fn time_per_sample(group: &Group<'_>) -> Option<Bars> {
    let bar = |member: &Member<'_>| {
        let rate = member.case.summary.samples_per_second.filter(|rate| rate.median > 0.0);
        Bar {
            series: member.series,
            name: member.label.clone(),
            value: rate.map_or(f64::NAN, |rate| 1e3 / rate.median),
            // The quartiles of a reciprocal change places.
            range: rate.filter(|rate| rate.count > 1).map(|rate| [1e3 / rate.high, 1e3 / rate.low]),
            label: rate.map_or(numbers::UNKNOWN.into(), |rate| numbers::seconds(1.0 / rate.median)),
        }
    };
    bars(group.members.iter().map(bar).collect(), || Bars {
        title: format!("{}: time per sample", group.name),
        x_title: "ms per sample of every pixel; median and quartiles".into(),
        bars: Vec::new(),
    })
}

fn efficiency(group: &Group<'_>) -> Option<Bars> {
    let bar = |member: &Member<'_>| {
        let efficiency = relative_efficiency(member.case.summary.efficiency, member.case.reference.mean);
        Bar {
            series: member.series,
            name: member.label.clone(),
            value: efficiency.map_or(f64::NAN, |efficiency| efficiency.value),
            range: efficiency.and_then(|efficiency| Some([efficiency.low?, efficiency.high?])),
            label: efficiency.map_or(numbers::UNKNOWN.into(), |of| numbers::significant(of.value, 3)),
        }
    };
    let random = group.members.iter().filter(|member| !member.case.deterministic);
    bars(random.map(bar).collect(), || Bars {
        title: format!("{}: efficiency, more is better", group.name),
        x_title: "1 / (relative MSE · s); 95 % interval".into(),
        bars: Vec::new(),
    })
}

fn bars(bars: Vec<Bar>, plot: impl Fn() -> Bars) -> Option<Bars> {
    bars.iter().any(|bar| bar.value.is_finite()).then(|| Bars { bars, ..plot() })
}

/// Efficiency with the error as a share of the reference's mean, so that it does not depend on the scene's brightness:
/// 10⁴ is an error of 1 % after a second.
pub fn relative_efficiency(efficiency: Option<Interval>, mean: f64) -> Option<Interval> {
    let efficiency = efficiency.filter(|efficiency| efficiency.value > 0.0 && mean != 0.0)?;
    let scaled = |value: f64| value * mean * mean;
    Some(Interval {
        value: scaled(efficiency.value),
        low: efficiency.low.map(scaled),
        high: efficiency.high.map(scaled),
    })
}
