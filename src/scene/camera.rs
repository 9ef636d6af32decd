//! The camera.

use glam::{DQuat, DVec3};

use super::context::Context;
use crate::config::types::{CameraConfig, TurntableConfig, ViewConfig};

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

/// The cameras of a scene file, each as it would stand there alone: the one of `[camera]`, or those of its turntable or
/// views instead. `None` where they are wrong.
pub(super) fn cameras(config: &CameraConfig, cx: &mut Context<'_>) -> Option<Vec<CameraConfig>> {
    let mut alone = config.clone();
    let (CameraConfig::Perspective { turntable, views, .. }
    | CameraConfig::Orthographic { turntable, views, .. }) = &mut alone;
    let (turntable, views) = (turntable.take(), std::mem::take(views));
    match (turntable, views.as_slice()) {
        (None, []) => Some(vec![alone]),
        (None, views) => Some(views.iter().map(|view| seen_from(&alone, view)).collect()),
        (Some(turntable), []) => around(&alone, &turntable, cx),
        (Some(_), _) => {
            cx.wrong(
                "camera.turntable",
                "`camera.turntable` does not go with `camera.views`",
                "give one of the two",
            );
            None
        }
    }
}

fn seen_from(camera: &CameraConfig, view: &ViewConfig) -> CameraConfig {
    let mut seen = camera.clone();
    let (CameraConfig::Perspective { position, target, up, .. }
    | CameraConfig::Orthographic { position, target, up, .. }) = &mut seen;
    *position = view.position.unwrap_or(*position);
    *target = view.target.unwrap_or(*target);
    *up = view.up.unwrap_or(*up);
    seen
}

/// The cameras of a turn about the target.
fn around(camera: &CameraConfig, table: &TurntableConfig, cx: &mut Context<'_>) -> Option<Vec<CameraConfig>> {
    let (CameraConfig::Perspective { position, target, up, .. }
    | CameraConfig::Orthographic { position, target, up, .. }) = camera;
    let [position, target, up] = [position, target, up].map(|v| DVec3::from_array(*v));
    let (axis, path) = match table.axis {
        Some(axis) => (axis, "camera.turntable.axis"),
        None => (up.to_array(), "camera.up"),
    };
    let axis = direction(axis, path, cx)?;
    let frame = |k: u32| {
        let turn =
            DQuat::from_axis_angle(axis, (table.angle * f64::from(k) / f64::from(table.frames)).to_radians());
        let view = ViewConfig {
            position: Some((target + turn * (position - target)).to_array()),
            target: None,
            up: Some((turn * up).to_array()),
        };
        // The first picture is the camera's own, to the bit.
        if k == 0 { camera.clone() } else { seen_from(camera, &view) }
    };
    Some((0..table.frames).map(frame).collect())
}

/// A camera of [`cameras`]; `place`: where problems with its place are shown, `camera` or a view.
pub(super) fn camera(config: &CameraConfig, place: &str, cx: &mut Context<'_>) -> Option<Camera> {
    let (CameraConfig::Perspective { position, target, up, .. }
    | CameraConfig::Orthographic { position, target, up, .. }) = config;
    let (position, target) = (DVec3::from_array(*position), DVec3::from_array(*target));
    let path = |key: &str| {
        let own = format!("{place}.{key}");
        if cx.has(&own) { own } else { format!("camera.{key}") }
    };
    let [target_path, up_path] = ["target", "up"].map(path);
    let view = target - position;
    let Some((forward, distance)) = unit_and_length(view) else {
        let how = if view == DVec3::ZERO { "must differ from" } else { "is too near to or far from" };
        let position_path = path("position");
        cx.wrong(&target_path, format!("`{target_path}` {how} `{position_path}`"), "no view direction");
        return None;
    };
    let up = direction(*up, &up_path, cx)?;
    if forward.cross(up).length() < LEAST_SINE {
        let message = format!("`{up_path}` must not be parallel to the view");
        cx.wrong(&up_path, message, "the view goes along this direction");
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
