//! Transfer functions as tables, and from their opacity to the extinction of a medium.
//!
//! A table holds straight-alpha `[r, g, b, opacity]` in linear sRGB, entry k of K at v = k/(K−1).
//! Classification happens after interpolation of the data (post-classification). Between entries the
//! renderer interpolates `[r, g, b, σₜ]` linearly, as [`sigma_table`] makes them: linear interpolation
//! of extinction *is* the model, in opacity mode too, where the opacity between entries follows from it.

//!
//! Beside it stands the emission Lₑ of every entry, a radiance, where any is more than 0.

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

/// The emission of all entries, if any emits.
fn some_if_any(emission: Vec<[f64; 3]>) -> Option<Vec<[f64; 3]>> {
    emission.iter().flatten().any(|&radiance| radiance > 0.0).then_some(emission)
}

/// Linear interpolation, exact at both ends.
fn lerp<const N: usize>(a: [f64; N], b: [f64; N], t: f64) -> [f64; N] {
    std::array::from_fn(|i| a[i] * (1.0 - t) + b[i] * t)
}
