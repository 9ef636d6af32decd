//! The camera.

use glam::DVec3;

use super::context::Context;
use crate::config::types::CameraConfig;

/// Views closer to `up` than this (sine of the angle) have no usable right direction.
const LEAST_SINE: f64 = 1e-6;

/// Where the camera stands and how it projects. Image right is forward × up.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Where it stands, scene units.
    pub position: DVec3,
    /// The point in the middle of the image, scene units; not `position`.
    pub target: DVec3,
    /// Up in the image: unit length, not parallel to the view, not necessarily perpendicular to it.
    pub up: DVec3,
    /// How it projects.
    pub kind: CameraKind,
}

/// How a camera projects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CameraKind {
    /// Pinhole or thin lens.
    Perspective {
        /// Vertical field of view, radians, 0..π exclusive.
        fov: f64,
        /// Radius of the lens, scene units; 0 is a pinhole.
        aperture: f64,
        /// Distance of the plane in focus along the view axis, scene units, > 0.
        focus: f64,
    },
    /// Parallel rays.
    Orthographic {
        /// Vertical extent of the image, scene units, > 0.
        height: f64,
    },
}

impl Camera {
    /// The view direction, unit length.
    pub fn forward(&self) -> DVec3 {
        (self.target - self.position).normalize_or_zero()
    }
}

pub(super) fn camera(config: &CameraConfig, cx: &mut Context<'_>) -> Option<Camera> {
    let (CameraConfig::Perspective { position, target, up, .. }
    | CameraConfig::Orthographic { position, target, up, .. }) = config;
    let (position, target) = (DVec3::from_array(*position), DVec3::from_array(*target));
    let Some((forward, distance)) = unit_and_length(target - position) else {
        let message = "`camera.target` must differ from `camera.position`, by a distance of ordinary size";
        cx.wrong("camera.target", message, "no view direction");
        return None;
    };
    let Some((up, _)) = unit_and_length(DVec3::from_array(*up)) else {
        cx.wrong("camera.up", "`camera.up` must have a length of ordinary size", "no direction");
        return None;
    };
    if forward.cross(up).length() < LEAST_SINE {
        let message = "`camera.up` must not be parallel to the view";
        cx.wrong("camera.up", message, "the view goes along this direction");
        return None;
    }
    let kind = match *config {
        CameraConfig::Perspective { fov, aperture, focus, .. } => {
            CameraKind::Perspective { fov: fov.to_radians(), aperture, focus: focus.unwrap_or(distance) }
        }
        CameraConfig::Orthographic { height, .. } => CameraKind::Orthographic { height },
    };
    Some(Camera { position, target, up, kind })
}

/// Direction and length of a vector; `None` where `f64` cannot hold both (zero, or too short or long).
pub(super) fn unit_and_length(vector: DVec3) -> Option<(DVec3, f64)> {
    Some((vector.try_normalize()?, vector.length()))
}
