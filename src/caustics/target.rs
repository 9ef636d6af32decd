//! Rectangles that cover what reflects and refracts, as lights see it: where photons are sent.

use crate::surfaces::{DeviceBall, DeviceShape, SurfaceArrays};
use glam::DVec3;

/// Directions further than this from the axis (tangent of the angle) are no business of a rectangle across it.
const STEEPEST: f64 = 3.0;
/// What rounding to float32 may do to places, relative to the distance and to the extent.
const MARGIN: f64 = 1e-5;

/// A rectangle, in local units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Target {
    /// Its middle.
    pub centre: DVec3,
    /// One edge from end to end.
    pub edge_u: DVec3,
    /// The other edge, at a right angle.
    pub edge_v: DVec3,
}

impl Target {
    pub fn corner(&self) -> DVec3 {
        self.centre - 0.5 * self.edge_u - 0.5 * self.edge_v
    }

    pub fn area(&self) -> f64 {
        self.edge_u.length() * self.edge_v.length()
    }

    pub fn normal(&self) -> DVec3 {
        self.edge_u.normalize().cross(self.edge_v.normalize())
    }

    /// A place on it, by coordinates from 0 to 1.
    pub fn at(&self, u: f64, v: f64) -> DVec3 {
        self.corner() + u * self.edge_u + v * self.edge_v
    }
}

/// A part of what is to be covered: the hull of points, or a sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Part {
    Point(DVec3),
    Sphere(DVec3, f64),
}

/// What a rectangle must cover, local units.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Parts {
    /// All that has bounds.
    pub parts: Vec<Part>,
    /// Whether some of it has none.
    pub unbounded: bool,
}

impl Parts {
    /// The shapes that are wanted.
    pub fn of(surfaces: &SurfaceArrays, wanted: impl Fn(&DeviceShape) -> bool) -> Self {
        let (planes, bounded) = surfaces.shapes.split_at(surfaces.plane_count);
        Self {
            parts: bounded
                .iter()
                .filter(|shape| wanted(shape))
                .flat_map(|shape| parts_of(shape, &surfaces.balls))
                .collect(),
            unbounded: planes.iter().any(wanted),
        }
    }

    /// The middle of the box around them.
    pub fn centre(&self) -> DVec3 {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for part in &self.parts {
            let (at, radius) = match *part {
                Part::Point(at) => (at, 0.0),
                Part::Sphere(at, radius) => (at, radius),
            };
            low = low.min(at - radius);
            high = high.max(at + radius);
        }
        0.5 * (low + high)
    }

    /// How far they reach from a place.
    pub fn radius_about(&self, place: DVec3) -> f64 {
        let reach = |part: &Part| match *part {
            Part::Point(at) => at.distance(place),
            Part::Sphere(at, radius) => at.distance(place) + radius,
        };
        self.parts.iter().map(reach).fold(0.0, f64::max)
    }

    /// The rectangle that all rays cross from any of the places (the corners of a light) to any of the parts. `None` where
    /// they are too near for that.
    pub fn seen_from(&self, places: &[DVec3]) -> Option<Target> {
        let middle = places.iter().sum::<DVec3>() / places.len() as f64;
        let centre = self.centre();
        let axis = (centre - middle).try_normalize()?;
        let (u, v) = axis.any_orthonormal_pair();
        let mut extents = [Extent::EMPTY; 2];
        for &place in places {
            // How far the rectangle's plane is from there.
            let distance = (centre - place).dot(axis);
            for (extent, side) in extents.iter_mut().zip([u, v]) {
                let start = (place - centre).dot(side);
                for part in &self.parts {
                    let [low, high] = slopes(part, place, axis, side)?;
                    extent.add([start + distance * low, start + distance * high]);
                }
            }
            if distance <= 0.0 {
                return None;
            }
        }
        let far = (centre - middle).length();
        Some(spanned(centre, [u, v], extents, far))
    }

    /// A little before the first of them along a direction; far ahead where there are none.
    pub fn begins_along(&self, direction: DVec3) -> f64 {
        if self.parts.is_empty() {
            return f32::MAX.into();
        }
        let begins = self.parts.iter().map(|part| match *part {
            Part::Point(at) => at.dot(direction),
            Part::Sphere(at, radius) => at.dot(direction) - radius,
        });
        let ends = self.parts.iter().map(|part| match *part {
            Part::Point(at) => at.dot(direction),
            Part::Sphere(at, radius) => at.dot(direction) + radius,
        });
        let (first, last) = (begins.fold(f64::INFINITY, f64::min), ends.fold(f64::NEG_INFINITY, f64::max));
        first - 1e-3 * (last - first) - MARGIN * first.abs()
    }

    /// The rectangle across a direction that all rays along it to any of the parts cross.
    pub fn seen_along(&self, direction: DVec3) -> Target {
        let centre = self.centre();
        let (u, v) = direction.any_orthonormal_pair();
        let mut extents = [Extent::EMPTY; 2];
        for (extent, side) in extents.iter_mut().zip([u, v]) {
            for part in &self.parts {
                let (at, radius) = match *part {
                    Part::Point(at) => (at, 0.0),
                    Part::Sphere(at, radius) => (at, radius),
                };
                let at = (at - centre).dot(side);
                extent.add([at - radius, at + radius]);
            }
        }
        spanned(centre, [u, v], extents, centre.length())
    }
}

/// An interval that grows.
#[derive(Clone, Copy)]
struct Extent {
    low: f64,
    high: f64,
}

impl Extent {
    const EMPTY: Self = Self { low: f64::INFINITY, high: f64::NEG_INFINITY };

    fn add(&mut self, [low, high]: [f64; 2]) {
        self.low = self.low.min(low);
        self.high = self.high.max(high);
    }
}

fn spanned(centre: DVec3, [u, v]: [DVec3; 2], extents: [Extent; 2], far: f64) -> Target {
    let [a, b] = extents.map(|Extent { low, high }| {
        let margin = MARGIN * (far + high - low);
        [low - margin, high + margin]
    });
    Target {
        centre: centre + 0.5 * (a[0] + a[1]) * u + 0.5 * (b[0] + b[1]) * v,
        edge_u: (a[1] - a[0]) * u,
        edge_v: (b[1] - b[0]) * v,
    }
}

/// Between which tangents of angles from `axis` towards `side` a part is seen.
fn slopes(part: &Part, place: DVec3, axis: DVec3, side: DVec3) -> Option<[f64; 2]> {
    let (at, radius) = match *part {
        Part::Point(at) => (at, 0.0),
        Part::Sphere(at, radius) => (at, radius),
    };
    let [depth, aside] = [axis, side].map(|along| (at - place).dot(along));
    // On the plane of both, a sphere is a circle: its tangents.
    let sine = radius / depth.hypot(aside);
    let (middle, half) = (aside.atan2(depth), sine.asin());
    let found = [middle - half, middle + half];
    // Not so where it is around the place: the sine is above 1, or none.
    let near = found.map(|angle| angle.abs() < STEEPEST.atan());
    (near == [true; 2]).then(|| found.map(f64::tan))
}

fn point(v: [f32; 4]) -> DVec3 {
    DVec3::new(v[0].into(), v[1].into(), v[2].into())
}

/// Points or the sphere around which a shape of `cl/types/surface.cl` is convex.
fn parts_of(shape: &DeviceShape, balls: &[DeviceBall]) -> Vec<Part> {
    let [a, b, c, d] = [shape.a, shape.b, shape.c, shape.d].map(point);
    let corners = |centre: DVec3, u: DVec3, v: DVec3| {
        [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)]
            .map(|(s, t)| Part::Point(centre + s * u + t * v))
            .to_vec()
    };
    match shape.kind {
        1 => vec![Part::Sphere(a, shape.a[3].into())],
        2 => {
            // The edges from their reciprocals: b . u = 1, b . v = 0, and so on.
            let (u, v) = (c.cross(d), d.cross(b));
            let (u, v) = (u / u.dot(b), v / v.dot(c));
            corners(a + 0.5 * (u + v), 0.5 * u, 0.5 * v)
        }
        3 => {
            let (u, v) = b.normalize().any_orthonormal_pair();
            let radius = f64::from(shape.a[3]);
            corners(a, radius * u, radius * v)
        }
        5 => parts_of_balls(&balls[shape.first as usize..][..shape.count as usize], shape.c[0].into()),
        6 => [a, b, c].map(Part::Point).to_vec(),
        _ => {
            let pick = |i: u32| {
                DVec3::new(
                    if i & 1 == 0 { a.x } else { b.x },
                    if i & 2 == 0 { a.y } else { b.y },
                    if i & 4 == 0 { a.z } else { b.z },
                )
            };
            (0..8).map(|i| Part::Point(pick(i))).collect()
        }
    }
}

/// Spheres around the surface of metaballs: where s > r for all balls, the field is below the sum of their weights times
/// (1 - r^2)^2.
fn parts_of_balls(balls: &[DeviceBall], threshold: f64) -> Vec<Part> {
    let positive = || balls.iter().filter(|ball| ball.weight > 0.0);
    let most: f64 = positive().map(|ball| f64::from(ball.weight)).sum();
    let reach = (1.0 - (threshold / most).min(1.0).sqrt()).sqrt();
    positive().map(|ball| Part::Sphere(point(ball.place), reach * f64::from(ball.place[3]))).collect()
}
