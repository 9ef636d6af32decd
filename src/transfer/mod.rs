//! Transfer functions as tables, and from their opacity to the extinction of a medium.
//!
//! A table holds straight-alpha `[r, g, b, opacity]` in linear sRGB, entry k of K at v = k/(K−1).
//! Classification happens after interpolation of the data (post-classification). Between entries the
//! renderer interpolates `[r, g, b, σₜ]` linearly, as [`sigma_table`] makes them: linear interpolation
//! of extinction *is* the model, in opacity mode too, where the opacity between entries follows from it.

mod colormap;
mod medium;
mod one_d;
mod picture;
mod shapes;
mod two_d;

pub use colormap::map_color;
pub use medium::{MOST_OPACITY, extinction, sigma_table};
pub use one_d::TransferFunction1d;
pub use two_d::TransferFunction2d;

/// Linear interpolation, exact at both ends.
fn lerp<const N: usize>(a: [f64; N], b: [f64; N], t: f64) -> [f64; N] {
    std::array::from_fn(|i| a[i] * (1.0 - t) + b[i] * t)
}
