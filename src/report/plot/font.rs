//! The one font of the plots: a subset of DejaVu Sans, embedded, so that every machine draws the same pictures.

use std::sync::LazyLock;

use ttf_parser::{Face, GlyphId, OutlineBuilder};

use super::drawing::Place;

/// What an SVG asks for: the embedded font where a viewer has it, else one of the same widths.
pub const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";

static FACE: LazyLock<Face<'static>> = LazyLock::new(|| {
    Face::parse(include_bytes!("../font/DejaVuSans-subset.ttf"), 0).expect("the embedded font is a font")
});

/// The glyph of a character; one that the font lacks is drawn as the replacement character.
fn glyph(character: char) -> GlyphId {
    FACE.glyph_index(character).or_else(|| FACE.glyph_index('\u{fffd}')).unwrap_or(GlyphId(0))
}

fn advance(character: char) -> f64 {
    f64::from(FACE.glyph_hor_advance(glyph(character)).unwrap_or(0))
}

fn scale(size: f64) -> f64 {
    size / f64::from(FACE.units_per_em())
}

/// How wide a text is in pixels.
pub fn width(text: &str, size: f64) -> f64 {
    text.chars().map(advance).sum::<f64>() * scale(size)
}

/// The text, or as much of it as fits with an ellipsis in its middle: names often differ in their ends.
pub fn fitted(text: &str, size: f64, room: f64) -> String {
    if width(text, size) <= room {
        return text.to_owned();
    }
    let characters: Vec<char> = text.chars().collect();
    let cut = |kept: usize| -> String {
        let (head, tail) = (kept.div_ceil(2), kept / 2);
        let head = characters[..head].iter().collect::<String>();
        head.trim_end().to_owned()
            + "…"
            + characters[characters.len() - tail..].iter().collect::<String>().trim_start()
    };
    let kept = (0..characters.len()).rev().find(|&kept| width(&cut(kept), size) <= room);
    cut(kept.unwrap_or(0))
}

/// Where the outlines of a text go.
pub trait Pen {
    /// Begins a contour.
    fn start(&mut self, to: Place);
    /// A straight part.
    fn line(&mut self, to: Place);
    /// A quadratic part.
    fn curve(&mut self, control: Place, to: Place);
    /// Ends the contour.
    fn close(&mut self);
}

/// Draws the outlines of a text that starts at 0 on the base line.
pub fn outline(text: &str, size: f64, pen: &mut impl Pen) {
    let mut left = 0.0;
    for character in text.chars() {
        FACE.outline_glyph(glyph(character), &mut Placed { pen, left, scale: scale(size) });
        left += advance(character) * scale(size);
    }
}

/// Font units, y up, to pixels, y down.
struct Placed<'a, P> {
    pen: &'a mut P,
    left: f64,
    scale: f64,
}

impl<P> Placed<'_, P> {
    fn place(&self, x: f32, y: f32) -> Place {
        [self.left + f64::from(x) * self.scale, -f64::from(y) * self.scale]
    }
}

impl<P: Pen> OutlineBuilder for Placed<'_, P> {
    fn move_to(&mut self, x: f32, y: f32) {
        self.pen.start(self.place(x, y));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.pen.line(self.place(x, y));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.pen.curve(self.place(x1, y1), self.place(x, y));
    }

    fn curve_to(&mut self, _: f32, _: f32, _: f32, _: f32, _: f32, _: f32) {
        unreachable!("a TrueType font has quadratic curves only");
    }

    fn close(&mut self) {
        self.pen.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_signs_of_plots_are_in_the_font() {
        let missing: String = "AZaz09µ×·−–…½²⁰¹⁻⁷√≤≥±∝°λσ→äčшΩ"
            .chars()
            .filter(|&character| FACE.glyph_index(character).is_none())
            .collect();
        assert_eq!(missing, "");
    }

    #[test]
    fn long_texts_keep_both_ends() {
        assert_eq!(fitted("short", 12.0, 100.0), "short");
        let long = "emission-absorption of a very long name, 64 steps";
        let cut = fitted(long, 12.0, 150.0);
        assert!(cut.starts_with("emiss") && cut.ends_with("steps") && cut.contains('…'), "{cut}");
        assert!(width(&cut, 12.0) <= 150.0);
        assert_eq!(fitted("x", 12.0, 0.0), "…");
        assert_eq!(fitted("日本語の名前です", 12.0, 40.0).matches('…').count(), 1);
    }
}
