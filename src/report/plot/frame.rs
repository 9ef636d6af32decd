//! What all plots share: title, axes with grid, and a legend.

use super::{
    axis::{Axis, Tick},
    drawing::{Anchor, Drawing, Ink},
    font,
};

/// Font size of titles.
pub const TITLE: f64 = 15.0;
/// Font size of axis titles and names.
pub const NAME: f64 = 12.5;
/// Font size of tick labels and notes.
pub const NOTE: f64 = 11.5;
/// Between the lines of a legend.
pub const LINE: f64 = 19.0;

/// The rectangle that the axes span.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Left edge.
    pub left: f64,
    /// Right edge.
    pub right: f64,
    /// Upper edge.
    pub top: f64,
    /// Lower edge.
    pub bottom: f64,
}

impl Frame {
    /// Two axes in this frame, y upwards.
    pub fn spread(&self, x: Axis, y: Axis) -> (Axis, Axis) {
        (x.between(self.left, self.right), y.between(self.bottom, self.top))
    }

    /// Draws grid, labels and titles of both axes.
    pub fn draw(&self, drawing: &mut Drawing, (x, x_title): (&Axis, &str), (y, y_title): (&Axis, &str)) {
        let (x_ticks, y_ticks) = (x.ticks(), y.ticks());
        let fainter_first = |ticks: &[Tick]| {
            let (major, minor): (Vec<Tick>, Vec<Tick>) =
                ticks.iter().cloned().partition(|tick| tick.label.is_some());
            (minor, major)
        };
        let ((x_minor, x_major), (y_minor, y_major)) = (fainter_first(&x_ticks), fainter_first(&y_ticks));
        for (x_lines, y_lines, ink) in [(x_minor, y_minor, Ink::Faint), (x_major, y_major, Ink::Grid)] {
            for tick in x_lines {
                drawing.line(vec![[tick.at, self.bottom], [tick.at, self.top]], ink, 1.0);
            }
            for tick in y_lines {
                drawing.line(vec![[self.left, tick.at], [self.right, tick.at]], ink, 1.0);
            }
        }
        for tick in &x_ticks {
            let label = tick.label.as_deref().unwrap_or_default();
            drawing.text([tick.at, self.bottom + 16.0], Anchor::Middle, NOTE, Ink::Muted, label);
        }
        for tick in &y_ticks {
            let label = tick.label.as_deref().unwrap_or_default();
            drawing.text([self.left - 7.0, tick.at + 4.0], Anchor::End, NOTE, Ink::Muted, label);
        }
        let middle = [0.5 * (self.left + self.right), 0.5 * (self.top + self.bottom)];
        drawing.text([middle[0], self.bottom + 36.0], Anchor::Middle, NAME, Ink::Text, x_title);
        drawing.turned([16.0, middle[1]], NAME, Ink::Text, y_title);
    }

    /// The lines of the axes, over what is plotted.
    pub fn close(&self, drawing: &mut Drawing) {
        let corners = vec![[self.left, self.top], [self.left, self.bottom], [self.right, self.bottom]];
        drawing.line(corners, Ink::Muted, 1.2);
    }
}

/// Draws the title, as much of it as fits.
pub fn title(drawing: &mut Drawing, text: &str) {
    let shown = font::fitted(text, TITLE, drawing.width - 24.0);
    drawing.text([12.0, 22.0], Anchor::Start, TITLE, Ink::Text, &shown);
}

/// One line of a legend.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Which series.
    pub series: usize,
    /// Its name.
    pub name: String,
    /// What is said behind it, in fainter letters.
    pub note: String,
}

/// Legend entries in columns, as wide as the widest of them.
pub struct Legend {
    entries: Vec<Entry>,
    columns: usize,
    column: f64,
}

/// Of a legend's sample with its gaps.
const SAMPLE: f64 = 38.0;

impl Legend {
    /// A legend that fits into this width.
    pub fn new(entries: Vec<Entry>, width: f64) -> Self {
        let room = width - SAMPLE;
        let note = entries.iter().map(|entry| font::width(&entry.note, NOTE)).fold(0.0, f64::max) + 14.0;
        let fit =
            |entry: Entry| Entry { name: font::fitted(&entry.name, NAME, (room - note).max(60.0)), ..entry };
        let entries: Vec<Entry> = entries.into_iter().map(fit).collect();
        let name = entries.iter().map(|entry| font::width(&entry.name, NAME)).fold(0.0, f64::max);
        let columns = (width / (SAMPLE + name + note)).floor().clamp(1.0, entries.len().max(1) as f64);
        Self { entries, columns: columns as usize, column: width / columns }
    }

    /// How high it is.
    pub fn height(&self) -> f64 {
        self.entries.len().div_ceil(self.columns) as f64 * LINE
    }

    /// Draws it below this place, column by column.
    pub fn draw(&self, drawing: &mut Drawing, left: f64, top: f64) {
        let rows = self.entries.len().div_ceil(self.columns).max(1);
        for (i, entry) in self.entries.iter().enumerate() {
            let (x, y) = (left + (i / rows) as f64 * self.column, top + (0.5 + (i % rows) as f64) * LINE);
            drawing.line(vec![[x, y], [x + 28.0, y]], Ink::Series(entry.series), 1.8);
            drawing.marker([x + 14.0, y], entry.series, false, None);
            drawing.text([x + SAMPLE - 4.0, y + 4.5], Anchor::Start, NAME, Ink::Text, &entry.name);
            let behind = x + SAMPLE + 6.0 + font::width(&entry.name, NAME);
            drawing.text([behind, y + 4.5], Anchor::Start, NOTE, Ink::Muted, &entry.note);
        }
    }
}
