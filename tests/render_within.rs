//! Bodies of glass with something in them: what they absorb on the way to it, of photons, camera rays and shadow rays.
//!
//! All bodies here have the index 1, so that light goes straight on: pictures with and without absorption differ by the
//! factor of Beer and Lambert alone, pixel by pixel.

mod common;
#[path = "common/photons.rs"]
mod photons;

use common::{EPS, close, device};
use glam::DVec3;
use photons::{PAPER, floor, sphere};
use std::path::Path;
use svetlo::caustics::{PassLedger, color_of, mean_color};
use svetlo::film::FilmPixel;
use svetlo::render::{BRICK_SHIFT, Plan, SceneData, Session};
use svetlo::scene::{Light, Scene, SurfaceMaterial, SurfaceShape};

/// A look straight down from z = 4, through the centres of pixels, at a white floor at z = 0.
const VIEW: &str = "[image]\nwidth = 4\nheight = 4\nfilter = \"point\"\n\
    [camera]\nkind = \"orthographic\"\nposition = [0, 0, 4]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\nheight = 1\n\
    [[material]]\nname = \"white\"\nkind = \"diffuse\"\ncolor = 1\n\
    [[surface]]\nkind = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nmaterial = \"white\"\n";
const WATER: [f64; 3] = [0.1, 0.5, 1.5];
const AMBER: [f64; 3] = [2.0, 0.7, 0.3];
const POOL: &str =
    "[[surface]]\nkind = \"plane\"\npoint = [0, 0, 1]\nnormal = [0, 0, 1]\nmaterial = \"water\"\n";
const SUN: &str = "[[light]]\nkind = \"directional\"\ndirection = [0, 0, -1]\nirradiance = 1\n";
const LAMP: &str = "[[light]]\nkind = \"point\"\nposition = [0, 0, 0.75]\nintensity = 1\n";
const PHOTONS: &str = "[method]\nkind = \"caustics\"\nphotons = 10000\nradius = 0.2\nbounces = 0\n\
    [method.emission]\ntarget = { centre = [0, 0, 3.5], edge_u = [2, 0, 0], edge_v = [0, 2, 0] }\n";
const DEEP_POOL: &str =
    "[[surface]]\nkind = \"plane\"\npoint = [0, 0, 5]\nnormal = [0, 0, 1]\nmaterial = \"water\"\n";
const NO_PHOTONS: &str = "[method]\nkind = \"caustics\"\nphotons = 0\n";

/// Rays start off the surface that they leave by 32 roundings of its coordinates, here up to 12: at most 12 times on the way to
/// the ground and back, through what absorbs 2 per unit at most.
const OFFSETS: f64 = 12.0 * 12.0 * 2.0 * 32.0 * EPS;

fn glass(name: &str, absorption: [f64; 3]) -> String {
    let [r, g, b] = absorption;
    format!("[[material]]\nname = \"{name}\"\nkind = \"dielectric\"\nior = 1\nabsorption = [{r}, {g}, {b}]\n")
}

fn cuboid(low: f64, high: f64, material: &str) -> String {
    let half = 2.0 * high;
    format!(
        "[[surface]]\nkind = \"box\"\nlow = [-{half}, -{half}, {low}]\nhigh = [{half}, {half}, {high}]\n\
         material = \"{material}\"\n"
    )
}

fn render(text: &str) -> (Vec<FilmPixel>, PassLedger) {
    render_samples(text, 1)
}

fn render_samples(text: &str, samples: u32) -> (Vec<FilmPixel>, PassLedger) {
    let loaded = svetlo::config::parse("test.toml", text, &[]).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let scene =
        Scene::from_loaded(&loaded, Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap_or_else(|e| panic!("{e}"));
    let data = SceneData::load(&scene).unwrap();
    let mut session = Session::new(device(), &Plan::new(&scene, &data, BRICK_SHIFT).unwrap()).unwrap();
    session.render(samples).unwrap();
    (session.film().unwrap(), *session.photons().unwrap())
}

/// Renders a scene with what its bodies absorb and without; every pixel must differ by e^-depth of its channel. Gives the
/// ledger with absorption.
fn differ_by(scene: &str, depth: impl Fn(usize, usize) -> f64) -> PassLedger {
    let [(dark, ledger), (clear, _)] = [(WATER, AMBER), ([0.0; 3], [0.0; 3])].map(|(water, amber)| {
        render(&format!("{VIEW}{}{}{scene}", glass("water", water), glass("amber", amber)))
    });
    for (index, (dark, clear)) in dark.iter().zip(&clear).enumerate() {
        for c in 0..3 {
            let (found, from, depth) = (dark.mean()[c], clear.mean()[c], depth(index, c));
            assert!(from > 0.0, "pixel {index} is lit");
            let expected = from * (-depth).exp();
            close(&format!("pixel {index}"), found, expected, OFFSETS * expected);
        }
    }
    ledger
}

#[test]
fn water_takes_of_the_light_on_its_way_to_the_ground_and_back() {
    let ledger = differ_by(&format!("{POOL}{SUN}{PHOTONS}"), |_, c| 2.0 * WATER[c]);
    let stored = WATER.iter().map(|a| (-a).exp()).sum::<f64>() / 3.0;
    let flux = ledger.flux;
    close("stored", flux.stored / flux.emitted, stored, OFFSETS * stored);
    close("absorbed", flux.absorbed / flux.emitted, 1.0 - stored, OFFSETS * stored);
}

#[test]
fn what_is_between_bodies_in_a_body_is_of_that_one() {
    // Amber from 1.5 to 2 and from 2.25 to 2.5 in water from 1 to 3.
    let bodies = [cuboid(1.0, 3.0, "water"), cuboid(1.5, 2.0, "amber"), cuboid(2.25, 2.5, "amber")].concat();
    differ_by(&format!("{bodies}{SUN}{PHOTONS}"), |_, c| 2.0 * (1.25 * WATER[c] + 0.75 * AMBER[c]));
}

#[test]
fn lamps_in_water_light_the_ground_through_it() {
    differ_by(&format!("{POOL}{LAMP}{NO_PHOTONS}"), |index, c| {
        let [x, y] = [index % 4, index / 4].map(|i| (i as f64 - 1.5) / 4.0);
        WATER[c] * (1.0 + (0.75_f64.powi(2) + x * x + y * y).sqrt())
    });
}

#[test]
fn cameras_in_amber_in_water_look_out_of_both() {
    // The camera at z = 4; light from above through all of it.
    let bodies = [cuboid(1.0, 5.0, "water"), cuboid(3.5, 4.5, "amber")].concat();
    differ_by(&format!("{bodies}{SUN}{PHOTONS}"), |_, c| 5.5 * WATER[c] + 1.5 * AMBER[c]);
    // A ball of amber instead, and half-spaces of water, one of which is not there to be left on the way down.
    let ball = "[[surface]]\nkind = \"sphere\"\ncentre = [0, 0, 4]\nradius = 0.75\nmaterial = \"amber\"\n";
    differ_by(&format!("{ball}{DEEP_POOL}{LAMP}{NO_PHOTONS}"), |index, c| {
        let [x, y] = [index % 4, index / 4].map(|i| (i as f64 - 1.5) / 4.0);
        let amber = (0.75_f64.powi(2) - x * x - y * y).sqrt();
        AMBER[c] * amber + WATER[c] * (4.0 - amber + (0.75_f64.powi(2) + x * x + y * y).sqrt())
    });
}

/// Photons alone: of a lamp 0.75 above the ground, in a ball of amber of radius 0.2 or in a plate of it from 0.5 to 1, all in
/// water up to 1 or beyond. They go through a square of 1 that is 0.5 below the lamp.
#[test]
fn photons_of_lamps_in_amber_in_water_lose_what_both_take() {
    let lamp = DVec3::Z * 0.75;
    let glass = |absorption| SurfaceMaterial::Dielectric { cauchy: [1.0, 0.0, 0.0], absorption };
    let plate = SurfaceShape::Box { low: DVec3::new(-2.0, -2.0, 0.5), high: DVec3::new(2.0, 2.0, 1.0) };
    // Out of the way, so that all have one program.
    let aside = |shape: SurfaceShape| (shape, PAPER);
    let far = DVec3::Z * -60.0;
    let far_box = SurfaceShape::Box { low: far - 1.0, high: far };
    type Amber = fn(f64) -> f64;
    let bodies: [(SurfaceShape, SurfaceShape, Amber); 2] =
        [(sphere(lamp, 0.2), far_box, |_| 0.2), (plate, sphere(far, 1.0), |slant| 0.25 * slant)];
    for (body, other, amber) in bodies {
        for surface in [1.0, 5.0] {
            let water = SurfaceShape::Plane { point: DVec3::Z * surface, normal: DVec3::Z };
            let parts =
                [floor(0.0), (water, glass(WATER)), (body.clone(), glass(AMBER)), aside(other.clone())];
            let light = Light::Point { position: lamp, intensity: [1.0; 3] };
            let mut scene =
                photons::Scene::new(parts, [light], 40_000).through(DVec3::Z * 0.25, DVec3::X, DVec3::Y);
            scene.settings.store_direct = true;
            let flux = scene.ledger(1);
            // The mean over the solid angle of the square, by the midpoints of 400 cells.
            let (mut sum, mut whole) = (0.0, 0.0);
            for i in 0..400 {
                let [x, y] = [i % 20, i / 20].map(|k| (f64::from(k) + 0.5) / 20.0 - 0.5);
                let slant = (x * x + y * y + 0.25).sqrt() / 0.5;
                let depth = |c: usize| AMBER[c] * amber(slant) + WATER[c] * (0.75 * slant - amber(slant));
                whole += slant.powi(-3);
                sum += slant.powi(-3) * (0..3).map(|c| (-depth(c)).exp()).sum::<f64>() / 3.0;
            }
            // Photons in cells of 1/200: sums of smooth functions to 1e-4, those of the quadrature to 1e-3.
            close("stored", flux.stored / flux.emitted, sum / whole, 2e-3);
            close("ledger", flux.imbalance(), 0.0, 1e-5);
        }
    }
}

/// Bodies of glass one below the other that the camera looks down on from outside, near a ball in whose bounds it is: `boxes` of
/// them, 0.4 thick with gaps of 0.6.
fn row_below(boxes: usize) -> String {
    let view = VIEW.split("[[surface]]").next().unwrap().replace("height = 1\n", "height = 0.01\n");
    let ball = "[[surface]]\nkind = \"sphere\"\ncentre = [9, 9, 13]\nradius = 9.5\nmaterial = \"amber\"\n";
    let row: String = (0..boxes)
        .map(|k| 3.5 - k as f64)
        .map(|low| {
            format!(
                "[[surface]]\nkind = \"box\"\nlow = [-0.5, -0.5, {low}]\nhigh = [0.5, 0.5, {}]\nmaterial = \"water\"\n",
                low + 0.4
            )
        })
        .collect();
    let [water, amber] = [glass("water", WATER), glass("amber", AMBER)];
    let method = NO_PHOTONS.replace("photons = 0", "photons = 0\ndepth = 200");
    format!("{view}{water}{amber}{ball}{row}{method}[background]\ncolor = 1\n")
}

#[test]
fn bodies_in_a_row_are_not_what_the_camera_is_in() {
    for boxes in [9, 40] {
        for pixel in render(&row_below(boxes)).0 {
            for (found, absorption) in pixel.mean().into_iter().zip(WATER) {
                let n = boxes as f64;
                let expected = (-0.4 * n * absorption).exp();
                // Rays start 32 roundings of a coordinate off each of 2 n faces, which are up to n + 19 from the origin.
                let tolerance = 2.0 * n * 32.0 * EPS * (n + 19.0) * absorption + 8.0 * n * EPS;
                close(&format!("{boxes} boxes"), found / expected, 1.0, tolerance);
            }
        }
    }
}

#[test]
fn cameras_in_flint_see_some_colours_leave_and_others_stay() {
    // Up through a surface of flint, at an angle at which green leaves it and violet is reflected; the sky shines above and below.
    const FLINT: [f64; 3] = [1.6, 0.02, 0.0];
    let angle = 36.5_f64.to_radians();
    let text = format!(
        "[image]\nwidth = 8\nheight = 8\nfilter = \"point\"\n\
         [camera]\nkind = \"orthographic\"\nposition = [{}, 0, -1]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\nheight = 1e-3\n\
         [[material]]\nname = \"flint\"\nkind = \"dielectric\"\ndispersion = {{ a = 1.6, b = 0.02 }}\n\
         [[surface]]\nkind = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nmaterial = \"flint\"\n\
         {NO_PHOTONS}[background]\ncolor = 1\n",
        -angle.tan()
    );
    const SAMPLES: u32 = 256;
    let film = render_samples(&text, SAMPLES).0;
    for (c, white) in mean_color().into_iter().enumerate() {
        // Over wavelengths: what is reflected shows the sky below, what leaves that above, n^2 as bright from within.
        let (mut expected, mut largest) = (0.0, 0.0_f64);
        for step in 0..3500 {
            let nanometres = 380.0 + (f64::from(step) + 0.5) / 10.0;
            let n = svetlo::reference::optics::cauchy(FLINT, 1e-3 * nanometres);
            let reflected = svetlo::reference::optics::fresnel(n, 1.0, angle.cos());
            let seen = color_of(nanometres)[c] / white * (reflected + (1.0 - reflected) * n * n);
            expected += seen / 3500.0;
            largest = largest.max(seen.abs());
        }
        let found = film.iter().map(|pixel| pixel.mean()[c]).sum::<f64>() / film.len() as f64;
        // Each pixel's wavelengths are evenly spread to 3 in SAMPLES; it takes one way or splits, by chance.
        let tolerance = largest * (3.0 / f64::from(SAMPLES) + 2.5 / f64::from(64 * SAMPLES).sqrt());
        close(&format!("channel {c}"), found, expected, tolerance);
    }
}

/// The pool seen with fog from the ground to z = 2 that scatters nothing, and without.
fn in_fog(pool: &str) -> [Vec<FilmPixel>; 2] {
    [0.7, 0.0].map(|sigma| {
        let text = format!(
            "{VIEW}{}{pool}{LAMP}{NO_PHOTONS}[volume]\nfield = {{ kind = \"constant\" }}\ndims = [1, 1, 1]\nspacing = [4, 4, 2]\n\
             origin = [-2, -2, 0]\nwindow = {{ lo = 0, hi = 1 }}\n[transfer]\npoints = [{{ value = 0, opacity = 1, color = 0 }}]\n\
             [medium]\nsigma_max = {sigma}\n",
            glass("water", [0.0; 3])
        );
        render(&text).0
    })
}

#[test]
fn there_is_no_fog_in_water() {
    // Only what is above the water takes of the view.
    let [dim, clear] = in_fog(POOL);
    for (dim, clear) in dim.iter().zip(&clear) {
        let expected = clear.mean()[0] * (-0.7_f64).exp();
        close("fog", dim.mean()[0], expected, 40.0 * EPS * expected);
    }
    // With the camera in the water, nothing.
    let [dim, clear] = in_fog(DEEP_POOL);
    for (dim, clear) in dim.iter().zip(&clear) {
        assert_eq!((dim.mean(), clear.mean()[0] > 0.0), (clear.mean(), true));
    }
}
