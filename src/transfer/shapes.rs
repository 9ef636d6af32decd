//! Paints shapes into a two-dimensional transfer function.
//!
//! Every shape is star-shaped about its centroid, so "how far out" is its gauge: 0 at the centroid, 1 on
//! the outline. Softness is a band of the gauge below 1 in which the coverage falls smoothly.

use super::{TransferFunction2d, lerp, some_if_any};
use crate::scene::{Outline, Shape};

/// Paints shapes over each other in order ("over"), each entry sampled at its position.
///
/// Entries that no shape covers are transparent and take colour and emission of the nearest shape (by gauge), so
/// that interpolation at an edge does not darken them. `resolution` counts entries, at least 2 each.
pub(super) fn paint(shapes: &[Shape], resolution: [usize; 2]) -> TransferFunction2d {
    let [width, height] = resolution.map(|entries| entries.max(2));
    let at = |index: usize, entries: usize| index as f64 / (entries - 1) as f64;
    let rows = 0..height;
    let positions = rows.flat_map(|j| (0..width).map(move |i| [at(i, width), at(j, height)]));
    let (rgba, emission) = positions.map(|p| entry(shapes, p)).unzip();
    TransferFunction2d { width, height, rgba, emission: some_if_any(emission) }
}

/// Colour with opacity, and emission.
fn entry(shapes: &[Shape], p: [f64; 2]) -> ([f64; 4], [f64; 3]) {
    let mut color = [0.0; 3];
    let mut emission = [0.0; 3];
    let mut opacity = 0.0;
    let mut nearest = f64::INFINITY;
    for shape in shapes {
        let gauge = gauge(shape, p);
        let alpha = shape.opacity * coverage(gauge, shape.softness);
        let total = alpha + opacity * (1.0 - alpha);
        if total > 0.0 {
            let weight = alpha / total;
            color = lerp(color, shape.color, weight);
            emission = lerp(emission, shape.emission, weight);
        } else if gauge < nearest {
            (color, emission) = (shape.color, shape.emission);
        }
        nearest = nearest.min(gauge);
        opacity = total;
    }
    let [r, g, b] = color;
    ([r, g, b, opacity], emission)
}

/// 0 at the centroid, 1 on the outline, more outside.
fn gauge(shape: &Shape, p: [f64; 2]) -> f64 {
    let [x, y] = [0, 1].map(|axis| 2.0 * (p[axis] - shape.centre[axis]) / shape.size[axis]);
    match shape.outline {
        Outline::Rectangle => x.abs().max(y.abs()),
        Outline::Ellipse => x.hypot(y),
        // Corners (0, -1), (-1, 1), (1, 1); centroid (0, 1/3), which all three sides see at gauge 0:
        // the base y = 1 at distance 2/3, the legs 2|x| - y = 1 at 1 + 1/3.
        Outline::Triangle => {
            let y = y - 1.0 / 3.0;
            (y * 1.5).max((2.0 * x.abs() - y) * 0.75)
        }
    }
}

/// 1 inside, 0 outside, smooth (3t² − 2t³) over the band of width `softness` inside the outline.
fn coverage(gauge: f64, softness: f64) -> f64 {
    if softness <= 0.0 {
        return if gauge <= 1.0 { 1.0 } else { 0.0 };
    }
    let t = ((1.0 - gauge) / softness).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: [f64; 3] = [1.0, 0.0, 0.0];

    fn shape(outline: Outline, softness: f64) -> Shape {
        Shape {
            outline,
            centre: [0.5, 0.5],
            size: [0.5, 0.5],
            color: RED,
            opacity: 0.5,
            softness,
            emission: [0.0; 3],
        }
    }

    #[test]
    fn the_gauge_is_one_on_the_outline() {
        let on = [
            (Outline::Rectangle, [0.75, 0.6]),
            (Outline::Rectangle, [0.75, 0.75]),
            (Outline::Ellipse, [0.5, 0.25]),
            (Outline::Triangle, [0.5, 0.25]),
            (Outline::Triangle, [0.75, 0.75]),
            (Outline::Triangle, [0.25, 0.75]),
            (Outline::Triangle, [0.625, 0.5]),
            (Outline::Triangle, [0.4, 0.75]),
        ];
        for (outline, p) in on {
            let gauge = gauge(&shape(outline, 0.0), p);
            assert!((gauge - 1.0).abs() < 1e-12, "{outline:?} {p:?}: {gauge}");
        }
        let centroid = gauge(&shape(Outline::Triangle, 0.0), [0.5, 0.5 + 0.25 / 3.0]);
        assert!(centroid.abs() < 1e-12, "{centroid}");
    }

    #[test]
    fn a_soft_edge_is_half_way_in_the_middle_of_its_band() {
        assert_eq!(coverage(1.0, 0.5), 0.0);
        assert_eq!(coverage(0.75, 0.5), 0.5);
        assert_eq!(coverage(0.5, 0.5), 1.0);
        assert_eq!([0.0, 1.0, 1.0 + 1e-9].map(|g| coverage(g, 0.0)), [1.0, 1.0, 0.0]);
    }

    #[test]
    fn rows_go_up_and_columns_right() {
        let corner = Shape { centre: [1.0, 0.0], size: [0.5, 0.5], ..shape(Outline::Rectangle, 0.0) };
        let table = paint(&[corner], [3, 2]);
        let opacities: Vec<_> = table.rgba.iter().map(|entry| entry[3]).collect();
        assert_eq!(opacities, [0.0, 0.0, 0.5, 0.0, 0.0, 0.0]);
        assert_eq!((table.width, table.height), (3, 2));
    }

    #[test]
    fn shapes_are_composited_over_each_other() {
        let below = Shape { color: [0.0, 1.0, 0.0], ..shape(Outline::Rectangle, 0.0) };
        let above = shape(Outline::Ellipse, 0.0);
        // Over: opacity 0.5 + 0.5·0.5 = 0.75; colour (0.5 red + 0.25 green)/0.75.
        let ([r, g, b, a], _) = entry(&[below, above], [0.5, 0.5]);
        assert!((r - 2.0 / 3.0).abs() < 1e-15 && (g - 1.0 / 3.0).abs() < 1e-15 && b == 0.0 && a == 0.75);
    }

    #[test]
    fn emission_is_painted_like_colours() {
        let below = Shape { emission: [3.0, 0.0, 9.0], ..shape(Outline::Rectangle, 0.0) };
        let above = Shape { emission: [0.0, 6.0, 0.0], ..shape(Outline::Ellipse, 0.0) };
        // Over, with the weights of the colours: 2/3 above, 1/3 below.
        let (_, emission) = entry(&[below, above], [0.5, 0.5]);
        for (got, expected) in emission.into_iter().zip([1.0, 4.0, 3.0]) {
            assert!((got - expected).abs() < 1e-14, "{emission:?}");
        }
        let ([.., opacity], outside) = entry(&[below, above], [0.9, 0.9]);
        assert_eq!((opacity, outside), (0.0, below.emission), "the rectangle is nearer");
        assert_eq!(paint(&[below], [2, 2]).emission, Some(vec![below.emission; 4]));
        assert_eq!(paint(&[shape(Outline::Ellipse, 0.0)], [2, 2]).emission, None);
    }

    #[test]
    fn empty_entries_take_the_colour_of_the_nearest_shape() {
        let far = Shape {
            centre: [0.0, 0.0],
            size: [0.1, 0.1],
            color: [0.0, 1.0, 0.0],
            ..shape(Outline::Ellipse, 0.0)
        };
        let near = shape(Outline::Ellipse, 0.0);
        for order in [[far, near], [near, far]] {
            assert_eq!(entry(&order, [0.5, 0.8]).0, [1.0, 0.0, 0.0, 0.0]);
        }
    }
}
