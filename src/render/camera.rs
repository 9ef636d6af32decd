//! The camera on the device.

use super::local::{LocalFrame, float4};
use crate::scene::{Camera, CameraKind, Image};
use crate::{Error, Result, device_struct};
use glam::DVec3;

/// Coordinates on the device, in voxels, stay within this: their squares are float32 numbers.
const FARTHEST: f32 = 1e18;

device_struct! {
    "types/camera.cl",
    /// A camera in local units; see `cl/types/camera.cl`.
    pub struct DeviceCamera {
        /// Point of the central ray at the reference depth.
        pub base: [f32; 4],
        /// Change of that point over half the image's width.
        pub base_u: [f32; 4],
        /// Change of that point over half the image's height.
        pub base_v: [f32; 4],
        /// Direction of the central ray per unit of view depth.
        pub dir: [f32; 4],
        /// Change of the direction over half the image's width.
        pub dir_u: [f32; 4],
        /// Change of the direction over half the image's height.
        pub dir_v: [f32; 4],
        /// Lens radius times the image plane's first axis.
        pub lens_u: [f32; 4],
        /// Lens radius times the image plane's second axis.
        pub lens_v: [f32; 4],
        /// View depth of `base`.
        pub depth: f32,
        /// 1 / focus distance.
        pub inv_focus: f32,
        /// Image width in pixels.
        pub width: u32,
        /// Image height in pixels.
        pub height: u32,
    }
}

impl DeviceCamera {
    /// The camera of a scene in the local frame of its volume.
    ///
    /// Rays start at the depth of the box's centre (when that lies ahead), so a far eye costs no precision.
    pub fn new(camera: &Camera, image: &Image, frame: &LocalFrame) -> Self {
        let forward = (camera.target - camera.position).normalize();
        let right = forward.cross(camera.up).normalize();
        let up = right.cross(forward);
        let eye = frame.point(camera.position);
        let depth = (frame.size() * 0.5 - eye).dot(forward).max(0.0);
        let aspect = f64::from(image.width) / f64::from(image.height);
        let (half_height, perspective, lens, inv_focus) = match camera.kind {
            CameraKind::Perspective { fov, aperture, focus } => {
                ((fov * 0.5).tan(), true, aperture / frame.unit, frame.unit / focus)
            }
            CameraKind::Orthographic { height } => (0.5 * height / frame.unit, false, 0.0, 0.0),
        };
        let (u, v) = (right * half_height * aspect, up * half_height);
        let (spread, slope) = if perspective { (depth, 1.0) } else { (1.0, 0.0) };
        let vector = |v: DVec3| float4(v, 0.0);
        Self {
            base: vector(eye + forward * depth),
            base_u: vector(u * spread),
            base_v: vector(v * spread),
            dir: vector(forward),
            dir_u: vector(u * slope),
            dir_v: vector(v * slope),
            lens_u: vector(right * lens),
            lens_v: vector(up * lens),
            depth: depth as f32,
            inv_focus: inv_focus as f32,
            width: image.width,
            height: image.height,
        }
    }

    /// Whether float32 holds the rays: those that it does not hold read memory anywhere.
    ///
    /// # Errors
    /// [`Error::Input`] when it does not.
    pub fn check(&self) -> Result<()> {
        // NaN is not within.
        let within = |values: &[f32]| values.iter().all(|value| value.abs() <= FARTHEST);
        let view = [self.base, self.base_u, self.base_v, self.dir_u, self.dir_v, [self.depth; 4]];
        if !within(view.as_flattened()) {
            return Err(Error::Input(format!(
                "the view is too large for the voxels: in their size, coordinates are above {FARTHEST:e}; check \
                 `volume.spacing` (without a volume, how far mirrors and glass extend) and the camera's position, target \
                 and field of view"
            )));
        }
        let radius =
            [self.lens_u, self.lens_v].as_flattened().iter().fold(0.0, |max: f32, x| max.max(x.abs()));
        let turn = radius * self.inv_focus;
        if radius == 0.0 && !within(&[self.inv_focus]) {
            return Err(Error::Input(format!(
                "the view is too small for the scene: over the voxels' size (without a volume, over how far mirrors and \
                 glass extend), the camera's distance from its target is below 1 / {FARTHEST:e}"
            )));
        }
        if !within(&[radius, self.inv_focus, turn, turn * self.depth]) {
            return Err(Error::Input(
                "the lens is too large for its focus; make `camera.aperture` smaller or `camera.focus` larger".into(),
            ));
        }
        Ok(())
    }
}
