//! Plots: what to show → [`Drawing`] → SVG and PNG, the same on every machine.
//!
//! | file | what |
//! | --- | --- |
//! | `drawing` | shapes, inks and markers |
//! | `font` | the embedded font: widths and outlines |
//! | `axis`, `frame` | values to pixels, ticks, grid, legend |
//! | `curves`, `bars` | the two kinds of plots |
//! | `svg`, `raster` | a drawing as text and as pixels |

mod axis;
mod bars;
mod curves;
mod drawing;
mod font;
mod frame;
mod raster;
mod svg;

pub use bars::{Bar, Bars};
pub use curves::{Curve, CurvePoint, Curves, Level};
pub use drawing::Drawing;
pub use svg::{element, printable};

use std::{io::Write, path::Path};

use crate::{
    error::Result,
    picture::{write_atomically, write_png_rgb8},
};

/// Pixels of the PNG for one of the drawing: sharp in print and on dense screens.
const PNG_SCALE: f64 = 2.0;

/// A plot of either kind.
#[derive(Clone, Debug)]
pub enum Plot {
    /// Error against cost.
    Curves(Curves),
    /// A number per case.
    Bars(Bars),
}

impl Plot {
    /// Its shapes.
    pub fn drawing(&self) -> Drawing {
        match self {
            Self::Curves(plot) => curves::draw(plot),
            Self::Bars(plot) => bars::draw(plot),
        }
    }
}

/// Writes `NAME.svg` and `NAME.png` into a folder, atomically.
///
/// # Errors
/// [`crate::Error::Failed`] where the disk refuses.
pub fn write(drawing: &Drawing, folder: &Path, name: &str) -> Result<()> {
    write_atomically(&folder.join(format!("{name}.svg")), |file| {
        file.write_all(svg::document(drawing).as_bytes())
    })?;
    let pixels = raster::pixels(drawing, PNG_SCALE)?;
    write_png_rgb8(&folder.join(format!("{name}.png")), pixels.width, pixels.height, &pixels.codes)
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
