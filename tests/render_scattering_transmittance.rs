//! The estimators of transmittance: their means along ramps, and their variances in a homogeneous medium.
//!
//! One number at a time: a camera ray runs along y through a medium that does not change along y and is so deep (40
//! free paths) that it always scatters, once. The way from there to a parallel light in the xz-plane is the same wherever
//! that was, so with E = 4π every sample of a pixel is one estimate of that way's transmittance and nothing else.

mod common;

use common::scattering::{Measured, all_finite, family, over_pixels, rows};
use common::{Case, EPS, volume_f32};
use glam::DVec3;
use std::f64::consts::PI;
use svetlo::film::FilmPixel;
use svetlo::reference::camera::Ray;

const SIDE: u32 = 256;
const ESTIMATORS: [&str; 5] = ["auto", "analog", "ratio", "residual-ratio", "ray-marching"];

/// A medium of 1 × `depth` × 1 whose extinction is `sigmas` at the voxels along z, seen along y through (x, z), under
/// light that travels along `light` (x, z).
fn ways(sigmas: &[f64], depth: f64, place: [f64; 2], light: [f64; 2], method: &str) -> Case {
    let most = sigmas.iter().fold(0.0_f64, |a, &b| a.max(b));
    let [x, z] = place;
    let text = format!(
        "[image]\nwidth = {SIDE}\nheight = {SIDE}\nfilter = \"point\"\n[camera]\nkind = \"orthographic\"\n\
         position = [{x}, -1, {z}]\ntarget = [{x}, 0, {z}]\nup = [0, 0, 1]\nheight = 1e-6\n\
         [volume]\nspacing = [1, {depth}, {}]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = {most}\n\
         [transfer]\nresolution = 2\n[[light]]\nkind = \"directional\"\ndirection = [{}, 0, {}]\nirradiance = {}\n\
         [method]\nkind = \"single-scattering\"\npaths = 1\n{method}\n",
        1.0 / sigmas.len() as f64,
        light[0],
        light[1],
        4.0 * PI
    );
    Case::new(&text, volume_f32([1, 1, sigmas.len()], sigmas.iter().map(|sigma| sigma / most)))
}

fn with(estimator: &str, scale: f64) -> String {
    format!("transmittance = \"{estimator}\"\nmajorant_scale = {scale}")
}

/// Variance of the pixels of a film, and its standard error.
fn spread(film: &[FilmPixel]) -> Measured {
    let values: Vec<f64> = film.iter().map(|pixel| pixel.mean()[1]).collect();
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let moment = |power: i32| values.iter().map(|x| (x - mean).powi(power)).sum::<f64>() / count;
    let (second, fourth) = (moment(2), moment(4));
    Measured { value: second * count / (count - 1.0), error: ((fourth - second * second) / count).sqrt() }
}

/// σ for an optical depth `tau` from the middle of the box to its top, and the box's depth.
fn homogeneous(tau: f64, estimator: &str, scale: f64) -> Case {
    ways(&[2.0 * tau; 2], 20.0 / tau, [0.5, 0.5], [0.0, -1.0], &with(estimator, scale))
}

#[test]
fn variances_in_a_homogeneous_medium_are_as_published() {
    let table = rows("estimator_variance");
    let k = family(6 * table.len());
    for row in &table {
        let [tau, scale, mean, ratio, delta] = ["sigma_d", "m_over_sigma", "mean", "var_ratio", "var_delta"]
            .map(|key| row[key].as_f64().unwrap());
        for (estimator, variance) in [("ratio", ratio), ("analog", delta)] {
            let what = format!("{estimator}, optical depth {tau}, majorant {scale}");
            let case = homogeneous(tau, estimator, scale);
            // The first samples of the pixels are independent of each other.
            let mut session = case.session();
            session.render(1).unwrap();
            let film = session.film().unwrap();
            over_pixels(&film, 1).agrees(&format!("{what}: mean"), mean, k, 64.0 * EPS);
            // The majorant is inflated by a few roundings; height of the picture: 10⁻⁶ of the way.
            spread(&film).agrees(&format!("{what}: variance over pixels"), variance, k, 1e-5 * variance);
            assert!(
                estimator != "analog"
                    || film.iter().all(|p| [0.0, 1.0].iter().any(|x| (p.mean()[1] - x).abs() < 1e-6)),
                "{what}: yes or no"
            );
            // What `variance.G` says: stratified samples lie apart, at most n/(n − 1) of independent ones.
            session.render(8).unwrap();
            let film = session.film().unwrap();
            all_finite(&film);
            let values: Vec<f64> = film.iter().map(|pixel| pixel.variance().unwrap()[1]).collect();
            let own = common::scattering::of_values(&values);
            let nearest = own.value.clamp(variance, variance * 8.0 / 7.0);
            own.agrees(&format!("{what}: variance of pixels"), nearest, k, 1e-5 * variance);
        }
    }
}

#[test]
fn homogeneous_media_are_free_of_noise_where_a_control_takes_all() {
    for tau in [1e-3, 0.5, 4.0, 60.0] {
        let film = homogeneous(tau, "residual-ratio", 1.0).film_of(2);
        all_finite(&film);
        for pixel in film {
            // The depth is a sum of at most 8 rounded parts, and so is e^{−τ} relatively by τ as much; the majorant is
            // inflated by 10⁻⁶, and the rest is tracked.
            let relative = pixel.mean()[1] / (-tau).exp() - 1.0;
            assert!(relative.abs() < 2e-6 * (1.0 + tau) + 8.0 * EPS, "{tau}: {relative:e}");
        }
    }
}

#[test]
fn ramps_transmit_as_published() {
    // σ = 1 + 4z on n voxels of the unit cube: constant beyond the outer voxels' centres.
    let table = rows("ramp_transmittance");
    let (edge, slope) = (1e-5, 5e-5);
    // Where a camera ray starts the way, and how light comes along it. Ways that start on a face start 10⁻⁵ inside it:
    // optical depths smaller by 5·10⁻⁵ at most.
    let ways_to = [
        ([0.5, edge], [0.0, -1.0]),
        ([0.5, 0.5], [0.0, -1.0]),
        ([0.5, 0.25], [0.0, 1.0]),
        ([edge, 0.1], [-1.0, -0.6]),
    ];
    let k = family(table.len() * 3 * ESTIMATORS.len());
    for (row, (place, light)) in table.iter().zip(ways_to) {
        for n in [4, 16, 64] {
            let exact = row[format!("T_N{n}")].as_f64().unwrap();
            let sigmas: Vec<f64> = (0..n).map(|i| 1.0 + 4.0 * (f64::from(i) + 0.5) / f64::from(n)).collect();
            for estimator in ESTIMATORS {
                let film = ways(&sigmas, 40.0, place, light, &with(estimator, 1.0)).film_of(8);
                let what = format!("{}, {n} voxels, {estimator}", row["ray"].as_str().unwrap());
                // Float32 positions of 64 cells: 64 roundings of a depth of 3.
                over_pixels(&film, 1).agrees(&what, exact, k, (slope + 64.0 * 3.0 * EPS) * exact);
            }
        }
    }
}

#[test]
fn estimators_agree_across_bricks_that_differ() {
    // Bricks of 8 cells with extinctions from 0 to 6: majorants that do not bound each other.
    let levels = [0.0, 6.0, 0.5, 3.0, 0.0, 1.0];
    let sigmas: Vec<f64> = (0..48).map(|i| levels[i / 8]).collect();
    let exact_depth = {
        let case = ways(&sigmas, 40.0, [0.5, 0.25], [0.0, -1.0], "");
        let twin = common::scattering::Twin::new(&case);
        let way = Ray { origin: DVec3::new(0.5, 20.0, 0.25), direction: DVec3::Z, start: 0.0 };
        twin.tracer().depth(&way)
    };
    for estimator in ESTIMATORS {
        for scale in [1.0, 3.0] {
            let film = ways(&sigmas, 40.0, [0.5, 0.25], [0.0, -1.0], &with(estimator, scale)).film_of(8);
            let what = format!("bricks, {estimator}, {scale}");
            let exact = (-exact_depth).exp();
            over_pixels(&film, 1).agrees(&what, exact, family(10), (2e-6 + 48.0 * 3.0 * EPS) * exact);
        }
    }
}
