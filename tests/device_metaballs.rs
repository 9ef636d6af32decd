//! Metaballs on the device: where rays go through the surface, against dense samples and closed forms.

mod common;
#[path = "common/probe.rs"]
mod probe;

use common::{EPS, close, largest, noise, report};
use glam::DVec3;
use probe::probe_with;
use svetlo::reference::metaballs::{Ball, Crossing, Metaballs};
use svetlo::surfaces::DeviceBall;

/// A ray, all float32.
#[derive(Clone, Copy, Debug)]
struct Ray {
    origin: [f32; 3],
    direction: [f32; 3],
    range: [f32; 2],
}

fn vector(v: [f32; 3]) -> DVec3 {
    DVec3::new(v[0].into(), v[1].into(), v[2].into())
}

impl Ray {
    fn new(origin: DVec3, direction: DVec3, range: [f32; 2]) -> Self {
        let single = |v: DVec3| [v.x as f32, v.y as f32, v.z as f32];
        Self { origin: single(origin), direction: single(direction.normalize()), range }
    }

    fn at(&self, t: f64) -> DVec3 {
        vector(self.origin) + t * vector(self.direction).normalize()
    }
}

/// Numbers that float32 has, so that twin and device know the same body.
fn ball(centre: [f32; 3], radius: f32, weight: f32) -> Ball {
    Ball { centre: vector(centre), radius: radius.into(), weight: weight.into() }
}

fn crossings(body: &Metaballs, rays: &[Ray]) -> Vec<Option<Crossing>> {
    let balls: Vec<DeviceBall> = body
        .balls
        .iter()
        .map(|b| {
            let place = [b.centre.x as f32, b.centre.y as f32, b.centre.z as f32, b.radius as f32];
            DeviceBall::new(place, b.weight as f32)
        })
        .collect();
    let text = "float t = -1.0f;\nfloat3 n = (float3)(0.0f);\n\
        bool hit = metaballs_hit(table, 0, (uint)x[2].x, x[2].y, x[0].xyz, x[1].xyz, x[0].w, x[1].w, false, &t, &n);\n\
        float before;\nfloat3 none;\n\
        bool blocked = metaballs_hit(table, 0, (uint)x[2].x, x[2].y, x[0].xyz, x[1].xyz, x[0].w, x[1].w, true, &before, &none);\n\
        y[0] = (float4)(n, t);\ny[1] = (float4)(hit ? 1.0f : 0.0f, blocked == hit ? 1.0f : 0.0f, 0.0f, 0.0f);";
    let [count, threshold] = [balls.len() as f32, body.threshold as f32];
    let inputs: Vec<[[f32; 4]; 3]> = rays
        .iter()
        .map(|Ray { origin: [x, y, z], direction: [u, v, w], range: [near, far] }| {
            [[*x, *y, *z, *near], [*u, *v, *w, *far], [count, threshold, 0.0, 0.0]]
        })
        .collect();
    let found = probe_with::<DeviceBall, 3, 2>("surfaces/metaballs.cl", "struct Ball", &balls, text, &inputs);
    let crossing = |(ray, [n, [hit, agreed, ..]]): (&Ray, &[[f32; 4]; 2])| {
        assert!(*agreed > 0.5, "{ray:?}: a shadow ray finds something else");
        let normal = vector([n[0], n[1], n[2]]);
        let leaves = normal.dot(vector(ray.direction)) > 0.0;
        (*hit > 0.5).then_some(Crossing { t: n[3].into(), normal, leaves })
    };
    rays.iter().zip(&found).map(crossing).collect()
}

/// The error of the device's field at a place along a ray: places err by some roundings of the distances, which the
/// slope of each share, at most 1.54 w / R, turns into a value; shares err by some roundings of themselves.
fn field_error(body: &Metaballs, ray: &Ray, t: f64) -> f64 {
    let reach = vector(ray.origin).length() + t;
    let share =
        |b: &Ball| b.weight.abs() * (1.54 * 4.0 * EPS * (reach + b.centre.length()) / b.radius + 16.0 * EPS);
    body.balls.iter().map(share).sum::<f64>() + 4.0 * EPS * body.threshold
}

/// Holds an answer of the device against the twin's field: the ray keeps its side of the surface up to what was found,
/// and there is on the surface. Returns the largest error over its bound.
#[track_caller]
fn check(body: &Metaballs, ray: &Ray, found: Option<Crossing>) -> f64 {
    const SAMPLES: u32 = 2000;
    let [near, far] = ray.range.map(f64::from);
    let field = |t: f64| body.field(ray.at(t));
    let bound = field_error(body, ray, far);
    let end = found.map_or(far, |found| found.t);
    assert!(end > near && end <= far, "{ray:?}: {found:?}");
    let start = field(near);
    if start.abs() < bound {
        return 0.0;
    }
    let before = (0..SAMPLES).map(|i| near + (end - near) * f64::from(i) / f64::from(SAMPLES));
    let wrong = largest(before.map(|t| -start.signum() * field(t)));
    assert!(wrong <= bound, "{ray:?}: goes through by {wrong} of {bound} before {found:?}");
    let Some(found) = found else { return wrong / bound };
    close(&format!("{ray:?}: field at {found:?}"), field(found.t), 0.0, bound);
    assert_eq!(found.leaves, start > 0.0, "{ray:?}: {found:?}");
    close("length of the normal", found.normal.length(), 1.0, 4.0 * EPS);
    // Shares of the gradient, of slopes up to 4 w / R^2, over its length. A grazing normal may be turned by as much.
    let gradient = body.gradient(ray.at(found.t));
    let steep: f64 = body.balls.iter().map(|b| 4.0 * b.weight.abs() / b.radius.powi(2)).sum();
    let reach = vector(ray.origin).length() + found.t + 2.0;
    let tilt = 8.0 * EPS * steep * reach / gradient.length() + 4e-6;
    if tilt < 0.1 {
        close(&format!("{ray:?}: normal"), found.normal.distance(-gradient.normalize()), 0.0, tilt);
    }
    wrong.max(field(found.t).abs()) / bound
}

/// Looks for a body along rays and checks every answer; how many there are.
#[track_caller]
fn check_all(what: &str, body: &Metaballs, rays: &[Ray]) -> usize {
    let found = crossings(body, rays);
    let errors: Vec<f64> = rays.iter().zip(&found).map(|(ray, found)| check(body, ray, *found)).collect();
    report(&format!("{what}, field of its bound"), largest(errors), 1.0);
    found.iter().flatten().count()
}

/// A ray from a sphere around everything towards a place within `towards` of the origin.
fn sphere_ray(u: &[f64], towards: f64) -> Ray {
    let on = |a: f64, b: f64| {
        let (z, phi) = (2.0 * a - 1.0, std::f64::consts::TAU * b);
        DVec3::new((1.0 - z * z).sqrt() * phi.cos(), (1.0 - z * z).sqrt() * phi.sin(), z)
    };
    let origin = 4.0 * on(u[0], u[1]);
    Ray::new(origin, towards * on(u[2], u[3]) * u[4] - origin, [0.0, 8.0])
}

fn blob(count: usize, seed: u32) -> Metaballs {
    let u = noise(5 * count, seed);
    let balls = u.chunks(5).enumerate().map(|(i, u)| {
        let centre = [u[0], u[1], u[2]].map(|v| (2.4 * v - 1.2) as f32);
        let weight = if i % 4 == 2 { -0.7 } else { 0.5 + u[4] };
        ball(centre, (0.4 + 0.9 * u[3]) as f32, weight as f32)
    });
    Metaballs { balls: balls.collect(), threshold: 0.25 }
}

#[test]
fn blobs_are_met_where_the_field_crosses_the_threshold() {
    let mut hits = 0;
    for (count, seed) in [(1, 1), (2, 2), (3, 3), (6, 4), (12, 5), (40, 6)] {
        let body = blob(count, seed);
        let u = noise(5 * 400, 100 + seed);
        let rays: Vec<Ray> = u.chunks(5).map(|u| sphere_ray(u, 2.0)).collect();
        hits += check_all(&format!("{count} balls"), &body, &rays);
    }
    assert!(hits > 600, "{hits}");
}

#[test]
fn rays_that_start_inside_leave() {
    let body = blob(12, 7);
    let u = noise(6 * 2000, 8);
    let start = |u: &[f64]| 2.4 * DVec3::new(u[0], u[1], u[2]) - DVec3::splat(1.2);
    let rays: Vec<Ray> = u
        .chunks(6)
        .filter(|u| body.field(start(u)) > 1e-3)
        .map(|u| Ray::new(start(u), DVec3::new(u[3], u[4], u[5]) - DVec3::splat(0.5), [0.0, 8.0]))
        .collect();
    assert!(rays.len() > 200, "{}", rays.len());
    assert_eq!(check_all("from inside", &body, &rays), rays.len(), "each leaves");
}

#[test]
fn one_ball_is_a_sphere() {
    // (1 - s^2)^2 = 1/4 on s^2 = 1/2.
    let body = Metaballs { balls: vec![ball([0.5, -0.25, 0.125], 1.5, 1.0)], threshold: 0.25 };
    let (centre, radius) = (body.balls[0].centre, 1.5 / 2.0_f64.sqrt());
    let u = noise(5 * 2000, 9);
    let rays: Vec<Ray> = u.chunks(5).map(|u| sphere_ray(u, 1.4)).collect();
    let mut hits = 0;
    for (ray, found) in rays.iter().zip(crossings(&body, &rays)) {
        let (o, d) = (vector(ray.origin) - centre, vector(ray.direction).normalize());
        let aside2 = o.length_squared() - o.dot(d).powi(2);
        let half2 = radius * radius - aside2;
        if half2.abs() < 1e-4 {
            continue;
        }
        assert_eq!(found.is_some(), half2 > 0.0, "{ray:?}");
        let Some(found) = found else { continue };
        hits += 1;
        // The place across the ray errs by 4 roundings of the distance 4, the radius by 8 of the field over its slope.
        let bound = 16.0 * EPS * (4.0 + radius / half2.sqrt() * 4.0);
        close(&format!("{ray:?}"), found.t, -o.dot(d) - half2.sqrt(), bound);
        let normal = (o + found.t * d) / radius;
        close("normal", found.normal.distance(normal), 0.0, bound / radius);
    }
    assert!(hits > 1000, "{hits}");
}

#[test]
fn fields_that_just_miss_or_just_reach_the_threshold() {
    // Along x the field of two balls has a saddle between them and one peak in each; along the line z = h above them its
    // largest value is known, and the threshold goes just above and just below it.
    let balls = vec![ball([-0.5, 0.0, 0.0], 1.0, 1.0), ball([0.5, 0.0, 0.0], 1.0, 1.0)];
    for height in [0.0_f32, 0.25, 0.5, 0.7] {
        let ray = Ray::new(DVec3::new(0.0, -3.0, height.into()), DVec3::Y, [0.0, 6.0]);
        let body = |threshold: f64| Metaballs { balls: balls.clone(), threshold };
        let peak = body(0.0).field(DVec3::new(0.0, 0.0, height.into()));
        for share in [1e-2, 1e-3, 1e-4, 1e-5, 3e-6] {
            for (sign, expected) in [(-1.0, true), (1.0, false)] {
                // As a float32, as the kernel has it.
                let body = body(f64::from((peak * (1.0 + sign * share)) as f32));
                let found = crossings(&body, &[ray])[0];
                assert_eq!(found.is_some(), expected, "peak {peak}, threshold {}", body.threshold);
                check(&body, &ray, found);
            }
        }
    }
}

#[test]
fn rays_along_tangents_and_through_touching_balls() {
    // Bodies that touch: spheres of radius 1 / sqrt 2 around (+-1 / sqrt 2, 0, 0), whose balls overlap, are joined by
    // the field; balls that touch at their rims are not. Rays pass at and around the tangents, and through the joint.
    let r = std::f32::consts::FRAC_1_SQRT_2;
    let joined = vec![ball([-r, 0.0, 0.0], 1.0, 1.0), ball([r, 0.0, 0.0], 1.0, 1.0)];
    let apart = vec![ball([-1.0, 0.0, 0.0], 1.0, 1.0), ball([1.0, 0.0, 0.0], 1.0, 1.0)];
    for balls in [joined, apart] {
        let body = Metaballs { balls, threshold: 0.25 };
        let mut rays = Vec::new();
        for i in -60_i32..=60 {
            let shift = f64::from(i.signum()) * 10f64.powf(-f64::from(i.abs()) / 10.0);
            for start in [f64::from(r) + shift, shift, -f64::from(r) + 0.1 * shift] {
                rays.push(Ray::new(DVec3::new(-3.0, start, 0.0), DVec3::X, [0.0, 6.0]));
                rays.push(Ray::new(DVec3::new(start, -3.0, 0.0), DVec3::Y, [0.0, 6.0]));
                rays.push(Ray::new(
                    DVec3::new(-3.0, -3.0 + start, 0.1),
                    DVec3::new(1.0, 1.0, 0.0),
                    [0.0, 9.0],
                ));
            }
        }
        assert!(check_all("tangents", &body, &rays) > rays.len() / 4);
    }
}

#[test]
fn far_away_and_many_balls() {
    // From 100 radii away, and more balls than any fixed list would hold, all of them over each other.
    let u = noise(3 * 100, 11);
    let balls = u.chunks(3).map(|u| ball([u[0], u[1], u[2]].map(|v| (0.4 * v - 0.2) as f32), 1.0, 0.03));
    let body = Metaballs { balls: balls.collect(), threshold: 0.25 };
    let u = noise(5 * 60, 12);
    let far = |u: &[f64]| {
        let ray = sphere_ray(u, 1.0);
        Ray {
            origin: ray.origin.map(|x| 25.0 * x),
            direction: (vector(ray.origin) * -1.0).normalize().to_array().map(|x| x as f32),
            range: [0.0, 200.0],
        }
    };
    let near: Vec<Ray> = u.chunks(5).map(|u| sphere_ray(u, 1.0)).collect();
    let rays: Vec<Ray> = u.chunks(5).map(far).chain(near).collect();
    assert!(check_all("100 balls", &body, &rays) > 80);
}

#[test]
fn nothing_is_found_beyond_the_range_or_without_balls() {
    let body = Metaballs { balls: vec![ball([0.0; 3], 1.0, 1.0)], threshold: 0.25 };
    let mut ray = Ray::new(DVec3::new(0.0, 0.0, -3.0), DVec3::Z, [0.0, 2.2]);
    assert!(crossings(&body, &[ray])[0].is_none(), "the surface is at 2.293");
    ray.range = [2.0, 2.4];
    assert!(crossings(&body, &[ray])[0].is_some());
    ray.range = [2.4, 3.0];
    assert!(crossings(&body, &[ray])[0].is_none(), "inside all the way");
    ray.range = [0.0, 6.0];
    let weak = Metaballs { balls: vec![ball([0.0; 3], 1.0, 0.2)], threshold: 0.25 };
    assert!(crossings(&weak, &[ray])[0].is_none());
    // A ball that takes away as much as the other gives.
    let none =
        Metaballs { balls: vec![ball([0.0; 3], 1.0, 1.0), ball([0.0; 3], 1.0, -1.0)], threshold: 0.25 };
    assert!(crossings(&none, &[ray])[0].is_none());
}
