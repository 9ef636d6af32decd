//! Scenes on which scattering goes wrong: huge and tiny extinctions, sharp edges, rays along faces, lights in the medium;
//! and what must not matter: units, place, brightness.

mod common;

use common::scattering::{
    Measured, Twin, all_finite, compare_blocks, family, of_film, over_pixels, write_map,
};
use common::{Case, EPS, noisy, stretches, volume_f32};
use std::f64::consts::PI;
use svetlo::film::FilmPixel;
use svetlo::reference::camera::Ray;
use svetlo::reference::half_space::plane_albedo;
use svetlo::render::{BRICK_SHIFT, Plan};
use svetlo::volume::Volume;

const SIDE: usize = 32;

fn bits(film: &[FilmPixel]) -> Vec<[u64; 4]> {
    film.iter().map(|pixel| pixel.mean().map(f64::to_bits)).collect()
}

/// A parallel view of the middle of an n³ box along one axis; `height` is how much of it is seen.
fn along(axis: usize, n: f64, height: f64) -> String {
    let mut from = [0.5 * n; 3];
    from[axis] = -2.0 * n;
    let up = [[0, 0, 1], [0, 0, 1], [0, 1, 0]][axis];
    format!(
        "[image]\nwidth = {SIDE}\nheight = {SIDE}\nfilter = \"point\"\n[camera]\nkind = \"orthographic\"\n\
         position = {from:?}\ntarget = {:?}\nup = {up:?}\nheight = {height}\n",
        [0.5 * n; 3]
    )
}

/// A checkerboard of voxels 0 and 1.
fn checkerboard(n: usize) -> Volume {
    volume_f32([n; 3], (0..n * n * n).map(|i| ((i % n + i / n % n + i / (n * n)) % 2) as f64))
}

/// The pixels of a pure absorber before light 1 against exp(−∫σ): binomial or better, so the variance of a pixel's mean
/// is below T(1 − T)/n, and the sum of squares over the pixels is judged, and their mean.
#[track_caller]
fn transmits(what: &str, case: &Case, samples: u32, slack: f64) {
    let film = case.film_of(samples);
    all_finite(&film);
    let (field, rays) = (case.field(), case.rays());
    let (low, high) = (field.origin, field.origin + field.size());
    // A ray that runs in a face of the box is neither inside nor outside.
    let in_face = |ray: &Ray| {
        let on = |axis: usize| {
            (ray.origin[axis] - low[axis]).abs().min((ray.origin[axis] - high[axis]).abs()) < 1e-6
        };
        (0..3).any(|axis| ray.direction[axis].abs() < 1e-9 && on(axis))
    };
    let exact = stretches(&field, &case.medium(), &rays);
    let (mut difference, mut variance, mut count) = (0.0, 0.0, 0.0);
    for ((pixel, exact), _) in film.iter().zip(&exact).zip(&rays).filter(|(_, ray)| !in_face(ray)) {
        let t = exact.transmittance();
        difference += pixel.mean()[1] - t;
        variance += t * (1.0 - t) / f64::from(samples);
        count += 1.0;
    }
    let found = Measured { value: difference / count, error: variance.sqrt() / count };
    found.agrees(what, 0.0, 4.0, slack);
}

#[test]
fn dense_grids_return_the_plane_albedo() {
    // σ × size = 10⁶ on 16³ voxels: free paths of 10⁻⁶ of the box. The rays meet the middle of a face.
    for axis in 0..3 {
        let text = format!(
            "{}[volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = 62500\nalbedo = 0.999\n\
             [transfer]\nresolution = 2\n[background]\ncolor = 1\n[method]\nkind = \"multiple-scattering\"\n",
            along(axis, 16.0, 8.0)
        );
        let film = Case::new(&text, volume_f32([16; 3], vec![1.0; 4096])).film_of(16);
        over_pixels(&film, 1).agrees(&format!("along {axis}"), plane_albedo(0.999, 1.0), family(3), 1e-6);
    }
}

#[test]
fn near_vacuum_scatters_what_it_should() {
    // Optical depth 10⁻⁶: L = ϖ E/(4π) τ, one path in a million; the variance of a path is L·ϖE/(4π) at most.
    let scene = |light: &str| {
        format!(
            "{}[volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = 1.25e-7\n[transfer]\nresolution = 2\n\
             {light}\n[method]\nkind = \"multiple-scattering\"\n",
            along(2, 8.0, 4.0)
        )
    };
    let sun = format!("[[light]]\nkind = \"directional\"\ndirection = [1, 2, 3]\nirradiance = {}", 4.0 * PI);
    let samples = 20_000;
    let film = Case::new(&scene(&sun), volume_f32([8; 3], vec![1.0; 512])).film_of(samples);
    all_finite(&film);
    let mean = film.iter().map(|pixel| pixel.mean()[1]).sum::<f64>() / film.len() as f64;
    let error = (1e-6 / (f64::from(samples) * film.len() as f64)).sqrt();
    Measured { value: mean, error }.agrees("near vacuum", 1e-6, 4.0, 0.0);
    for pixel in Case::new(&scene("[background]\ncolor = 1"), volume_f32([8; 3], vec![1.0; 512])).film_of(4) {
        assert!((pixel.mean()[1] - 1.0).abs() < 1e-6);
    }
}

#[test]
fn neighbours_empty_and_full_transmit_exactly() {
    // The step rises over 1/64, so over 1/64 of a voxel at least, where float32 positions up to 16 err by 10⁻⁶: a part of
    // 6·10⁻⁵ of σ, at each of two crossings per voxel, either way.
    let step = "resolution = 65\npoints = [{ value = 0.5, opacity = 0 }, { value = 0.515625, opacity = 1 }]";
    for (transfer, sigma, slack) in [("resolution = 2", 0.5, 1e-6), (step, 0.5, 1e-5), (step, 8.0, 1e-5)] {
        for (axis, n) in [(0, 8), (1, 9), (2, 8), (2, 9)] {
            // 32 wide: rays on voxels' centres for 8, between voxels for 9, and so on faces of cells and bricks.
            for height in [f64::from(n), 32.0] {
                let text = format!(
                    "{}[volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = {sigma}\nalbedo = 0\n\
                     [transfer]\n{transfer}\n[background]\ncolor = 1\n[method]\nkind = \"multiple-scattering\"\n",
                    along(axis, f64::from(n), height)
                );
                let what = format!("along {axis}, {n} voxels, {transfer}, σ {sigma}, height {height}");
                transmits(&what, &Case::new(&text, checkerboard(n as usize)), 16, slack);
            }
        }
    }
}

#[test]
fn albedo_zero_is_absorption_for_single_and_multiple_scattering() {
    for method in ["single-scattering", "multiple-scattering"] {
        let text = format!(
            "[image]\nwidth = {SIDE}\nheight = {SIDE}\nfilter = \"point\"\n[camera]\nposition = [30, 20, -17]\n\
             target = [4, 4, 4]\nfov = 20\n[volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = 0.6\n\
             [transfer]\nresolution = 3\npoints = [{{ value = 0.5, opacity = 0, color = 0 }}, {{ value = 1, opacity = 1, color = 0 }}]\n\
             [background]\ncolor = 1\n[[light]]\nkind = \"point\"\nposition = [4, 4, 4]\nintensity = 1000\n\
             [method]\nkind = \"{method}\"\n"
        );
        transmits(method, &Case::new(&text, noisy([8, 9, 7], 2)), 64, 1e-6);
    }
}

#[test]
fn rays_on_faces_of_the_box_are_white() {
    // Pixel centres on whole numbers from −8 to 24: on the faces of bricks, cells and the box, and beside it.
    for axis in 0..3 {
        let text = format!(
            "{}[volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = 0.7\n[transfer]\nresolution = 2\n\
             [background]\ncolor = 1\n[method]\nkind = \"multiple-scattering\"\n",
            along(axis, 17.0, SIDE as f64)
        );
        for pixel in Case::new(&text, noisy([17; 3], 3)).film_of(4) {
            assert!((pixel.mean()[1] - 1.0).abs() < 1e-6 && pixel.rejected == 0, "{}", pixel.mean()[1]);
        }
    }
}

/// A noisy medium under a lamp, a sun and a sky; lengths times `scale`, moved by `shift`, lights `bright` times as strong.
fn lit(scale: f64, shift: f64, bright: f64) -> Case {
    let place = |p: [f64; 3]| format!("{:?}", p.map(|x| x * scale + shift));
    let text = format!(
        "[image]\nwidth = {SIDE}\nheight = {SIDE}\n[camera]\nposition = {}\ntarget = {}\nfov = 24\n\
         [volume]\norigin = {}\nspacing = {:?}\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = {}\nalbedo = 0.9\n\
         [phase]\nkind = \"henyey-greenstein\"\ng = 0.5\n[transfer]\nresolution = 2\n\
         [background]\ncolor = {bright}\n[[light]]\nkind = \"point\"\nposition = {}\nintensity = {}\n\
         [[light]]\nkind = \"directional\"\ndirection = [-1, -2, 0.5]\nirradiance = {}\n\
         [[light]]\nkind = \"rectangle\"\ncentre = {}\nedge_u = {:?}\nedge_v = {:?}\nradiance = {}\n\
         [method]\nkind = \"multiple-scattering\"\n",
        place([20.0, 26.0, -15.0]),
        place([4.0, 4.0, 4.0]),
        place([0.0; 3]),
        [scale; 3],
        0.5 / scale,
        place([13.0, 5.0, -3.0]),
        300.0 * bright * scale * scale,
        4.0 * bright,
        place([4.0, 16.0, 4.0]),
        [8.0 * scale, 0.0, 0.0],
        [0.0, 0.0, 8.0 * scale],
        3.0 * bright
    );
    Case::new(&text, noisy([8; 3], 4))
}

#[test]
fn units_place_and_brightness_in_powers_of_two_do_not_change_a_bit() {
    let plain = lit(1.0, 0.0, 1.0).film_of(4);
    all_finite(&plain);
    let plain_bits = bits(&plain);
    for (what, scale, shift) in
        [("1024 times", 1024.0, 0.0), ("1/1024", 1.0 / 1024.0, 0.0), ("moved", 1.0, 8192.0)]
    {
        assert!(bits(&lit(scale, shift, 1.0).film_of(4)) == plain_bits, "{what}");
    }
    for (dim, bright) in plain.iter().zip(&lit(1.0, 0.0, 2.0).film_of(4)) {
        for c in 0..3 {
            assert_eq!(2.0 * dim.mean()[c], bright.mean()[c]);
        }
    }
}

#[test]
fn units_and_place_do_not_change_the_picture() {
    // The device gets the same local numbers but for last bits, which lead some paths apart.
    let plain = lit(1.0, 0.0, 1.0).film_of(16);
    let frames = [
        ("thousandfold", 1e3, 0.0),
        ("a thousandth", 1e-3, 0.0),
        ("moved by 10⁴", 1.0, 1e4),
        ("both", 1e-3, 10.1),
    ];
    for (what, scale, shift) in frames {
        let film = lit(scale, shift, 1.0).film_of(16);
        all_finite(&film);
        for channel in 0..3 {
            let (a, b) = (of_film(&plain, channel), of_film(&film, channel));
            let z = a.deviation(b, 0.0);
            println!("{what}, channel {channel}: {a:?} {b:?}: {z:.2} σ");
            assert!(z < family(12), "{what}: {a:?} {b:?}");
        }
        // Most paths are the same: so are most of the pixels, to rounding.
        let same = plain.iter().zip(&film).filter(|(p, q)| (p.mean()[1] - q.mean()[1]).abs() < 1e-4).count();
        println!("{what}: {same} of {} pixels agree to 10⁻⁴", film.len());
    }
}

#[test]
fn lights_in_the_medium_and_in_its_faces_agree_with_the_twin() {
    let lights = [
        // Beside voxels' centres, on one, and on a face of the box; no ray of the camera comes nearer than 0.9.
        "kind = \"point\"\nposition = [1.6, 6.3, 2.9]\nintensity = 20",
        "kind = \"point\"\nposition = [1.5, 6.5, 3.5]\nintensity = 20",
        "kind = \"point\"\nposition = [4, 4, 0]\nintensity = 20",
        // In a face, shining in and out; cutting through the medium.
        "kind = \"rectangle\"\ncentre = [4, 8, 4]\nedge_u = [5, 0, 0]\nedge_v = [0, 0, 5]\nradiance = 1",
        "kind = \"rectangle\"\ncentre = [4, 8, 4]\nedge_u = [0, 0, 5]\nedge_v = [5, 0, 0]\nradiance = 1",
        "kind = \"rectangle\"\ncentre = [4, 4, 4]\nedge_u = [0, 3, 1]\nedge_v = [2, 0, 1]\nradiance = 1",
        // Along the faces.
        "kind = \"directional\"\ndirection = [0, 0, 1]\nirradiance = 4",
    ];
    for light in lights {
        let text = format!(
            "[image]\nwidth = {SIDE}\nheight = {SIDE}\n[camera]\nposition = [20, 26, -15]\ntarget = [4, 4, 4]\nfov = 6\n\
             [volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = 0.5\nalbedo = 0.8\n\
             [transfer]\nresolution = 2\n[[light]]\n{light}\n[method]\nkind = \"single-scattering\"\n"
        );
        let case = Case::new(&text, noisy([8; 3], 4));
        compare_blocks(&light.replace('\n', ", "), &case.film_of(64), &Twin::new(&case).image(32), SIDE, 2);
    }
}

/// Tiles whose rays pass the medium by are not followed before a constant background. Before a map of that one colour
/// they are, with the same random numbers: nothing may be missing, from any side, with a lens, beside the eye.
#[test]
fn tiles_that_pass_the_medium_by_miss_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let map = write_map(folder.path(), 2, 1, |_, _| [0.5; 3]);
    let ball = || {
        let inside =
            |i: usize| [i % 40, i / 40 % 40, i / 1600].map(|x| (x as f64 - 20.0).powi(2)).iter().sum::<f64>();
        volume_f32([40; 3], (0..64_000).map(|i| if inside(i) < 100.0 { 1.0 } else { 0.0 }))
    };
    let cameras = [
        "position = [90, 70, -60]\ntarget = [24, 12, 20]\nup = [0.3, 1, 0.2]\nfov = 40\naperture = 6\nfocus = 60",
        "position = [33, 22, 19]\ntarget = [20, 35, 24]\nfov = 120",
        "kind = \"orthographic\"\nposition = [60, 70, -60]\ntarget = [20, 14, 20]\nup = [0, 0, 1]\nheight = 60",
    ];
    for camera in cameras {
        let film = |background: &str| {
            let text = format!(
                "[image]\nwidth = 92\nheight = 60\n[camera]\n{camera}\n[volume]\nwindow = {{ lo = 0, hi = 1 }}\n\
                 [medium]\nsigma_max = 0.3\nalbedo = 0.8\n[transfer]\npoints = [{{ value = 0, opacity = 0, color = 1 }}, \
                 {{ value = 1, opacity = 1, color = 1 }}]\n[background]\n{background}\n\
                 [method]\nkind = \"multiple-scattering\"\n"
            );
            Case::new(&text, ball()).film_of(2)
        };
        let (constant, map) = (film("color = 0.5"), film(&format!("environment = '{}'", map.display())));
        let untouched = constant.iter().filter(|pixel| pixel.mean()[3] == 0.0).count();
        assert!((1000..constant.len() - 100).contains(&untouched), "{untouched} pixels without medium");
        for (a, b) in constant.iter().zip(&map) {
            for (a, b) in a.mean().into_iter().zip(b.mean()) {
                // Sums of 8 paths, each rounded a few times.
                assert!((a - b).abs() < 64.0 * EPS, "{a} and {b} with {camera}");
            }
        }
    }
}

/// Steps between collisions that float32 coordinates do not resolve would keep a path where it is for ever.
#[test]
fn extinctions_that_paths_cannot_follow_are_refused() {
    let plan = |sigma: &str| {
        let text = format!(
            "[image]\nwidth = 8\nheight = 8\n[camera]\nposition = [2, 2, -9]\ntarget = [2, 2, 2]\n\
             [volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = {sigma}\n\
             [method]\nkind = \"multiple-scattering\"\n"
        );
        let case = Case::new(&text, checkerboard(4));
        Plan::new(&case.scene, &case.volume, BRICK_SHIFT).map(drop).map_err(|error| error.to_string())
    };
    assert_eq!(plan("2e6"), Ok(()));
    let message = plan("1e30").unwrap_err();
    assert!(message.contains("4.0e30 mean free paths across the box"), "{message}");
    assert!(message.contains("lower `medium.sigma_max`"), "{message}");
}
