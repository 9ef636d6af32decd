//! The fluence of light volumes against multiple scattering, where diffusion is right: deep in thick media of high albedo.

mod common;

use common::{Case, device};
use std::f64::consts::PI;
use svetlo::irradiance::LightData;
use svetlo::render::Session;

/// A cube of 32³ voxels and 20 mean free paths, whose channels differ in albedo, in oblique light.
fn scene(camera: &str, rest: &str) -> String {
    format!(
        "[image]\nwidth = {PIXELS}\nheight = {PIXELS}\n[camera]\n{camera}\n[volume]\nwindow = {{ lo = 0, hi = 1 }}\n\
         [medium]\nsigma_max = 0.625\n[transfer]\n\
         points = [{{ value = 0.5, opacity = 1, color = [0.999, 0.997, 0.99] }}]\n\
         [[light]]\nkind = \"directional\"\ndirection = [2, -3, 1]\nirradiance = 10\n{rest}"
    )
}

/// Pixels along an edge of each of the six faces of a cube about a point.
const PIXELS: usize = 12;
const SAMPLES: u32 = 24;

fn case(camera: &str, rest: &str) -> Case {
    Case::new(&scene(camera, rest), common::volume_f32([32; 3], vec![0.8; 32 * 32 * 32]))
}

/// Fluence of scattered light at a point and its standard error, per channel: ∫ L dω by multiple scattering, from six
/// views of 90° whose pixels have the solid angles (2/n)² / (1 + u² + v²)^{3/2}.
fn transported(point: [f64; 3], phase: &str) -> [[f64; 2]; 3] {
    let mut sums = [[0.0; 2]; 3];
    let mut solid = 0.0;
    for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0)] {
        let mut target = point;
        target[axis] += sign;
        let up = if axis == 1 { [1, 0, 0] } else { [0, 1, 0] };
        let camera = format!("position = {point:?}\ntarget = {target:?}\nup = {up:?}\nfov = 90");
        let film =
            case(&camera, &format!("{phase}[method]\nkind = \"multiple-scattering\"\n")).film_of(SAMPLES);
        for (i, pixel) in film.iter().enumerate() {
            let place = |i: usize| (2 * i + 1) as f64 / PIXELS as f64 - 1.0;
            let (u, v) = (place(i % PIXELS), place(i / PIXELS));
            let angle = (2.0 / PIXELS as f64).powi(2) / (1.0 + u * u + v * v).powf(1.5);
            solid += angle;
            let (mean, variance) = (pixel.mean(), pixel.variance().unwrap());
            for (sum, c) in sums.iter_mut().zip(0..3) {
                sum[0] += angle * mean[c];
                sum[1] += angle * angle * variance[c] / f64::from(SAMPLES);
            }
        }
    }
    // The midpoint rule over a pixel errs by its curvature: a few parts in a thousand of the sphere.
    assert!((solid / (4.0 * PI) - 1.0).abs() < 4e-3, "{solid}");
    sums.map(|[sum, variance]| [sum, variance.sqrt()].map(|x| x * 4.0 * PI / solid))
}

/// The light volume of the method.
fn light(method: &str, phase: &str) -> LightData {
    let case = case("position = [16, 16, 90]\ntarget = [16, 16, 16]", &format!("{phase}{method}"));
    let mut session = Session::new(device(), &case.plan()).unwrap();
    session.render(1).unwrap();
    session.light().unwrap().unwrap()
}

/// Scattered fluence at the corner between cells where voxel centres meet: the mean over its eight cells.
fn between(light: &LightData, [x, y, z]: [usize; 3]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for i in 0..8 {
        let cell = (x - (i & 1)) + 32 * ((y - (i >> 1 & 1)) + 32 * (z - (i >> 2)));
        for (c, sum) in sum.iter_mut().enumerate() {
            let direct = if light.directions.is_some() { 0.0 } else { light.direct[cell][c] };
            *sum += f64::from(light.fluence[cell][c] - direct) / 8.0;
        }
    }
    sum
}

/// Fluence within 5 % of transport, and the colours' ratios too, at points five mean free paths and more inside.
fn agrees(method: &str, phase: &str, points: &[[usize; 3]]) {
    let light = light(method, phase);
    for &point in points {
        let found = between(&light, point);
        let exact = transported(point.map(|x| x as f64), phase);
        let ratios: Vec<f64> = found.iter().zip(exact).map(|(found, [exact, _])| found / exact).collect();
        let noise: Vec<f64> = exact.iter().map(|[exact, error]| error / exact).collect();
        println!("{point:?}: {ratios:.4?}, noise {noise:.4?}");
        for c in 0..3 {
            // Four standard errors of six numbers each at two or three points: one in a thousand by chance.
            assert!((ratios[c] - 1.0).abs() < 0.05 + 4.0 * noise[c], "{point:?}: {ratios:?}");
            let colours = (ratios[c] / ratios[0] - 1.0).abs();
            assert!(colours < 0.05 + 4.0 * noise[c].hypot(noise[0]), "{point:?}: {ratios:?}");
        }
    }
}

#[test]
fn hybrid_diffusion_has_the_fluence_of_multiple_scattering() {
    agrees("[method]\nkind = \"hybrid-diffusion\"\n", "", &[[16, 16, 16], [10, 20, 12]]);
}

#[test]
fn forward_scattering_is_reduced_by_similarity() {
    // A mean cosine of 0.5 leaves 10 reduced mean free paths.
    let phase = "[phase]\nkind = \"henyey-greenstein\"\ng = 0.5\n";
    agrees("[method]\nkind = \"hybrid-diffusion\"\n", phase, &[[16, 16, 16]]);
}
