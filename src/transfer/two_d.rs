//! Transfer functions of value and gradient magnitude.

use super::{picture, shapes};
use crate::error::Result;
use crate::scene::{Table2d, Transfer2d};

/// A table over the windowed value (x) and the scaled gradient s (y).
///
/// Entry (i, j) stands at v = i/(width−1), s = j/(height−1), at index j·width + i: row 0 has the lowest gradient.
#[derive(Debug, Clone, PartialEq)]
pub struct TransferFunction2d {
    /// Entries along the value, at least 2.
    pub width: usize,
    /// Entries along the gradient, at least 2.
    pub height: usize,
    /// Straight-alpha `[r, g, b, opacity]`, linear sRGB, all in 0..=1.
    pub rgba: Vec<[f64; 4]>,
    /// Emission Lₑ of each entry, a radiance ≥ 0; `None` if all are 0, and for pictures.
    pub emission: Option<Vec<[f64; 3]>>,
}

impl TransferFunction2d {
    /// The table of a scene's transfer function: reads its picture or paints its shapes.
    ///
    /// # Errors
    /// [`Error::Input`](crate::Error::Input) if the picture cannot be read or has values outside 0..=1.
    pub fn from_settings(settings: &Transfer2d) -> Result<Self> {
        match &settings.table {
            Table2d::File(path) => picture::read(path),
            Table2d::Shapes { shapes, resolution } => Ok(shapes::paint(shapes, *resolution)),
        }
    }
}
