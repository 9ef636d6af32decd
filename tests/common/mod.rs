//! What the tests that need a device share: scenes from text, volumes from numbers, renders, twins.
//!
//! Each test file uses a part of this.
#![allow(dead_code)]

pub mod scattering;

use glam::DVec3;
use rayon::prelude::*;
use std::path::Path;
use svetlo::device::{Catalog, Device};
use svetlo::film::FilmPixel;
use svetlo::reference::camera::{Ray, central_ray};
use svetlo::reference::emission_absorption::{Integrator, Stretch};
use svetlo::reference::field::Field;
use svetlo::reference::medium::Medium;
use svetlo::reference::random::{philox4x32, uniform};
use svetlo::render::{BRICK_SHIFT, Plan, Session};
use svetlo::scene::Scene;
use svetlo::volume::{Volume, Voxels};

/// Half a unit in the last place of a float32 near 1: the relative error of one operation.
pub const EPS: f64 = 1.0 / (1 << 24) as f64;

/// Opens the device that `SVETLO_DEVICE` selects, or the default one.
pub fn device() -> Device {
    let selector = std::env::var("SVETLO_DEVICE").ok();
    Device::open(Catalog::enumerate().select(selector.as_deref()).unwrap()).unwrap()
}

/// A scene from its text. `[volume]` may say only where the box lies: tests bring the voxels themselves.
pub fn scene(text: &str) -> Scene {
    let text = text.replace("[volume]", "[volume]\nfield = { kind = \"constant\" }\ndims = [1, 1, 1]");
    let loaded = svetlo::config::parse("test.toml", &text, &[]).unwrap_or_else(|e| panic!("{e}\n{text}"));
    Scene::from_loaded(&loaded, Path::new(env!("CARGO_MANIFEST_DIR")))
        .unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// A scene with its volume, ready to be rendered and to be followed by the twins.
pub struct Case {
    /// The scene.
    pub scene: Scene,
    /// The voxels.
    pub volume: Volume,
}

impl Case {
    /// A scene text and its voxels.
    pub fn new(text: &str, volume: Volume) -> Self {
        Self { scene: scene(text), volume }
    }

    /// The plan with the usual bricks.
    pub fn plan(&self) -> Plan<'_> {
        Plan::new(&self.scene, &self.volume, BRICK_SHIFT).unwrap()
    }

    /// A session on the test device.
    pub fn session(&self) -> Session {
        Session::new(device(), &self.plan()).unwrap()
    }

    /// The film of one sample per pixel.
    pub fn film(&self) -> Vec<FilmPixel> {
        self.film_of(1)
    }

    /// The film of some samples per pixel.
    pub fn film_of(&self, samples: u32) -> Vec<FilmPixel> {
        let mut session = self.session();
        session.render(samples).unwrap();
        session.film().unwrap()
    }

    /// The field as the twin sees it.
    pub fn field(&self) -> Field {
        let plan = self.plan();
        Field::new(
            &self.volume,
            plan.local.origin,
            plan.local.spacing * plan.local.unit,
            plan.volume().unwrap().window,
        )
    }

    /// The transfer function as the twin sees it.
    pub fn medium(&self) -> Medium {
        let plan = self.plan();
        Medium::new(&self.scene.transfer, &self.scene.medium, plan.volume().unwrap().window, plan.local.unit)
            .unwrap()
    }

    /// The rays through the pixels' centres, row by row.
    pub fn rays(&self) -> Vec<Ray> {
        let image = self.scene.image;
        let pixels = (0..image.height).flat_map(|y| (0..image.width).map(move |x| [x, y]));
        pixels.map(|pixel| central_ray(&self.scene.camera, &image, pixel)).collect()
    }

    /// Emission and absorption along the rays through the pixels' centres, without background.
    pub fn stretches(&self) -> Vec<Stretch> {
        stretches(&self.field(), &self.medium(), &self.rays())
    }
}

/// Emission and absorption along rays.
pub fn stretches(field: &Field, medium: &Medium, rays: &[Ray]) -> Vec<Stretch> {
    let integrator = Integrator::new(field, medium);
    rays.par_iter().map(|ray| integrator.ray(ray)).collect()
}

/// Uniform numbers in [0, 1), the same in every run.
pub fn noise(count: usize, seed: u32) -> Vec<f64> {
    (0..count as u32).map(|i| uniform(philox4x32([i, seed, 0, 0], [0x5eed, 0])[0])).collect()
}

/// A volume of float32 voxels of spacing 1.
pub fn volume_f32(dims: [usize; 3], values: impl IntoIterator<Item = f64>) -> Volume {
    let values: Vec<f32> = values.into_iter().map(|v| v as f32).collect();
    Volume::new(dims, DVec3::ONE, Voxels::F32(values)).unwrap()
}

/// Independent voxels between 0 and 1: the roughest field there is.
pub fn noisy(dims: [usize; 3], seed: u32) -> Volume {
    volume_f32(dims, noise(dims.iter().product(), seed))
}

/// A sum of waves of a few voxels' length, between 0 and 1.
pub fn smooth(dims: [usize; 3], seed: u32) -> Volume {
    let waves = noise(12, seed);
    let [nx, ny, nz] = dims;
    let value = move |x: usize, y: usize, z: usize| {
        let wave = |k: usize| {
            let phase = waves[4 * k..4 * k + 3].iter().zip([x, y, z]);
            let phase: f64 = phase.map(|(w, i)| (w - 0.5) * i as f64).sum();
            (phase + 6.0 * waves[4 * k + 3]).sin()
        };
        0.5 + (0..3).map(wave).sum::<f64>() / 6.0
    };
    let indices = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| (x, y, z))));
    volume_f32(dims, indices.map(|(x, y, z)| value(x, y, z)))
}

/// Asserts |found − expected| ≤ bound, naming the place.
#[track_caller]
pub fn close(what: &str, found: f64, expected: f64, bound: f64) {
    let error = (found - expected).abs();
    assert!(
        error <= bound,
        "{what}: found {found}, expected {expected}: error {error:.3e} > bound {bound:.3e}"
    );
}

/// Slope of the straight line through (ln x, ln y) by least squares.
pub fn log_slope(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let count = logs.len() as f64;
    let mean_x = logs.iter().map(|p| p.0).sum::<f64>() / count;
    let mean_y = logs.iter().map(|p| p.1).sum::<f64>() / count;
    let covariance: f64 = logs.iter().map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum();
    covariance / logs.iter().map(|p| (p.0 - mean_x).powi(2)).sum::<f64>()
}

/// Root mean square.
pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values.into_iter().fold((0.0, 0.0), |(s, n), v| (s + v * v, n + 1.0));
    f64::sqrt(sum / count)
}

/// The largest.
pub fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, f64::max)
}

/// Prints a measured error beside its tolerance (seen with `--nocapture`).
pub fn report(what: &str, error: f64, bound: f64) {
    println!("{what}: {error:.2e} of {bound:.2e}");
}
