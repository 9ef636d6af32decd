//! Error metrics between pictures. Depends on no device.
//!
//! [`compare`] measures how far a linear picture x is from a reference r of the same size, over
//! all M = pixels × channels values where both are finite, and says how sure it is. Where a file
//! carries its own noise (`variance.*`, per sample, and `samples`), that noise is taken out.
//!
//! | metric | definition |
//! |--------|------------|
//! | MSE    | mean (x−r)² |
//! | RMSE   | √MSE |
//! | PSNR   | 10 log₁₀(P²/MSE): once with P = max r on linear values, once with P = 1 on sRGB codes of values clamped to [0, 1] |
//! | relMSE | mean (x−r)²/(r²+ε), ε = (0.1 · mean \|r\|)² |
//! | MAPE   | mean \|x−r\|/(\|r\| + 0.1 · mean \|r\|) |
//! | bias   | mean (x−r) |

mod blocks;
pub mod command;
mod compare;
mod corrected;
mod difference;
mod noise;
mod pair;
mod report;
mod thresholds;

pub use blocks::Estimate;
pub(crate) use blocks::student_t_975;
pub use command::{CompareArgs, run};
pub use compare::{Bias, ChannelBias, Comparison, NonFinite, Psnr, compare, squared_error_blocks};
pub use corrected::{Corrected, PixelZ, Removed};
pub use difference::{difference_picture, write_difference};
pub use thresholds::Thresholds;

#[cfg(test)]
pub(crate) mod test_pictures;
