//! Pictures of light between diffuse surfaces: what is gathered within a radius of its own.

mod common;

use common::{close, device, report};
use std::f64::consts::PI;
use std::path::Path;
use svetlo::caustics::{PassFacts, PassLedger};
use svetlo::film::FilmPixel;
use svetlo::render::{BRICK_SHIFT, Plan, SceneData, Session};
use svetlo::scene::Scene;

/// What a render of a scene found.
struct Rendered {
    film: Vec<FilmPixel>,
    ledger: PassLedger,
    facts: PassFacts,
    /// Whether its kernel knows of two maps.
    two_maps: bool,
}

fn render(text: &str, samples: u32) -> Rendered {
    let loaded = svetlo::config::parse("test.toml", text, &[]).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let scene = Scene::from_loaded(&loaded, Path::new("/")).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let data = SceneData::load(&scene).unwrap();
    let plan = Plan::new(&scene, &data, BRICK_SHIFT).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let mut session = Session::new(device(), &plan).unwrap();
    session.render(samples).unwrap();
    Rendered {
        film: session.film().unwrap(),
        ledger: *session.photons().unwrap(),
        facts: *session.pass_facts().unwrap(),
        two_maps: plan.spec.defines.iter().any(|(name, _)| *name == "BOUNCED"),
    }
}

const MATERIALS: &str = "[[material]]\nname = \"paint\"\nkind = \"diffuse\"\ncolor = [0.9, 0.5, 0.2]\n\
    [[material]]\nname = \"glass\"\nkind = \"dielectric\"\nior = 1.5\n";

/// The mean of a channel over a film's pixels.
fn mean_of(film: &[FilmPixel], channel: usize) -> f64 {
    film.iter().map(|pixel| pixel.mean()[channel]).sum::<f64>() / film.len() as f64
}

/// The mean of what several seeds gave, and its standard error.
fn mean_over(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

#[test]
fn in_a_sphere_of_paint_every_place_gets_the_flux_that_is_stored() {
    // An integrating sphere: each reflection spreads evenly, E = I (a + a^2 + a^3) / R^2 (the lamp's 4 pi I over 4 pi R^2).
    // The radius is larger than what the sphere's curvature allows, which is half of its radius.
    const SAMPLES: u32 = 8;
    let text = |seed: u32| {
        format!(
            "seed = {seed}\n[image]\nwidth = 12\nheight = 12\n[camera]\nposition = [0.3, -0.2, 0.1]\ntarget = [1, 0, 0]\nup = [0, 0, 1]\n\
             fov = 90\n{MATERIALS}[[surface]]\nkind = \"sphere\"\ncentre = [0, 0, 0]\nradius = 1.5\nmaterial = \"paint\"\n\
             [[light]]\nkind = \"point\"\nposition = [0.4, 0.5, -0.3]\nintensity = 2\n\
             [method]\nkind = \"caustics\"\nphotons = 8192\nradius = 0.02\nbounces = 3\nbounce_radius = 1.4\ndirect = \"none\"\n"
        )
    };
    let found: Vec<Rendered> = (1..=12).map(|seed| render(&text(seed), SAMPLES)).collect();
    for (channel, albedo) in [0.9_f64, 0.5, 0.2].into_iter().enumerate() {
        let irradiance = 2.0 / (1.5 * 1.5) * (albedo + albedo.powi(2) + albedo.powi(3));
        let means: Vec<f64> = found.iter().map(|found| mean_of(&found.film, channel)).collect();
        let (mean, sigma) = mean_over(&means);
        let expected = albedo / PI * irradiance;
        report("radiance", (mean - expected).abs() / expected, 5.0 * sigma / expected);
        close(&format!("channel {channel}"), mean, expected, 5.0 * sigma);
        assert!(sigma < 0.01 * expected, "{sigma} of {expected}");
    }
    // In W, the mean over channels: the picture's irradiance times the sphere.
    let stored: f64 = found.iter().map(|found| found.ledger.bounced.received / f64::from(SAMPLES)).sum();
    let expected: f64 = [0.9_f64, 0.5, 0.2].iter().map(|a| 8.0 * PI * (a + a * a + a * a * a) / 3.0).sum();
    close("stored", stored / 12.0, expected, 0.01 * expected);
}

/// A ball of glass in a room of paint.
fn room(seed: u32, photons: u32, method: &str) -> String {
    format!(
        "seed = {seed}\n[image]\nwidth = 16\nheight = 12\n[camera]\nposition = [-0.9, -0.8, 0.7]\ntarget = [0.5, 0.4, 0.3]\nup = [0, 0, 1]\n\
         fov = 70\n{MATERIALS}[[surface]]\nkind = \"box\"\nlow = [-1, -1, 0]\nhigh = [1, 1, 1.2]\nmaterial = \"paint\"\n\
         [[surface]]\nkind = \"sphere\"\ncentre = [0.3, 0.2, 0.3]\nradius = 0.2\nmaterial = \"glass\"\n\
         [[light]]\nkind = \"point\"\nposition = [-0.2, 0.1, 1]\nintensity = 1\n\
         [method]\nkind = \"caustics\"\nphotons = {photons}\nradius = 0.02\n{method}"
    )
}

#[test]
fn a_larger_radius_takes_noise_away_and_no_light() {
    let films = |radius: f64| -> Vec<Vec<FilmPixel>> {
        (1..=12)
            .map(|seed| render(&room(seed, 1 << 15, &format!("bounce_radius = {radius}\n")), 4).film)
            .collect()
    };
    let (narrow, wide) = (films(0.15), films(0.3));
    // Of the same photons, so that what all else has of noise is the same.
    let gained: Vec<f64> =
        narrow.iter().zip(&wide).map(|(a, b)| mean_of(b, 0) / mean_of(a, 0) - 1.0).collect();
    let (gained, sigma) = mean_over(&gained);
    report("mean", gained.abs(), 5.0 * sigma + 0.01);
    // Blur moves light about within the room, half of which is seen: 1 % are allowed for what it moves out of sight.
    close("gained", gained, 0.0, 5.0 * sigma + 0.01);
    assert!(sigma < 0.01, "{sigma}");
    // What pixels have of noise alone, over the seeds.
    let noise = |films: &[Vec<FilmPixel>]| -> f64 {
        (0..films[0].len())
            .map(|i| {
                let values: Vec<f64> = films.iter().map(|film| film[i].mean()[0]).collect();
                let mean = values.iter().sum::<f64>() / values.len() as f64;
                values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (mean * mean)
            })
            .sum()
    };
    let ratio = noise(&wide) / noise(&narrow);
    println!("variance: {ratio:.3} of what it was");
    assert!(ratio < 0.5, "{ratio}");
}

#[test]
fn each_map_holds_its_photons() {
    let found = render(&room(1, 1 << 13, "bounce_radius = 0.3\nalpha = 0.5\n"), 1);
    assert!(found.two_maps);
    assert_eq!(found.facts.mapped as u64, found.ledger.flux.stored_photons);
    assert_eq!(found.facts.bounced_mapped as u64, found.ledger.bounced.stored_photons);
    assert!(found.facts.mapped > 100 && found.facts.bounced_mapped > 100, "{:?}", found.facts);
    close("radius", found.facts.bounce_radius, 0.3, 1e-12);
    // Both shrink alike, and the larger one has fewer cells.
    let later = render(&room(1, 1 << 13, "bounce_radius = 0.3\nalpha = 0.5\n"), 2).facts;
    close("ratio", later.bounce_radius / later.radius, 15.0, 1e-12);
    let cells = |cells: [u32; 3]| cells.into_iter().product::<u32>();
    assert!(cells(later.bounced_cells) < cells(later.cells));

    let alone = render(&room(1, 1 << 13, "bounces = 0\nbounce_radius = 0.3\n"), 1);
    assert!(!alone.two_maps);
    assert_eq!((alone.facts.bounced_mapped, alone.facts.bounce_radius), (0, 0.0));
}
