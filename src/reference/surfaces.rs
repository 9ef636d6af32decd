//! Surfaces as rays meet them, one after the other, each by the equation of its shape.

use super::metaballs::{Ball, Metaballs};
use crate::scene::{Metaball, Surface, SurfaceShape};
use crate::surfaces::Meshes;
use glam::DVec3;

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray.
    pub t: f64,
    /// The point.
    pub point: DVec3,
    /// Unit length, outward; of the triangle itself where a mesh is smooth.
    pub normal: DVec3,
    /// Index of the surface.
    pub surface: usize,
}

impl Hit {
    /// Whether a ray of this direction comes from behind the surface.
    pub fn inside(&self, direction: DVec3) -> bool {
        direction.dot(self.normal) > 0.0
    }
}

/// The nearest hit with 0 < t < `t_max` of a ray whose direction has unit length.
pub fn nearest_hit(
    surfaces: &[Surface],
    meshes: &Meshes,
    origin: DVec3,
    direction: DVec3,
    t_max: f64,
) -> Option<Hit> {
    let hits = surfaces.iter().enumerate().flat_map(|(index, surface)| {
        let found = hits(&surface.shape, meshes, index, origin, direction);
        found.into_iter().map(move |(t, normal)| (t, normal, index))
    });
    let ahead = hits.filter(|(t, _, _)| *t > 0.0 && *t < t_max);
    let (t, normal, surface) = ahead.min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Hit { t, point: origin + t * direction, normal, surface })
}

/// Every crossing of a line with a shape (of metaballs, the first ahead): distance along the line, and the outward normal.
fn hits(shape: &SurfaceShape, meshes: &Meshes, index: usize, o: DVec3, d: DVec3) -> Vec<(f64, DVec3)> {
    match *shape {
        SurfaceShape::Plane { point, normal } => on_plane(point, normal, o, d).into_iter().collect(),
        SurfaceShape::Sphere { centre, radius } => {
            let normal = |t| (t, (o + t * d - centre) / radius);
            sphere(centre, radius, o, d).into_iter().flatten().map(normal).collect()
        }
        SurfaceShape::Rectangle { centre, edge_u, edge_v } => {
            let normal = edge_u.cross(edge_v).normalize();
            let within = |&(t, _): &(f64, DVec3)| {
                let [u, v] = coordinates(o + t * d - centre, edge_u, edge_v);
                u.abs() <= 0.5 && v.abs() <= 0.5
            };
            on_plane(centre, normal, o, d).filter(within).into_iter().collect()
        }
        SurfaceShape::Disk { centre, normal, radius } => {
            let within = |&(t, _): &(f64, DVec3)| (o + t * d).distance(centre) <= radius;
            on_plane(centre, normal, o, d).filter(within).into_iter().collect()
        }
        SurfaceShape::Box { low, high } => on_box(low, high, o, d),
        SurfaceShape::Metaballs { ref balls, threshold } => {
            metaballs(balls, threshold, o, d).into_iter().collect()
        }
        SurfaceShape::Mesh { .. } => {
            let faces = meshes.of(index).into_iter().flat_map(|mesh| mesh.faces());
            faces.filter_map(|(corners, _)| triangle(corners, o, d)).collect()
        }
    }
}

fn on_plane(point: DVec3, normal: DVec3, o: DVec3, d: DVec3) -> Option<(f64, DVec3)> {
    let approach = normal.dot(d);
    (approach != 0.0).then(|| (normal.dot(point - o) / approach, normal))
}

/// Both crossings of a sphere. The quadratic starts from the point of the line that is nearest to the centre.
fn sphere(centre: DVec3, radius: f64, o: DVec3, d: DVec3) -> Option<[f64; 2]> {
    let middle = d.dot(centre - o);
    let square = radius * radius - (o + middle * d - centre).length_squared();
    (square >= 0.0).then(|| [middle - square.sqrt(), middle + square.sqrt()])
}

/// The factors of a vector of the plane of two edges.
fn coordinates(vector: DVec3, u: DVec3, v: DVec3) -> [f64; 2] {
    let normal = u.cross(v);
    let area = normal.length_squared();
    [vector.cross(v).dot(normal) / area, u.cross(vector).dot(normal) / area]
}

fn on_box(low: DVec3, high: DVec3, o: DVec3, d: DVec3) -> Vec<(f64, DVec3)> {
    let mut hits = Vec::new();
    for axis in (0..3).filter(|&axis| d[axis] != 0.0) {
        for (side, sign) in [(low, -1.0), (high, 1.0)] {
            let t = (side[axis] - o[axis]) / d[axis];
            let point = o + t * d;
            let within = |other: usize| other == axis || (low[other]..=high[other]).contains(&point[other]);
            if (0..3).all(within) {
                hits.push((t, sign * DVec3::AXES[axis]));
            }
        }
    }
    hits
}

fn triangle(corners: [DVec3; 3], o: DVec3, d: DVec3) -> Option<(f64, DVec3)> {
    let (u, v) = (corners[1] - corners[0], corners[2] - corners[0]);
    let hit = on_plane(corners[0], u.cross(v).try_normalize()?, o, d)?;
    let [a, b] = coordinates(o + hit.0 * d - corners[0], u, v);
    (a >= 0.0 && b >= 0.0 && a + b <= 1.0).then_some(hit)
}

/// The first crossing ahead. Outside of its balls there is nothing.
fn metaballs(balls: &[Metaball], threshold: f64, o: DVec3, d: DVec3) -> Option<(f64, DVec3)> {
    let ends = balls.iter().filter_map(|ball| sphere(ball.centre, ball.radius, o, d)).flatten();
    let last = ends.fold(0.0, f64::max);
    let ball = |&Metaball { centre, radius, weight }: &Metaball| Ball { centre, radius, weight };
    let body = Metaballs { balls: balls.iter().map(ball).collect(), threshold };
    let crossing = body.crossing(o, d, [0.0, last], 1000)?;
    Some((crossing.t, crossing.normal))
}
