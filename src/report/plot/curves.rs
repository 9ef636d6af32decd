//! Error against cost, both axes logarithmic: a series per case, with confidence bands and slopes.

use super::{
    axis::{Axis, is_plottable},
    drawing::{Anchor, Drawing, Ink, Place},
    frame::{self, Entry, Frame, LINE, Legend, NOTE},
};

/// A plot of several series.
#[derive(Clone, Debug, Default)]
pub struct Curves {
    /// Above the plot.
    pub title: String,
    /// What is on the x axis, with its unit.
    pub x_title: String,
    /// What is on the y axis, with its unit.
    pub y_title: String,
    /// The series.
    pub curves: Vec<Curve>,
    /// What the grey lines of slope −½ mean; none without it.
    pub guide: Option<String>,
    /// Level lines across the plot.
    pub levels: Vec<Level>,
}

/// One series.
#[derive(Clone, Debug, Default)]
pub struct Curve {
    /// Colour and marker; one case has the same in all plots of its group.
    pub series: usize,
    /// Its name.
    pub name: String,
    /// What the legend says behind the name, such as the slope.
    pub note: String,
    /// In ascending x.
    pub points: Vec<CurvePoint>,
    /// The slope of the fit, where one is drawn.
    pub slope: Option<f64>,
}

/// A point with what is known of its uncertainty.
#[derive(Clone, Debug, Default)]
pub struct CurvePoint {
    /// Cost.
    pub x: f64,
    /// From where to where the cost was seen.
    pub x_range: Option<[f64; 2]>,
    /// Error; `None` where it is not known but for being small.
    pub y: Option<f64>,
    /// Lower end of its interval, 0 where it is not above 0.
    pub low: Option<f64>,
    /// Upper end of its interval.
    pub high: Option<f64>,
    /// Whether it is part of the line only, without a marker.
    pub plain: bool,
    /// What a pointer over it is told.
    pub hint: String,
}

/// A line at a value of y.
#[derive(Clone, Debug)]
pub struct Level {
    /// Where.
    pub y: f64,
    /// What is written on it.
    pub label: String,
}

impl Curves {
    /// Whether any error has a place on the plot.
    pub fn is_empty(&self) -> bool {
        !self.curves.iter().flat_map(|curve| &curve.points).any(|point| point.seen().is_some())
    }
}

impl CurvePoint {
    fn seen(&self) -> Option<Place> {
        self.y.filter(|&y| is_plottable(y) && is_plottable(self.x)).map(|y| [self.x, y])
    }

    /// Whether it has a place on the x axis but none on the y axis.
    fn sunk(&self) -> bool {
        is_plottable(self.x) && self.seen().is_none()
    }
}

const WIDTH: f64 = 640.0;
const AXES: f64 = 330.0;
const LEFT: f64 = 68.0;
const TOP: f64 = 38.0;
const MARGIN: f64 = 24.0;

/// Draws the plot. What is not finite or not positive has no place on it; an error below the noise is a hollow
/// marker on the lower edge.
pub fn draw(plot: &Curves) -> Drawing {
    let sunk = plot.curves.iter().any(|curve| curve.points.iter().any(CurvePoint::sunk));
    let legend = Legend::new(plot.curves.iter().map(entry).collect(), WIDTH - 2.0 * MARGIN);
    let frame = Frame { left: LEFT, right: WIDTH - MARGIN, top: TOP, bottom: TOP + AXES };
    let below = frame.bottom + 48.0;
    let remarks = remarks(plot, sunk);
    let height = below + legend.height() + remarks.len() as f64 * LINE + 8.0;
    let mut drawing = Drawing::new(WIDTH, height, &plot.title);
    let (x, y) = axes(plot, &frame);
    frame::title(&mut drawing, &plot.title);
    frame.draw(&mut drawing, (&x, &plot.x_title), (&y, &plot.y_title));
    if plot.guide.is_some() {
        guides(&mut drawing, &x, &y);
    }
    levels(&mut drawing, plot, &frame, &y);
    plot.curves.iter().for_each(|curve| band(&mut drawing, curve, &x, &y));
    frame.close(&mut drawing);
    plot.curves.iter().for_each(|curve| lines(&mut drawing, curve, &x, &y));
    plot.curves.iter().for_each(|curve| markers(&mut drawing, curve, &x, &y));
    legend.draw(&mut drawing, MARGIN, below);
    for (i, remark) in remarks.iter().enumerate() {
        let line = below + legend.height() + (0.5 + i as f64) * LINE + 4.5;
        drawing.text([MARGIN, line], Anchor::Start, NOTE, Ink::Muted, remark);
    }
    drawing
}

fn entry(curve: &Curve) -> Entry {
    Entry { series: curve.series, name: curve.name.clone(), note: curve.note.clone() }
}

fn remarks(plot: &Curves, sunk: bool) -> Vec<String> {
    let guide = plot.guide.as_ref().map(|meaning| format!("grey dashes: slope −½, {meaning}"));
    let sunk =
        sunk.then(|| "hollow, at the lower edge: not told from 0, the error is below the noise".to_owned());
    guide.into_iter().chain(sunk).collect()
}

fn axes(plot: &Curves, frame: &Frame) -> (Axis, Axis) {
    let points = || plot.curves.iter().flat_map(|curve| &curve.points);
    let x = points().flat_map(|point| [point.x].into_iter().chain(point.x_range.into_iter().flatten()));
    let seen: Vec<f64> = points().filter_map(CurvePoint::seen).map(|[_, y]| y).collect();
    // An interval may reach far down, to 0 even: it must not press the curves together.
    let least = seen.iter().copied().fold(f64::INFINITY, f64::min);
    let ends = points().filter(|point| point.seen().is_some()).flat_map(|point| [point.low, point.high]);
    let ends = ends.flatten().filter(|&end| end > 0.4 * least);
    let levels = plot.levels.iter().map(|level| level.y).filter(|&y| seen.is_empty() || y > 0.1 * least);
    let highs = points().filter(|point| point.sunk()).filter_map(|point| point.high);
    let y = Axis::log(seen.iter().copied().chain(ends).chain(levels).chain(highs));
    frame.spread(Axis::log(x), y)
}

/// Lines of slope −½, a factor of √10 apart in y: the same efficiency along each of them.
fn guides(drawing: &mut Drawing, x: &Axis, y: &Axis) {
    let ([x0, x1], [y0, y1]) = (x.range().map(f64::log10), y.range().map(f64::log10));
    let lowest = (2.0 * (y0 + 0.5 * x0)).ceil() as i32;
    let highest = (2.0 * (y1 + 0.5 * x1)).floor() as i32;
    let every = ((highest - lowest) / 16 + 1) as usize;
    for k in (lowest..=highest).step_by(every) {
        // y + x/2 = k/2 between the four edges.
        let along = |at: f64| [at, 0.5 * (f64::from(k) - at)];
        let from = x0.max(f64::from(k) - 2.0 * y1);
        let to = x1.min(f64::from(k) - 2.0 * y0);
        if from < to {
            let place = |[a, b]: Place| [x.place(10_f64.powf(a)), y.place(10_f64.powf(b))];
            drawing.dashed(vec![place(along(from)), place(along(to))], Ink::Guide, 0.8, [5.0, 6.0]);
        }
    }
}

fn levels(drawing: &mut Drawing, plot: &Curves, frame: &Frame, y: &Axis) {
    let [low, high] = y.range();
    for level in plot.levels.iter().filter(|level| (low..=high).contains(&level.y)) {
        let at = y.place(level.y);
        drawing.dashed(vec![[frame.left, at], [frame.right, at]], Ink::Text, 1.0, [2.0, 3.0]);
        drawing.text([frame.left + 6.0, at - 4.0], Anchor::Start, NOTE, Ink::Text, &level.label);
    }
}

/// The confidence band; where an interval is open below it goes to the lower edge.
fn band(drawing: &mut Drawing, curve: &Curve, x: &Axis, y: &Axis) {
    let known: Vec<(f64, f64, f64)> = curve
        .points
        .iter()
        .filter(|point| point.seen().is_some())
        .filter_map(|point| Some((x.place(point.x), y.place(point.low?), y.place(point.high?))))
        .collect();
    if let [(at, low, high)] = known[..] {
        drawing.line(vec![[at, low], [at, high]], Ink::Series(curve.series), 1.4);
        return;
    }
    let upper = known.iter().map(|&(at, _, high)| [at, high]);
    let lower = known.iter().rev().map(|&(at, low, _)| [at, low]);
    if !known.is_empty() {
        drawing.area(upper.chain(lower).collect(), Ink::Series(curve.series), 0.18);
    }
}

fn lines(drawing: &mut Drawing, curve: &Curve, x: &Axis, y: &Axis) {
    let seen: Vec<Place> = curve.points.iter().filter_map(CurvePoint::seen).collect();
    let ink = Ink::Series(curve.series);
    drawing.line(seen.iter().map(|&[a, b]| [x.place(a), y.place(b)]).collect(), ink, 1.8);
    if let Some(slope) = curve.slope.filter(|slope| slope.is_finite() && seen.len() > 1) {
        let mean = |axis: usize| seen.iter().map(|place| place[axis].ln()).sum::<f64>() / seen.len() as f64;
        let (middle_x, middle_y) = (mean(0), mean(1));
        let fitted = |at: f64| [x.place(at), y.place((middle_y + slope * (at.ln() - middle_x)).exp())];
        let (first, last) = (seen[0][0] / 1.15, seen[seen.len() - 1][0] * 1.15);
        drawing.dashed(vec![fitted(first), fitted(last)], ink, 1.0, [2.0, 3.0]);
    }
    for point in &curve.points {
        let range = point.x_range.filter(|range| range.iter().copied().all(is_plottable));
        if let (Some([_, b]), Some([from, to])) = (point.seen(), range) {
            let at = y.place(b);
            drawing.line(vec![[x.place(from), at], [x.place(to), at]], ink, 1.4);
        }
    }
}

fn markers(drawing: &mut Drawing, curve: &Curve, x: &Axis, y: &Axis) {
    for point in curve.points.iter().filter(|point| is_plottable(point.x) && !point.plain) {
        let height = point.seen().map_or(0.0, |[_, b]| b);
        let hint = Some(point.hint.clone()).filter(|hint| !hint.is_empty());
        drawing.marker([x.place(point.x), y.place(height)], curve.series, point.sunk(), hint);
    }
}
