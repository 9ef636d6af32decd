//! Several devices on one picture: the same bits as one, whatever falls to whom and whatever fails.

mod common;

use common::device;
use std::path::Path;
use svetlo::caustics::PassLedger;
use svetlo::crew::Crew;
use svetlo::device::Device;
use svetlo::film::FilmPixel;
use svetlo::render::{BRICK_SHIFT, PathLedger, Plan, Rendering, SavedFilm, SceneData, Session, Spent};
use svetlo::scene::Scene;

/// Scenes of all kinds: emission-absorption, scattering with auxiliary images, a light volume, caustics.
const SCENES: [(&str, &[&str]); 4] = [
    ("configs/cloud.toml", &["image.width=52", "image.height=45", "method.kind='emission-absorption'"]),
    ("configs/cloud.toml", &["image.width=52", "image.height=45", "film.auxiliary=true"]),
    ("configs/head_hybrid.toml", &["image.width=40", "image.height=36"]),
    ("configs/metaballs.toml", &["image.width=44", "image.height=33", "method.photons=4096"]),
];
