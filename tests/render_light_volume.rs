//! The projection of light volumes against closed forms and the twin of emission-absorption.

mod common;

use common::{Case, EPS, close, device, smooth, volume_f32};
use std::f64::consts::PI;
use std::path::Path;
use svetlo::irradiance::{Directions, LightData};
use svetlo::render::{BRICK_SHIFT, Plan, SceneData, Session, announced_memory};
use svetlo::scene::Scene;

const METHOD: &str = "[method]\nkind = \"hybrid-diffusion\"\ntermination = 0\n";

/// One ray along −z through the middle of a box of 8³ voxels.
fn along_z(rest: &str) -> String {
    format!(
        "[image]\nwidth = 1\nheight = 1\nfilter = \"point\"\n[camera]\nkind = \"orthographic\"\nheight = 1\n\
         position = [4.1, 3.9, 20]\ntarget = [4.1, 3.9, 0]\n[volume]\nwindow = {{ lo = 0, hi = 1 }}\n{rest}{METHOD}"
    )
}

/// The mean of the only pixel.
fn seen(case: &Case, light: &LightData) -> [f64; 4] {
    let mut session = Session::lit(device(), &case.plan(), Some(light)).unwrap();
    session.render(1).unwrap();
    session.film().unwrap()[0].mean()
}

/// The same light everywhere.
fn uniform(dims: [usize; 3], fluence: [f32; 3]) -> LightData {
    let cells = dims.iter().product();
    LightData { dims, fluence: vec![fluence; cells], direct: vec![[0.0; 3]; cells], directions: None }
}

/// Bound of rounding: some eight operations in each of the eight or so cells of a ray, on numbers of this size.
fn rounding(size: f64) -> f64 {
    9.0 * 16.0 * EPS * size
}

#[test]
fn uniform_light_in_a_constant_medium_has_the_closed_form() {
    for tau in [0.01, 1.0, 30.0] {
        let text = along_z(&format!(
            "[medium]\nsigma_max = {}\nalbedo = 0.9\n[transfer]\n\
             points = [{{ value = 0.5, opacity = 1, color = [1, 0.5, 0.25] }}]\n[background]\ncolor = [0.7, 0.2, 0]\n",
            tau / 8.0
        ));
        let case = Case::new(&text, volume_f32([8; 3], vec![0.3; 512]));
        let fluence = [12.0, 5.0, 100.0];
        let mean = seen(&case, &uniform([8; 3], fluence));
        let opacity = -f64::exp_m1(-tau);
        let (albedo, behind) = ([0.9, 0.45, 0.225], [0.7, 0.2, 0.0]);
        for c in 0..3 {
            let light = f64::from(fluence[c]) / (4.0 * PI);
            let exact = albedo[c] * light * opacity + (1.0 - opacity) * behind[c];
            close(&format!("tau {tau}, channel {c}"), mean[c], exact, rounding(1.0 + light));
        }
        close("opacity", mean[3], opacity, rounding(1.0));
    }
}

#[test]
fn channels_of_extinction_have_their_own_transmittance() {
    let text = along_z(
        "[medium]\nsigma_max = 0.25\nextinction_color = [1, 0.5, 0.1]\nalbedo = [0.9, 0.8, 0.7]\n[transfer]\n\
         points = [{ value = 0.5, opacity = 1, color = 1 }]\n[background]\ncolor = 2\n",
    );
    let case = Case::new(&text, volume_f32([8; 3], vec![0.3; 512]));
    let mean = seen(&case, &uniform([8; 3], [4.0, 5.0, 6.0]));
    for c in 0..3 {
        let tau = 2.0 * [1.0, 0.5, 0.1][c];
        let light = [0.9, 0.8, 0.7][c] * [4.0, 5.0, 6.0][c] / (4.0 * PI);
        close("channel", mean[c], 2.0 * f64::exp(-tau) - light * f64::exp_m1(-tau), rounding(3.0));
    }
}

#[test]
fn what_glows_is_seen_besides() {
    let text = along_z(
        "[medium]\nsigma_max = 0.25\nalbedo = 0.6\n[transfer]\n\
         points = [{ value = 0.5, opacity = 1, color = 1, emission = [3, 2, 1] }]\n",
    );
    let case = Case::new(&text, volume_f32([8; 3], vec![0.3; 512]));
    let mean = seen(&case, &uniform([8; 3], [4.0; 3]));
    for c in 0..3 {
        let source = 0.6 * 4.0 / (4.0 * PI) + 0.4 * [3.0, 2.0, 1.0][c];
        close("channel", mean[c], -source * f64::exp_m1(-2.0), rounding(3.0));
    }
}

#[test]
fn light_is_linear_between_cells() {
    // Fluence 4π (k + ½)/n in slice k of n: linear in z but for the last half cell at both ends, where it stays.
    let (n, sigma, depth): (usize, f64, f64) = (8, 0.3, 8.0);
    let text = along_z(&format!(
        "[medium]\nsigma_max = {sigma}\nalbedo = 1\n[transfer]\n\
         points = [{{ value = 0.5, opacity = 1, color = 1 }}]\n"
    ));
    let case = Case::new(&text, volume_f32([8; 3], vec![0.3; 512]));
    let slice = |k: usize| (4.0 * PI * (k as f64 + 0.5) / n as f64) as f32;
    let mut light = uniform([n; 3], [0.0; 3]);
    for (i, fluence) in light.fluence.iter_mut().enumerate() {
        *fluence = [slice(i / (n * n)); 3];
    }
    // The eye looks along −z from z = depth: L = ∫ σ e^{−σ t} z(t)/depth dt with z clamped to its centres, here by
    // 10⁵ midpoints, whose error is 10⁻¹⁰.
    let steps = 100_000;
    let integrand = |i: usize| {
        let t = (i as f64 + 0.5) / steps as f64 * depth;
        sigma * f64::exp(-sigma * t) * (depth - t).clamp(0.5, 7.5) / depth
    };
    let exact = (0..steps).map(integrand).sum::<f64>() * depth / steps as f64;
    // The two Gauss points of a voxel of optical depth 0.3 weigh a linear source right to O(τ⁴/4320) = 2e-6 of it.
    close("linear light", seen(&case, &light)[0], exact, rounding(1.0) + 2e-6);
}

#[test]
fn uniform_light_looks_as_a_medium_that_shines_by_itself() {
    let transfer = "[transfer]\npoints = [{ value = 0.2, opacity = 0, color = [1, 0, 0.5] }, \
                    { value = 0.6, opacity = 1, color = [0.2, 1, 0.1] }, { value = 0.9, opacity = 0.1, color = 1 }]\n";
    let view = "[image]\nwidth = 12\nheight = 12\nfilter = \"point\"\n[camera]\nposition = [40, 30, -20]\n\
                target = [4, 4, 4]\nfov = 13\n[volume]\nwindow = { lo = 0, hi = 1 }\n[medium]\nsigma_max = 1.5\n";
    let case = Case::new(&format!("{view}{transfer}{METHOD}"), smooth([8, 9, 7], 5));
    let light = uniform([8, 9, 7], [4.0 * PI as f32; 3]);
    let mut session = Session::lit(device(), &case.plan(), Some(&light)).unwrap();
    session.render(1).unwrap();
    let film = session.film().unwrap();
    let stretches = case.stretches();
    assert!(stretches.iter().filter(|s| s.radiance[1] > 0.1).count() > 40, "the medium fills the view");
    let mut squares = 0.0;
    for (pixel, stretch) in film.iter().zip(&stretches) {
        for c in 0..3 {
            squares += (pixel.mean()[c] - stretch.radiance[c]).powi(2);
        }
    }
    // Emission-absorption meets its twin to an RMS of 2.3e-4 at an optical depth of 1 per voxel; here it is 1.5.
    let rms = (squares / (3 * film.len()) as f64).sqrt();
    println!("RMS {rms:.1e}");
    assert!(rms < 5e-4, "{rms}");
}

#[test]
fn one_beam_is_scattered_by_the_phase_function_itself() {
    let albedo = 0.9;
    for (phase, mean) in [
        ("kind = \"henyey-greenstein\"\ng = 0.8", 0.8),
        ("kind = \"henyey-greenstein\"\ng = -0.5", -0.5),
        ("kind = \"rayleigh\"", 0.0),
    ] {
        let text = along_z(&format!(
            "[medium]\nsigma_max = 0.25\nalbedo = {albedo}\n[phase]\n{phase}\n[transfer]\n\
             points = [{{ value = 0.5, opacity = 1, color = 1 }}]\n"
        ));
        let case = Case::new(&text, volume_f32([8; 3], vec![0.3; 512]));
        // A beam along (0.6, 0, 0.8): light towards the eye, +z, is scattered by a cosine of 0.8.
        let (beam, rest, drift) = (5.0_f32, 2.0_f32, 0.3_f32);
        let light = LightData {
            dims: [8; 3],
            fluence: vec![[rest; 3]; 512],
            direct: vec![[beam; 3]; 512],
            directions: Some(Directions {
                drift: vec![[0.0, 0.0, drift]; 512],
                flow: vec![[0.6, 0.0, 0.8]; 512],
            }),
        };
        let mu = 0.8;
        let value = if phase.contains("rayleigh") {
            3.0 / (16.0 * PI) * (1.0 + mu * mu)
        } else {
            (1.0 - mean * mean) / (4.0 * PI * (1.0 + mean * mean - 2.0 * mean * mu).powf(1.5))
        };
        let diffuse = f64::from(rest) * (1.0 + 3.0 * mean * f64::from(drift)).max(0.0) / (4.0 * PI);
        let exact = -albedo * (f64::from(beam) * value + diffuse) * f64::exp_m1(-2.0);
        // |flow| is 1 to a rounding, which a narrow lobe turns into as much of its own share.
        close(phase, seen(&case, &light)[0], exact, rounding(1.0 + exact));
    }
}

#[test]
fn light_that_goes_all_ways_alike_is_scattered_alike() {
    let text = along_z(
        "[medium]\nsigma_max = 0.25\nalbedo = 1\n[phase]\nkind = \"henyey-greenstein\"\ng = 0.8\n[transfer]\n\
         points = [{ value = 0.5, opacity = 1, color = 1 }]\n",
    );
    let case = Case::new(&text, volume_f32([8; 3], vec![0.3; 512]));
    let none = vec![[0.0; 3]; 512];
    let directions = Some(Directions { drift: none.clone(), flow: none });
    let all = [4.0 * PI as f32; 3];
    let light = LightData { dims: [8; 3], fluence: vec![[0.0; 3]; 512], direct: vec![all; 512], directions };
    close("radiance", seen(&case, &light)[0], -f64::exp_m1(-2.0), rounding(1.0));
}

#[test]
fn memory_of_the_light_is_known_before_the_voxels() {
    for method in ["kind = \"hybrid-diffusion\"\ncoarsening = 2", "kind = \"convection-diffusion\""] {
        let text = format!(
            "[camera]\nposition = [0, 0, -9]\ntarget = [0, 0, 0]\n[volume]\nfield = {{ kind = \"sphere\" }}\n\
             dims = [40, 30, 50]\nspacing = [1, 2, 1]\n[medium]\nsigma_max = 0.1\n[[light]]\nkind = \"directional\"\n\
             direction = [0, 0, 1]\nirradiance = 1\n[method]\n{method}\n"
        );
        let loaded = svetlo::config::parse("test.toml", &text, &[]).unwrap();
        let scene = Scene::from_loaded(&loaded, Path::new(".")).unwrap();
        let announced = announced_memory(&scene).total();
        let volume = SceneData::load(&scene).unwrap();
        let planned = Plan::new(&scene, &volume, BRICK_SHIFT).unwrap().memory().total();
        println!("{method}: announced {announced} of {planned}");
        assert!(announced <= planned && announced > planned - planned / 10);
    }
}
