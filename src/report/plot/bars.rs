//! Horizontal bars with spread: one number per case, names of any length beside them.

use super::{
    axis::{Axis, is_plottable},
    drawing::{Anchor, Drawing, Ink, Shape},
    font,
    frame::{self, Frame, NAME, NOTE},
};

/// A plot of bars.
#[derive(Clone, Debug, Default)]
pub struct Bars {
    /// Above the plot.
    pub title: String,
    /// What the numbers are, with their unit.
    pub x_title: String,
    /// From top to bottom.
    pub bars: Vec<Bar>,
}

/// One number with its spread.
#[derive(Clone, Debug, Default)]
pub struct Bar {
    /// Colour; one case has the same in all plots of its group.
    pub series: usize,
    /// Its name.
    pub name: String,
    /// The number.
    pub value: f64,
    /// From where to where it was seen.
    pub range: Option<[f64; 2]>,
    /// The number with its unit, as it stands beside the bar.
    pub label: String,
}

const WIDTH: f64 = 640.0;
const TOP: f64 = 38.0;
const ROW: f64 = 26.0;
const MARGIN: f64 = 16.0;
/// Bars from 0 show a smaller ratio; beyond it the short ones could not be told apart.
const LINEAR_RATIO: f64 = 30.0;

/// Draws the plot: bars from 0, or, where the numbers differ by orders of magnitude, marks on a logarithmic axis.
/// A number that is not positive and finite has its label only.
pub fn draw(plot: &Bars) -> Drawing {
    let name_room = plot.bars.iter().map(|bar| font::width(&bar.name, NAME)).fold(0.0, f64::max).min(230.0);
    let label_room = plot.bars.iter().map(|bar| font::width(&bar.label, NOTE)).fold(0.0, f64::max);
    let frame = Frame {
        left: MARGIN + name_room + 10.0,
        right: WIDTH - MARGIN - label_room - 10.0,
        top: TOP,
        bottom: TOP + ROW * plot.bars.len().max(1) as f64 + 6.0,
    };
    let mut drawing = Drawing::new(WIDTH, frame.bottom + 48.0, &plot.title);
    frame::title(&mut drawing, &plot.title);
    let (axis, from_zero) = axis(plot);
    let axis = axis.between(frame.left, frame.right);
    for tick in axis.ticks() {
        let ink = if tick.label.is_some() { Ink::Grid } else { Ink::Faint };
        drawing.line(vec![[tick.at, frame.top], [tick.at, frame.bottom]], ink, 1.0);
        let label = tick.label.unwrap_or_default();
        drawing.text([tick.at, frame.bottom + 16.0], Anchor::Middle, NOTE, Ink::Muted, &label);
    }
    let middle = 0.5 * (frame.left + frame.right);
    drawing.text([middle, frame.bottom + 36.0], Anchor::Middle, NAME, Ink::Text, &plot.x_title);
    for (i, bar) in plot.bars.iter().enumerate() {
        let y = frame.top + 3.0 + ROW * (0.5 + i as f64);
        let name = font::fitted(&bar.name, NAME, name_room);
        drawing.text([frame.left - 8.0, y + 4.5], Anchor::End, NAME, Ink::Text, &name);
        drawing.text([WIDTH - MARGIN, y + 4.0], Anchor::End, NOTE, Ink::Text, &bar.label);
        if is_plottable(bar.value) {
            draw_bar(&mut drawing, bar, &axis, y, from_zero);
        }
    }
    frame.close(&mut drawing);
    drawing
}

/// The axis, and whether it begins at 0.
fn axis(plot: &Bars) -> (Axis, bool) {
    let values = || plot.bars.iter().map(|bar| bar.value).filter(|&value| is_plottable(value));
    let least = values().fold(f64::INFINITY, f64::min);
    let ends = plot.bars.iter().flat_map(|bar| bar.range).flatten().filter(|&end| end > 0.4 * least);
    let all = values().chain(ends.clone());
    if values().fold(0.0, f64::max) > LINEAR_RATIO * least {
        return (Axis::log(all), false);
    }
    (Axis::from_zero(all), true)
}

fn draw_bar(drawing: &mut Drawing, bar: &Bar, axis: &Axis, y: f64, from_zero: bool) {
    let ink = Ink::Series(bar.series);
    let (start, end) = (axis.place(0.0), axis.place(bar.value));
    let hint = Some(format!("{}: {}", bar.name, bar.label));
    if from_zero {
        let corners = vec![[start, y - 8.0], [end, y - 8.0], [end, y + 8.0], [start, y + 8.0]];
        drawing.shapes.push(Shape::Area { points: corners, ink, opacity: 0.75, hint });
    } else {
        drawing.marker([end, y], bar.series, false, hint);
    }
    let range = bar.range.filter(|range| range.iter().all(|end| end.is_finite()));
    let Some([low, high]) = range.map(|range| range.map(|end| axis.place(end))) else { return };
    let whisker = if from_zero { Ink::Text } else { ink };
    drawing.line(vec![[low, y], [high, y]], whisker, 1.4);
    for end in [low, high] {
        drawing.line(vec![[end, y - 5.0], [end, y + 5.0]], whisker, 1.4);
    }
}
