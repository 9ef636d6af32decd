//! Image, preview and stop settings.

use std::time::Duration;

use super::context::Context;
use super::method::follows_paths;
use crate::config::types::{FilmConfig, Filter, ImageConfig, MethodConfig, StopConfig, Tonemap};

/// Most pixels of an image: indices and buffer sizes stay well inside 32 bits.
const MOST_PIXELS: u64 = 1 << 28;
/// Samples per pixel when the scene names no limit at all.
const DEFAULT_SAMPLES: u64 = 16;

/// Size of the image and how a pixel is sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Image {
    /// Pixels, 1..=65536.
    pub width: u32,
    /// Pixels, 1..=65536; width × height ≤ 2²⁸.
    pub height: u32,
    /// Which points of a pixel the rays go through.
    pub filter: Filter,
}

/// How the PNG preview is made from linear radiance, and what else the EXR holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmSettings {
    /// The curve.
    pub tonemap: Tonemap,
    /// Factor before the curve, > 0.
    pub exposure: f64,
    /// Exponent of a pure power encoding, > 0; the sRGB curve if `None`.
    pub gamma: Option<f64>,
    /// Whether the EXR holds channels for denoisers too; only with scattering methods.
    pub auxiliary: bool,
}

/// When to stop: whichever limit is reached first. At least one is set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// Samples per pixel, 1..=10⁹.
    pub samples: Option<u64>,
    /// Rendering time, longer than zero.
    pub time: Option<Duration>,
    /// Estimated relative root-mean-square error, a fraction > 0.
    pub error: Option<f64>,
}

pub(super) fn image(config: &ImageConfig, cx: &mut Context<'_>) -> Image {
    let pixels = u64::from(config.width) * u64::from(config.height);
    if pixels > MOST_PIXELS {
        let message = format!("the image is too large: {} × {} pixels", config.width, config.height);
        cx.wrong("image.width", message, format!("width × height must be at most {MOST_PIXELS}"));
    }
    Image { width: config.width, height: config.height, filter: config.filter }
}

pub(super) fn film(config: &FilmConfig, method: &MethodConfig, cx: &mut Context<'_>) -> FilmSettings {
    if config.auxiliary && !follows_paths(method) {
        let label = "this method makes no such channels";
        cx.wrong("film.auxiliary", "`film.auxiliary` needs a scattering method", label);
    }
    let &FilmConfig { tonemap, exposure, gamma, auxiliary } = config;
    FilmSettings { tonemap, exposure, gamma, auxiliary }
}

pub(super) fn stop(config: &StopConfig) -> Stop {
    let unlimited = config.samples.is_none() && config.time.is_none() && config.error.is_none();
    Stop {
        samples: config.samples.or(unlimited.then_some(DEFAULT_SAMPLES)),
        time: config.time.map(|limit| limit.0),
        error: config.error.map(|target| target.0),
    }
}
