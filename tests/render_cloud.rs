//! The transmittance of the cloud, the scene of the accuracy and speed comparisons.

mod common;

use common::{Case, EPS, report, rms};
use svetlo::volume::{Volume, field};

/// The scene of the bench without its volume, every ray followed to its end; the method is its last table.
fn scene() -> String {
    let text = include_str!("../benches/scenes/cloud.toml");
    let volume = |line: &&str| line.starts_with("field =") || line.starts_with("dims =");
    text.lines().filter(|line| !volume(line)).chain(["termination = 0", ""]).collect::<Vec<_>>().join("\n")
}

fn cloud() -> Volume {
    let mut volume = field::sample(&field::Cloud, [128; 3]).unwrap();
    volume.spacing /= 128.0;
    volume
}

#[test]
fn its_mean_is_the_exact_one() {
    // The exact integral in every cell in float64, at 256² pixel centres, has the mean 0.85082197 (given to 8 digits).
    let film = Case::new(&scene(), cloud()).film();
    assert_eq!(film.len(), 256 * 256);
    let mean = film.iter().map(|pixel| pixel.mean()[1]).sum::<f64>() / film.len() as f64;
    // Half a digit, and the roundings of a pixel (see below), which hardly average out where they are systematic.
    let bound = 0.5e-8 + 4.0 * EPS;
    report("cloud, mean", (mean - 0.850_821_97).abs(), bound);
    assert!((mean - 0.850_821_97).abs() < bound, "{mean}");
}

#[test]
fn every_pixel_follows_the_twin() {
    let scene = scene().replace("width = 256", "width = 32").replace("height = 256", "height = 32");
    // Two entries are the same straight line as many, and the twin cuts its cells at every entry.
    let scene = scene.replace("points = [", "resolution = 2\npoints = [");
    let case = Case::new(&scene, cloud());
    let film = case.film();
    let stretches = case.stretches();
    let errors = film.iter().zip(&stretches).map(|(pixel, exact)| pixel.mean()[1] - exact.transmittance());
    // A ray crosses up to 150 cells. In each, places near 130 grid units round by 130·EPS, the optical depth changes by
    // at most 0.03 a voxel over a voxel, and 8 roundings of at most 0.3 follow; errors of cells are independent.
    let bound = 150.0_f64.sqrt() * (130.0 * 0.03 + 8.0 * 0.3) * EPS;
    let error = rms(errors);
    report("cloud, RMS against the twin", error, bound);
    assert!(error < bound, "{error} > {bound}");
    assert!(stretches.iter().any(|exact| exact.transmittance() < 0.1), "some rays are nearly blocked");
}
