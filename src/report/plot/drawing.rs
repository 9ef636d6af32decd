//! What a plot is made of: lines, areas and texts in pixels, x to the right and y down.

/// A place in pixels.
pub type Place = [f64; 2];

/// What something is painted with: a role, so that a page can give it another colour in the dark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// Titles and labels.
    Text,
    /// Axes, and texts of less weight.
    Muted,
    /// Grid lines.
    Grid,
    /// Lines to compare slopes with.
    Guide,
    /// Fainter grid lines.
    Faint,
    /// The ground.
    Paper,
    /// The n-th series.
    Series(usize),
}

/// Okabe & Ito's colours, which people with any colour vision tell apart, without the yellow that is too faint
/// on white; then grey.
const SERIES: [[u8; 3]; 7] = [
    [0x00, 0x72, 0xb2],
    [0xd5, 0x5e, 0x00],
    [0x00, 0x9e, 0x73],
    [0xcc, 0x79, 0xa7],
    [0xe6, 0x9f, 0x00],
    [0x56, 0xb4, 0xe9],
    [0x77, 0x77, 0x77],
];

impl Ink {
    /// Its colour on white.
    pub fn rgb(self) -> [u8; 3] {
        match self {
            Self::Text => [0x1a, 0x1a, 0x1a],
            Self::Muted => [0x5c, 0x5c, 0x5c],
            Self::Grid => [0xcf, 0xcf, 0xcf],
            Self::Guide => [0x99, 0x99, 0x99],
            Self::Faint => [0xea, 0xea, 0xea],
            Self::Paper => [0xff, 0xff, 0xff],
            Self::Series(index) => SERIES[index % SERIES.len()],
        }
    }

    /// Its name in style sheets.
    pub fn class(self) -> String {
        match self {
            Self::Text => "text".into(),
            Self::Muted => "muted".into(),
            Self::Grid => "grid".into(),
            Self::Guide => "guide".into(),
            Self::Faint => "faint".into(),
            Self::Paper => "paper".into(),
            Self::Series(index) => format!("series{}", index % SERIES.len()),
        }
    }
}

/// Which end of a text is at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// The left end.
    Start,
    /// The middle.
    Middle,
    /// The right end.
    End,
}

/// Something to draw.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// An open line.
    Line {
        /// Its corners.
        points: Vec<Place>,
        /// Its colour.
        ink: Ink,
        /// Its width.
        width: f64,
        /// Lengths of dash and gap.
        dash: Option<[f64; 2]>,
    },
    /// A filled polygon.
    Area {
        /// Its corners.
        points: Vec<Place>,
        /// Its colour.
        ink: Ink,
        /// 0 to 1.
        opacity: f64,
        /// What a pointer over it is told.
        hint: Option<String>,
    },
    /// A text on one line.
    Text {
        /// The anchor, on the base line.
        at: Place,
        /// The text itself.
        text: String,
        /// Font size.
        size: f64,
        /// Its colour.
        ink: Ink,
        /// What of it is at `at`.
        anchor: Anchor,
        /// Whether it is turned to read from below.
        turned: bool,
    },
}

/// A picture of shapes, the later over the earlier.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// In pixels.
    pub width: f64,
    /// In pixels.
    pub height: f64,
    /// What it shows, for those who do not see it.
    pub title: String,
    /// In the order of drawing.
    pub shapes: Vec<Shape>,
}

impl Drawing {
    /// An empty one.
    pub fn new(width: f64, height: f64, title: &str) -> Self {
        let mut drawing = Self { width, height, title: title.to_owned(), shapes: Vec::new() };
        let corners = vec![[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]];
        drawing.area(corners, Ink::Paper, 1.0);
        drawing
    }

    /// Adds a line.
    pub fn line(&mut self, points: Vec<Place>, ink: Ink, width: f64) {
        self.shapes.push(Shape::Line { points, ink, width, dash: None });
    }

    /// Adds a dashed line.
    pub fn dashed(&mut self, points: Vec<Place>, ink: Ink, width: f64, dash: [f64; 2]) {
        self.shapes.push(Shape::Line { points, ink, width, dash: Some(dash) });
    }

    /// Adds a filled polygon.
    pub fn area(&mut self, points: Vec<Place>, ink: Ink, opacity: f64) {
        self.shapes.push(Shape::Area { points, ink, opacity, hint: None });
    }

    /// Adds a text.
    pub fn text(&mut self, at: Place, anchor: Anchor, size: f64, ink: Ink, text: &str) {
        self.shapes.push(Shape::Text { at, text: text.to_owned(), size, ink, anchor, turned: false });
    }

    /// Adds a text that reads from below, its middle at `at`.
    pub fn turned(&mut self, at: Place, size: f64, ink: Ink, text: &str) {
        let (text, anchor) = (text.to_owned(), Anchor::Middle);
        self.shapes.push(Shape::Text { at, text, size, ink, anchor, turned: true });
    }

    /// Adds the marker of a series; a hollow one stands for a value that is only bounded.
    pub fn marker(&mut self, at: Place, series: usize, hollow: bool, hint: Option<String>) {
        let ink = Ink::Series(series);
        let corners =
            |size| marker(series).into_iter().map(|[x, y]| [at[0] + size * x, at[1] + size * y]).collect();
        // A rim of paper keeps markers apart that overlap.
        self.area(corners(6.0), Ink::Paper, 1.0);
        self.shapes.push(Shape::Area { points: corners(4.6), ink, opacity: 1.0, hint });
        if hollow {
            self.area(corners(2.6), Ink::Paper, 1.0);
        }
    }
}

/// The corners of the marker of a series, within about 1 of its middle. As there are 7 colours and 8 shapes, the
/// first 56 series differ.
fn marker(series: usize) -> Vec<Place> {
    let polygon = |corners: usize, turn: f64, size: f64| -> Vec<Place> {
        let angle = |k: usize| (k as f64 / corners as f64 + turn) * std::f64::consts::TAU;
        (0..corners).map(|k| [size * angle(k).sin(), -size * angle(k).cos()]).collect()
    };
    let star = |turn: f64, inner: f64, tips: usize| -> Vec<Place> {
        let corners = polygon(2 * tips, turn, 1.25);
        let sizes = [1.0, inner].into_iter().cycle();
        corners.into_iter().zip(sizes).map(|([x, y], size)| [x * size, y * size]).collect()
    };
    match series % 8 {
        0 => polygon(24, 0.0, 1.0),
        1 => polygon(4, 0.125, 1.25),
        2 => polygon(3, 0.0, 1.25),
        3 => polygon(4, 0.0, 1.25),
        4 => polygon(3, 0.5, 1.25),
        5 => star(0.0, 0.35, 4),
        6 => star(0.125, 0.35, 4),
        _ => star(0.0, 0.45, 5),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_series_differ_in_colour_or_marker() {
        let looks: Vec<_> = (0..56).map(|series| (Ink::Series(series).rgb(), series % 8)).collect();
        for (i, look) in looks.iter().enumerate() {
            assert!(!looks[..i].contains(look), "series {i}");
        }
        let shapes: Vec<_> = (0..8).map(marker).collect();
        for (i, shape) in shapes.iter().enumerate() {
            assert!(!shapes[..i].contains(shape), "marker {i}");
        }
    }
}
