//! What the tests of light sampling share: lit scenes, probes, maps, random numbers.
//!
//! Each test file uses a part of this.
#![allow(dead_code)]

use super::common::{self, EPS, close, noise, report};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use std::f64::consts::TAU;
use std::path::Path;
use svetlo::device::{Buffer, Program, ProgramSpec};
use svetlo::picture::Environment;
use svetlo::reference::lights::Sky;
use svetlo::reference::random::{philox4x32, uniform};
use svetlo::render::lights::Lights;
use svetlo::render::local::LocalFrame;
use svetlo::render::method::DeviceFrame;
use svetlo::scene::{Background, EnvironmentSampling, Light};

/// A lit scene: lights, and a map with its rotation.
pub struct Lit {
    pub lights: Vec<Light>,
    pub map: Option<Environment>,
    pub background: Background,
    pub local: LocalFrame,
}

pub const INTENSITY: f64 = 1.5;
pub const ROTATION: f64 = 2.0;

/// What every probe gives for each point (or origin) and each four numbers (or direction).
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Found {
    pub direction: [f32; 4],
    pub weight: [f32; 4],
    pub distance: f32,
    pub pdf: f32,
    pad: [f32; 2],
}

impl Lit {
    /// In a box of 10×8×6 voxels of 0.5 whose corner is at (3, −2, 1).
    pub fn new(lights: Vec<Light>, map: Option<Environment>) -> Self {
        let background = map.as_ref().map_or(Background::Constant([1.0; 3]), |_| Background::Environment {
            path: "unread".into(),
            intensity: INTENSITY,
            rotation: ROTATION,
            sampling: EnvironmentSampling::Importance,
        });
        let local = LocalFrame::new(DVec3::new(3.0, -2.0, 1.0), DVec3::splat(0.5), [10, 8, 6]);
        Self { lights, map, background, local }
    }

    pub fn sky(&self) -> Option<Sky<'_>> {
        self.map.as_ref().map(|map| Sky { map, intensity: INTENSITY, rotation: ROTATION })
    }

    pub fn table(&self) -> Lights {
        Lights::new(&self.lights, &self.background, self.map.as_ref(), &self.local)
    }

    /// Runs `body`, which sets `found` from `frame, lights, sums, map, a, b`.
    pub fn probe(&self, body: &str, pairs: &[[[f32; 4]; 2]]) -> Vec<Found> {
        let device = common::device();
        let table = self.table();
        let kernel = format!(
            "struct Found {{ float4 direction, weight; float distance, pdf; float pad[2]; }};\n\
             __kernel void probe(__constant struct Frame *frame, __global const struct Light *lights,\n\
             __global const float *sums, __global const float4 *map, __global const float4 *in,\n\
             __global struct Found *out, uint count) {{\n\
             size_t i = get_global_id(0);\nif (i >= count) return;\nfloat4 a = in[2 * i];\nfloat4 b = in[2 * i + 1];\n\
             struct LightSample found;\nfound.direction = found.weight = (float4)(0.0f);\n\
             found.distance = found.pdf = 0.0f;\n{body}\n\
             out[i].direction = found.direction;\nout[i].weight = found.weight;\n\
             out[i].distance = found.distance;\nout[i].pdf = found.pdf;\n}}\n"
        );
        let spec = ProgramSpec::new("lights/sample.cl")
            .feature("ENVIRONMENT", self.map.is_some())
            .feature("RECTANGLES", table.has_rectangles());
        let program = Program::build_probe(&device, &spec, &kernel).unwrap();
        let mut frame = DeviceFrame::zeroed();
        let mut texels = vec![[0.0_f32; 4]];
        if let Some(map) = &self.map {
            frame.background = [INTENSITY as f32; 4];
            (frame.environment_width, frame.environment_height) = (map.width as u32, map.height as u32);
            frame.environment_turn = (ROTATION / TAU) as f32;
            texels = map.rgb.iter().map(|c| [c[0], c[1], c[2], 0.0]).collect();
        }
        table.describe(&mut frame);
        let [lights, sums] = table.buffers();
        let frame = Buffer::from_slice(&device, &[frame]).unwrap();
        let lights = Buffer::from_slice(&device, &lights.bytes).unwrap();
        let sums = Buffer::from_slice(&device, &sums.bytes).unwrap();
        let texels = Buffer::from_slice(&device, &texels).unwrap();
        let input = Buffer::from_slice(&device, pairs).unwrap();
        let output = Buffer::<Found>::zeroed(&device, pairs.len()).unwrap();
        let arguments = [
            (&frame).into(),
            (&lights).into(),
            (&sums).into(),
            (&texels).into(),
            (&input).into(),
            (&output).into(),
            (pairs.len() as u32).into(),
        ];
        program.kernel(&device, "probe").unwrap().run(&device, &arguments, pairs.len()).unwrap();
        output.read(&device).unwrap()
    }

    /// Samples as seen from points in scene units.
    pub fn samples(&self, pairs: &[(DVec3, [f64; 3])]) -> Vec<Found> {
        let pairs: Vec<_> = pairs
            .iter()
            // Points bring a w of their own.
            .map(|(point, u)| [float4(self.local.point(*point), 1.0), u.map(|u| u as f32).extend(0.0)])
            .collect();
        self.probe("found = light_sample(frame, lights, sums, map, a, b);", &pairs)
    }

    /// What a ray from a point in scene units finds: density of the sky in `pdf`, weighted rectangles in `weight`.
    pub fn rays(&self, pairs: &[(DVec3, DVec3)], t_max: &str, phase_pdf: &str) -> Vec<Found> {
        let pairs: Vec<_> = pairs
            .iter()
            .map(|(point, direction)| [float4(self.local.point(*point), 1.0), float4(*direction, 0.0)])
            .collect();
        let sky = if self.map.is_some() { "found.pdf = environment_pdf(frame, sums, b);\n" } else { "" };
        let body = format!(
            "{sky}for (uint i = 0; i < frame->rectangle_count; ++i) {{\n\
             float t = rectangle_distance(lights + i, a, b, 0.0f);\n\
             if (t < {t_max}) found.weight += rectangle_radiance(lights + i, b, t, {phase_pdf}); }}"
        );
        self.probe(&body, &pairs)
    }
}

pub trait Extend4 {
    fn extend(self, w: f32) -> [f32; 4];
}

impl Extend4 for [f32; 3] {
    fn extend(self, w: f32) -> [f32; 4] {
        [self[0], self[1], self[2], w]
    }
}

pub fn float4(v: DVec3, w: f32) -> [f32; 4] {
    v.to_array().map(|x| x as f32).extend(w)
}

pub fn vector(v: [f32; 4]) -> DVec3 {
    DVec3::new(v[0].into(), v[1].into(), v[2].into())
}

/// `count` times three uniform numbers.
pub fn numbers(count: u32, seed: u32) -> impl Iterator<Item = [f64; 3]> {
    (0..count).map(move |i| {
        let [a, b, c, _] = philox4x32([i, seed, 0, 0], [0x11947, 0]).map(uniform);
        [a, b, c]
    })
}

/// Directions uniform over the sphere.
pub fn directions(count: u32, seed: u32) -> impl Iterator<Item = DVec3> {
    numbers(count, seed).map(|[a, b, _]| {
        let (cosine, azimuth) = (1.0 - 2.0 * a, TAU * b);
        let sine = (1.0 - cosine * cosine).sqrt();
        DVec3::new(sine * azimuth.cos(), cosine, sine * azimuth.sin())
    })
}

/// Mean and its standard deviation.
pub fn mean_and_sigma(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let (n, sum, squares) =
        values.into_iter().fold((0.0, 0.0, 0.0), |(n, s, q), v| (n + 1.0, s + v, q + v * v));
    let mean: f64 = sum / n;
    (mean, ((squares / n - mean * mean).max(0.0) / n).sqrt())
}

/// Five standard deviations: one run in 1.7 million fails by chance, and the numbers are the same in every run.
#[track_caller]
pub fn within_sigmas(what: &str, values: impl IntoIterator<Item = f64>, expected: f64) {
    let (mean, sigma) = mean_and_sigma(values);
    // Rounding of single values, where they do not scatter.
    let bound = 5.0 * sigma + 64.0 * EPS * expected.abs();
    report(what, (mean - expected).abs(), bound);
    close(what, mean, expected, bound);
}

pub fn environment(width: usize, height: usize, texel: impl Fn(usize, usize) -> [f32; 3]) -> Environment {
    let rgb = (0..width * height).map(|i| texel(i % width, i / width)).collect();
    Environment { width, height, rgb, notes: Vec::new() }
}

/// Channels over five orders of magnitude, some of them 0.
pub fn hdr(width: usize, height: usize, seed: u32) -> Environment {
    let values = noise(3 * width * height, seed);
    let value = |i: usize| if values[i] < 0.2 { 0.0 } else { 10_f32.powf(6.0 * values[i] as f32 - 3.0) };
    environment(width, height, |x, y| {
        let i = 3 * (y * width + x);
        [value(i), value(i + 1), value(i + 2)]
    })
}

pub fn spot(width: usize, height: usize, at: [usize; 2]) -> Environment {
    environment(width, height, |x, y| if [x, y] == at { [100.0, 50.0, 25.0] } else { [0.0; 3] })
}

pub fn studio() -> Environment {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/data/studio_512x256.exr");
    Environment::read(&file).unwrap()
}

pub fn maps() -> Vec<(String, Environment)> {
    let mut maps = vec![
        ("constant".into(), environment(6, 4, |_, _| [0.25, 0.5, 1.0])),
        ("spot".into(), spot(16, 8, [5, 3])),
        ("spot in the first row".into(), spot(16, 8, [0, 0])),
        ("spot in the last row".into(), spot(15, 9, [14, 8])),
        ("random".into(), hdr(32, 16, 1)),
    ];
    for (width, height) in [(1, 1), (1, 7), (9, 1), (2, 2), (3, 5)] {
        maps.push((format!("{width}×{height}"), hdr(width, height, 2)));
    }
    maps
}

/// One of each kind, at the box and far from it.
pub fn every_light() -> Vec<Light> {
    vec![
        Light::Point { position: DVec3::new(4.0, 1.0, 2.0), intensity: [1.0, 2.0, 3.0] },
        Light::Directional { direction: DVec3::new(1.0, -2.0, 0.5), irradiance: [3.0, 2.0, 0.0] },
        Light::Rectangle {
            centre: DVec3::new(5.0, 4.0, 3.0),
            edge_u: DVec3::new(2.0, 0.0, 0.5),
            edge_v: DVec3::new(0.3, 0.2, 3.0),
            radiance: [1.0, 0.5, 2.0],
        },
        Light::Point { position: DVec3::new(0.0, 0.0, 0.0), intensity: [0.0; 3] },
        Light::Point { position: DVec3::new(-20.0, 9.0, 30.0), intensity: [900.0, 800.0, 700.0] },
        Light::Rectangle {
            centre: DVec3::new(6.0, -1.0, 2.0),
            edge_u: DVec3::new(0.0, 1.0, 0.0),
            edge_v: DVec3::new(0.0, 0.0, 1.0),
            radiance: [4.0; 3],
        },
    ]
}

/// Points inside the box.
pub fn points(local: &LocalFrame, count: u32, seed: u32) -> Vec<DVec3> {
    let size = local.size() * local.unit;
    numbers(count, seed).map(|u| local.origin + size * DVec3::from_array(u)).collect()
}
