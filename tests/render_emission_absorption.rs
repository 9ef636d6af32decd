//! Emission-absorption against closed forms, published rows and the twin.

mod common;

use common::{Case, EPS, close, largest, log_slope, noisy, report, rms, smooth, volume_f32};
use glam::DVec3;
use serde_json::Value;
use svetlo::reference::emission_absorption::Stretch;
use svetlo::render::Session;
use svetlo::volume::{Volume, Voxels};

/// Oblique views of a box of `n`³ voxels of spacing 1 from outside, 12×12 pixels; all rays hit the box.
fn view(n: usize) -> String {
    let (far, middle) = (2.0 * n as f64, 0.5 * n as f64);
    format!(
        "[image]\nwidth = 12\nheight = 12\nfilter = \"point\"\n[camera]\nposition = [{far}, {}, {}]\n\
         target = [{middle}, {middle}, {middle}]\nfov = 10\n",
        1.3 * far,
        -0.7 * far
    )
}

const QUADRATURES: [&str; 6] = [
    "",
    "quadrature = \"step\"\nstep = 0.37\njitter = false",
    "quadrature = \"step\"\nstep = 0.37\njitter = true",
    "quadrature = \"step\"\nstep = 1\njitter = false",
    "quadrature = \"step\"\nstep = 2.3\njitter = true",
    "quadrature = \"step\"\nstep = 64\njitter = true",
];

#[test]
fn a_constant_medium_has_the_closed_form_at_any_step() {
    // L = c L0 (1 − e^{−σD}) + e^{−σD} L_bg over D = 8, as in Max (1995).
    let (colour, l0, background) = ([1.0, 0.5, 0.25], 3.0, 0.7);
    let mut worst: f64 = 0.0;
    for tau in [1e-3, 0.1, 1.0, 5.0, 20.0, 1000.0] {
        for quadrature in QUADRATURES {
            let text = format!(
                "[image]\nwidth = 1\nheight = 1\nfilter = \"point\"\n[camera]\nposition = [4, 4, 20]\n\
                 target = [4, 4, 0]\n[volume]\nwindow = {{ lo = 0, hi = 1 }}\n\
                 [transfer]\npoints = [{{ value = 0.5, opacity = 1, color = {colour:?} }}]\n\
                 [medium]\nsigma_max = {}\n[background]\ncolor = {background}\n\
                 [method]\nkind = \"emission-absorption\"\nradiance = {l0}\ntermination = 0\n{quadrature}\n",
                tau / 8.0
            );
            let film = Case::new(&text, volume_f32([8; 3], vec![0.3; 512])).film();
            let transmittance = f64::exp(-tau);
            // Optical depth and transmittance are sums and products over at most 8 / 0.37 + 1 = 23 parts, each
            // rounded a few times: 23·8 roundings, and T τ ≤ 1/e.
            let bound = 23.0 * 8.0 * EPS * (l0 + background);
            for (c, colour) in colour.into_iter().enumerate() {
                let exact = colour * l0 * -f64::exp_m1(-tau) + transmittance * background;
                close(
                    &format!("tau {tau} channel {c} {quadrature}"),
                    film[0].mean()[c],
                    exact,
                    bound.min(1e-5),
                );
                worst = worst.max((film[0].mean()[c] - exact).abs());
            }
            close(
                &format!("opacity, tau {tau} {quadrature}"),
                film[0].mean()[3],
                1.0 - transmittance,
                bound.min(1e-5),
            );
        }
    }
    report("constant medium", worst, 1e-5);
}

#[test]
fn a_constant_medium_has_the_closed_form_in_two_dimensions_too() {
    for quadrature in QUADRATURES {
        let text = format!(
            "[image]\nwidth = 1\nheight = 1\nfilter = \"point\"\n[camera]\nposition = [4, 4, 20]\ntarget = [4, 4, 0]\n\
             [volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = 0.25\n\
             [transfer]\nkind = \"2d\"\nshapes = [{{ shape = \"rectangle\", centre = [0.5, 0.5], size = [2, 2], \
             color = [1, 0.5, 0] }}]\n[background]\ncolor = [0, 0, 1]\n\
             [method]\nkind = \"emission-absorption\"\nradiance = 3\ntermination = 0\n{quadrature}\n"
        );
        let mean = Case::new(&text, volume_f32([8; 3], vec![0.3; 512])).film()[0].mean();
        let transmittance = f64::exp(-2.0);
        let exact =
            [3.0 * (1.0 - transmittance), 1.5 * (1.0 - transmittance), transmittance, 1.0 - transmittance];
        for (found, exact) in mean.into_iter().zip(exact) {
            close(quadrature, found, exact, 23.0 * 8.0 * EPS * 3.0);
        }
    }
}

#[test]
fn a_thin_constant_medium_is_right_relatively() {
    for tau in [1e-6, 1e-9, 1e-20] {
        for quadrature in QUADRATURES {
            let text = format!(
                "[image]\nwidth = 1\nheight = 1\nfilter = \"point\"\n[camera]\nposition = [4, 4, 20]\n\
                 target = [4, 4, 0]\n[volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = {}\n\
                 [method]\nkind = \"emission-absorption\"\n{quadrature}\n",
                tau / 8.0
            );
            let film = Case::new(&text, volume_f32([8; 3], vec![1.0; 512])).film();
            let exact = -f64::exp_m1(-tau);
            // Each of at most 23 parts is rounded a few times; nothing cancels.
            let what = format!("tau {tau} {quadrature}");
            close(&what, film[0].mean()[0] / exact, 1.0, 23.0 * 8.0 * EPS);
            close(&what, film[0].mean()[3] / exact, 1.0, 23.0 * 8.0 * EPS);
            // Black media have a kernel of their own.
            let film = Case::new(&format!("{text}radiance = 0\n"), volume_f32([8; 3], vec![1.0; 512])).film();
            close(&what, film[0].mean()[3] / exact, 1.0, 23.0 * 8.0 * EPS);
        }
    }
}

/// A ramp on n³ voxels of the unit cube.
fn ramp(n: usize) -> Volume {
    volume_f32([n; 3], (0..n * n * n).map(|i| ((i / (n * n)) as f64 + 0.5) / n as f64))
}

fn rows() -> Vec<Value> {
    let text = include_str!("truths.json");
    let truths: Value = serde_json::from_str(text).unwrap();
    truths["ramp_transmittance"]["rows"].as_array().unwrap().clone()
}

/// Start, end and whether the row's ray starts inside the cube.
fn ends(row: &Value) -> (DVec3, DVec3) {
    let (z0, z1) = (row["z0"].as_f64().unwrap(), row["z1"].as_f64().unwrap());
    if row["ray"].as_str().unwrap().starts_with("oblique") {
        (DVec3::new(0.0, 0.5, z0), DVec3::new(1.0, 0.5, z1))
    } else {
        (DVec3::new(0.5, 0.5, z0), DVec3::new(0.5, 0.5, z1))
    }
}

#[test]
fn every_ramp_row_is_met() {
    let mut worst: f64 = 0.0;
    let colours = ["[0, 0, 0]", "[0.5, 0, 0.5]"];
    for row in rows() {
        let (from, to) = ends(&row);
        let length = row["length"].as_f64().unwrap();
        assert!(((to - from).length() - length).abs() < 1e-12);
        // A ray that ends inside the cube is followed backwards: its camera stands where the row ends.
        let inside = |p: DVec3| p.z > 0.0 && p.z < 1.0 && p.x > 0.0 && p.x < 1.0;
        let (eye, towards) = if inside(to) { (to, from) } else { (from, to) };
        let back = if inside(eye) { eye } else { eye - (towards - eye) };
        let target = eye + 2.0 * (towards - eye);
        for n in [4, 16, 64] {
            let tau = row[format!("tau_N{n}")].as_f64().unwrap();
            let transmittance = row[format!("T_N{n}")].as_f64().unwrap();
            for camera in ["fov = 30", "kind = \"orthographic\"\nheight = 1"] {
                for (colour, resolution) in colours.into_iter().zip([2, 1024]) {
                    let text = format!(
                        "[image]\nwidth = 1\nheight = 1\nfilter = \"point\"\n\
                         [camera]\nposition = {:?}\ntarget = {:?}\n{camera}\n\
                         [volume]\nspacing = {}\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = 5\n\
                         [transfer]\nresolution = {resolution}\npoints = [{{ value = 0, opacity = 0.2, color = {colour} }}, \
                         {{ value = 1, opacity = 1, color = {colour} }}]\n[background]\ncolor = [0, 1, 0]\n\
                         [method]\nkind = \"emission-absorption\"\ntermination = 0\n",
                        back.to_array(),
                        target.to_array(),
                        1.0 / n as f64
                    )
                    .replace("target", if towards.x == eye.x { "up = [1, 0, 0]\ntarget" } else { "target" });
                    let film = Case::new(&text, ramp(n)).film();
                    let found = film[0].mean()[1];
                    let what = format!("{} N{n} {camera}", row["ray"]);
                    close(&what, found, transmittance, 1e-5);
                    close(&what, -found.ln(), tau, 1e-5);
                    worst = worst.max((found.ln() + tau).abs());
                }
            }
        }
    }
    report("ramp rows, optical depth", worst, 1e-5);
}

/// Transmittances of all pixels of a midpoint render.
fn midpoint(case_text: &str, volume: Volume, step: f64) -> Vec<f64> {
    let text = format!("{case_text}quadrature = \"step\"\njitter = false\nstep = {step}\n");
    Case::new(&text, volume).film().iter().map(|pixel| 1.0 - pixel.mean()[3]).collect()
}

#[test]
fn the_midpoint_rule_converges_as_it_should() {
    let continuous =
        "[{ value = 0, opacity = 0 }, { value = 0.4, opacity = 0.1 }, { value = 1, opacity = 0.8 }]";
    let jump = "[{ value = 0.5, opacity = 0 }, { value = 0.500001, opacity = 1 }]";
    // Slopes of the RMS over 144 rays: 2 where the medium is continuous along the ray, 1 where it jumps. Rays are
    // independent, so an RMS is known to 1/√(2·144) = 6 %; over four octaves that moves a slope by
    // 0.06/(ln 2·√10) = 0.03; k = 5.
    for (points, resolution, order) in [(continuous, 1024, 2.0), (jump, 65536, 1.0)] {
        let text = format!(
            "{}[volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = 0.4\n\
             [transfer]\nresolution = {resolution}\npoints = {points}\n\
             [method]\nkind = \"emission-absorption\"\nradiance = 0\ntermination = 0\n",
            view(8)
        );
        let exact = Case::new(&text, smooth([8; 3], 5)).stretches();
        let mut errors = Vec::new();
        for k in 0..5 {
            let step = 0.5 / f64::from(1 << k);
            let found = midpoint(&text, smooth([8; 3], 5), step);
            errors.push((step, rms(found.iter().zip(&exact).map(|(f, e)| f - e.transmittance()))));
        }
        let slope = log_slope(&errors);
        report(&format!("slope {slope:.3} for order {order}"), (slope - order).abs(), 0.15);
        close(&format!("order {order}: {errors:?}"), slope, order, 0.15);
    }
}

#[test]
fn opacity_is_corrected_for_the_step() {
    // A layer of thickness 2 has opacity 0.3, so 8 units let (1 − 0.3)^4 through, at any step.
    for quadrature in QUADRATURES {
        let text = format!(
            "[image]\nwidth = 1\nheight = 1\nfilter = \"point\"\n[camera]\nposition = [4, 4, 20]\ntarget = [4, 4, 0]\n\
             [volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nmode = \"opacity\"\nreference_length = 2\n\
             [transfer]\npoints = [{{ value = 0, opacity = 0.3 }}]\n\
             [method]\nkind = \"emission-absorption\"\ntermination = 0\n{quadrature}\n"
        );
        let film = Case::new(&text, volume_f32([8; 3], vec![0.2; 512])).film();
        close(quadrature, film[0].mean()[3], 1.0 - 0.7_f64.powi(4), 23.0 * 8.0 * EPS);
    }
}

#[test]
fn linear_compositing_is_the_form_of_the_paper() {
    // Ĉᵢ = Ĉᵢ₋₁ + (1 − Aᵢ₋₁) αᵢ cᵢ, Aᵢ = Aᵢ₋₁ + (1 − Aᵢ₋₁) αᵢ with αᵢ = min(σ Δ, 1), front to back.
    for (sigma, step) in [(0.2, 0.5), (0.9, 0.7), (1.9, 0.5), (3.0, 0.5)] {
        let text = format!(
            "[image]\nwidth = 1\nheight = 1\nfilter = \"point\"\n[camera]\nposition = [4, 4, 20]\ntarget = [4, 4, 0]\n\
             [volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = {sigma}\n[background]\ncolor = 0.5\n\
             [transfer]\npoints = [{{ value = 0, opacity = 1, color = [1, 0.5, 0] }}]\n\
             [method]\nkind = \"emission-absorption\"\ntermination = 0\nquadrature = \"step\"\nstep = {step}\n\
             jitter = false\ncompositing = \"linear\"\n"
        );
        let film = Case::new(&text, volume_f32([8; 3], vec![0.2; 512])).film();
        let (mut colour, mut opacity, mut at) = (0.0, 0.0, 0.0);
        while at < 8.0 - 1e-9 {
            let alpha = (sigma * f64::min(step, 8.0 - at)).min(1.0);
            colour += (1.0 - opacity) * alpha;
            opacity += (1.0 - opacity) * alpha;
            at += step;
        }
        // 16 steps of about 4 roundings each.
        for (c, factor) in [1.0, 0.5, 0.0].into_iter().enumerate() {
            let exact = factor * colour + 0.5 * (1.0 - opacity);
            close(&format!("sigma {sigma} channel {c}"), film[0].mean()[c], exact, 64.0 * EPS);
        }
    }
}

/// Errors of opacity and of the colours (background included) against the twin, pixel by pixel.
fn against_the_twin(case: &Case, stretches: &[Stretch], background: [f64; 3], l0: f64) -> [Vec<f64>; 2] {
    let film = case.film();
    let error = |c: usize| {
        film.iter().zip(stretches).map(move |(pixel, exact)| {
            let seen = match c {
                3 => 1.0 - exact.transmittance(),
                c => l0 * exact.radiance[c] + exact.transmittance() * background[c],
            };
            pixel.mean()[c] - seen
        })
    };
    [error(3).collect(), (0..3).flat_map(error).collect()]
}

/// The quadrature per cell must beat the midpoint rule of `step` voxels, in opacity and in colour, for black media
/// (which have a kernel of their own) and glowing ones.
fn beats_the_midpoint_rule(what: &str, text: &str, volume: &dyn Fn() -> Volume, step: f64) {
    let background = [0.2, 0.4, 0.6];
    let mut stretches: Option<Vec<Stretch>> = None;
    for l0 in [0.0, 2.0] {
        let text = format!(
            "{text}[background]\ncolor = {background:?}\n\
             [method]\nkind = \"emission-absorption\"\ntermination = 0\nradiance = {l0}\n"
        );
        let midpoint = format!("{text}quadrature = \"step\"\njitter = false\nstep = {step}\n");
        let [cell, midpoint] = [text, midpoint].map(|text| {
            let case = Case::new(&text, volume());
            let stretches = stretches.get_or_insert_with(|| case.stretches());
            against_the_twin(&case, stretches, background, l0)
        });
        for ((cell, midpoint), name) in cell.into_iter().zip(midpoint).zip(["opacity", "colour"]) {
            let (error, bound) = (rms(cell), rms(midpoint));
            report(&format!("{what}, L0 {l0}, {name}, RMS"), error, bound);
            assert!(error <= bound, "{what}, L0 {l0}, {name}: {error} > {bound}");
        }
    }
}

const SHARP: &str = "[{ value = 0.0, opacity = 0.02, color = [0, 0, 1] }, { value = 0.3, opacity = 0.02, color = [0, 1, 0] }, \
    { value = 0.34, opacity = 0.9, color = [1, 0, 0] }, { value = 0.4, opacity = 0.9, color = [1, 0.5, 0] }, \
    { value = 0.42, opacity = 0.05, color = [0, 1, 1] }, { value = 1, opacity = 0.3, color = [1, 1, 1] }]";

type MakeVolume = fn([usize; 3], u32) -> Volume;
const VOLUMES: [(&str, MakeVolume); 2] = [("smooth", smooth), ("noisy", noisy)];

#[test]
fn the_cell_quadrature_follows_the_twin_with_sharp_functions() {
    for (name, volume) in VOLUMES {
        for sigma in [0.1, 1.0] {
            let text = format!(
                "{}[volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = {sigma}\n\
                 [transfer]\nresolution = 256\npoints = {SHARP}\n",
                view(8)
            );
            beats_the_midpoint_rule(&format!("{name}, sigma {sigma}"), &text, &|| volume([8; 3], 3), 0.05);
        }
    }
}

#[test]
fn a_bump_inside_a_cell_is_seen() {
    // Along the diagonal of this cell the field is 2 s (1 - s): 0 at the ends, 1/3 at the Gauss points, 1/2 between.
    let text = "[image]\nwidth = 1\nheight = 1\nfilter = \"point\"\n\
        [camera]\nposition = [-1, -1, 0.5]\ntarget = [1, 1, 0.5]\nup = [0, 0, 1]\n\
        [volume]\nwindow = { lo = 0, hi = 1 }\n[medium]\nsigma_max = 1\n\
        [transfer]\npoints = [{ value = 0.4, opacity = 0 }, { value = 0.5, opacity = 1 }]\n\
        [method]\nkind = \"emission-absorption\"\ntermination = 0\n";
    let case = Case::new(text, volume_f32([2, 2, 1], [0.0, 1.0, 1.0, 0.0]));
    let [opacity, _] = against_the_twin(&case, &case.stretches(), [0.0; 3], 1.0);
    // It is about 0.3. In each of 16 parts the field departs from a straight line by 2/8/16^2; the slope of the
    // extinction is 10, and the bump less than a unit long.
    close("opacity", opacity[0], 0.0, 10.0 * 2.0 / 8.0 / 256.0);
}

#[test]
fn the_cell_quadrature_is_exact_for_straight_functions() {
    // Two Gauss points integrate the cubic of a cell exactly, whatever the field; what remains is rounding. The depth
    // sums at most 24 cells; positions near 16 grid units round by 16·2^-24, and the slope of the noise is below 3.
    for (name, volume) in VOLUMES {
        let text = format!(
            "{}[volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = 0.5\n[transfer]\nresolution = 2\n\
             [method]\nkind = \"emission-absorption\"\ntermination = 0\nradiance = 0\n",
            view(8)
        );
        let case = Case::new(&text, volume([8; 3], 3));
        let [opacity, _] = against_the_twin(&case, &case.stretches(), [0.0; 3], 0.0);
        let opacity = largest(opacity.into_iter().map(f64::abs));
        let bound = 24.0 * (8.0 + 16.0 * 3.0) * EPS * 0.5 / std::f64::consts::E;
        report(&format!("straight function, {name}"), opacity, bound);
        assert!(opacity <= bound, "{name}: {opacity} > {bound}");
    }
}

#[test]
fn the_cell_quadrature_follows_the_twin_in_two_dimensions() {
    // Four Gauss points per cell. In noise the function has kinks in every cell, where they are as good as midpoints;
    // those of half a voxel are half as many.
    for ((name, volume), step) in VOLUMES.into_iter().zip([0.25, 0.5]) {
        let text = format!(
            "{}[volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = 1\n\
             [transfer]\nkind = \"2d\"\nresolution = [16, 16]\ngradient_max = 0.8\n\
             shapes = [{{ shape = \"rectangle\", centre = [0.5, 0.5], size = [2, 2], color = [0.5, 0.5, 1], opacity = 0.1 }}, \
             {{ shape = \"ellipse\", centre = [0.5, 0.5], size = [0.8, 1.2], color = [1, 0.5, 0], softness = 1 }}]\n",
            view(6)
        );
        beats_the_midpoint_rule(&format!("2-D {name}"), &text, &|| volume([6; 3], 3), step);
    }
}

#[test]
fn early_termination_errs_by_less_than_it_says() {
    let (l0, background) = (2.0, [0.5, 3.0, 1.0]);
    let film = |termination: f64, quadrature: &str| {
        let text = format!(
            "{}[volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = 2\n[transfer]\npoints = {SHARP}\n\
             [background]\ncolor = {background:?}\n[method]\nkind = \"emission-absorption\"\nradiance = {l0}\n\
             termination = {termination}\n{quadrature}\n",
            view(8)
        );
        Case::new(&text, smooth([8; 3], 3)).film()
    };
    for quadrature in ["", "quadrature = \"step\"\njitter = false"] {
        let exact = film(0.0, quadrature);
        for epsilon in [0.3, 0.01, 1.0 / 1024.0] {
            let stopped = film(epsilon, quadrature);
            let error =
                largest(stopped.iter().zip(&exact).flat_map(|(a, b)| {
                    (0..3).map(|c| (a.mean()[c] - b.mean()[c]).abs()).collect::<Vec<_>>()
                }));
            // |δC| ≤ ε max(L_q, L_bg); colours are at most 1, so L_q ≤ L0.
            let bound = epsilon * 3.0;
            assert!(error <= bound, "{epsilon}: {error}");
            assert!(error > 0.0, "nothing stopped early at {epsilon}");
            let (few, all): (u64, u64) =
                stopped.iter().zip(&exact).fold((0, 0), |(a, b), (p, q)| (a + p.lookups(), b + q.lookups()));
            assert!(few < all, "{few} of {all} look-ups");
        }
    }
}

#[test]
fn jitter_keeps_the_optical_depth_unbiased() {
    let text = format!(
        "{}[volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = 0.3\n[transfer]\npoints = {SHARP}\n\
         [method]\nkind = \"emission-absorption\"\nradiance = 0\ntermination = 0\nquadrature = \"step\"\nstep = 1.7\n",
        view(8)
    );
    let case = Case::new(&text, noisy([8; 3], 4));
    let mut session: Session = case.session();
    let exact = case.stretches();
    let samples = 256;
    let mut before = vec![0.0; exact.len()];
    let mut depths = vec![Vec::new(); exact.len()];
    for n in 1..=samples {
        session.render(n).unwrap();
        for (i, pixel) in session.film().unwrap().iter().enumerate() {
            // The two-float mean is good enough to tell the last sample: n·mean(n) − (n − 1)·mean(n − 1).
            let sum = f64::from(n) * pixel.mean()[3];
            depths[i].push(-(1.0 - (sum - before[i])).ln());
            before[i] = sum;
        }
    }
    // z-scores of the pixels' means: each standard normal (256 samples make the t-distribution normal enough).
    let scores: Vec<f64> = depths
        .iter()
        .zip(&exact)
        .map(|(samples, exact)| {
            let (mean, variance) = svetlo::reference::film::mean_and_variance(samples);
            assert!(variance > 0.0, "jitter does something");
            (mean - exact.depth) / (variance / samples.len() as f64).sqrt()
        })
        .collect();
    let overall = scores.iter().sum::<f64>() / (scores.len() as f64).sqrt();
    report("jitter, z of all pixels", overall.abs(), 4.0);
    assert!(overall.abs() < 4.0, "biased: z = {overall}");
    assert!(largest(scores.iter().map(|z| z.abs())) < 5.0, "{scores:?}");
    let spread = rms(scores);
    // χ² with 144 degrees: the RMS is 1 ± 1/√288.
    close("RMS of the z-scores", spread, 1.0, 4.0 / 288.0_f64.sqrt());
}

#[test]
fn a_negative_slope_in_the_file_changes_nothing() {
    // 255 − v stored with the slope −1 is v. Empty cells and bricks are where the function is 0 at low values.
    let points = "[{ value = 0.6, opacity = 0 }, { value = 0.9, opacity = 1 }]";
    let values: Vec<u8> = common::noise(512, 9).iter().map(|v| (v * 255.99) as u8).collect();
    let volume = |values: Vec<u8>| Volume::new([8; 3], DVec3::ONE, Voxels::U8(values)).unwrap();
    for quadrature in QUADRATURES {
        let text = format!(
            "{}[volume]\nwindow = {{ lo = 0, hi = 255 }}\n[medium]\nsigma_max = 1\n[transfer]\npoints = {points}\n\
             [method]\nkind = \"emission-absorption\"\ntermination = 0\n{quadrature}\n",
            view(8)
        );
        let plain = Case::new(&text, volume(values.clone())).film();
        let mut turned = volume(values.iter().map(|v| 255 - v).collect());
        (turned.slope, turned.intercept) = (-1.0, 255.0);
        for (a, b) in plain.iter().zip(Case::new(&text, turned).film()) {
            // Window values differ by 2^-24, and σ by 1/0.3 of that over 16 units of length, in sums of 50 parts.
            close(quadrature, b.mean()[3], a.mean()[3], (16.0 / 0.3 + 50.0) * 4.0 * EPS);
        }
    }
}
