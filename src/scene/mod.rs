//! The validated scene: what the renderer works from.
//!
//! A [`Scene`] is made from a [`SceneConfig`](crate::config::SceneConfig) in one step, which checks all
//! that is valid key by key but wrong together, resolves paths and defaults, and reports every problem
//! at once. Past this point nothing is checked again and nothing sees TOML.
//!
//! Lengths are in scene units, angles in radians, colours in linear sRGB; the coordinates are `f64`.

mod camera;
mod context;
mod hash;
mod light;
mod medium;
mod method;
mod output;
#[cfg(test)]
mod tests;
mod transfer;
mod volume;

use std::path::Path;

pub use camera::{Camera, CameraKind};
pub use light::{Background, Light};
pub use medium::{Medium, Phase, ScatteringMedium};
pub use method::{Material, Method, MipColor, Orders, Quadrature, Scattering};
pub use output::{FilmSettings, Image, Stop};
pub use transfer::{Point, Shape, Table2d, Transfer, Transfer1d, Transfer2d};
pub use volume::{FieldKind, Origin, Volume, VolumeSource};

/// Words of the scene language that need no validation.
pub use crate::config::types::{
    Axis, ColorMap, Compositing, Domain, Endian, EnvironmentSampling, Filter, Outline, SheppLoganRotation,
    Tonemap, Transmittance, VoxelKind,
};

use crate::config::{self, Loaded};
use crate::error::Result;
use context::Context;

/// Everything a render needs to know.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Size of the image and how a pixel is sampled.
    pub image: Image,
    /// The camera.
    pub camera: Camera,
    /// The volume and where it lies.
    pub volume: Volume,
    /// How opacity becomes extinction. Meaningful for methods that absorb.
    pub medium: Medium,
    /// What of the medium scatters. Meaningful for scattering methods, as is `phase`.
    pub scattering: ScatteringMedium,
    /// Into which directions the medium scatters.
    pub phase: Phase,
    /// Data value (and gradient) to colour and opacity.
    pub transfer: Transfer,
    /// The lights, in the order of the file; may be empty.
    pub lights: Vec<Light>,
    /// What rays see that leave the volume.
    pub background: Background,
    /// The rendering method.
    pub method: Method,
    /// How the preview is made.
    pub film: FilmSettings,
    /// When to stop.
    pub stop: Stop,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Identifies what determines the pixels: all of the scene file but `[stop]` and `[film]`, as 32
    /// hexadecimal digits. Independent of the order of keys, comments, and how a colour is spelt.
    /// Files are covered by their names as written, not by their contents.
    pub hash: String,
    /// Like `hash`, without the seed: equal for independent renders of one image.
    pub seedless_hash: String,
}

impl Scene {
    /// Reads and validates a scene file, with overrides `key.path=value`.
    ///
    /// # Errors
    /// [`Error::Input`](crate::Error::Input) with every problem rendered: file:line:col, the line, a caret and help.
    pub fn load(path: &Path, sets: &[String]) -> Result<Self> {
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::from_loaded(&config::load(path, sets)?, folder)
    }

    /// Validates a scene whose relative paths start at `folder`.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn from_loaded(loaded: &Loaded, folder: &Path) -> Result<Self> {
        let config = &loaded.config;
        let mut context = Context::new(&loaded.document, folder);
        let cx = &mut context;
        let image = output::image(&config.image, cx);
        let camera = camera::camera(&config.camera, cx);
        let volume = volume::volume(&config.volume, cx);
        let transfer = transfer::transfer(&config.transfer, cx);
        let medium = medium::medium(&config.medium, &config.method, cx);
        let scattering = medium::scattering(&config.medium, cx);
        let lights = light::lights(&config.light, &config.method, cx);
        let background = light::background(&config.background, cx);
        let method = method::method(&config.method, cx);
        let film = output::film(&config.film, &config.method, cx);
        let problems = context.into_problems();
        match (camera, volume, transfer) {
            (Some(camera), Some(volume), Some(transfer)) if problems.is_empty() => Ok(Self {
                image,
                camera,
                volume,
                medium,
                scattering,
                phase: medium::phase(&config.phase),
                transfer,
                lights,
                background,
                method,
                film,
                stop: output::stop(&config.stop),
                seed: config.seed,
                hash: hash::hash(config, true),
                seedless_hash: hash::hash(config, false),
            }),
            _ => Err(loaded.document.error(&problems)),
        }
    }
}
