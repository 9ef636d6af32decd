//! The validated scene: what the renderer works from.
//!
//! A [`Scene`] is made from a [`SceneConfig`](crate::config::SceneConfig) in one step, which checks all
//! that is valid key by key but wrong together, resolves paths and defaults, and reports every problem
//! at once. Past this point nothing is checked again and nothing sees TOML.
//!
//! Lengths are in scene units, angles in radians, colours in linear sRGB; the coordinates are `f64`.

mod camera;
mod caustics;
mod context;
mod hash;
mod light;
mod light_volume;
mod medium;
mod method;
mod output;
mod surface;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod tests_surface;
mod transfer;
mod volume;

use std::path::Path;

pub use camera::{Camera, CameraKind};
pub use caustics::{Caustics, Gather, Target};
pub use light::{Background, Light};
pub use light_volume::{DirectLight, LightVolume, ScatteredLight, Steady};
pub use medium::{Medium, Phase, ScatteringMedium};
pub use method::{Material, Method, MipColor, Orders, Quadrature, Scattering};
pub use output::{FilmSettings, Image, Stop};
pub use surface::{Metaball, Surface, SurfaceMaterial, SurfaceShape};
pub use transfer::{Point, Shape, Table2d, Transfer, Transfer1d, Transfer2d};
pub use volume::{FieldKind, Origin, Volume, VolumeSource};

/// Words of the scene language that need no validation.
pub use crate::config::types::{
    AccelerationConfig as Acceleration, Axis, ColorMap, Compositing, DiffusionSolver,
    DirectConfig as CausticsDirect, Domain, Endian, EnvironmentSampling, FillConfig as Fill, Filter,
    FluxConfig as PhotonFlux, FluxLimiter, KernelConfig as GatherKernel, Outline, SheppLoganRotation,
    SortConfig as Sort, Tonemap, Transmittance, VoxelKind,
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
    /// The volume and where it lies; every method but caustics has one.
    pub volume: Option<Volume>,
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
    /// What surfaces are made of, in the order of the file; may be empty.
    pub materials: Vec<SurfaceMaterial>,
    /// The surfaces, in the order of the file; may be empty.
    pub surfaces: Vec<Surface>,
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
    /// The pictures to render, of which the first is that of `camera`; one unless the scene has a turntable or views.
    pub views: Vec<View>,
    /// Identifies what determines the pixels: all of the scene file but `[stop]` and `[film]`, as 32
    /// hexadecimal digits. Independent of the order of keys, comments, and how a colour is spelt.
    /// Files are covered by their names as written, not by their contents.
    pub hash: String,
    /// Like `hash`, without the seed: equal for independent renders of one image.
    pub seedless_hash: String,
    /// Like `hash`, without the camera and the image: equal for scenes whose volumes are lit alike.
    pub light_hash: String,
}

/// One picture of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// From where.
    pub camera: Camera,
    /// The hash of the scene with this camera alone.
    pub hash: String,
    /// The same without the seed.
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
        let views = views(config, cx);
        let volume = volume::volume(config.volume.as_ref(), &config.method, cx);
        let transfer = transfer::transfer(&config.transfer, cx);
        let medium = medium::medium(&config.medium, &config.method, cx);
        let scattering = medium::scattering(&config.medium, cx);
        let lights = light::lights(&config.light, &config.method, cx);
        let materials = surface::materials(&config.material, cx);
        let surfaces = surface::surfaces(&config.surface, &config.material, cx);
        surface::refuse_surfaces(&config.surface, &config.method, cx);
        caustics::refuse_curved(&config.method, &surfaces, &materials, cx);
        let background = light::background(&config.background, cx);
        let method = method::method(&config.method, cx);
        let film = output::film(&config.film, &config.method, cx);
        let problems = context.into_problems();
        match (views, transfer) {
            (Some(views), Some(transfer)) if problems.is_empty() => Ok(Self {
                image,
                camera: views[0].camera.clone(),
                volume,
                medium,
                scattering,
                phase: medium::phase(&config.phase),
                transfer,
                lights,
                materials,
                surfaces,
                background,
                method,
                film,
                stop: output::stop(&config.stop),
                seed: config.seed,
                hash: views[0].hash.clone(),
                seedless_hash: views[0].seedless_hash.clone(),
                light_hash: hash::hash(config, &["camera", "image"]),
                views,
            }),
            _ => Err(loaded.document.error(&problems)),
        }
    }

    /// The scene of one of its views alone.
    pub fn of_view(&self, view: &View) -> Self {
        let View { camera, hash, seedless_hash } = view.clone();
        Self { camera, hash, seedless_hash, views: vec![view.clone()], ..self.clone() }
    }
}

/// The views of a scene, at least one; `None` where a camera is wrong.
fn views(config: &config::SceneConfig, cx: &mut Context<'_>) -> Option<Vec<View>> {
    let cameras = camera::cameras(&config.camera, cx)?;
    let view = |(index, alone): (usize, config::types::CameraConfig)| {
        let camera = camera::camera(&alone, &format!("camera.views.{index}"), cx)?;
        let alone = config::SceneConfig { camera: alone, ..config.clone() };
        let (hash, seedless_hash) = (hash::hash(&alone, &[]), hash::hash(&alone, &["seed"]));
        Some(View { camera, hash, seedless_hash })
    };
    cameras.into_iter().enumerate().map(view).collect()
}
