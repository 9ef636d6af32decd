//! Camera rays: pinhole, thin lens and parallel.

use crate::scene::{Camera, CameraKind, Image};
use glam::DVec3;

/// A ray; distances along it are scene units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where distances are counted from.
    pub origin: DVec3,
    /// Unit length.
    pub direction: DVec3,
    /// Nothing before this distance is seen.
    pub start: f64,
}

impl Ray {
    /// The ray from one point towards another.
    pub fn towards(origin: DVec3, target: DVec3) -> Self {
        Self { origin, direction: (target - origin).normalize(), start: 0.0 }
    }

    /// The point at a distance.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }
}

/// The ray through the pixel in column `x` and row `y` (from the top), at the fraction `at` of the pixel's width and
/// height, from the point `lens` of the unit disk of the lens (ignored by cameras without one).
pub fn ray(camera: &Camera, image: &Image, [x, y]: [u32; 2], at: [f64; 2], lens: [f64; 2]) -> Ray {
    let forward = (camera.target - camera.position).normalize();
    let right = forward.cross(camera.up).normalize();
    let up = right.cross(forward);
    let (width, height) = (f64::from(image.width), f64::from(image.height));
    let u = (2.0 * (f64::from(x) + at[0]) / width - 1.0) * width / height;
    let v = 1.0 - 2.0 * (f64::from(y) + at[1]) / height;
    match camera.kind {
        CameraKind::Perspective { fov, aperture, focus } => {
            let slope = (0.5 * fov).tan();
            let in_focus = camera.position + focus * (forward + slope * (u * right + v * up));
            let origin = camera.position + aperture * (lens[0] * right + lens[1] * up);
            Ray::towards(origin, in_focus)
        }
        CameraKind::Orthographic { height } => {
            let origin = camera.position + 0.5 * height * (u * right + v * up);
            Ray { origin, direction: forward, start: 0.0 }
        }
    }
}

/// The ray through the centre of a pixel and of the lens.
pub fn central_ray(camera: &Camera, image: &Image, pixel: [u32; 2]) -> Ray {
    ray(camera, image, pixel, [0.5; 2], [0.0; 2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Filter;

    fn camera(kind: CameraKind) -> Camera {
        Camera { position: DVec3::new(0.0, 0.0, 5.0), target: DVec3::ZERO, up: DVec3::Y, kind }
    }

    const IMAGE: Image = Image { width: 4, height: 2, filter: Filter::Point };

    #[test]
    fn right_is_forward_cross_up_and_rows_go_down() {
        let camera = camera(CameraKind::Orthographic { height: 2.0 });
        assert_eq!(central_ray(&camera, &IMAGE, [0, 0]).origin, DVec3::new(-1.5, 0.5, 5.0));
        assert_eq!(central_ray(&camera, &IMAGE, [3, 1]).origin, DVec3::new(1.5, -0.5, 5.0));
    }

    #[test]
    fn rays_through_the_lens_meet_in_the_focal_plane() {
        let camera = camera(CameraKind::Perspective { fov: 1.0, aperture: 0.3, focus: 4.0 });
        let rays =
            [[0.0, 0.0], [1.0, 0.0], [-0.3, 0.8]].map(|lens| ray(&camera, &IMAGE, [1, 0], [0.2, 0.7], lens));
        let meet = rays.map(|ray| ray.at((1.0 - ray.origin.z) / ray.direction.z));
        assert!(meet[0].distance(meet[1]) < 1e-14 && meet[0].distance(meet[2]) < 1e-14, "{meet:?}");
        assert!((rays[1].origin - DVec3::new(0.3, 0.0, 5.0)).length() < 1e-15);
    }
}
