//! White furnaces: where nothing is absorbed and light of radiance 1 comes from everywhere, all that is seen is 1.
//!
//! Where light is found by leaving the volume, every path brings back exactly 1, so every pixel is 1 to the rounding of
//! its float32 weights from the first sample. Where it is looked for, or channels have extinctions of their own, weights
//! differ and only the mean is 1.

mod common;

use common::scattering::{all_finite, compare_blocks, family, of_film, write_map};
use common::{Case, noisy, smooth, volume_f32};
use svetlo::film::FilmPixel;
use svetlo::reference::scattering::Estimate;
use svetlo::volume::Volume;

const SIDE: usize = 24;

const PHASES: [&str; 6] = [
    "kind = \"isotropic\"",
    "kind = \"henyey-greenstein\"\ng = 0.9",
    "kind = \"henyey-greenstein\"\ng = -0.9",
    "kind = \"henyey-greenstein\"\ng = 0.5",
    "kind = \"rayleigh\"",
    "kind = \"two-lobe\"\ng = [0.9, -0.4]\nweight = 0.7",
];

const TRANSFERS: [&str; 4] = [
    // Opacity is the value.
    "resolution = 2",
    // Bumps narrower than a cell of a noisy field.
    "points = [{ value = 0.3, opacity = 0 }, { value = 0.32, opacity = 1 }, { value = 0.34, opacity = 0 },\n\
     { value = 0.8, opacity = 0 }, { value = 0.81, opacity = 0.7 }]",
    // A step: empty or dense.
    "points = [{ value = 0.5, opacity = 0 }, { value = 0.501, opacity = 1 }]",
    "kind = \"2d\"\ngradient_max = 0.8\nshapes = [{ shape = \"ellipse\", centre = [0.6, 0.3], size = [0.7, 0.9], \
     opacity = 0.9, softness = 0.6 }, { shape = \"rectangle\", centre = [0.2, 0.8], size = [0.3, 0.4], opacity = 0.4 }]",
];

fn view() -> String {
    format!(
        "[image]\nwidth = {SIDE}\nheight = {SIDE}\n[camera]\nposition = [34, 21, -19]\ntarget = [6, 5, 6]\nfov = 28\n"
    )
}

/// Everything but the background and the method.
fn scene(transfer: &str, phase: &str) -> String {
    format!(
        "{}[volume]\nspacing = [1, 0.8, 1.1]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = 1.3\n\
         [transfer]\n{transfer}\n[phase]\n{phase}\n",
        view()
    )
}

type Maker = fn() -> Volume;

const VOLUMES: [(&str, Maker); 2] =
    [("noisy", || noisy([12, 13, 11], 5)), ("smooth", || smooth([12, 13, 11], 9))];

/// Every pixel and channel is 1.
#[track_caller]
fn white(what: &str, film: &[FilmPixel]) {
    all_finite(film);
    for (index, pixel) in film.iter().enumerate() {
        for value in &pixel.mean()[..3] {
            assert!((value - 1.0).abs() < 1e-6, "{what}: pixel {index} is {value}");
        }
    }
}

/// The mean over blocks and channels is 1, by the pixels' variances.
#[track_caller]
fn white_on_average(what: &str, film: &[FilmPixel]) {
    let one = Estimate { mean: [1.0; 3], error: [0.0; 3] };
    compare_blocks(what, film, &vec![one; SIDE * SIDE], SIDE, 4);
}

#[test]
fn constant_light_is_white_in_every_pixel() {
    for (v, (name, volume)) in VOLUMES.into_iter().enumerate() {
        for (i, transfer) in TRANSFERS.iter().enumerate() {
            // Each phase with some transfer functions and volumes, each of them with some phases.
            for phase in PHASES.iter().skip((i + 2 * v) % 4).step_by(4) {
                let text = format!(
                    "{}[background]\ncolor = 1\n[method]\nkind = \"multiple-scattering\"\n",
                    scene(transfer, phase)
                );
                let film = Case::new(&text, volume()).film_of(4);
                white(&format!("{name}, {transfer}, {phase}"), &film);
            }
        }
    }
}

#[test]
fn majorants_and_paths_do_not_matter() {
    for method in
        ["majorant_scale = 1.7", "majorant_scale = 20", "paths = 1", "paths = 7", "max_order = 1000000"]
    {
        let text = format!(
            "{}[background]\ncolor = 1\n[method]\nkind = \"multiple-scattering\"\n{method}\n",
            scene(TRANSFERS[1], PHASES[1])
        );
        white(method, &Case::new(&text, noisy([12, 13, 11], 5)).film_of(4));
    }
}

#[test]
fn single_scattering_is_white_where_the_rest_cannot_be() {
    // Opacity 10⁻³ in all: what is scattered twice, 10⁻⁶, is missing.
    let text = format!(
        "{}[background]\ncolor = 1\n[method]\nkind = \"single-scattering\"\n",
        scene("resolution = 2", PHASES[3]).replace("sigma_max = 1.3", "sigma_max = 5e-5")
    );
    let film = Case::new(&text, noisy([12, 13, 11], 5)).film_of(16);
    all_finite(&film);
    // Chords are below 23; the missing part is below half the square of the depth, 1.2·10⁻³.
    let mean = of_film(&film, 1);
    mean.agrees("thin single scattering", 1.0, 3.0, 0.5 * 1.2e-3_f64.powi(2));
}

#[test]
fn maps_are_white_by_escape_and_by_importance() {
    let folder = tempfile::tempdir().unwrap();
    let map = write_map(folder.path(), 16, 8, |_, _| [1.0; 3]);
    let background = |sampling: &str| {
        format!("[background]\nenvironment = '{}'\nrotation = 30\nsampling = \"{sampling}\"\n", map.display())
    };
    for phase in PHASES {
        let text = format!(
            "{}{}[method]\nkind = \"multiple-scattering\"\n",
            scene(TRANSFERS[2], phase),
            background("escape")
        );
        white(&format!("escape, {phase}"), &Case::new(&text, noisy([12, 13, 11], 5)).film_of(4));
        let all = ["auto", "analog", "ratio", "residual-ratio", "ray-marching"];
        for transmittance in if phase == PHASES[1] { &all[..] } else { &all[..1] } {
            let text = format!(
                "{}{}[method]\nkind = \"multiple-scattering\"\ntransmittance = \"{transmittance}\"\n",
                scene(TRANSFERS[2], phase),
                background("importance")
            );
            let film = Case::new(&text, noisy([12, 13, 11], 5)).film_of(24);
            white_on_average(&format!("importance, {transmittance}, {phase}"), &film);
        }
    }
}

#[test]
fn channels_of_different_extinction_are_white_on_average() {
    for (color, phase) in [("[1, 0.6, 0.2]", PHASES[0]), ("[0.1, 0, 1]", PHASES[5])] {
        let text = format!(
            "{}[background]\ncolor = 1\n[method]\nkind = \"multiple-scattering\"\n",
            scene(TRANSFERS[0], phase)
                .replace("sigma_max = 1.3", &format!("sigma_max = 1.3\nextinction_color = {color}"))
        );
        let film = Case::new(&text, noisy([12, 13, 11], 5)).film_of(64);
        white_on_average(&format!("extinction {color}"), &film);
    }
}

#[test]
fn media_in_thermal_equilibrium_are_invisible() {
    // Whatever absorbs glows as much as what it hides.
    let glowing = "resolution = 3\npoints = [{ value = 0, opacity = 0, color = [0.9, 0.5, 0], emission = 1 },\n\
                   { value = 1, opacity = 1, color = [0.2, 0.8, 1], emission = 1 }]";
    for method in ["", "transmittance = \"ratio\"\n"] {
        let text = format!(
            "{}[background]\ncolor = 1\n[method]\nkind = \"multiple-scattering\"\n{method}",
            scene(glowing, PHASES[3])
        );
        let film = Case::new(&text, noisy([12, 13, 11], 5)).film_of(64);
        white_on_average("equilibrium", &film);
    }
}

#[test]
fn no_light_is_black() {
    let text = format!("{}[method]\nkind = \"multiple-scattering\"\n", scene(TRANSFERS[0], PHASES[1]));
    for pixel in Case::new(&text, noisy([12, 13, 11], 5)).film_of(2) {
        assert_eq!(pixel.mean()[..3], [0.0; 3]);
        assert_eq!(pixel.rejected, 0);
    }
}

#[test]
fn furnaces_are_white_from_inside_and_with_one_voxel_across() {
    for (what, dims, camera) in [
        ("inside", [12, 13, 11], "position = [6, 5, 6]\ntarget = [7, 5.5, 6.2]\nfov = 100"),
        ("a rod", [1, 1, 17], "position = [9, 7, 3]\ntarget = [0.5, 0.5, 8]\nfov = 60"),
        ("a sheet", [19, 1, 18], "position = [9, 7, 3]\ntarget = [5, 0.5, 8]\nfov = 60"),
        ("a voxel", [1, 1, 1], "position = [9, 7, 3]\ntarget = [0.5, 0.5, 0.5]\nfov = 10"),
    ] {
        let text = format!(
            "[image]\nwidth = {SIDE}\nheight = {SIDE}\n[camera]\n{camera}\n[volume]\nwindow = {{ lo = 0, hi = 1 }}\n\
             [medium]\nsigma_max = 2\n[transfer]\nresolution = 2\n[background]\ncolor = 1\n\
             [method]\nkind = \"multiple-scattering\"\n"
        );
        let volume = if dims == [1, 1, 1] { volume_f32(dims, [0.7]) } else { noisy(dims, 8) };
        white(what, &Case::new(&text, volume).film_of(8));
    }
    assert!(family(1) > 2.99 && family(1) < 3.01);
}
