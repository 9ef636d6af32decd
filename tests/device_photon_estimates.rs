//! What photons say of irradiance: mean, variance and bias of each kernel, at edges, on curved surfaces, in a medium.

mod common;
#[path = "common/photon_maps.rs"]
mod photons;

use common::EPS;
use glam::{DVec3, dvec2, dvec3};
use photons::{Gathering, Query, photon};
use std::f64::consts::{PI, TAU};
use svetlo::caustics::{MapSettings, Photon, Receiver, Weighting};
use svetlo::device::{Buffer, Program, ProgramSpec};
use svetlo::reference::photons::{Weight, cone, constant, mass_inside, smoothstep};

/// A kernel, and from its table: bias over radius^2 and Laplacian, variance over that of the constant one.
struct Kernel {
    weighting: Weighting,
    weight: Weight,
    bias: f64,
    variance: f64,
}

const KERNELS: [Kernel; 3] = [
    Kernel { weighting: Weighting::Constant, weight: constant, bias: 1.0 / 8.0, variance: 1.0 },
    Kernel { weighting: Weighting::Cone, weight: cone, bias: 3.0 / 40.0, variance: 1.5 },
    Kernel { weighting: Weighting::Smoothstep, weight: smoothstep, bias: 5.0 / 84.0, variance: 40.0 / 21.0 },
];

fn plain(weighting: Weighting) -> MapSettings {
    MapSettings { weighting, edge_correction: false, table_cells: 1 << 16, ..MapSettings::default() }
}

fn corrected(weighting: Weighting) -> MapSettings {
    MapSettings { edge_correction: true, ..plain(weighting) }
}

fn unit_square() -> Gathering {
    Gathering::new(vec![Receiver::parallelogram(DVec3::ZERO, DVec3::X, DVec3::Y)])
}

fn reds(found: &[photons::Found]) -> Vec<f64> {
    found.iter().map(|found| found.sums[0].into()).collect()
}

#[test]
fn uniform_photons_give_their_irradiance_with_the_variance_of_the_table() {
    const PHOTONS: usize = 1 << 16;
    const ACROSS: usize = 40;
    let random = common::noise(2 * PHOTONS, 1);
    let slots: Vec<Photon> = random
        .chunks_exact(2)
        .map(|u| photon(dvec3(u[0], u[1], 0.0), DVec3::Z, [1.0 / PHOTONS as f64; 3], 0))
        .collect();
    // Disks that touch, so that no photon is counted twice.
    let radius = 0.5 / ACROSS as f64;
    let at = |k: usize| (2 * k + 1) as f64 * radius;
    let queries: Vec<Query> = (0..ACROSS * ACROSS)
        .map(|i| Query::new(dvec3(at(i % ACROSS), at(i / ACROSS), 0.0), DVec3::Z, 0))
        .collect();
    for kernel in KERNELS {
        let found = reds(&unit_square().irradiance(plain(kernel.weighting), &slots, radius as f32, &queries));
        let count = found.len() as f64;
        let variance = kernel.variance / (PI * radius * radius * PHOTONS as f64);
        let mean = found.iter().sum::<f64>() / count;
        common::close("mean", mean, 1.0, 5.0 * (variance / count).sqrt());
        let spread = found.iter().map(|e| (e - 1.0).powi(2)).sum::<f64>() / count;
        // 32 photons in a disk: the variance of the squares is 2 to 2.2 times the square of the variance.
        common::close("variance", spread / variance, 1.0, 5.0 * (2.2 / count).sqrt());
    }
}

#[test]
fn bias_is_that_of_the_table() {
    const ACROSS: usize = 400;
    const STEEPNESS: f64 = 100.0;
    let (radius, step) = (0.1_f64, 1e-3);
    let irradiance = |x: f64, y: f64| 1.0 + STEEPNESS * (x * x + y * y);
    let at = |k: usize| (k as f64 - 0.5 * (ACROSS - 1) as f64) * step;
    let slots: Vec<Photon> = (0..ACROSS * ACROSS)
        .map(|i| {
            let [x, y] = [at(i % ACROSS), at(i / ACROSS)];
            photon(dvec3(x, y, 0.0), DVec3::Z, [irradiance(x, y) * step * step; 3], 0)
        })
        .collect();
    // Points all over a cell of the lattice, so that the photons at the kernel's rim come and go.
    let places: Vec<[f64; 2]> =
        (0..64).map(|i| [i % 8, i / 8].map(|k| (f64::from(k) / 8.0 + 0.03) * step)).collect();
    let queries: Vec<Query> =
        places.iter().map(|&[x, y]| Query::new(dvec3(x, y, 0.0), DVec3::Z, 0)).collect();
    let gathering = Gathering::new(vec![Receiver::plane(DVec3::ZERO, DVec3::Z)]);
    for kernel in KERNELS {
        let found = reds(&gathering.irradiance(plain(kernel.weighting), &slots, radius as f32, &queries));
        let errors = found.iter().zip(&places).map(|(found, &[x, y])| found - irradiance(x, y));
        let bias = errors.sum::<f64>() / found.len() as f64;
        let expected = kernel.bias * radius * radius * 4.0 * STEEPNESS;
        // 31 000 photons: their lattice counts a disk to 7 of them (the circle problem), which 64 points average out, and
        // sums in eight lanes round 4000 times, 1e-5 at random. Kernels differ by more than 20 %.
        common::close(&format!("{:?}", kernel.weighting), bias, expected, 0.005 * expected);
    }
}

/// Photons on a parallelogram, evenly; their irradiance is 1.
fn even(corner: DVec3, u: DVec3, v: DVec3, across: usize, surface: u32) -> Vec<Photon> {
    let normal = u.cross(v);
    let flux = [normal.length() / (across * across) as f64; 3];
    let at = |k: usize| (k as f64 + 0.5) / across as f64;
    (0..across * across)
        .map(|i| {
            let place = corner + at(i % across) * u + at(i / across) * v;
            photon(place, normal.normalize(), flux, surface)
        })
        .collect()
}

/// Irradiance 1 at points on a surface, up to its edges, to the evenness of the photons.
fn is_flat(what: &str, gathering: &Gathering, slots: &[Photon], at: &[Query], radius: f32) {
    for kernel in KERNELS {
        let found = reds(&gathering.irradiance(corrected(kernel.weighting), slots, radius, at));
        for (query, found) in at.iter().zip(found) {
            common::close(&format!("{what}, {:?}, {query:?}", kernel.weighting), found, 1.0, 0.01);
        }
    }
}

#[test]
fn rectangles_are_evenly_lit_up_to_their_edges() {
    let (corner, u, v) = (dvec3(0.3, -0.2, 0.5), dvec3(0.8, 0.36, 0.48), dvec3(-0.6, 0.48, 0.64));
    // Slanted.
    let v = v + 0.4 * u;
    let gathering = Gathering::new(vec![Receiver::parallelogram(corner, u, v)]);
    let slots = even(corner, u, v, 500, 0);
    let query = |a: f64, b: f64| Query::new(corner + a * u + b * v, u.cross(v).normalize(), 0);
    let at: Vec<Query> = [0.0, 0.01, 0.04, 0.5, 0.97, 1.0]
        .into_iter()
        .flat_map(|a| [0.0, 0.03, 0.3, 0.96, 1.0].map(|b| query(a, b)))
        .collect();
    is_flat("parallelogram", &gathering, &slots, &at, 0.1);

    // What is divided by: a half at an edge, at corners their share of the circle.
    let open = [query(0.5, 0.5), query(0.5, 0.0), query(1.0, 0.5), query(0.0, 0.0)];
    let found = reds(&gathering.irradiance(plain(Weighting::Cone), &slots, 0.1, &open));
    let corner_share = u.angle_between(v) / TAU;
    for (found, expected) in found.into_iter().zip([1.0, 0.5, 0.5, corner_share]) {
        common::close("without correction", found, expected, 0.01 * expected);
    }
}

#[test]
fn disks_are_evenly_lit_up_to_their_edges() {
    const PHOTONS: usize = 100_000;
    let (centre, normal, radius) = (dvec3(0.2, -0.3, 0.1), dvec3(0.6, 0.0, 0.8), 0.5);
    let across = normal.any_orthonormal_vector();
    let place = |r: f64, angle: f64| centre + r * (angle.cos() * across + angle.sin() * normal.cross(across));
    let flux = [PI * radius * radius / PHOTONS as f64; 3];
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    let slots: Vec<Photon> = (0..PHOTONS)
        .map(|i| {
            let r = radius * ((i as f64 + 0.5) / PHOTONS as f64).sqrt();
            photon(place(r, golden * i as f64), normal, flux, 0)
        })
        .collect();
    let gathering = Gathering::new(vec![Receiver::disk(centre, normal, radius)]);
    let at: Vec<Query> = [0.0, 0.2, 0.4, 0.45, 0.49, 0.5]
        .into_iter()
        .flat_map(|r| [0.3, 2.0, 5.0].map(|angle| Query::new(place(r, angle), normal, 0)))
        .collect();
    is_flat("disk", &gathering, &slots, &at, 0.1);
}

#[test]
fn faces_of_boxes_are_evenly_lit_up_to_their_edges() {
    let (low, size) = (dvec3(-0.2, 0.1, 0.3), dvec3(0.6, 0.4, 0.5));
    let [x, y, z] = [size * DVec3::X, size * DVec3::Y, size * DVec3::Z];
    let gathering = Gathering::new(vec![Receiver::cuboid(low, low + size)]);
    // Three faces, all lit: none counts for another.
    let faces = [(low + z, x, y), (low + x, y, z), (low, x, z)];
    let slots: Vec<Photon> = faces.iter().flat_map(|&(corner, u, v)| even(corner, u, v, 250, 0)).collect();
    for (corner, u, v) in faces {
        let normal = u.cross(v).normalize();
        let at: Vec<Query> = [0.0, 0.05, 0.5, 1.0]
            .into_iter()
            .flat_map(|a| [0.0, 0.06, 0.5, 0.95, 1.0].map(|b| Query::new(corner + a * u + b * v, normal, 0)))
            .collect();
        is_flat("box", &gathering, &slots, &at, 0.08);
    }
}

#[test]
fn spheres_are_as_bright_as_planes() {
    const PHOTONS: usize = 50_000;
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    let place = |i: usize| {
        let z = 1.0 - (2 * i + 1) as f64 / PHOTONS as f64;
        let (sin, cos) = (golden * i as f64).sin_cos();
        dvec3((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z)
    };
    let flux = [4.0 * PI / PHOTONS as f64; 3];
    let slots: Vec<Photon> = (0..PHOTONS).map(|i| photon(place(i), place(i), flux, 0)).collect();
    let at: Vec<Query> = (0..50).map(|i| Query::new(place(1000 * i + 7), place(1000 * i + 7), 0)).collect();
    // By distances in the tangent plane it would be 2.3 % more.
    is_flat("sphere", &Gathering::new(vec![Receiver::curved()]), &slots, &at, 0.3);
}

#[test]
fn even_photons_in_a_medium_give_their_density() {
    const ACROSS: usize = 50;
    let at = |k: usize| (k as f64 + 0.5) / ACROSS as f64;
    let slots: Vec<Photon> = (0..ACROSS.pow(3))
        .map(|i| {
            let place = dvec3(at(i % ACROSS), at(i / ACROSS % ACROSS), at(i / ACROSS / ACROSS));
            photon(place, DVec3::X, [(ACROSS as f64).powi(-3); 3], 0)
        })
        .collect();
    let places = common::noise(3 * 50, 5);
    let queries: Vec<Query> = (places.chunks_exact(3))
        .map(|u| Query::new(0.3 + 0.4 * dvec3(u[0], u[1], u[2]), DVec3::Z, 0))
        .collect();
    let gathering = Gathering::new(vec![Receiver::curved()]);
    for kernel in KERNELS {
        for found in reds(&gathering.density(plain(kernel.weighting), &slots, 0.3, &queries)) {
            // 14 000 photons in a ball; the lattice counts it to some 70 of them.
            common::close(&format!("{:?}", kernel.weighting), found, 1.0, 0.01);
        }
    }
}

/// How far a convex polygon reaches from the origin inside it, counterclockwise, in a direction.
fn reach(corners: &[glam::DVec2], angle: f64) -> f64 {
    let direction = dvec2(angle.cos(), angle.sin());
    let edge = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        let leaving = direction.perp_dot(b - a);
        if leaving > 0.0 { a.perp_dot(b - a) / leaving } else { f64::INFINITY }
    };
    (0..corners.len()).map(edge).fold(f64::INFINITY, f64::min).max(0.0)
}

#[test]
fn masses_of_kernels_are_those_of_the_twin() {
    let random = common::noise(7 * 60, 3);
    let device = common::device();
    let mut receivers = Vec::new();
    let mut points = Vec::new();
    let mut expected: [Vec<f64>; 3] = Default::default();
    for u in random.chunks_exact(7) {
        // Shapes from a tenth of the radius to 30 radii across, in the plane z = 0; the radius is 1.
        let size = |u: f64| 0.1 * 300.0_f64.powf(u);
        let (edge_u, edge_v) = (dvec2(size(u[0]), 0.0), dvec2((u[2] - 0.5) * size(u[0]), size(u[1])));
        let near = |u: f64| if u < 0.2 { 0.0 } else { (u - 0.2) / 0.8 * 0.999 };
        let place = near(u[3]) * edge_u + near(u[4]) * edge_v;
        let corners = [-place, edge_u - place, edge_u + edge_v - place, edge_v - place];
        receivers.push(Receiver::parallelogram(DVec3::ZERO, edge_u.extend(0.0), edge_v.extend(0.0)));
        points.push([place.x as f32, place.y as f32, 0.0, 0.0]);
        for (kernel, expected) in KERNELS.iter().zip(&mut expected) {
            expected.push(mass_inside(kernel.weight, |angle| reach(&corners, angle)));
        }

        let (radius, from_centre) = (size(u[5]), size(u[5]) * near(u[6]).sqrt());
        let reach = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            ((radius.powi(2) - (from_centre * sin).powi(2)).sqrt() - from_centre * cos).max(0.0)
        };
        receivers.push(Receiver::disk(DVec3::ZERO, DVec3::Z, radius));
        points.push([from_centre as f32, 0.0, 0.0, 0.0]);
        for (kernel, expected) in KERNELS.iter().zip(&mut expected) {
            expected.push(mass_inside(kernel.weight, reach));
        }
    }
    let [receivers_, points_] = [
        Buffer::from_slice(&device, bytemuck::cast_slice::<Receiver, [f32; 4]>(&receivers)).unwrap(),
        Buffer::from_slice(&device, &points).unwrap(),
    ];
    let out = Buffer::<f32>::zeroed(&device, points.len()).unwrap();
    for (kernel, expected) in KERNELS.iter().zip(&expected) {
        let spec = corrected(kernel.weighting).define(ProgramSpec::new("caustics/edges.cl"), device.info());
        let probe = "__kernel void probe(__global const struct Receiver *receivers, __global const float4 *points,\n\
            __global float *out, uint count) {\nuint i = (uint)get_global_id(0);\nif (i >= count) return;\n\
            out[i] = kernel_mass(receivers + i, points[i].xyz, (float3)(0.0f, 0.0f, 1.0f), 1.0f);\n}\n";
        let program = Program::build_probe(&device, &spec, probe).unwrap();
        let arguments =
            [(&receivers_).into(), (&points_).into(), (&out).into(), (points.len() as u32).into()];
        program.kernel(&device, "probe").unwrap().run(&device, &arguments, points.len()).unwrap();
        for (i, (found, expected)) in out.read(&device).unwrap().iter().zip(expected).enumerate() {
            // Gauss's rule on disks, and the twin: 1e-5 each. Points of float32 up to 30 radii from the origin, whose distances from edges
            // take a few roundings more, against edges of kernels that fall by at most 2 per radius.
            let bound = 1e-5 * expected + 1e-5 + 2.0 * 8.0 * 30.0 * EPS;
            let what = format!("{:?}, {:?} at {:?}", kernel.weighting, receivers[i], points[i]);
            common::close(&what, f64::from(*found), *expected, bound);
        }
    }
}
