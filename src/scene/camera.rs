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
    let view = target - position;
    let Some((forward, distance)) = unit_and_length(view) else {
        let how = if view == DVec3::ZERO { "must differ from" } else { "is too near to or far from" };
        cx.wrong("camera.target", format!("`camera.target` {how} `camera.position`"), "no view direction");
        return None;
    };
    let up = direction(*up, "camera.up", cx)?;
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

/// The unit vector along a direction of the scene.
pub(super) fn direction(vector: [f64; 3], path: &str, cx: &mut Context<'_>) -> Option<DVec3> {
    let vector = DVec3::from_array(vector);
    let unit = unit_and_length(vector);
    if unit.is_none() {
        let what = if vector == DVec3::ZERO { "must not be zero" } else { "is too short or too long" };
        cx.wrong(path, format!("`{path}` {what}"), "no direction");
    }
    unit.map(|(unit, _)| unit)
}

/// Direction and length of a vector; `None` where `f64` cannot hold both (zero, or too short or long).
fn unit_and_length(vector: DVec3) -> Option<(DVec3, f64)> {
    Some((vector.try_normalize()?, vector.length()))
}
