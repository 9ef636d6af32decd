//! The film: means and variances, samples that are not finite, pixel filter and lens.

mod common;

use bytemuck::Zeroable;
use common::{Case, EPS, close, device, log_slope, noise, report, rms, volume_f32};
use glam::DVec3;
use svetlo::device::{Buffer, Program, ProgramSpec};
use svetlo::film::FilmPixel;
use svetlo::reference::camera::ray;
use svetlo::reference::emission_absorption::Integrator;
use svetlo::reference::film::mean_and_variance;
use svetlo::reference::quadrature::gauss_legendre;
use svetlo::volume::field::{Cloud, sample};

/// Adds samples to one pixel with the kernels' own function, all of them once a launch. (A launch has fewer loop
/// iterations than llvmpipe's 65535.)
fn accumulate(samples: &[[f32; 4]], depths: &[f32], launches: u32) -> FilmPixel {
    let device = device();
    let kernel = "__kernel void probe(__global const float4 *samples, __global const float *depths,\n\
         __global struct FilmPixel *film, uint count) {\n\
         if (get_global_id(0) != 0) return;\nstruct FilmPixel pixel = film[0];\n\
         for (uint i = 0; i < count; ++i) film_add(&pixel, samples[i], depths[i], 3u);\nfilm[0] = pixel;\n}\n";
    let program = Program::build_probe(&device, &ProgramSpec::new("film/accumulate.cl"), kernel).unwrap();
    let mut kernel = program.kernel(&device, "probe").unwrap();
    let samples_buffer = Buffer::from_slice(&device, samples).unwrap();
    let depths_buffer = Buffer::from_slice(&device, depths).unwrap();
    let film = Buffer::from_slice(&device, &[FilmPixel::zeroed()]).unwrap();
    let count = samples.len() as u32;
    for _ in 0..launches {
        let arguments = [(&samples_buffer).into(), (&depths_buffer).into(), (&film).into(), count.into()];
        kernel.run(&device, &arguments, 1).unwrap();
    }
    film.read(&device).unwrap()[0]
}

#[test]
fn mean_and_variance_are_those_of_the_samples() {
    let count = 20_000;
    // A large mean with little variance, noise, rare fireflies, and a negative channel.
    let [a, b, c, d] = [1, 2, 3, 4].map(|seed| noise(count, seed));
    let samples: Vec<[f32; 4]> = (0..count)
        .map(|i| {
            let firefly = if c[i] < 1e-3 { 1e4 } else { c[i] };
            [1000.0 + a[i], b[i], firefly, -d[i]].map(|x| x as f32)
        })
        .collect();
    let pixel = accumulate(&samples, &vec![-1.0; count], 1);
    assert_eq!(
        (pixel.count, pixel.hits, pixel.rejected, pixel.lookups()),
        (count as u32, 0, 0, 3 * count as u64)
    );
    let variance = pixel.variance().unwrap();
    for channel in 0..4 {
        let values: Vec<f64> = samples.iter().map(|s| f64::from(s[channel])).collect();
        let (mean, exact) = mean_and_variance(&values);
        let spread = exact.sqrt();
        // Every update adds a difference that is rounded once (relative 2^-24) to a two-float sum (relative 2^-47):
        // errors are a random walk of steps 2^-24·|δ|/n, whose sum is below 2^-24·(spread·π/√6 + …); k = 8. The
        // differences themselves come from the float32 high part: they carry its last bit of up to 2^-47·mean.
        let bound = 8.0 * EPS * spread + 1e-10 * mean.abs();
        close(&format!("mean, channel {channel}"), pixel.mean()[channel], mean, bound);
        // Each of the terms δ·δ' ≥ 0 is rounded three times; the sum loses nothing.
        close(&format!("variance, channel {channel}"), variance[channel] / exact, 1.0, 3.0 * EPS);
        report(&format!("channel {channel}, variance"), (variance[channel] / exact - 1.0).abs(), 3.0 * EPS);
    }
}

#[test]
fn two_million_equal_samples_neither_stall_nor_spread() {
    let samples = vec![[0.1_f32, 1e-4, 123.456, 1.0]; 1 << 15];
    let pixel = accumulate(&samples, &vec![2.5; 1 << 15], 1 << 6);
    assert_eq!((pixel.count, pixel.hits), (1 << 21, 1 << 21));
    for (channel, value) in samples[0].into_iter().enumerate() {
        assert_eq!(pixel.mean()[channel], f64::from(value), "channel {channel}");
        assert_eq!(pixel.variance().unwrap()[channel], 0.0);
    }
    assert_eq!(pixel.depth, 2.5);
}

#[test]
fn two_values_in_turn_keep_their_mean_and_variance() {
    let samples: Vec<[f32; 4]> = (0..1 << 15).map(|i| [if i % 2 == 0 { 0.1 } else { 0.3 }; 4]).collect();
    let pixel = accumulate(&samples, &vec![-1.0; 1 << 15], 1 << 6);
    let values: Vec<f64> = samples.iter().map(|s| f64::from(s[0])).collect();
    let count = f64::from(1 << 21);
    let (mean, variance) = mean_and_variance(&values);
    let exact = variance * (values.len() as f64 - 1.0) / values.len() as f64 * count / (count - 1.0);
    // A float32 sum would stall near 2^24 · 0.01 and be off by percents; two-float sums keep 2^-24 per term.
    close("mean", pixel.mean()[0], mean, 8.0 * EPS * 0.1);
    close("variance", pixel.variance().unwrap()[0] / exact, 1.0, 8.0 * EPS);
}

#[test]
fn samples_that_are_not_finite_are_counted_and_left_out() {
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    let mut samples = vec![[0.5_f32; 4]; 10];
    for (k, value) in bad.into_iter().enumerate() {
        samples[2 * k][k + 1] = value;
    }
    let mut depths = vec![1.0_f32; 10];
    depths[9] = f32::NAN;
    let pixel = accumulate(&samples, &depths, 1);
    assert_eq!((pixel.count, pixel.rejected, pixel.hits), (6, 4, 6));
    assert_eq!((pixel.mean(), pixel.variance()), ([0.5; 4], Some([0.0; 4])));
}

#[test]
fn nan_is_the_low_end_of_a_window_that_the_file_turns_around() {
    // A negative slope in the file makes the stored value of the window's low end the larger one.
    let text = "[image]\nwidth = 1\nheight = 1\nfilter = \"point\"\n[camera]\nposition = [4, 4, 20]\ntarget = [4, 4, 0]\n\
         [volume]\nwindow = { lo = 0, hi = 1 }\n[medium]\nsigma_max = 0.1\n\
         [method]\nkind = \"emission-absorption\"\n";
    for (voxel, opacity) in [(f64::NAN, 0.0), (f64::INFINITY, 0.0), (f64::NEG_INFINITY, -f64::exp_m1(-0.8))] {
        let mut volume = volume_f32([8; 3], vec![voxel; 512]);
        volume.slope = -1.0;
        close(&format!("{voxel}"), Case::new(text, volume).film()[0].mean()[3], opacity, 16.0 * EPS);
    }
}

const METHODS: [&str; 3] = [
    "[medium]\nsigma_max = 0.3\n[method]\nkind = \"emission-absorption\"\n",
    "[method]\nkind = \"mip\"\n",
    "[method]\nkind = \"isosurface\"\nvalue = 0.5\n",
];

#[test]
fn voxels_that_are_not_finite_render_finitely_and_are_reported() {
    let mut values = noise(8 * 8 * 8, 1);
    for (i, value) in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY].into_iter().cycle().take(60).enumerate() {
        values[(i * 37) % 512] = value;
    }
    let replaced: Vec<f64> =
        values.iter().map(|v| if v.is_finite() { *v } else { f64::from(*v > 0.0) }).collect();
    for method in METHODS {
        let text = format!(
            "[image]\nwidth = 16\nheight = 16\nfilter = \"point\"\n[camera]\nposition = [20, 15, -10]\ntarget = [4, 4, 4]\n\
             fov = 20\n[volume]\nwindow = {{ lo = 0, hi = 1 }}\n{method}"
        );
        let case = Case::new(&text, volume_f32([8; 3], values.iter().copied()));
        let note = case.plan().notes.iter().any(|note| note.starts_with("20 NaN and 40 infinite voxels"));
        assert!(note, "{:?}", case.plan().notes);
        let film = case.film();
        assert!(film.iter().all(|p| p.rejected == 0 && p.mean().iter().all(|x| x.is_finite())));
        // The same as with the ends of the window in their place.
        let clean = Case::new(&text, volume_f32([8; 3], replaced.iter().copied()));
        assert_eq!(film, clean.film(), "{method}");
    }
}

#[test]
fn the_box_filter_converges_to_the_mean_of_the_pixel() {
    let text = |filter: &str| {
        format!(
            "[image]\nwidth = 4\nheight = 4\nfilter = \"{filter}\"\n[camera]\nposition = [8, 8, -30]\ntarget = [8, 8, 8]\n\
             fov = 26\n[volume]\nwindow = {{ lo = 0, hi = 1 }}\n[transfer]\nresolution = 2\n[medium]\nsigma_max = 0.5\n\
             [method]\nkind = \"emission-absorption\"\nradiance = 0\ntermination = 0\n"
        )
    };
    let case = Case::new(&text("box"), sample(&Cloud, [16; 3]).unwrap());
    let (field, medium) = (case.field(), case.medium());
    let integrator = Integrator::new(&field, &medium);
    // Exact means: two Gauss points in each of 24×24 parts of a pixel. Cells are seen at 1/4 of a pixel, so parts
    // are a sixth of a cell and err by less than 1e-6, far below the noise of 1024 samples.
    let rule: Vec<(f64, f64)> = gauss_legendre(2);
    let parts = 24;
    let nodes: Vec<(f64, f64)> = (0..parts)
        .flat_map(|k| {
            rule.iter().map(move |(x, w)| ((f64::from(k) + x) / f64::from(parts), w / f64::from(parts)))
        })
        .collect();
    let exact = |pixel: [u32; 2]| -> f64 {
        let row = |y: &(f64, f64)| {
            let seen = |x: &(f64, f64)| {
                let ray = ray(&case.scene.camera, &case.scene.image, pixel, [x.0, y.0], [0.0; 2]);
                x.1 * integrator.ray(&ray).transmittance()
            };
            y.1 * nodes.iter().map(seen).sum::<f64>()
        };
        1.0 - nodes.iter().map(row).sum::<f64>()
    };
    let exact: Vec<f64> = (0..16).map(|i| exact([i % 4, i / 4])).collect();
    let mut session = case.session();
    let mut errors = Vec::new();
    for samples in [4, 16, 64, 256, 1024] {
        session.render(samples).unwrap();
        let film = session.film().unwrap();
        errors.push((f64::from(samples), rms(film.iter().zip(&exact).map(|(p, e)| p.mean()[3] - e))));
    }
    let slope = log_slope(&errors);
    // Independent samples would give −½ ± 0.07: each RMS over 16 pixels is known to 1/√32 = 18 %, and the slope over
    // 8 octaves to 0.18/(ln 4·√10). A slope below −½ − 4·0.04 is no accident.
    println!("box filter: slope {slope:.3}, last RMS {:.2e}", errors[4].1);
    assert!(slope < -0.5 - 4.0 * 0.041, "{slope}: {errors:?}");
    // Unbiased: what remains is far below the pixels' own spread.
    assert!(errors[4].1 < 1e-4, "{errors:?}");
}

/// A thin plate (1e-4 thick) perpendicular to the view at a distance of 20, with a ramp along x.
fn plate(aperture: f64, focus: f64, filter: &str) -> Case {
    let text = format!(
        "[image]\nwidth = 8\nheight = 8\nfilter = \"{filter}\"\n[camera]\nposition = [8, 8, 20]\ntarget = [8, 8, 0]\n\
         fov = 20\naperture = {aperture}\nfocus = {focus}\n[volume]\nspacing = [1, 1, 1e-4]\n\
         window = {{ lo = 0, hi = 16 }}\n[method]\nkind = \"mip\"\n"
    );
    Case::new(&text, volume_f32([16, 16, 1], (0..256).map(|i| f64::from(i % 16) + 0.5)))
}

#[test]
fn a_plate_in_focus_is_sharp() {
    let aperture = 1.5;
    let sharp = plate(0.0, 20.0, "point").film();
    let lens = plate(aperture, 20.0 - 0.5e-4, "point").film_of(64);
    for (a, b) in sharp.iter().zip(&lens) {
        // Half the plate's thickness away from the focus, rays spread by aperture·1e-4/2/20; the ramp rises by 1/16
        // per unit. In local units the plate is 16/1e-4 wide: positions round by 1.6e5·2^-24 of 1e-4.
        let bound = (aperture * 0.5e-4 / 20.0 + 8.0 * 16.0 * EPS) / 16.0 + 4.0 * EPS;
        close("mean", b.mean()[0], a.mean()[0], bound);
        close("spread", b.variance().unwrap()[0].sqrt(), 0.0, bound);
    }
}

#[test]
fn a_plate_out_of_focus_blurs_by_the_disk_it_should() {
    let (aperture, focus) = (1.5, 30.0);
    let samples = 1024;
    let film = plate(aperture, focus, "point").film_of(samples);
    let sharp = plate(0.0, focus, "point").film();
    // The disk of confusion: aperture·|1 − 20/30| = 0.5; x over a disk has the variance r²/4, and v = x/16.
    let variance = (aperture * (1.0 - 20.0 / focus) / 16.0_f64).powi(2) / 4.0;
    for (a, b) in sharp.iter().zip(&film) {
        // Independent samples would know the mean to σ/√n, and the variance (the fourth moment of x over a disk is
        // r⁴/8, twice its squared variance) to σ²/√n. Stratified ones know both better; k = 4.
        let n = f64::from(samples);
        close("mean", b.mean()[0], a.mean()[0], 4.0 * (variance / n).sqrt());
        close("variance", b.variance().unwrap()[0] / variance, 1.0, 4.0 / n.sqrt());
    }
}

#[test]
fn every_ray_through_the_lens_starts_on_its_disk() {
    // What the twin says about the plate: the mean over the lens's disk is the value at its centre.
    let case = plate(1.5, 30.0, "point");
    let at = |lens: [f64; 2]| {
        let ray = ray(&case.scene.camera, &case.scene.image, [2, 3], [0.5; 2], lens);
        ray.at(20.0 / -ray.direction.z)
    };
    let (left, right) = (at([-1.0, 0.0]), at([1.0, 0.0]));
    assert!(((right - left) - DVec3::new(1.0, 0.0, 0.0)).length() < 1e-12, "{left} {right}");
}
