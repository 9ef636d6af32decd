//! What the tests of convection share: both forms of a medium's light, their twin, boxes and lights of every kind.
//!
//! Each test file uses a part of this.
#![allow(dead_code)]

use crate::cells::Medium;
use crate::common::{self, EPS};
use glam::DVec3;
use svetlo::device::Device;
use svetlo::irradiance::{Carrying, Convection, SteadyLight, steady_light};
use svetlo::reference::convection::{Convection as Twin, Source};
use svetlo::scene::Light;

pub const GREY: Carrying = Carrying { chromatic: false, mean_cosine: 0.0, directed: false };
pub const CHROMATIC: Carrying = Carrying { chromatic: true, ..GREY };

/// Roundings of a steady cell, relative: each rate has those of the direction (offset, squares, root, quotient, the last
/// two up to 3 ulps), sums and the quotient of both add theirs.
pub const SETTLED: f64 = 54.0 * EPS;
/// Roundings of an explicit step, in units of the largest share, 1: rates (20), differences and sums (9), exp (3 ulps and
/// its argument), the product.
pub const STEPPED: f64 = 40.0 * EPS;
/// What light has not crossed the box by then.
pub const CROSSED: f64 = 3.36e-4; // e^-8

pub fn parallel(direction: DVec3) -> Light {
    Light::Directional { direction: direction.normalize(), irradiance: [1.0, 2.0, 0.5] }
}

pub fn point(medium: &Medium, local: DVec3) -> Light {
    Light::Point { position: medium.point(local), intensity: [1.0, 2.0, 0.5] }
}

pub fn source(medium: &Medium, light: &Light) -> Source {
    match *light {
        Light::Directional { direction, .. } => Source::Parallel(direction),
        Light::Point { position, .. } => Source::Point(medium.local.point(position)),
        Light::Rectangle { .. } => unreachable!("no rectangles here"),
    }
}

/// The device, opened once by each test's thread.
pub fn device() -> &'static Device {
    thread_local!(static DEVICE: &'static Device = Box::leak(Box::new(common::device())));
    DEVICE.with(|device| *device)
}

pub fn steady(medium: &Medium, lights: &[Light], carrying: Carrying) -> SteadyLight {
    let device = device();
    steady_light(device, &medium.grid, &medium.cells(device), lights, &medium.local, carrying).unwrap()
}

pub fn steady_fluence(medium: &Medium, lights: &[Light], carrying: Carrying) -> Vec<[f32; 4]> {
    steady(medium, lights, carrying).direct.fluence.read(device()).unwrap()
}

pub fn explicit(
    medium: &Medium,
    lights: &[Light],
    carrying: Carrying,
    courant: f64,
    steps: u32,
) -> Vec<[f32; 4]> {
    let device = device();
    let cells = medium.cells(device);
    let mut convection =
        Convection::new(device, &medium.grid, &cells, lights, &medium.local, carrying, courant).unwrap();
    // In two parts, with a look in between: the same steps.
    convection.advance(device, steps / 3).unwrap();
    convection.direct(device).unwrap();
    convection.advance(device, steps - steps / 3).unwrap();
    assert_eq!(convection.steps(), u64::from(steps));
    convection.direct(device).unwrap().fluence.read(device).unwrap()
}

/// The fluence that a light of full share would bring, per channel: E, or I/r² beyond the cell's own mean.
pub fn unattenuated(medium: &Medium, light: &Light, i: usize) -> [f64; 3] {
    match *light {
        Light::Directional { irradiance, .. } => irradiance,
        Light::Point { position, intensity } => {
            let volume = medium.grid.cell.element_product();
            let ball = (0.75 * volume / std::f64::consts::PI).cbrt();
            let centre =
                (medium.centre(i) - medium.local.point(position)).length_squared().max(ball * ball / 3.0);
            let r2 = twin(medium, 0, 1.0).held_distance2(source(medium, light), i).unwrap_or(centre);
            intensity.map(|intensity| intensity / (r2 * medium.local.unit.powi(2)))
        }
        Light::Rectangle { .. } => unreachable!("no rectangles here"),
    }
}

/// Shares of one channel.
pub fn shares(medium: &Medium, light: &Light, fluence: &[[f32; 4]], channel: usize) -> Vec<f64> {
    let share = |(i, f): (usize, &[f32; 4])| f64::from(f[channel]) / unattenuated(medium, light, i)[channel];
    fluence.iter().enumerate().map(share).collect()
}

pub fn twin(medium: &Medium, channel: usize, counted: f64) -> Twin {
    let grid = &medium.grid;
    Twin { dims: grid.dims, cell: grid.cell, extinction: medium.extinction(channel, counted) }
}

/// Boxes with odd sizes, unlike edges, and one cell thick.
pub fn boxes() -> [([usize; 3], DVec3); 5] {
    [
        ([7, 9, 5], DVec3::ONE),
        ([12, 5, 11], DVec3::new(1.0, 1.3, 1.7)),
        ([1, 13, 8], DVec3::new(2.0, 1.0, 1.5)),
        ([19, 1, 1], DVec3::ONE),
        ([1, 1, 1], DVec3::new(1.0, 3.0, 1.2)),
    ]
}

/// Lights from everywhere: along axes, oblique, points near, far, level with the box, in it and in its corner.
pub fn lights(medium: &Medium) -> Vec<Light> {
    let size = medium.grid.cell * DVec3::from_array(medium.grid.dims.map(|n| n as f64));
    let at = |x: f64, y: f64, z: f64| point(medium, (size * DVec3::new(x, y, z) * 8.0).round() / 8.0);
    vec![
        parallel(DVec3::NEG_Y),
        parallel(DVec3::new(0.0, 0.6, -0.8)),
        parallel(DVec3::new(-1.0, 2.0, 3.0)),
        at(0.5, 0.5, 0.5),
        at(0.2, 0.9, 0.4),
        at(0.0, 0.0, 0.0),
        at(0.3, 0.6, 1.4),
        at(-2.0, 0.4, -1.0),
        at(40.0, -30.0, 50.0),
    ]
}
