//! What the tests of surfaces share: surfaces on the device, rays through them, and meshes.
//!
//! Each test file uses a part of this.
#![allow(dead_code)]

use super::common::{self, EPS};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use std::collections::HashMap;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use svetlo::device::{Buffer, Device, Program, ProgramSpec};
use svetlo::reference::random::{philox4x32, uniform};
use svetlo::reference::surfaces::{Hit, nearest_hit};
use svetlo::render::local::LocalFrame;
use svetlo::scene::{Surface, SurfaceMaterial, SurfaceShape};
use svetlo::surfaces::{Meshes, SurfaceArrays, load};

/// What the device says of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Found {
    /// w: t.
    pub point: [f32; 4],
    /// w: margin.
    pub normal: [f32; 4],
    pub face: [f32; 4],
    /// Where a ray that goes on would start, and one that turns back.
    pub onward: [f32; 4],
    pub back: [f32; 4],
    /// 0xffffffff: nothing.
    pub surface: u32,
    pub inside: u32,
    /// What surfaces_block says.
    pub blocked: u32,
    pad: u32,
}

impl Found {
    pub fn hit(&self) -> Option<usize> {
        (self.surface != u32::MAX).then_some(self.surface as usize)
    }

    pub fn t(&self) -> f64 {
        self.point[3].into()
    }
}

const KERNEL: &str = "
struct Found { float4 point, normal, face, onward, back; uint surface, inside, blocked, pad; };
__kernel void probe(__global const struct Shape *shapes, uint plane_count, __global const struct Node *nodes,
    uint node_count, __global const struct Ball *balls, __global const float4 *normals,
    __global const uint *materials_of, __global const struct Material *materials, __global const float4 *in,
    float t_max, __global struct Found *out, uint count) {
    size_t i = get_global_id(0);
    if (i >= count) return;
    struct Surfaces s = {shapes, plane_count, nodes, node_count, balls, normals, materials_of, materials};
    float3 origin = in[2 * i].xyz;
    float3 direction = in[2 * i + 1].xyz;
    struct Hit hit;
    struct Found found;
    found.surface = 0xffffffffu;
    found.inside = found.pad = 0;
    found.blocked = surfaces_block(&s, origin, direction, t_max);
    found.point = found.normal = found.face = found.onward = found.back = (float4)(0.0f);
    if (surfaces_hit(&s, origin, direction, t_max, &hit)) {
        found.point = (float4)(hit.point, hit.t);
        found.normal = (float4)(hit.normal, hit.margin);
        found.face = (float4)(hit.face, 0.0f);
        found.surface = hit.surface;
        found.inside = hit.inside;
        found.onward = (float4)(surface_offset(&hit, direction), 0.0f);
        found.back = (float4)(surface_offset(&hit, -direction), 0.0f);
    }
    out[i] = found;
}
";

const SHAPES: [&str; 8] = [
    "SHAPE_PLANE",
    "SHAPE_SPHERE",
    "SHAPE_RECTANGLE",
    "SHAPE_DISK",
    "SHAPE_BOX",
    "SHAPE_METABALLS",
    "SHAPE_TRIANGLE",
    "SHAPE_SMOOTH",
];

pub fn vector(v: [f32; 4]) -> DVec3 {
    DVec3::new(v[0].into(), v[1].into(), v[2].into())
}

fn float4(v: DVec3, w: f64) -> [f32; 4] {
    [v.x as f32, v.y as f32, v.z as f32, w as f32]
}

/// The frame of most tests: local units are scene units, around the cube 0..10.
pub const FRAME: LocalFrame =
    LocalFrame { origin: DVec3::ZERO, unit: 1.0, dims: [10; 3], spacing: DVec3::ONE };

/// Surfaces of one material.
pub struct World {
    pub surfaces: Vec<Surface>,
    pub meshes: Meshes,
    pub arrays: SurfaceArrays,
    pub frame: LocalFrame,
}

impl World {
    pub fn new(shapes: impl IntoIterator<Item = SurfaceShape>) -> Self {
        Self::in_frame(shapes, FRAME)
    }

    pub fn in_frame(shapes: impl IntoIterator<Item = SurfaceShape>, frame: LocalFrame) -> Self {
        let surfaces: Vec<_> = shapes.into_iter().map(|shape| Surface { shape, material: 0 }).collect();
        let materials = [SurfaceMaterial::Diffuse { color: [0.5; 3] }];
        let meshes = load(&surfaces, &materials).unwrap_or_else(|e| panic!("{e}"));
        let arrays = SurfaceArrays::new(&surfaces, &materials, &meshes, &frame).unwrap();
        Self { surfaces, meshes, arrays, frame }
    }

    /// The twin's nearest hit. Directions that are rounded to float32 are 1e-7 from unit length, which both t have in
    /// them.
    pub fn nearest(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Option<Hit> {
        nearest_hit(&self.surfaces, &self.meshes, origin, direction.normalize(), t_max)
    }

    /// The device's nearest hits of rays: origin and direction in local units. By a program for all shapes, so that the
    /// worlds of all tests share it.
    pub fn trace(&self, rays: &[(DVec3, DVec3)], t_max: f32) -> Vec<Found> {
        let spec = ProgramSpec::new("surfaces/intersect.cl");
        self.trace_by(&SHAPES.into_iter().fold(spec, |spec, shape| spec.feature(shape, true)), rays, t_max)
    }

    /// The same by a program for the shapes of this world alone.
    pub fn trace_specialised(&self, rays: &[(DVec3, DVec3)], t_max: f32) -> Vec<Found> {
        let spec = ProgramSpec::new("surfaces/intersect.cl");
        self.trace_by(&self.arrays.specialise(spec), rays, t_max)
    }

    fn trace_by(&self, spec: &ProgramSpec, rays: &[(DVec3, DVec3)], t_max: f32) -> Vec<Found> {
        let device = common::device();
        let arrays = &self.arrays;
        let program = Program::build_probe(&device, spec, KERNEL).unwrap();
        let shapes = buffer(&device, &arrays.shapes);
        let nodes = buffer(&device, &arrays.nodes);
        let balls = buffer(&device, &arrays.balls);
        let normals = buffer(&device, &arrays.normals);
        let materials_of = buffer(&device, &arrays.materials_of);
        let materials = buffer(&device, &arrays.materials);
        let input: Vec<_> = rays.iter().flat_map(|(o, d)| [float4(*o, 1.0), float4(*d, 0.0)]).collect();
        let input = buffer(&device, &input);
        let output = Buffer::<Found>::zeroed(&device, rays.len()).unwrap();
        let arguments = [
            (&shapes).into(),
            (arrays.plane_count as u32).into(),
            (&nodes).into(),
            (arrays.nodes.len() as u32).into(),
            (&balls).into(),
            (&normals).into(),
            (&materials_of).into(),
            (&materials).into(),
            (&input).into(),
            t_max.into(),
            (&output).into(),
            (rays.len() as u32).into(),
        ];
        program.kernel(&device, "probe").unwrap().run(&device, &arguments, rays.len()).unwrap();
        output.read(&device).unwrap()
    }
}

fn buffer<T: Pod>(device: &Device, values: &[T]) -> Buffer<T> {
    // OpenCL knows no empty buffers.
    let some = if values.is_empty() { &[T::zeroed()] } else { values };
    Buffer::from_slice(device, some).unwrap()
}

/// What [`compare`] found.
#[derive(Debug, Default)]
pub struct Agreement {
    pub hits: usize,
    pub inside: usize,
    /// Rays so near to an edge or a silhouette that rounding decides: they agree with a ray beside them.
    pub at_edges: usize,
    /// The largest error over its bound.
    pub worst: f64,
}

/// Compares the device with the twin along rays whose numbers are float32, in a frame whose local units are those of
/// the scene. `scale`: the largest coordinates that shapes are given by; `curvature`: the largest of any surface.
#[track_caller]
pub fn compare(world: &World, rays: &[(DVec3, DVec3)], scale: f64, curvature: f64) -> Agreement {
    let mut agreement = Agreement::default();
    for (&(origin, direction), found) in rays.iter().zip(world.trace(rays, f32::INFINITY)) {
        assert_eq!(found.blocked == 1, found.hit().is_some(), "{origin} {direction}");
        let error = |shift: DVec3| {
            let exact = world.nearest(origin + shift, direction, f64::INFINITY);
            error_of(exact, &found, origin, direction, scale, curvature)
        };
        let straight = error(DVec3::ZERO);
        if straight > 1.0 {
            let reach = 8.0 * EPS * (scale + origin.abs().max_element());
            let u = direction.any_orthonormal_vector();
            let v = direction.cross(u);
            let beside = (0..16).map(|k| {
                let (sine, cosine) = (TAU * f64::from(k) / 16.0).sin_cos();
                error(reach * (cosine * u + sine * v))
            });
            let beside = beside.fold(f64::INFINITY, f64::min);
            let exact = world.nearest(origin, direction, f64::INFINITY);
            assert!(beside <= 2.0, "{origin} {direction}: {straight} {beside}\n{exact:?}\n{found:?}");
            agreement.at_edges += 1;
        } else {
            agreement.worst = agreement.worst.max(straight);
        }
        agreement.hits += usize::from(found.hit().is_some());
        agreement.inside += usize::from(found.inside == 1);
    }
    agreement
}

/// The largest error of a hit over its bound; infinite where both do not hit the same.
fn error_of(exact: Option<Hit>, found: &Found, o: DVec3, d: DVec3, scale: f64, curvature: f64) -> f64 {
    let (Some(exact), Some(surface)) = (exact, found.hit()) else {
        return if exact.is_none() && found.hit().is_none() { 0.0 } else { f64::INFINITY };
    };
    let slope = d.dot(vector(found.face));
    assert!((slope > 0.0) == (found.inside == 1), "{o} {d} {found:?}");
    if surface != exact.surface || exact.inside(d) != (found.inside == 1) {
        return f64::INFINITY;
    }
    // Coordinates and what is computed from them are rounded a few times, which moves the surface by this much along its
    // normal, hence the hit along the ray by more.
    let moved = 8.0 * EPS * (scale + o.abs().max_element() + exact.t);
    let along = moved / d.dot(exact.normal).abs();
    let point = vector(found.point);
    let errors = [
        (found.t() - exact.t).abs() / along,
        point.distance(exact.point) / (2.0 * along),
        // On the surface, wherever on it.
        (point - exact.point).dot(exact.normal).abs() / (moved + curvature * along * along),
        vector(found.face).distance(exact.normal) / (2.0 * curvature * along + 8.0 * EPS),
    ];
    errors.into_iter().fold(0.0, f64::max)
}

/// `count` times six uniform numbers.
pub fn numbers(count: u32, seed: u32) -> impl Iterator<Item = [f64; 6]> {
    (0..count).map(move |i| {
        let [a, b, c, d] = philox4x32([i, seed, 0, 0], [0x50f, 0]).map(uniform);
        let [e, f, ..] = philox4x32([i, seed, 1, 0], [0x50f, 0]).map(uniform);
        [a, b, c, d, e, f]
    })
}

/// Uniform over the sphere.
pub fn direction(a: f64, b: f64) -> DVec3 {
    let cosine = 1.0 - 2.0 * a;
    let (x, y) = (TAU * b).sin_cos();
    let sine = (1.0 - cosine * cosine).sqrt();
    DVec3::new(sine * y, sine * x, cosine)
}

/// The ray as float32 holds it.
pub fn rounded((origin, direction): (DVec3, DVec3)) -> (DVec3, DVec3) {
    let round = |v: DVec3| v.map(|x| f64::from(x as f32));
    (round(origin), round(direction))
}

/// Rays from places in a box towards places in another.
pub fn rays(count: u32, seed: u32, from: [DVec3; 2], to: [DVec3; 2]) -> Vec<(DVec3, DVec3)> {
    let between = |[low, high]: [DVec3; 2], u: DVec3| low + (high - low) * u;
    let ray = |[a, b, c, d, e, f]: [f64; 6]| {
        let origin = between(from, DVec3::new(a, b, c));
        rounded((origin, (between(to, DVec3::new(d, e, f)) - origin).normalize()))
    };
    numbers(count, seed).map(ray).collect()
}

/// A closed mesh as an OBJ file: an octahedron whose edges are halved `halvings` times, pushed out to a ball with bumps
/// of height `bumps`, in units of its radius; the normals are those of the ball.
pub fn ball_obj(halvings: u32, bumps: f64) -> String {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
    let mut points = axes.to_vec();
    let mut triangles =
        vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    for _ in 0..halvings {
        let mut middles = HashMap::new();
        let mut middle = |a: usize, b: usize| {
            *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                points.push((points[a] + points[b]).normalize());
                points.len() - 1
            })
        };
        let quarters = |[a, b, c]: [usize; 3]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(quarters).collect();
    }
    let mut text = String::new();
    for n in points {
        let _ = writeln!(text, "vn {} {} {}", n.x, n.y, n.z);
        let p = n * (1.0 + bumps * (7.0 * n.x).sin() * (5.0 * n.y + 1.0).sin() * (6.0 * n.z).cos());
        let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
    }
    for [a, b, c] in triangles {
        let _ = writeln!(text, "f {0}//{0} {1}//{1} {2}//{2}", a + 1, b + 1, c + 1);
    }
    text
}
