//! Lights and background.

use std::path::PathBuf;

use glam::DVec3;

use super::camera::direction;
use super::context::Context;
use crate::config::types::{BackgroundConfig, LightConfig};

/// A light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Light {
    /// A point that shines equally in all directions.
    Point {
        /// Where it is, scene units.
        position: DVec3,
        /// Radiant intensity per channel, W/sr, ≥ 0.
        intensity: [f64; 3],
    },
    /// Parallel light.
    Directional {
        /// The direction of travel, unit length.
        direction: DVec3,
        /// Irradiance on the perpendicular plane per channel, W/m², ≥ 0.
        irradiance: [f64; 3],
    },
    /// A parallelogram that shines on one side, towards `edge_u` × `edge_v`. It blocks nothing.
    Rectangle {
        /// Its centre, scene units.
        centre: DVec3,
        /// One whole edge, scene units.
        edge_u: DVec3,
        /// The other edge, not parallel to the first.
        edge_v: DVec3,
        /// Radiance per channel, ≥ 0.
        radiance: [f64; 3],
    },
}

/// How an environment map lights a scattering volume.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EnvironmentSampling {
    /// What suits the map.
    Auto,
    /// By the rays that leave the volume alone.
    Escape,
    /// By directions drawn from the map, too.
    Importance,
}

/// What rays see that leave the volume.
#[derive(Debug, Clone, PartialEq)]
pub enum Background {
    /// The same radiance in every direction, per channel, ≥ 0.
    Constant([f64; 3]),
    /// A latitude-longitude map.
    Environment {
        /// An existing file.
        path: PathBuf,
        /// Factor on its radiance, ≥ 0.
        intensity: f64,
        /// Rotation about +y, radians.
        rotation: f64,
        /// How it lights a scattering volume.
        sampling: EnvironmentSampling,
    },
}

pub(super) fn lights(configs: &[LightConfig], cx: &mut Context<'_>) -> Vec<Light> {
    configs.iter().enumerate().map(|(index, config)| light(config, index, cx)).collect()
}

fn light(config: &LightConfig, index: usize, cx: &mut Context<'_>) -> Light {
    match config {
        LightConfig::Point { position, intensity } => {
            Light::Point { position: DVec3::from_array(*position), intensity: intensity.0 }
        }
        LightConfig::Directional { direction: travel, irradiance } => {
            // A wrong direction has been reported: any stands in for it.
            let unit = direction(*travel, &format!("light.{index}.direction"), cx);
            Light::Directional { direction: unit.unwrap_or(DVec3::NEG_Y), irradiance: irradiance.0 }
        }
    }
}

pub(super) fn background(config: &BackgroundConfig, cx: &mut Context<'_>) -> Background {
    let Some(name) = &config.environment else {
        for key in ["background.intensity", "background.rotation"] {
            cx.useless(key, "needs `background.environment`", "there is no environment map to apply it to");
        }
        return Background::Constant(config.color.map_or([0.0; 3], |color| color.0));
    };
    cx.useless("background.color", "does not go with `background.environment`", "give one of the two");
    Background::Environment {
        path: cx.file("background.environment", name),
        intensity: config.intensity.unwrap_or(1.0),
        rotation: config.rotation.unwrap_or(0.0).to_radians(),
        sampling: EnvironmentSampling::Auto,
    }
}
