//! Lights and background.

use std::path::PathBuf;

use glam::DVec3;

use super::camera::direction;
use super::context::Context;
use crate::config::types::{BackgroundConfig, EnvironmentSampling, LightConfig, MethodConfig};

/// Edges closer to each other than this (sine of the angle) span no rectangle.
const LEAST_SINE: f64 = 1e-6;

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
    /// A parallelogram that shines towards `edge_u` × `edge_v` and blocks nothing; a rectangle where the edges are
    /// perpendicular. Never together with an isosurface.
    Rectangle {
        /// Its middle, scene units.
        centre: DVec3,
        /// One edge from end to end, scene units.
        edge_u: DVec3,
        /// The other edge, not parallel to `edge_u`.
        edge_v: DVec3,
        /// Radiance of its front per channel, W/(m² sr), ≥ 0.
        radiance: [f64; 3],
    },
}

impl Light {
    /// Its intensity, irradiance or radiance per channel.
    pub fn color(&self) -> [f64; 3] {
        match *self {
            Self::Point { intensity, .. } => intensity,
            Self::Directional { irradiance, .. } => irradiance,
            Self::Rectangle { radiance, .. } => radiance,
        }
    }
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
        /// How methods that scatter find its light.
        sampling: EnvironmentSampling,
    },
}

pub(super) fn lights(configs: &[LightConfig], method: &MethodConfig, cx: &mut Context<'_>) -> Vec<Light> {
    if matches!(method, MethodConfig::Isosurface { .. }) {
        refuse_rectangles(configs, cx);
    }
    configs.iter().enumerate().map(|(index, config)| light(config, index, cx)).collect()
}

fn refuse_rectangles(configs: &[LightConfig], cx: &mut Context<'_>) {
    for (index, config) in configs.iter().enumerate() {
        if matches!(config, LightConfig::Rectangle { .. }) {
            let message = "isosurface takes point and directional lights";
            cx.wrong(&format!("light.{index}.kind"), message, "a rectangle is for scattering methods");
        }
    }
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
        LightConfig::Rectangle { centre, edge_u, edge_v, radiance } => {
            let [u, v] = [("edge_u", edge_u), ("edge_v", edge_v)]
                .map(|(key, edge)| direction(*edge, &format!("light.{index}.{key}"), cx));
            if let (Some(u), Some(v)) = (u, v)
                && u.cross(v).length() < LEAST_SINE
            {
                let path = format!("light.{index}.edge_v");
                let message = format!("`{path}` must not be parallel to `light.{index}.edge_u`");
                cx.wrong(&path, message, "they span no rectangle");
            }
            let [centre, edge_u, edge_v] = [centre, edge_u, edge_v].map(|vector| DVec3::from_array(*vector));
            Light::Rectangle { centre, edge_u, edge_v, radiance: radiance.0 }
        }
    }
}

pub(super) fn background(config: &BackgroundConfig, cx: &mut Context<'_>) -> Background {
    let Some(name) = &config.environment else {
        for key in ["background.intensity", "background.rotation", "background.sampling"] {
            cx.useless(key, "needs `background.environment`", "there is no environment map to apply it to");
        }
        return Background::Constant(config.color.map_or([0.0; 3], |color| color.0));
    };
    cx.useless("background.color", "does not go with `background.environment`", "give one of the two");
    Background::Environment {
        path: cx.file("background.environment", name),
        intensity: config.intensity.unwrap_or(1.0),
        // Whole turns are none, and many would leave the range of float32.
        rotation: (config.rotation.unwrap_or(0.0) % 360.0).to_radians(),
        sampling: config.sampling.unwrap_or_default(),
    }
}
