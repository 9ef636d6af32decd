//! The transfer function.

use std::path::PathBuf;

use super::context::Context;
use super::method::normalized_value;
use crate::config::types::{ColorMap, Domain, Outline, PointConfig, ShapeConfig, TransferConfig};

/// Data value (and gradient) to colour and opacity.
#[derive(Debug, Clone, PartialEq)]
pub enum Transfer {
    /// By value.
    OneD(Transfer1d),
    /// By value and gradient magnitude.
    TwoD(Transfer2d),
}

/// A transfer function by value: points joined by straight lines.
#[derive(Debug, Clone, PartialEq)]
pub struct Transfer1d {
    /// The unit of the points' values.
    pub domain: Domain,
    /// Colours where the points have none.
    pub colormap: Option<ColorMap>,
    /// At least one, strictly increasing in value.
    pub points: Vec<Point>,
    /// Entries of the lookup table, 2..=65536.
    pub resolution: usize,
}

/// One point of a transfer function.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// The value, in the unit of the domain.
    pub value: f64,
    /// Opacity, 0..=1.
    pub opacity: f64,
    /// Linear colour, components 0..=1; from the colour map, else white, if `None`.
    pub color: Option<[f64; 3]>,
    /// Lₑ: radiance of which the medium emits σₐ Lₑ per length, per channel, ≥ 0.
    pub emission: [f64; 3],
}

/// A transfer function by value and gradient.
#[derive(Debug, Clone, PartialEq)]
pub struct Transfer2d {
    /// Where its table comes from.
    pub table: Table2d,
    /// The gradient that maps to the top of the table, in windowed value per smallest spacing, > 0.
    pub gradient_max: f64,
}

/// Where a two-dimensional table comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum Table2d {
    /// An existing picture, PNG or EXR.
    File(PathBuf),
    /// Shapes painted over each other in order.
    Shapes {
        /// At least one.
        shapes: Vec<Shape>,
        /// Entries [value, gradient], each 2..=4096.
        resolution: [usize; 2],
    },
}

/// A shape in a two-dimensional transfer function; x is the value, y the gradient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    /// The outline.
    pub outline: Outline,
    /// Middle of its box.
    pub centre: [f64; 2],
    /// Full extent of its box, each > 0.
    pub size: [f64; 2],
    /// Linear colour, components 0..=1.
    pub color: [f64; 3],
    /// Opacity in the middle, 0..=1.
    pub opacity: f64,
    /// Part of the way from edge to centroid over which the opacity rises, 0..=1.
    pub softness: f64,
    /// Lₑ: radiance of which the medium emits σₐ Lₑ per length, per channel, ≥ 0.
    pub emission: [f64; 3],
}

pub(super) fn transfer(config: &TransferConfig, cx: &mut Context<'_>) -> Option<Transfer> {
    match config {
        TransferConfig::OneD { domain, colormap, points, resolution } => {
            // Without points the ramp runs over the window, whatever the unit.
            let domain = if points.is_some() { *domain } else { Domain::Normalized };
            let points = points.as_ref().map_or_else(ramp, |points| knots(points, domain, cx));
            let resolution = *resolution as usize;
            Some(Transfer::OneD(Transfer1d { domain, colormap: *colormap, points, resolution }))
        }
        TransferConfig::TwoD { table, shapes, resolution, gradient_max } => {
            let table = table_2d(table.as_deref(), shapes.as_deref(), *resolution, cx)?;
            Some(Transfer::TwoD(Transfer2d { table, gradient_max: *gradient_max }))
        }
    }
}

fn ramp() -> Vec<Point> {
    [0.0, 1.0].map(|value| Point { value, opacity: value, color: None, emission: [0.0; 3] }).to_vec()
}

fn knots(configs: &[PointConfig], domain: Domain, cx: &mut Context<'_>) -> Vec<Point> {
    let mut previous = f64::NEG_INFINITY;
    for (index, point) in configs.iter().enumerate() {
        let path = format!("transfer.points.{index}.value");
        normalized_value(point.value, domain, &path, "transfer.domain", cx);
        if point.value <= previous {
            let message = "the points of a transfer function must be sorted by value, without equal values";
            cx.wrong(&path, message, format!("must be more than {previous}, the value before it"));
        }
        previous = point.value;
    }
    let knot = |point: &PointConfig| Point {
        value: point.value,
        opacity: point.opacity,
        color: point.color.map(|color| color.0),
        emission: point.emission.0,
    };
    configs.iter().map(knot).collect()
}

fn table_2d(
    table: Option<&str>,
    shapes: Option<&[ShapeConfig]>,
    resolution: Option<[u32; 2]>,
    cx: &mut Context<'_>,
) -> Option<Table2d> {
    match (table, shapes) {
        (Some(name), None) => {
            let why = "a picture has its own size";
            cx.useless("transfer.resolution", "does not go with `transfer.table`", why);
            Some(Table2d::File(cx.file("transfer.table", name)))
        }
        (None, Some(shapes)) => {
            let resolution = resolution.unwrap_or([256, 256]).map(|entries| entries as usize);
            let shapes = shapes.iter().enumerate().map(|(index, config)| shape(config, index, cx)).collect();
            Some(Table2d::Shapes { shapes, resolution })
        }
        (Some(_), Some(_)) => {
            cx.useless("transfer.shapes", "does not go with `transfer.table`", "give one of the two");
            None
        }
        (None, None) => {
            let message = "a two-dimensional transfer function needs `table` or `shapes`";
            cx.wrong("transfer.kind", message, "neither is given");
            None
        }
    }
}

fn shape(config: &ShapeConfig, index: usize, cx: &mut Context<'_>) -> Shape {
    for (axis, extent) in config.size.into_iter().enumerate() {
        if extent <= 0.0 {
            let path = format!("transfer.shapes.{index}.size.{axis}");
            cx.wrong(&path, format!("`{path}` is out of range"), "must be more than 0");
        }
    }
    Shape {
        outline: config.shape,
        centre: config.centre,
        size: config.size,
        color: config.color.0,
        opacity: config.opacity,
        softness: config.softness,
        emission: config.emission.0,
    }
}
