//! A volume among surfaces: what it takes of direct light, photons and camera rays, and what it scatters.

mod common;

use common::{EPS, close, device};
use std::f64::consts::PI;
use std::path::Path;
use svetlo::caustics::PassLedger;
use svetlo::film::FilmPixel;
use svetlo::render::{BRICK_SHIFT, Plan, SceneData, Session};
use svetlo::scene::Scene;

/// Materials; and far away one of each shape, so that few kernels are for all scenes.
const SURFACES: &str = "[[material]]\nname = \"white\"\nkind = \"diffuse\"\ncolor = 1\n\
    [[material]]\nname = \"mirror\"\nkind = \"mirror\"\ncolor = [0.9, 0.6, 0.3]\n\
    [[material]]\nname = \"glass\"\nkind = \"dielectric\"\nior = 1.5\n\
    [[material]]\nname = \"nothing\"\nkind = \"dielectric\"\nior = 1\n\
    [[surface]]\nkind = \"sphere\"\ncentre = [50, 50, 50]\nradius = 0.1\nmaterial = \"white\"\n\
    [[surface]]\nkind = \"box\"\nlow = [50, 50, 60]\nhigh = [50.1, 50.1, 60.1]\nmaterial = \"white\"\n\
    [[surface]]\nkind = \"plane\"\npoint = [80, 0, 0]\nnormal = [-1, 0, 0]\nmaterial = \"white\"\n";

fn parsed(text: &str) -> svetlo::Result<Scene> {
    let loaded = svetlo::config::parse("test.toml", text, &[])?;
    Scene::from_loaded(&loaded, Path::new(env!("CARGO_MANIFEST_DIR")))
}

fn render(text: &str, samples: u32) -> (Vec<FilmPixel>, Option<PassLedger>) {
    let scene = parsed(text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let data = SceneData::load(&scene).unwrap();
    let plan = Plan::new(&scene, &data, BRICK_SHIFT).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let mut session = Session::new(device(), &plan).unwrap();
    session.render(samples).unwrap();
    (session.film().unwrap(), session.photons().copied())
}

/// A camera without perspective, a surface square of `extent` × `extent` seen by `pixels` × `pixels`.
fn camera(pixels: u32, extent: f64, from: [f64; 3], to: [f64; 3], up: [f64; 3]) -> String {
    format!(
        "[image]\nwidth = {pixels}\nheight = {pixels}\nfilter = \"point\"\n[camera]\nkind = \"orthographic\"\n\
         position = {from:?}\ntarget = {to:?}\nup = {up:?}\nheight = {extent}\n{SURFACES}"
    )
}

/// Where the ray through the centre of a pixel is: to the right and up, from the middle.
fn place(index: usize, pixels: u32, extent: f64) -> (f64, f64) {
    let n = f64::from(pixels);
    let (i, j) = (index % pixels as usize, index / pixels as usize);
    (extent * ((i as f64 + 0.5) / n - 0.5), extent * (0.5 - (j as f64 + 0.5) / n))
}

/// A volume that fills the box, of one extinction or of one that rises along z from 0 to twice that.
fn fog(low: [f64; 3], size: [f64; 3], sigma: f64, ramp: bool) -> String {
    let (field, opacity) = if ramp { ("kind = \"ramp\"", 0) } else { ("kind = \"constant\"", 1) };
    let cells = if ramp { [3, 2, 40] } else { [1, 1, 1] };
    let spacing: Vec<f64> = size.iter().zip(cells).map(|(size, n)| size / f64::from(n)).collect();
    format!(
        "[volume]\nfield = {{ {field} }}\ndims = {cells:?}\nspacing = {spacing:?}\norigin = {low:?}\nwindow = {{ lo = 0, hi = 1 }}\n\
         [transfer]\npoints = [ {{ value = 0, opacity = {opacity}, color = 1 }}, {{ value = 1, opacity = 1, color = 1 }} ]\n\
         [medium]\nsigma_max = {}\n",
        if ramp { 2.0 * sigma } else { sigma }
    )
}

const FLOOR: &str =
    "[[surface]]\nkind = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nmaterial = \"white\"\n";
const DOWN: &str = "[[light]]\nkind = \"directional\"\ndirection = [0, 0, -1]\n";

#[test]
fn a_layer_between_lamp_and_floor_takes_the_light_that_crosses_it() {
    for ramp in [false, true] {
        let layer = fog([-20.0, -20.0, 1.0], [40.0, 40.0, 1.0], 0.7, ramp);
        let text = format!(
            "{}{layer}albedo = 0\n{FLOOR}[[light]]\nkind = \"point\"\nposition = [0.3, -0.2, 3]\nintensity = [3, 2, 1]\n\
             [method]\nkind = \"caustics\"\n",
            camera(8, 4.0, [0.0, 0.0, 0.5], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0])
        );
        let samples = if ramp { 256 } else { 1 };
        let (film, _) = render(&text, samples);
        for (index, pixel) in film.iter().enumerate() {
            let (x, y) = place(index, 8, 4.0);
            let square = (x - 0.3).powi(2) + (y + 0.2).powi(2) + 9.0;
            let left = (-0.7 * square.sqrt() / 3.0).exp();
            for (c, intensity) in [3.0, 2.0, 1.0].into_iter().enumerate() {
                let expected = intensity / PI * 3.0 / square.powf(1.5) * left;
                let noise = pixel.variance().map_or(0.0, |v| (v[c] / f64::from(samples)).sqrt());
                // 16 roundings of places and products, twice that where distances are cubed; 512 pixels and channels.
                close(
                    &format!("pixel {index}"),
                    pixel.mean()[c],
                    expected,
                    6.0 * noise + 64.0 * EPS * expected,
                );
            }
        }
    }
}

#[test]
fn fog_that_nothing_shines_through_shows_what_its_front_scatters() {
    const SAMPLES: u32 = 64;
    for sigma in [0.1, 3.0, 100.0, 1e4] {
        // 2 deep, seen along the light.
        let text = format!(
            "{}{}albedo = 0.8\n{DOWN}irradiance = 1\n[method]\nkind = \"caustics\"\nphotons = 0\n",
            camera(4, 1.0, [0.0, 0.0, 5.0], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
            fog([-20.0, -20.0, 0.0], [40.0, 40.0, 2.0], sigma, false)
        );
        let (film, _) = render(&text, SAMPLES);
        // The integral over the depth of what comes, is scattered into all directions alike, and is left of that.
        let expected = 0.8 / (8.0 * PI) * -(-4.0 * sigma).exp_m1();
        let pixels = film.len() as f64;
        let mean = film.iter().map(|pixel| pixel.mean()[0]).sum::<f64>() / pixels;
        let square: f64 = film.iter().map(|pixel| pixel.variance().unwrap()[0] / f64::from(SAMPLES)).sum();
        let noise = square.sqrt() / pixels;
        assert!(noise < 0.01 * expected, "sigma {sigma}: {noise} of {expected}");
        // Places, 3 away, and the fog's boundary are rounded: 4 times, each by so much of a mean free path.
        let rounding = (64.0 + 12.0 * sigma) * EPS * expected;
        close(&format!("sigma {sigma}"), mean, expected, 6.0 * noise + rounding);
    }
}

#[test]
fn what_is_behind_a_layer_is_seen_through_it_and_glass_displaces_it() {
    // A box that refracts nothing, half as deep as the layer, before the right half of the picture.
    let text = format!(
        "{}{}albedo = 0\n[[surface]]\nkind = \"box\"\nlow = [0, -5, 1]\nhigh = [5, 5, 2]\nmaterial = \"nothing\"\n\
         [background]\ncolor = [1, 2, 4]\n[method]\nkind = \"caustics\"\n",
        camera(6, 4.0, [0.0, 0.0, 9.0], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        fog([-20.0, -20.0, 0.0], [40.0, 40.0, 3.0], 0.4, false)
    );
    let (film, _) = render(&text, 1);
    for (index, pixel) in film.iter().enumerate() {
        let way = if place(index, 6, 4.0).0 > 0.0 { 2.0 } else { 3.0 };
        for (c, radiance) in [1.0, 2.0, 4.0].into_iter().enumerate() {
            let expected = radiance * (-0.4_f64 * way).exp();
            // Places to some 9 units; behind the box the ray starts by SURFACE_MARGIN of place and size, 6 and 5, later.
            let rounding = 32.0 * EPS + 0.4 * 4e-6 * 11.0;
            close(&format!("pixel {index}"), pixel.mean()[c], expected, rounding * expected);
        }
    }
}

#[test]
fn direct_light_is_scattered_once_as_by_single_scattering() {
    let point = "[[light]]\nkind = \"point\"\nposition = [0.4, -2, 1.5]\nintensity = [3, 2, 1]\n";
    let rectangle = "[[light]]\nkind = \"rectangle\"\ncentre = [0, 0, 3]\nedge_u = [0, 0.4, 0]\nedge_v = [0.4, 0, 0]\nradiance = 5\n";
    let forward = "kind = \"henyey-greenstein\"\ng = 0.4";
    for (phase, ramp, second) in [(forward, false, rectangle), ("kind = \"isotropic\"", true, "")] {
        let scene = |method: &str| {
            format!(
                "{}{}albedo = [0.9, 0.6, 0.3]\n[phase]\n{phase}\n{point}{second}[method]\n{method}",
                camera(6, 1.6, [3.0, -5.0, 1.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
                fog([-1.0, -1.0, -1.0], [2.0, 2.0, 2.0], 0.8, ramp)
            )
        };
        let (ours, _) = render(&scene("kind = \"caustics\"\n"), 128);
        let method = scene("kind = \"single-scattering\"\n").replace(SURFACES, "");
        let (theirs, _) = render(&method, 128);
        for (index, (a, b)) in ours.iter().zip(&theirs).enumerate() {
            for c in 0..3 {
                let sigma = ((a.variance().unwrap()[c] + b.variance().unwrap()[c]) / 128.0).sqrt();
                assert!(sigma < 0.1 * b.mean()[c], "{sigma} of {}", b.mean()[c]);
                // 216 values.
                close(&format!("pixel {index}"), a.mean()[c], b.mean()[c], 5.5 * sigma);
            }
        }
    }
}

/// A box in light that goes down, above a volume from z = 0 to 1, seen from the side.
fn beam(pixels: u32, phase: &str, ramp: bool, method: &str) -> String {
    format!(
        "{}{}albedo = [0.9, 0.6, 0.3]\n[phase]\n{phase}\n\
         [[surface]]\nkind = \"box\"\nlow = [-0.4, -0.4, 1.2]\nhigh = [0.4, 0.4, 1.4]\nmaterial = \"nothing\"\n\
         {DOWN}irradiance = 2\n\
         [method]\nkind = \"caustics\"\ndirect = \"none\"\n{method}",
        camera(pixels, 0.5, [0.0, -9.0, 0.5], [0.0, 0.0, 0.5], [0.0, 0.0, 1.0]),
        fog([-1.0, -1.0, 0.0], [2.0, 2.0, 1.0], 0.6, ramp)
    )
}

#[test]
fn photons_in_the_volume_show_the_beam_that_they_are_of() {
    // The box turns nothing, and its light counts as that of glass. Scattered once: two boundaries and one collision.
    let g = 0.5_f64;
    let lobe = (1.0 - g * g) / (4.0 * PI * (1.0 + g * g).powf(1.5));
    for (phase, share, ramp) in
        [("kind = \"isotropic\"", 0.25 / PI, false), ("kind = \"henyey-greenstein\"\ng = 0.5", lobe, true)]
    {
        let samples = 48;
        let text = beam(6, phase, ramp, "depth = 2\nphotons = 65536\nradius = 0.1\nalpha = 1\n");
        let (film, ledger) = render(&text, samples);
        let ledger = ledger.unwrap();
        for (index, pixel) in film.iter().enumerate() {
            let z = 0.5 + place(index, 6, 0.5).1;
            let sigma = if ramp { 1.2 * z } else { 0.6 };
            // From above to there, and from there to the camera: exp(-sigma (1 + y)) over the beam.
            let depth = if ramp { 0.6 * (1.0 - z * z) } else { 0.6 * (1.0 - z) };
            let across = ((-sigma * 0.6).exp() - (-sigma * 1.4_f64).exp()) / sigma;
            for (c, albedo) in [0.9, 0.6, 0.3].into_iter().enumerate() {
                let expected = 2.0 * albedo * sigma * share * (-depth).exp() * across;
                let noise = (pixel.variance().unwrap()[c] / f64::from(samples)).sqrt();
                assert!(noise < 0.07 * expected, "{noise} of {expected}");
                // The kernel's bias: a fifteenth of r² f'' (t² is 0.4 on average, a third of that along z), and f'' < 5 f.
                let bias = 0.1_f64.powi(2) / 15.0 * 5.0 * expected;
                close(&format!("{phase}, pixel {index}"), pixel.mean()[c], expected, 5.5 * noise + bias);
            }
        }
        let flux = &ledger.flux;
        assert!(flux.imbalance().abs() < 1e-5, "{}", flux.imbalance());
        let emitted = 2.0 * 0.64 * f64::from(samples);
        close("emitted", flux.emitted, emitted, 0.02 * emitted);
        // Optical depth 0.6; a photon is stopped or not, and the albedo is 0.6 on average.
        let stopped = 1.0 - (-0.6_f64).exp();
        let chance = 5.0 * (stopped * (1.0 - stopped) / f64::from(samples) / 65536.0).sqrt();
        let light = flux.emitted;
        close("scattered", flux.medium_scattered / light, 0.6 * stopped, chance);
        close("absorbed", flux.medium_absorbed / light, 0.4 * stopped, chance);
        assert_eq!(flux.medium_scattered, flux.truncated);
    }
}

#[test]
fn the_ledger_closes_around_a_glass_sphere_in_fog() {
    let text = format!(
        "{}{}albedo = [0.9, 0.8, 0.7]\n{FLOOR}\
         [[surface]]\nkind = \"sphere\"\ncentre = [0, 0, 1]\nradius = 0.5\nmaterial = \"glass\"\n\
         {DOWN}irradiance = 2\n[method]\nkind = \"caustics\"\nphotons = 32768\ndepth = 12\nradius = 0.05\n",
        camera(8, 3.0, [0.0, -9.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]),
        fog([-2.0, -2.0, 0.0], [4.0, 4.0, 2.5], 0.8, true)
    );
    let (film, ledger) = render(&text, 2);
    let flux = ledger.unwrap().flux;
    assert!(flux.imbalance().abs() < 1e-5, "{flux:?}");
    let parts = [flux.stored, flux.direct, flux.medium_absorbed, flux.medium_scattered, flux.escaped];
    // A hundredth goes up and past the fog, half of that to the plane far away.
    assert!(parts.iter().all(|&part| part > 0.003 * flux.emitted), "{flux:?}");
    assert!(film.iter().all(|pixel| pixel.mean()[..3].iter().all(|c| c.is_finite())));
    // The target is the square around the sphere. What misses the sphere crosses the optical depth 2 = 0.32 2.5²; the rest
    // 0.32 (2.5² - z²) down to its top. The floor leaves all to direct light, the fog 0.8 of what it stops.
    let left = |z: f64| (-0.32 * (6.25 - z * z)).exp();
    let rings = (0..1000).map(|i| 0.5 * (f64::from(i) + 0.5) / 1000.0);
    let meets: f64 =
        rings.map(|r| 2.0 * PI * r * 0.5e-3 * 0.8 * (1.0 - left(1.0 + (0.25 - r * r).sqrt()))).sum();
    let misses = (1.0 - PI / 4.0) * (left(0.0) + 0.8 * (1.0 - left(0.0)));
    // A photon is stopped or not; the target is a little wider than the sphere.
    let chance = 5.0 * 0.5 / 65536_f64.sqrt();
    close("direct", flux.direct / flux.emitted, misses + meets, chance + 2e-3);
}

#[test]
fn a_volume_that_holds_nothing_changes_nothing() {
    let text = |volume: &str| {
        format!(
            "{}{volume}{FLOOR}[[surface]]\nkind = \"sphere\"\ncentre = [0.2, 0, 0.7]\nradius = 0.3\nmaterial = \"mirror\"\n\
             [[light]]\nkind = \"point\"\nposition = [0.3, -0.2, 3]\nintensity = [3, 2, 1]\n[background]\ncolor = 1\n\
             [method]\nkind = \"caustics\"\nphotons = 16384\nradius = 0.1\nbounces = 0\n",
            camera(9, 3.0, [1.0, -4.0, 3.0], [0.0, 0.0, 0.3], [0.0, 0.0, 1.0])
        )
    };
    let (without, _) = render(&text(""), 2);
    let (with, ledger) = render(&text(&fog([-1.0, -1.0, -1.0], [2.0, 2.0, 2.0], 0.0, false)), 2);
    assert_eq!(ledger.unwrap().flux.medium_scattered, 0.0);
    for (a, b) in with.iter().zip(&without) {
        for c in 0..3 {
            // Places have other roundings in the volume's units, which decide on photons at the edge of the kernel, whose
            // weight is next to none.
            close("radiance", a.mean()[c], b.mean()[c], 1e-3 * b.mean()[c]);
        }
    }
}

#[test]
fn what_a_volume_among_surfaces_cannot_do_is_refused_in_words() {
    let refusal = |medium: &str, method: &str| {
        // All that receives light is flat.
        let text = format!(
            "{}{}{medium}\n{FLOOR}[method]\nkind = \"caustics\"\n{method}",
            camera(4, 1.0, [0.0, 0.0, 9.0], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
            fog([0.0; 3], [1.0; 3], 1.0, false)
        );
        let text = text.replace("radius = 0.1\nmaterial = \"white\"", "radius = 0.1\nmaterial = \"mirror\"");
        let text = text.replace("60.1]\nmaterial = \"white\"", "60.1]\nmaterial = \"mirror\"");
        let refused = parsed(&text).and_then(|scene| {
            let data = SceneData::load(&scene)?;
            Plan::new(&scene, &data, BRICK_SHIFT).map(drop)
        });
        refused.unwrap_err().to_string()
    };
    let message = refusal("extinction_color = [1, 0.5, 0.2]", "");
    assert!(message.contains("medium.extinction_color"), "{message}");
    let message = refusal("", "gather = { acceleration = \"planar\" }");
    assert!(message.contains("planar") && message.contains("voxels"), "{message}");
    let message =
        refusal("", "emission = { flux = \"equal\" }\ngather = { weights = \"paper\", intensity = 1 }");
    assert!(message.contains("method.gather.weights"), "{message}");
}
