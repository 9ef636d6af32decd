//! A drawing as pixels.

use tiny_skia::{FillRule, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, StrokeDash, Transform};

use super::{
    drawing::{Anchor, Drawing, Ink, Place, Shape},
    font,
};
use crate::error::{Error, Result};

/// 8-bit RGB code values.
#[derive(Clone, Debug)]
pub struct Pixels {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Three codes a pixel, row by row from the top left.
    pub codes: Vec<u8>,
}

/// Draws with `scale` pixels for one of the drawing.
///
/// # Errors
/// [`Error::Failed`] for a drawing without size, or of more than the memory takes.
pub fn pixels(drawing: &Drawing, scale: f64) -> Result<Pixels> {
    let (width, height) = (drawing.width * scale, drawing.height * scale);
    let mut map = Pixmap::new(width.ceil() as u32, height.ceil() as u32)
        .ok_or_else(|| Error::Failed(format!("a plot of {width:.0}×{height:.0} pixels cannot be drawn")))?;
    let transform = Transform::from_scale(scale as f32, scale as f32);
    for shape in &drawing.shapes {
        draw(&mut map, shape, transform);
    }
    // The first shape covers everything with opaque paper: no pixel is transparent.
    let codes = map.data().chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    Ok(Pixels { width: map.width() as usize, height: map.height() as usize, codes })
}

fn draw(map: &mut Pixmap, shape: &Shape, transform: Transform) {
    match shape {
        Shape::Line { points, ink, width, dash } => {
            let dash =
                dash.and_then(|lengths| StrokeDash::new(lengths.map(|length| length as f32).to_vec(), 0.0));
            let stroke =
                Stroke { width: *width as f32, dash, line_join: LineJoin::Round, ..Stroke::default() };
            if let Some(path) = polygon(points, false) {
                map.stroke_path(&path, &paint(*ink, 1.0), &stroke, transform, None);
            }
        }
        Shape::Area { points, ink, opacity, .. } => {
            if let Some(path) = polygon(points, true) {
                map.fill_path(&path, &paint(*ink, *opacity), FillRule::Winding, transform, None);
            }
        }
        Shape::Text { at, text, size, ink, anchor, turned } => {
            let start = match anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => -0.5 * font::width(text, *size),
                Anchor::End => -font::width(text, *size),
            };
            let mut outline = Outline::default();
            font::outline(text, *size, &mut outline);
            let turn = if *turned { Transform::from_rotate(-90.0) } else { Transform::identity() };
            let place = turn.pre_translate(start as f32, 0.0).post_translate(at[0] as f32, at[1] as f32);
            if let Some(path) = outline.0.finish() {
                map.fill_path(
                    &path,
                    &paint(*ink, 1.0),
                    FillRule::Winding,
                    place.post_concat(transform),
                    None,
                );
            }
        }
    }
}

fn paint(ink: Ink, opacity: f64) -> Paint<'static> {
    let [r, g, b] = ink.rgb();
    let mut paint = Paint::default();
    paint.set_color_rgba8(r, g, b, (255.0 * opacity).round() as u8);
    paint
}

/// `None` where there is nothing to draw.
fn polygon(points: &[Place], closed: bool) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for (i, &[x, y]) in points.iter().enumerate() {
        let (x, y) = (x as f32, y as f32);
        if i == 0 { builder.move_to(x, y) } else { builder.line_to(x, y) }
    }
    if closed {
        builder.close();
    }
    builder.finish()
}

#[derive(Default)]
struct Outline(PathBuilder);

impl font::Pen for Outline {
    fn start(&mut self, [x, y]: Place) {
        self.0.move_to(x as f32, y as f32);
    }

    fn line(&mut self, [x, y]: Place) {
        self.0.line_to(x as f32, y as f32);
    }

    fn curve(&mut self, [cx, cy]: Place, [x, y]: Place) {
        self.0.quad_to(cx as f32, cy as f32, x as f32, y as f32);
    }

    fn close(&mut self) {
        self.0.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How many pixels of a box of pixels are dark.
    fn dark(pixels: &Pixels, [x0, y0, x1, y1]: [usize; 4]) -> usize {
        let row = |y: usize| (x0..x1).filter(move |x| pixels.codes[3 * (y * pixels.width + x)] < 128).count();
        (y0..y1).map(row).sum()
    }

    #[test]
    fn shapes_are_where_they_should_be() {
        let mut drawing = Drawing::new(40.0, 20.0, "");
        drawing.area(vec![[10.0, 5.0], [20.0, 5.0], [20.0, 10.0], [10.0, 10.0]], Ink::Text, 1.0);
        drawing.line(vec![[0.0, 15.0], [40.0, 15.0]], Ink::Text, 2.0);
        let pixels = pixels(&drawing, 2.0).unwrap();
        assert_eq!((pixels.width, pixels.height, pixels.codes.len()), (80, 40, 9600));
        assert_eq!(dark(&pixels, [0, 0, 80, 40]), 20 * 10 + 80 * 4);
        assert_eq!(dark(&pixels, [20, 10, 40, 20]), 200);
    }

    #[test]
    fn texts_are_drawn_at_their_anchors() {
        for (anchor, from, to) in [(Anchor::Start, 50, 86), (Anchor::Middle, 32, 68), (Anchor::End, 14, 50)] {
            let mut drawing = Drawing::new(100.0, 30.0, "");
            drawing.text([50.0, 20.0], anchor, 12.0, Ink::Text, "Hxg½");
            let width = font::width("Hxg½", 12.0);
            assert!(width > 30.0 && width < 36.0, "{width}");
            let pixels = pixels(&drawing, 1.0).unwrap();
            let all = dark(&pixels, [0, 0, 100, 30]);
            assert!(all > 30, "{anchor:?}: {all} dark pixels");
            assert_eq!(dark(&pixels, [from, 8, to, 24]), all, "{anchor:?}");
        }
        let mut drawing = Drawing::new(30.0, 100.0, "");
        drawing.turned([20.0, 50.0], 12.0, Ink::Text, "Hxg½");
        let pixels = pixels(&drawing, 1.0).unwrap();
        let all = dark(&pixels, [0, 0, 30, 100]);
        assert!(all > 30 && dark(&pixels, [8, 32, 24, 68]) == all);
    }

    #[test]
    fn degenerate_drawings_are_errors_or_empty() {
        assert!(pixels(&Drawing::new(0.0, 10.0, ""), 1.0).is_err());
        let mut drawing = Drawing::new(4.0, 4.0, "");
        drawing.line(vec![], Ink::Text, 1.0);
        drawing.line(vec![[1.0, 1.0]], Ink::Text, 1.0);
        drawing.area(vec![[f64::NAN, 1.0], [2.0, 2.0]], Ink::Text, 1.0);
        drawing.text([1.0, 1.0], Anchor::Start, 12.0, Ink::Text, "");
        assert!(pixels(&drawing, 1.0).unwrap().codes.iter().all(|&code| code == 255));
    }
}
