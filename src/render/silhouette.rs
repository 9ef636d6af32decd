//! Which tiles of the image see the medium: the others need no paths where nothing but a constant lies behind it.

use super::local::LocalFrame;
use super::tiles::TILE;
use crate::scene::{Camera, CameraKind, Image};
use glam::DVec3;
use rayon::prelude::*;

/// A margin around boxes in local units: far more than float32 rays may stray from where they should be.
const MARGIN: f64 = 0.01;

/// The view of a camera as a projection of local points onto the image.
struct Projection {
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Half the image's extent in pixels.
    half: [f64; 2],
    /// Pixels per unit of slope (perspective) or length (orthographic).
    pixels_per: f64,
    /// Of a perspective: radius of the lens and distance of focus, local units.
    lens: Option<[f64; 2]>,
}

/// A rectangle of the image, in pixels: [x, y] of its low and of its high corner.
type Rectangle = [[f64; 2]; 2];

impl Projection {
    fn new(camera: &Camera, image: &Image, frame: &LocalFrame) -> Self {
        let forward = (camera.target - camera.position).normalize();
        let right = forward.cross(camera.up).normalize();
        let half = [image.width, image.height].map(|n| 0.5 * f64::from(n));
        let (pixels_per, lens) = match camera.kind {
            CameraKind::Perspective { fov, aperture, focus } => {
                (half[1] / (0.5 * fov).tan(), Some([aperture / frame.unit, focus / frame.unit]))
            }
            CameraKind::Orthographic { height } => (half[1] / (0.5 * height / frame.unit), None),
        };
        Self {
            eye: frame.point(camera.position),
            right,
            up: right.cross(forward),
            forward,
            half,
            pixels_per,
            lens,
        }
    }

    /// Where rays that meet the box between two corners cross the image: low beyond high when they are all behind the
    /// eye, `None` when that has no bounds.
    fn rectangle(&self, low: DVec3, high: DVec3) -> Option<Rectangle> {
        let (mut least, mut most) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let corners: [DVec3; 8] = std::array::from_fn(|corner| {
            let pick = |a: usize| if corner >> a & 1 == 0 { low[a] } else { high[a] };
            DVec3::new(pick(0), pick(1), pick(2)) - self.eye
        });
        let depths = corners.map(|corner| corner.dot(self.forward));
        if depths.iter().all(|&depth| depth < 0.0) {
            return Some([least, most]);
        }
        for (offset, depth) in corners.into_iter().zip(depths) {
            let (scale, blur) = match self.lens {
                // What lies beside the eye may be seen anywhere.
                Some(_) if depth < MARGIN => return None,
                // The lens moves what is not in focus.
                Some([radius, focus]) => {
                    (self.pixels_per / depth, self.pixels_per * radius * (1.0 / depth - 1.0 / focus).abs())
                }
                None => (self.pixels_per, 0.0),
            };
            let place = [offset.dot(self.right) * scale, -offset.dot(self.up) * scale];
            for a in 0..2 {
                least[a] = least[a].min(self.half[a] + place[a] - blur);
                most[a] = most[a].max(self.half[a] + place[a] + blur);
            }
        }
        Some([least, most])
    }
}

/// For every tile of the image, row by row from the top, 1 where a camera ray may meet one of the `boxes` (low and high
/// corner, local units), else 0.
pub(super) fn tiles_that_see(
    camera: &Camera,
    image: &Image,
    frame: &LocalFrame,
    boxes: &[[DVec3; 2]],
) -> Vec<u8> {
    let projection = Projection::new(camera, image, frame);
    let counts = [image.width.div_ceil(TILE), image.height.div_ceil(TILE)].map(|n| n as usize);
    let margin = DVec3::splat(MARGIN);
    let seen_in = |boxes: &[[DVec3; 2]]| {
        let mut seen = vec![0_u8; counts[0] * counts[1]];
        for &[low, high] in boxes {
            let Some([least, most]) = projection.rectangle(low - margin, high + margin) else {
                return vec![1; seen.len()];
            };
            // Float to integer saturates: what lies beside the image comes out empty.
            let tile = |pixel: f64| (pixel / f64::from(TILE)).floor();
            let [x, y] = [0, 1].map(|a| {
                tile(least[a]).max(0.0) as usize..(tile(most[a]) + 1.0).clamp(0.0, counts[a] as f64) as usize
            });
            for row in y {
                if let Some(tiles) = seen.get_mut(row * counts[0]..(row + 1) * counts[0])
                    && let Some(tiles) = tiles.get_mut(x.clone())
                {
                    tiles.fill(1);
                }
            }
        }
        seen
    };
    let join = |mut all: Vec<u8>, part: Vec<u8>| {
        all.iter_mut().zip(part).for_each(|(all, part)| *all |= part);
        all
    };
    let part = boxes.len().div_ceil(rayon::current_num_threads()).max(1);
    boxes.par_chunks(part).map(seen_in).reduce(|| vec![0; counts[0] * counts[1]], join)
}

#[cfg(test)]
mod tests {
    use super::tiles_that_see;
    use crate::render::local::LocalFrame;
    use crate::scene::{Camera, CameraKind, Filter, Image};
    use glam::DVec3;

    const FRAME: LocalFrame =
        LocalFrame { origin: DVec3::ZERO, unit: 1.0, dims: [8, 8, 8], spacing: DVec3::ONE };

    fn camera(kind: CameraKind) -> Camera {
        Camera { position: DVec3::new(0.0, 0.0, 10.0), target: DVec3::ZERO, up: DVec3::Y, kind }
    }

    fn perspective(aperture: f64) -> CameraKind {
        CameraKind::Perspective { fov: 2.0 * 0.5_f64.atan(), aperture, focus: 10.0 }
    }

    fn seen(kind: CameraKind, low: [f64; 3], high: [f64; 3]) -> Vec<u8> {
        let boxes = [[DVec3::from_array(low), DVec3::from_array(high)]];
        tiles_that_see(&camera(kind), &Image { width: 32, height: 24, filter: Filter::Box }, &FRAME, &boxes)
    }

    #[test]
    fn boxes_mark_the_tiles_that_they_cover() {
        // At the focus, the image is 10 units high: a tile of a third of that.
        let row = |a: f64, b: f64| seen(perspective(0.0), [a, 4.0, 0.0], [b, 4.5, 0.0])[..4].to_vec();
        assert_eq!(row(-6.0, -4.0), [1, 0, 0, 0]);
        assert_eq!(row(-1.0, 1.0), [0, 1, 1, 0]);
        assert_eq!(row(-100.0, 100.0), [1, 1, 1, 1]);
        assert_eq!(row(100.0, 101.0), [0, 0, 0, 0]);
        assert_eq!(row(-101.0, -100.0), [0, 0, 0, 0]);
        assert_eq!(
            seen(CameraKind::Orthographic { height: 10.0 }, [4.0, -4.0, 5.0], [6.0, -4.0, 20.0]),
            [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1]
        );
    }

    #[test]
    fn near_boxes_look_larger_and_those_beside_the_eye_are_everywhere() {
        let count = |low: f64, high: f64| {
            let tiles = seen(perspective(0.0), [-0.4, -0.4, low], [0.4, 0.4, high]);
            tiles.iter().map(|&tile| u32::from(tile)).sum::<u32>()
        };
        assert_eq!(count(-1.0, 0.0), 2);
        assert_eq!(count(0.0, 9.5), 12);
        assert_eq!(count(0.0, 10.5), 12);
        assert_eq!(count(10.5, 12.0), 0);
    }

    #[test]
    fn a_lens_blurs_what_is_not_in_focus() {
        // At half the focus distance a lens of radius 1 moves points by 1 at the focus: from the second tile to the first.
        let row = |z: f64| seen(perspective(1.0), [-1.2, 2.0, z], [-1.2, 2.0, z])[..4].to_vec();
        assert_eq!(row(5.0), [1, 1, 0, 0]);
        assert_eq!(seen(perspective(0.0), [-1.2, 2.0, 5.0], [-1.2, 2.0, 5.0])[..4], [0, 1, 0, 0]);
    }
}
