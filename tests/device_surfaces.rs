//! What rays meet, against the twin, which tries one shape after the other.

mod common;
#[path = "common/surfaces.rs"]
mod surfaces;

use common::report;
use glam::DVec3;
use std::path::{Path, PathBuf};
use surfaces::{Agreement, World, ball_obj, compare, direction, numbers, rays, rounded, vector};
use svetlo::scene::{Metaball, SurfaceShape};
use tempfile::TempDir;

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

fn sphere(centre: DVec3, radius: f64) -> SurfaceShape {
    SurfaceShape::Sphere { centre, radius }
}

fn mesh(folder: &Path, text: &str, translate: DVec3, scale: f64, smooth: bool) -> SurfaceShape {
    let path: PathBuf = folder.join("mesh.obj");
    std::fs::write(&path, text).unwrap();
    SurfaceShape::Mesh { path, scale, translate, smooth }
}

/// One of each within the cube 0..10.
fn one_of_each(folder: &Path) -> Vec<SurfaceShape> {
    let ball = |x: f64, z: f64, weight| Metaball { centre: v(x, 8.0, z), radius: 1.5, weight };
    vec![
        SurfaceShape::Plane { point: v(5.0, 5.0, 0.3), normal: v(0.1, -0.05, 1.0).normalize() },
        sphere(v(2.0, 2.0, 2.5), 1.3),
        SurfaceShape::Rectangle {
            centre: v(7.0, 2.0, 3.0),
            edge_u: v(3.0, 0.5, 0.0),
            edge_v: v(0.3, 0.4, 4.0),
        },
        SurfaceShape::Disk { centre: v(2.0, 7.0, 3.0), normal: v(1.0, 1.0, 2.0).normalize(), radius: 1.7 },
        SurfaceShape::Box { low: v(6.0, 5.5, 1.5), high: v(9.0, 6.5, 4.5) },
        SurfaceShape::Metaballs { balls: vec![ball(3.0, 7.0, 1.0), ball(4.6, 7.5, 0.8)], threshold: 0.3 },
        mesh(folder, &ball_obj(2, 0.0), v(7.5, 3.0, 7.5), 1.5, true),
    ]
}

fn check(name: &str, agreement: &Agreement, rays: usize) {
    report(name, agreement.worst, 1.0);
    let Agreement { hits, inside, at_edges, .. } = agreement;
    println!("{name}: {hits} hits of {rays}, {inside} from inside, {at_edges} at edges");
}

#[test]
fn every_shape_from_everywhere() {
    let folder = TempDir::new().unwrap();
    let world = World::new(one_of_each(folder.path()));
    let all = [DVec3::ZERO, DVec3::splat(10.0)];
    let around = [DVec3::splat(-30.0), DVec3::splat(40.0)];
    for (name, from) in [("from within", all), ("from around", around)] {
        let rays = rays(5_000, 1, from, all);
        let agreement = compare(&world, &rays, 12.0, 3.0);
        check(name, &agreement, rays.len());
        assert!(agreement.hits > 2500 && agreement.inside > 100 && agreement.at_edges < 20, "{agreement:?}");
    }
}

/// Surfaces in a frame of their own: local units are half a scene unit, from another corner.
#[test]
fn the_frame_of_the_scene_does_not_matter() {
    use svetlo::render::local::LocalFrame;
    let folder = TempDir::new().unwrap();
    let frame = LocalFrame::new(v(100.0, -50.0, 25.0), DVec3::splat(0.5), [10; 3]);
    let moved = one_of_each(folder.path()).into_iter().map(|shape| match shape {
        SurfaceShape::Plane { point, normal } => {
            SurfaceShape::Plane { point: frame.origin + 0.5 * point, normal }
        }
        SurfaceShape::Sphere { centre, radius } => sphere(frame.origin + 0.5 * centre, 0.5 * radius),
        SurfaceShape::Rectangle { centre, edge_u, edge_v } => SurfaceShape::Rectangle {
            centre: frame.origin + 0.5 * centre,
            edge_u: 0.5 * edge_u,
            edge_v: 0.5 * edge_v,
        },
        SurfaceShape::Disk { centre, normal, radius } => {
            SurfaceShape::Disk { centre: frame.origin + 0.5 * centre, normal, radius: 0.5 * radius }
        }
        SurfaceShape::Box { low, high } => {
            SurfaceShape::Box { low: frame.origin + 0.5 * low, high: frame.origin + 0.5 * high }
        }
        SurfaceShape::Metaballs { balls, threshold } => {
            let moved = |ball: Metaball| Metaball {
                centre: frame.origin + 0.5 * ball.centre,
                radius: 0.5 * ball.radius,
                ..ball
            };
            SurfaceShape::Metaballs { balls: balls.into_iter().map(moved).collect(), threshold }
        }
        SurfaceShape::Mesh { path, scale, translate, smooth } => {
            SurfaceShape::Mesh { path, scale: 0.5 * scale, translate: frame.origin + 0.5 * translate, smooth }
        }
    });
    let moved = World::in_frame(moved, frame);
    let still = World::new(one_of_each(folder.path()));
    // All numbers are powers of two times those of the other or exact in float64 all the same, to its rounding.
    let rays = rays(500, 2, [DVec3::ZERO, DVec3::splat(10.0)], [DVec3::ZERO, DVec3::splat(10.0)]);
    let pairs = moved.trace(&rays, f32::INFINITY).into_iter().zip(still.trace(&rays, f32::INFINITY));
    let differ = |a: f32, b: f32| (a - b).abs() > 1e-5 * (1.0 + a.abs());
    let far = pairs.filter(|(a, b)| a.surface != b.surface || differ(a.point[3], b.point[3])).count();
    assert!(far <= 1, "{far}");
    let [low, high] = [moved.arrays.bounds.unwrap().low, moved.arrays.bounds.unwrap().high];
    let bounds = still.arrays.bounds.unwrap();
    assert!((low - (frame.origin + 0.5 * bounds.low)).length() < 1e-12);
    assert!((high - (frame.origin + 0.5 * bounds.high)).length() < 1e-12);
}

#[test]
fn a_thousand_spheres_through_the_hierarchy() {
    let spheres = numbers(1000, 3).map(|[a, b, c, d, ..]| sphere(10.0 * v(a, b, c), 0.02 + 0.4 * d * d));
    let world = World::new(spheres);
    assert!(world.arrays.nodes.len() > 300 && world.arrays.plane_count == 0);
    let all = [DVec3::ZERO, DVec3::splat(10.0)];
    for from in [all, [DVec3::splat(-30.0), DVec3::splat(40.0)]] {
        let rays = rays(2000, 4, from, all);
        let agreement = compare(&world, &rays, 20.0, 50.0);
        check("a thousand spheres", &agreement, rays.len());
        assert!(agreement.hits > 1200 && agreement.at_edges < 20, "{agreement:?}");
    }
}

#[test]
fn a_mesh_through_the_hierarchy() {
    let folder = TempDir::new().unwrap();
    let world = World::new([mesh(folder.path(), &ball_obj(4, 0.1), DVec3::splat(5.0), 4.0, false)]);
    assert_eq!(world.arrays.shapes.len(), 2048);
    let all = [DVec3::ZERO, DVec3::splat(10.0)];
    let rays = rays(1000, 5, all, all);
    let agreement = compare(&world, &rays, 20.0, 0.0);
    check("a mesh", &agreement, rays.len());
    assert!(agreement.hits > 600 && agreement.at_edges < 20, "{agreement:?}");
}

/// Where rounding could open gaps: from inside every ray hits, at edges and corners as well, and from there on as well.
#[test]
fn a_closed_mesh_leaks_nothing() {
    let folder = TempDir::new().unwrap();
    let centre = v(5.1, 4.9, 5.3);
    let world = World::new([mesh(folder.path(), &ball_obj(4, 0.05), centre, 4.0, false)]);
    let mesh = world.meshes.of(0).unwrap();
    let mut rays: Vec<_> = numbers(100_000, 6)
        .map(|[a, b, c, d, e, _]| (centre + 2.0 * e * direction(a, b), direction(c, d)))
        .collect();
    for (corners, _) in mesh.faces() {
        let origin = centre + v(0.3, -0.2, 0.1);
        let towards = |p: DVec3| (origin, (p - origin).normalize());
        rays.extend(corners.map(towards));
        rays.push(towards(0.5 * (corners[0] + corners[1])));
        rays.push(towards(0.3 * corners[1] + 0.7 * corners[2]));
    }
    let rays: Vec<_> = rays.into_iter().map(rounded).collect();
    let found = world.trace(&rays, f32::INFINITY);
    for (found, ray) in found.iter().zip(&rays) {
        assert!(found.hit().is_some() && found.inside == 1 && found.blocked == 1, "{ray:?} {found:?}");
    }
    // Turned back into the body, or out of it: only the first hit again.
    let back: Vec<_> = found.iter().zip(&rays).map(|(found, ray)| (vector(found.back), -ray.1)).collect();
    let leaks = world.trace(&back, f32::INFINITY).iter().filter(|found| found.inside == 0).count();
    assert_eq!(leaks, 0);
}

/// Rays that touch: within rounding of the silhouette from both sides, and exactly along faces.
#[test]
fn grazing_rays() {
    let sphere_world = World::new([sphere(v(5.0, 5.0, 5.0), 2.0)]);
    let graze = |[a, b, c, d, e, _]: [f64; 6]| {
        let normal = direction(a, b);
        let along = normal.any_orthonormal_vector();
        let along = (c - 0.5) * along + (d - 0.5) * normal.cross(along);
        let offset = 10_f64.powf(-7.0 * e) * if c > d { 1.0 } else { -1.0 };
        let point = v(5.0, 5.0, 5.0) + 2.0 * (1.0 + offset) * normal;
        rounded((point - 6.0 * along.normalize(), along.normalize()))
    };
    let rays: Vec<_> = numbers(5000, 7).map(graze).collect();
    let agreement = compare(&sphere_world, &rays, 8.0, 0.5);
    check("along a sphere", &agreement, rays.len());
    assert!((2000..3000).contains(&agreement.hits) && agreement.at_edges < 500, "{agreement:?}");
}

#[test]
fn rays_along_the_axes() {
    let folder = TempDir::new().unwrap();
    let cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let shapes = [
        vec![SurfaceShape::Box { low: v(2.0, 3.0, 4.0), high: v(5.0, 6.0, 7.0) }],
        vec![mesh(folder.path(), cube, v(2.0, 3.0, 4.0), 3.0, false)],
    ];
    let axes = DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
    for shapes in shapes {
        let world = World::new(shapes);
        let mut rays = Vec::new();
        for axis in axes.clone() {
            for k in 0..11 * 11 * 11 {
                // Among them the inside, and beside the box.
                let place = v(f64::from(k % 11), f64::from(k / 11 % 11), f64::from(k / 121));
                rays.push((place + v(0.5, 0.25, 0.125), axis));
            }
        }
        let agreement = compare(&world, &rays, 10.0, 0.0);
        check("along the axes", &agreement, rays.len());
        assert!(agreement.hits == 378 && agreement.inside == 162 && agreement.at_edges == 0, "{agreement:?}");
        // In the planes of faces, along edges and through corners: any answer is right that is one.
        let grid = rays.iter().map(|(origin, axis)| (origin.floor(), *axis)).collect::<Vec<_>>();
        for ((origin, axis), found) in grid.iter().zip(world.trace(&grid, f32::INFINITY)) {
            let point = *origin + found.t() * *axis;
            if found.hit().is_some() {
                let near = (vector(found.point) - point).length() < 1e-5 && found.t() > 0.0;
                assert!(
                    near && point.clamp(v(2.0, 3.0, 4.0), v(5.0, 6.0, 7.0)) == point,
                    "{origin} {found:?}"
                );
            }
            let strictly = (0..3)
                .all(|k| axis[k] != 0.0 || (2 + k as i32 + 1..5 + k as i32).contains(&(origin[k] as i32)));
            let ahead = (v(3.5, 4.5, 5.5) - *origin).dot(*axis) > -1.5;
            assert_eq!(found.hit().is_some() && strictly, ahead && strictly, "{origin} {axis} {found:?}");
        }
    }
}

/// From a thousandth to ten thousand times the extent of the scene.
#[test]
fn spheres_of_any_size() {
    for (radius, seed) in [(1e-2, 8), (1.0, 9), (1e2, 10), (1e5, 11)] {
        // One point of it is in the middle of the scene.
        let normal = v(0.3, -0.4, 0.866).normalize();
        let world = World::new([sphere(v(5.0, 5.0, 5.0) - radius * normal, radius)]);
        let reach = f64::min(radius, 4.0);
        let [low, high] = [-reach, reach].map(|reach| v(5.0, 5.0, 5.0) + reach);
        let rays = rays(3000, seed, [DVec3::ZERO, DVec3::splat(10.0)], [low, high]);
        // The error does not grow with the radius.
        let agreement = compare(&world, &rays, 10.0, 1.0 / radius);
        check(&format!("radius {radius}"), &agreement, rays.len());
        assert!(agreement.hits > 500 && agreement.at_edges < 30, "{agreement:?}");
    }
}

/// A ray that turns back at a convex body does not meet it again, one that goes through meets it from inside, at every
/// size and distance, and however flat it leaves.
#[test]
fn rays_that_start_on_surfaces() {
    let folder = TempDir::new().unwrap();
    let far = 3000.0;
    for (radius, distance) in [(1e-2, 5.0), (1.0, 5.0), (1.0, far), (1e3, 5.0), (1e5, 5.0)] {
        let surface = v(5.0, 4.0, 6.0);
        let convex = [
            sphere(surface - v(0.0, 0.0, radius), radius),
            SurfaceShape::Box { low: surface - 2.0 * radius, high: surface },
            mesh(folder.path(), &ball_obj(3, 0.0), surface - v(0.0, 0.0, radius), radius, false),
            SurfaceShape::Plane { point: surface, normal: DVec3::Z },
            SurfaceShape::Disk { centre: surface, normal: v(0.6, 0.0, 0.8), radius },
        ];
        for (kind, shape) in convex.into_iter().enumerate() {
            let world = World::new([shape]);
            let reach = 0.5 * radius.min(2.0);
            let target = surface - v(0.3 * reach, 0.3 * reach, 0.0);
            let towards =
                rays(3000, 12, [surface - distance, surface + distance], [target - reach, target + reach]);
            let found = world.trace(&towards, f32::INFINITY);
            let mut onward = Vec::new();
            let mut back = Vec::new();
            for ((_, d), found) in towards.iter().zip(&found).filter(|(_, found)| found.hit().is_some()) {
                let face = vector(found.face) * if found.inside == 1 { 1.0 } else { -1.0 };
                // Down to a thousandth of a degree from the surface.
                let flat = (*d - d.dot(face) * face).normalize_or(face.any_orthonormal_vector());
                for slope in [1.0, 0.1, 1e-3, 2e-5] {
                    let leaves = if found.inside == 1 { &mut back } else { &mut onward };
                    leaves.push(rounded((vector(found.onward), (flat + slope * face).normalize())));
                    let leaves = if found.inside == 1 { &mut onward } else { &mut back };
                    leaves.push(rounded((vector(found.back), (flat - slope * face).normalize())));
                }
            }
            assert!(onward.len() > 1000, "{kind} {radius} {}", onward.len());
            let name = format!("kind {kind} radius {radius} distance {distance}");
            // Out of the body.
            let again =
                world.trace(&back, f32::INFINITY).iter().filter(|found| found.hit().is_some()).count();
            assert_eq!(again, 0, "{name} of {}", back.len());
            // Into it.
            let onward = world.trace(&onward, f32::INFINITY);
            let wrong = onward.iter().filter(|found| (found.inside == 0) == (kind < 3)).count();
            assert_eq!(wrong, 0, "{name} of {}", onward.len());
        }
    }
}

#[test]
fn touching_spheres() {
    let world = World::new([sphere(v(3.0, 5.0, 5.0), 2.0), sphere(v(7.0, 5.0, 5.0), 2.0)]);
    let touch = v(5.0, 5.0, 5.0);
    let near = |[a, b, c, d, e, _]: [f64; 6]| {
        let reach = 10_f64.powf(-6.0 * e);
        let target = touch + reach * direction(a, b);
        rounded((target - 6.0 * direction(c, d), direction(c, d)))
    };
    let rays: Vec<_> = numbers(3000, 13).map(near).collect();
    let agreement = compare(&world, &rays, 10.0, 0.5);
    check("touching spheres", &agreement, rays.len());
    assert!(agreement.hits > 2900 && agreement.at_edges < 50, "{agreement:?}");
}

#[test]
fn nothing_beyond_the_end_of_a_ray() {
    let world = World::new([
        sphere(v(5.0, 5.0, 5.0), 2.0),
        SurfaceShape::Plane { point: v(0.0, 0.0, 1.0), normal: DVec3::Z },
    ]);
    let ray = [(v(5.0, 5.0, 0.0), DVec3::Z)];
    let found = |t_max| world.trace(&ray, t_max)[0];
    for (t_max, hit) in [(0.9, None), (1.1, Some(1))] {
        assert_eq!((found(t_max).hit(), found(t_max).blocked == 1), (hit, hit.is_some()), "{t_max}");
    }
    let behind = [(v(5.0, 5.0, 8.0), DVec3::Z)];
    assert_eq!(world.trace(&behind, f32::INFINITY)[0].hit(), None);
    assert_eq!(World::new([]).trace_specialised(&ray, f32::INFINITY)[0].hit(), None);
}

/// A program knows the shapes of its scene, and needs no others.
#[test]
fn shapes_that_a_scene_lacks_are_compiled_out() {
    let folder = TempDir::new().unwrap();
    let all = [DVec3::ZERO, DVec3::splat(10.0)];
    let rays = rays(300, 15, all, all);
    let differ = |a: f32, b: f32| (a - b).abs() > 1e-5 * (1.0 + a.abs());
    for shapes in one_of_each(folder.path()).chunks(4) {
        let world = World::new(shapes.to_vec());
        let pairs =
            world.trace(&rays, f32::INFINITY).into_iter().zip(world.trace_specialised(&rays, f32::INFINITY));
        let (mut hits, mut different) = (0, 0);
        for (all, own) in pairs {
            hits += usize::from(own.hit().is_some());
            // Contracted otherwise, perhaps: a ray at an edge may tell.
            different += usize::from(all.surface != own.surface || differ(all.point[3], own.point[3]));
        }
        assert!(hits > 30 && different <= 1, "{hits} {different}");
    }
}

/// The interpolated normals of a fine ball are those of a sphere, and never on the wrong side.
#[test]
fn smooth_normals() {
    let folder = TempDir::new().unwrap();
    let centre = DVec3::splat(5.0);
    let world = World::new([mesh(folder.path(), &ball_obj(4, 0.0), centre, 3.0, true)]);
    let all = [DVec3::ZERO, DVec3::splat(10.0)];
    let rays = rays(4000, 14, all, [DVec3::splat(2.0), DVec3::splat(8.0)]);
    let (mut hits, mut faceted) = (0, 0);
    for ((_, d), found) in rays.iter().zip(world.trace(&rays, f32::INFINITY)) {
        if found.hit().is_none() {
            continue;
        }
        hits += 1;
        let (normal, face) = (vector(found.normal), vector(found.face));
        let exact = (vector(found.point) - centre).normalize();
        assert!((normal.length() - 1.0).abs() < 1e-5 && d.dot(normal) * d.dot(face) > 0.0);
        let reflected = *d - 2.0 * d.dot(normal) * normal;
        assert!(reflected.dot(face) * d.dot(face) < 0.0, "{found:?}");
        // Edges of the mesh span about 1/16 of a right angle: flat faces are up to 0.06 off, interpolated normals by the
        // square of that.
        let close = normal.distance(exact) < 5e-3;
        faceted += usize::from(!close);
        assert!(close || normal == face, "{found:?}");
    }
    assert!(hits > 2000 && faceted < hits / 20, "{faceted} of {hits}");
}
