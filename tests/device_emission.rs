//! What lights emit: its flux against closed forms, how it is spread, and that targets cover what they should.

mod common;
#[path = "common/photons.rs"]
mod photons;

use common::{close, report};
use glam::DVec3;
use photons::{GLASS, PAPER, Scene, bump, floor, number, sphere, sun, truths};
use std::f64::consts::PI;
use svetlo::caustics::{Emission, Emitter, emitters};
use svetlo::scene::{Light, Metaball, SurfaceShape};

/// Sums of so many float32 fluxes in two floats, each rounded some 20 times: systematically, at most by this.
const ROUNDING: f64 = 20.0 * common::EPS;

fn point(position: DVec3) -> Light {
    Light::Point { position, intensity: [1.0, 2.0, 3.0] }
}

/// An opaque ball that is no business of light that is sent elsewhere.
fn aside() -> (SurfaceShape, svetlo::scene::SurfaceMaterial) {
    (sphere(DVec3::new(30.0, 0.0, 5.0), 0.5), PAPER)
}

#[test]
fn a_plane_is_lit_by_a_point_as_it_should_be() {
    for (h, side) in [(1.0, 6.0), (2.0, 7.0)] {
        let below = DVec3::new(0.3, 0.2, 0.0);
        let light = point(below + h * DVec3::Z);
        let mut scene = Scene::new([floor(0.0), aside()], [light], 1 << 16).through(
            below,
            side * DVec3::X,
            side * DVec3::Y,
        );
        scene.settings.store_direct = true;
        let (stored, ledger) = scene.passes(3);
        assert_eq!((stored.len(), ledger.stored_photons, ledger.photons), (3 << 16, 3 << 16, 3 << 16));
        let angle = 4.0 * (side * side / 4.0).atan2(h * (side * side / 2.0 + h * h).sqrt());
        close("flux", ledger.emitted / 3.0, 2.0 * angle, ROUNDING * 2.0 * angle);
        close("ledger", ledger.imbalance(), 0.0, 1e-7);
        for row in truths()["point_light_plane"]["rows"].as_array().unwrap() {
            if number(row, "h") == h {
                let r = number(row, "r");
                let irradiance = |r: f64| h / (r * r + h * h).powf(1.5);
                close("E(r) of the truths", irradiance(r), number(row, "E"), 1e-12);
                let [found, exact] = bump(&stored, below, r, 0.4, irradiance);
                // The grid integrates a bump, which is smooth, by squares of cell / width = 0.06 and better.
                report(&format!("E({r}), light at {h}"), (found / 3.0 / exact - 1.0).abs(), 1e-3);
                close("E(r)", found / 3.0 / exact, 1.0, 1e-3);
            }
        }
    }
}

#[test]
fn few_large_cells_have_the_right_flux_and_are_lit_smoothly() {
    // A target as wide as 6 times its distance, in 12 x 12 cells, over many passes.
    let mut scene = Scene::new([floor(0.0), aside()], [point(DVec3::Z)], 144).through(
        DVec3::ZERO,
        6.0 * DVec3::X,
        6.0 * DVec3::Y,
    );
    scene.settings.store_direct = true;
    let (stored, ledger) = scene.passes(512);
    let angle = 4.0 * 9.0_f64.atan2(19.0_f64.sqrt());
    close("flux", ledger.emitted / 512.0, 2.0 * angle, ROUNDING * 2.0 * angle);
    for r in [0.0, 0.25, 0.5, 1.0] {
        let [found, exact] = bump(&stored, DVec3::ZERO, r, 0.4, |r| 1.0 / (r * r + 1.0).powf(1.5));
        // Within cells, the density errs by the square of cell / distance, 1/4, times its curvature, up to 3, over 12;
        // bumps wider than cells even this out further.
        report(&format!("E({r})"), (found / 512.0 / exact - 1.0).abs(), 0.01);
        close("E(r)", found / 512.0 / exact, 1.0, 0.01);
    }
}

#[test]
fn equal_intensities_are_equal() {
    let mut scene = Scene::new([floor(0.0), aside()], [point(DVec3::Z)], 1 << 12).through(
        DVec3::ZERO,
        4.0 * DVec3::X,
        2.0 * DVec3::Y,
    );
    scene.settings.store_direct = true;
    let exact = scene.ledger(1);
    scene.settings.emission.emission = Emission::Equal;
    let (stored, ledger) = scene.passes(1);
    close("all of the flux", ledger.emitted, exact.emitted, 2.0 * ROUNDING * exact.emitted);
    assert!(stored.iter().all(|p| p.flux == stored[0].flux), "equal");
    // So that the plane is lit evenly: the paper's light is none.
    let half = stored.iter().filter(|p| p.position.x.abs() < 1.0).count();
    close("half of the target", half as f64 / 4096.0, 0.5, 0.02);
}

#[test]
fn lights_inside_of_glass_and_mirrors_shine_everywhere() {
    // From the middle of a sphere of glass, all rays are upright; nothing else is there but far away.
    let scene = Scene::new([(sphere(DVec3::ZERO, 1.0), GLASS), aside()], [point(DVec3::ZERO)], 10_000);
    let first = scene.to_depth(0).ledger(1);
    close("4 pi I", first.emitted, 8.0 * PI, ROUNDING * 8.0 * PI);
    close("all meets the glass", first.truncated, first.emitted, 1e-6 * first.emitted);
    let ledger = scene.to_depth(1).ledger(1);
    // One photon in 25 is reflected.
    let sigma = (0.04 * 0.96 / 10_000.0_f64).sqrt();
    close("let through", (ledger.escaped + ledger.direct) / ledger.emitted, 0.96, 5.0 * sigma);
    close("ledger", ledger.imbalance(), 0.0, 1e-6);
}

/// Flux between a square of side a and one opposite at distance c, over the radiance (Howell, C-11).
fn opposed_squares(a: f64, c: f64) -> f64 {
    let x = a / c;
    let s = (1.0 + x * x).sqrt();
    let factor = 2.0 / (PI * x * x)
        * (((1.0 + x * x).powi(2) / (1.0 + 2.0 * x * x)).sqrt().ln() + 2.0 * x * s * (x / s).atan()
            - 2.0 * x * x.atan());
    PI * a * a * factor
}

#[test]
fn rectangles_send_what_form_factors_say() {
    let light = Light::Rectangle {
        centre: DVec3::new(0.0, 0.0, 2.0),
        edge_u: 2.0 * DVec3::X,
        edge_v: -2.0 * DVec3::Y,
        radiance: [1.0, 1.0, 1.0],
    };
    let mut scene = Scene::new([floor(0.0), aside()], [light], 1 << 16).through(
        DVec3::ZERO,
        2.0 * DVec3::X,
        2.0 * DVec3::Y,
    );
    scene.settings.store_direct = true;
    let (stored, ledger) = scene.passes(2);
    let exact = opposed_squares(2.0, 2.0);
    // Photons differ by the cosines and distances, by a third at most: sigma / mean < 0.33.
    let sigma = 0.33 / f64::sqrt((2 << 16) as f64);
    report("flux between squares", (ledger.emitted / 2.0 / exact - 1.0).abs(), 5.0 * sigma);
    close("flux between squares", ledger.emitted / 2.0 / exact, 1.0, 5.0 * sigma);
    assert!(
        stored
            .iter()
            .all(|p| p.position.x.abs() < 1.001 && p.position.y.abs() < 1.001 && p.direction.z < 0.0)
    );
    scene.settings.emission.emission = Emission::Equal;
    // By the midpoints of cells of 1/16 at distance 2.
    close("the same for each", scene.ledger(1).emitted / exact, 1.0, 1e-3);
    // Turned away, it sends nothing.
    scene.lights = vec![Light::Rectangle {
        centre: DVec3::new(0.0, 0.0, 2.0),
        edge_u: 2.0 * DVec3::X,
        edge_v: 2.0 * DVec3::Y,
        radiance: [1.0; 3],
    }];
    assert_eq!(scene.passes(1).0.len(), 0);
}

#[test]
fn rectangles_close_to_glass_shine_like_lambert() {
    let light = Light::Rectangle {
        centre: DVec3::ZERO,
        edge_u: 0.2 * DVec3::X,
        edge_v: -0.1 * DVec3::Y,
        radiance: [1.0, 2.0, 3.0],
    };
    let glass = (sphere(DVec3::new(0.0, 0.0, -1.5), 1.49), GLASS);
    let mut scene = Scene::new([glass, floor(-10.0)], [light], 1 << 14).to_depth(0);
    scene.settings.store_direct = true;
    let ledger = scene.ledger(2);
    close("pi L A", ledger.emitted / 2.0, 2.0 * PI * 0.02, ROUNDING * 0.2);
    // The light is all but a point: a cone with sin = 1.49 / 1.5 has sin^2 of Lambert's flux; the corners see up to
    // 0.05 / sqrt(2.25 - 2.22) of the radius more or less, even in the mean to its square.
    let share = (1.49_f64 / 1.5).powi(2);
    let sigma = (share * (1.0 - share) / f64::from(2 << 14)).sqrt();
    close("meets the glass", ledger.truncated / ledger.emitted, share, 5.0 * sigma + 0.01);
}

#[test]
fn default_targets_cover_what_is_to_be_met_and_little_else() {
    let bodies: Vec<(&str, SurfaceShape)> = vec![
        ("sphere", sphere(DVec3::new(0.5, -0.3, 1.0), 0.7)),
        ("box", SurfaceShape::Box { low: DVec3::new(-0.5, -1.0, 0.5), high: DVec3::new(0.7, 0.2, 0.8) }),
        ("disk", SurfaceShape::Disk { centre: DVec3::ONE, normal: DVec3::ONE.normalize(), radius: 0.6 }),
        (
            "rectangle",
            SurfaceShape::Rectangle {
                centre: DVec3::new(0.2, 0.1, 1.0),
                edge_u: DVec3::new(1.0, 0.2, 0.3),
                edge_v: DVec3::new(0.1, 0.7, -0.4),
            },
        ),
        (
            "metaballs",
            SurfaceShape::Metaballs {
                balls: vec![
                    Metaball { centre: DVec3::new(0.0, 0.0, 1.0), radius: 0.8, weight: 1.0 },
                    Metaball { centre: DVec3::new(0.6, 0.0, 1.2), radius: 0.8, weight: 1.0 },
                ],
                threshold: 0.2,
            },
        ),
    ];
    let lights = [
        ("point", point(DVec3::new(1.0, 2.0, 5.0))),
        ("near point", point(DVec3::new(1.0, 1.6, 2.4))),
        (
            "sun",
            Light::Directional { direction: DVec3::new(0.3, 0.2, -1.0).normalize(), irradiance: [1.0; 3] },
        ),
        (
            "rectangle",
            Light::Rectangle {
                centre: DVec3::new(0.5, 0.3, 5.0),
                edge_u: 2.0 * DVec3::X,
                edge_v: -1.0 * DVec3::Y,
                radiance: [1.0; 3],
            },
        ),
    ];
    // All in one program: every kind of shape, most of them out of the way and no business of photons.
    for (what, body) in &bodies {
        for (kind, light) in &lights {
            let others =
                bodies.iter().filter(|(name, _)| name != what).map(|(_, shape)| (moved(shape), PAPER));
            let mirror = svetlo::scene::SurfaceMaterial::Mirror { color: [1.0; 3] };
            let parts = std::iter::once((body.clone(), mirror)).chain(others).chain([floor(-50.0)]);
            let scene = Scene::new(parts, [*light], 1 << 14).to_depth(0);
            let met = |scene: &Scene| {
                let ledger = scene.ledger(2);
                (ledger.truncated / 2.0, ledger.truncated / ledger.emitted)
            };
            let (flux, share) = met(&scene);
            // Twice as wide a target around the same middle.
            let emitter = scene.emitters().remove(0);
            let wide = scene.clone().around(&emitter, 2.0);
            let (expected, wide_share) = met(&wide);
            // Cells along the outline: 4 sides of 128 at most, half of which may be wrong either way, of those that are
            // met; the wider grid has as few as a quarter.
            let sigma = 0.5 * (2.0 * 512.0_f64).sqrt() / (wide_share * f64::from(2 << 14));
            report(&format!("{what} by {kind}, {share:.2} met"), (flux / expected - 1.0).abs(), 5.0 * sigma);
            close(&format!("{what} by {kind}"), flux / expected, 1.0, 5.0 * sigma);
            assert!(share > 0.15, "{what} by {kind}: {share}");
        }
    }
}

fn moved(shape: &SurfaceShape) -> SurfaceShape {
    let away = DVec3::new(40.0, 0.0, 0.0);
    match shape.clone() {
        SurfaceShape::Sphere { centre, radius } => SurfaceShape::Sphere { centre: centre + away, radius },
        SurfaceShape::Box { low, high } => SurfaceShape::Box { low: low + away, high: high + away },
        SurfaceShape::Disk { centre, normal, radius } => {
            SurfaceShape::Disk { centre: centre + away, normal, radius }
        }
        SurfaceShape::Rectangle { centre, edge_u, edge_v } => {
            SurfaceShape::Rectangle { centre: centre + away, edge_u, edge_v }
        }
        SurfaceShape::Metaballs { mut balls, threshold } => {
            balls.iter_mut().for_each(|ball| ball.centre += away);
            SurfaceShape::Metaballs { balls, threshold }
        }
        other => other,
    }
}

#[test]
fn photons_are_counted_out_by_flux() {
    let glass = (sphere(DVec3::ZERO, 1.0), GLASS);
    let lamp = |x: f64, intensity: f64| Light::Point {
        position: DVec3::new(x, 0.0, 4.0),
        intensity: [intensity; 3],
    };
    let dark = Light::Directional { direction: DVec3::NEG_Y, irradiance: [0.0; 3] };
    let counts = |lights: Vec<Light>, photons: u32| -> Vec<u32> {
        let scene = Scene::new([glass.clone()], lights, photons);
        let found = scene.emitters();
        assert_eq!(found.iter().map(|e| e.count).sum::<u32>(), if found.is_empty() { 0 } else { photons });
        let firsts: Vec<u32> = found.iter().map(|e| e.first).collect();
        let sums: Vec<u32> =
            (0..found.len()).map(|i| found[..i].iter().map(|e: &Emitter| e.count).sum()).collect();
        assert_eq!(firsts, sums);
        found.iter().map(|e| e.count).collect()
    };
    assert_eq!(counts(vec![lamp(1.0, 1.0), dark, lamp(-1.0, 3.0)], 1000), [251, 749]);
    assert_eq!(counts(vec![lamp(1.0, 1.0), lamp(-1.0, 1e9)], 7), [1, 6], "one at least");
    assert_eq!(counts(vec![lamp(1.0, 1.0), lamp(-1.0, 1.0)], 2), [1, 1]);
    assert_eq!(counts(vec![lamp(1.0, 1.0); 3], 1_000_003).iter().sum::<u32>(), 1_000_003);
    assert!(counts(vec![dark], 100).is_empty());
    assert!(counts(vec![], 100).is_empty());
    assert!(counts(vec![lamp(1.0, 1.0)], 0).is_empty());
    // The paper's grids.
    let square = Scene::new([glass.clone()], [sun()], 1 << 16).emitters();
    assert_eq!((square[0].count, square[0].rows), (1 << 16, 256));
    let wide = Scene::new([glass.clone()], [sun()], 1920 * 1080).through(
        DVec3::ZERO,
        16.0 * DVec3::X,
        9.0 * DVec3::Y,
    );
    assert_eq!(wide.emitters()[0].rows, 1080);
}

#[test]
fn grids_of_any_count_are_even() {
    // 1009 is prime: rows of 32 and 31 cells. Each quarter of the target gets a quarter of the photons, within a row.
    let mut scene = Scene::new([floor(0.0), aside()], [sun()], 1009).through(DVec3::ZERO, DVec3::X, DVec3::Y);
    scene.settings.store_direct = true;
    let (stored, ledger) = scene.passes(1);
    assert_eq!(stored.len(), 1009);
    close("flux", ledger.emitted, 1.0, 1e-6);
    let corner = |p: &&photons::Stored| p.position.x < 0.0 && p.position.y < 0.0;
    close("a quarter", stored.iter().filter(corner).count() as f64, 1009.0 / 4.0, 32.0);
    let mut places: Vec<[i64; 2]> =
        stored.iter().map(|p| [p.position.x, p.position.y].map(|x| (x * 1e4).round() as i64)).collect();
    places.sort_unstable();
    places.dedup();
    assert_eq!(places.len(), 1009, "each photon has its own place");
}

#[test]
fn what_cannot_be_is_said() {
    let glass = || (sphere(DVec3::ZERO, 1.0), GLASS);
    let message = |scene: Scene| {
        emitters(&scene.lights, &scene.arrays(), &scene.frame, &scene.settings.emission)
            .unwrap_err()
            .to_string()
    };
    let two = [point(DVec3::Z * 3.0), point(DVec3::Z * 4.0)];
    assert_eq!(
        message(Scene::new([glass()], two, 1)),
        "1 photons are too few for 2 lights: each light that shines needs one at least"
    );
    let skew = Scene::new([glass()], [sun()], 100).through(DVec3::ZERO, DVec3::X, DVec3::new(0.1, 1.0, 0.0));
    assert_eq!(message(skew), "the edges of the photons' target must be at a right angle, and not zero");
    let level = Scene::new([glass()], [point(DVec3::X * 9.0)], 100).through(DVec3::ZERO, DVec3::X, DVec3::Y);
    assert_eq!(
        message(level),
        "the target of the photons is seen edge-on from `light.0`; it must not lie in one plane with a light"
    );
    let water = (SurfaceShape::Plane { point: DVec3::ZERO, normal: DVec3::Z }, GLASS);
    assert_eq!(
        message(Scene::new([water], [sun()], 100)),
        "photons of `light.0`, which is directional, need a target: nothing in the scene has bounds"
    );
}

#[test]
fn parallel_light_begins_above_planes_of_water() {
    let water = || (SurfaceShape::Plane { point: DVec3::Z, normal: DVec3::Z }, GLASS);
    let slanted = Light::Directional { direction: DVec3::new(0.6, 0.0, -0.8), irradiance: [1.0; 3] };
    let scene = Scene::new([water(), floor(0.0), aside()], [slanted], 1 << 12)
        .through(DVec3::ZERO, DVec3::X, DVec3::Y)
        .to_depth(1);
    let (stored, ledger) = scene.passes(4);
    close("flux", ledger.emitted / 4.0, 0.8, 1e-6);
    // All of it meets the water first; sin = 0.4 below.
    let reflected = svetlo::reference::optics::fresnel(1.0, 1.5, 0.8);
    let sigma = (reflected * (1.0 - reflected) / f64::from(4 << 12)).sqrt();
    close("reflected", ledger.escaped / ledger.emitted, reflected, 5.0 * sigma);
    assert_eq!(ledger.direct, 0.0);
    let below = DVec3::new(0.4, 0.0, -(1.0 - 0.16_f64).sqrt());
    assert!(!stored.is_empty() && stored.iter().all(|p| p.direction.distance(below) < 1e-4));
}
