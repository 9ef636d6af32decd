//! What lights emit that send photons all around: as many in every direction, and into glass that they touch.

mod common;
#[path = "common/photons.rs"]
mod photons;

use common::{close, report};
use glam::DVec3;
use photons::{GLASS, PAPER, Scene, sphere};
use std::f64::consts::PI;
use svetlo::scene::{Light, SurfaceMaterial};

/// Sums of so many float32 fluxes in two floats, each rounded some 20 times: systematically, at most by this.
const ROUNDING: f64 = 20.0 * common::EPS;

fn point(position: DVec3) -> Light {
    Light::Point { position, intensity: [1.0, 2.0, 3.0] }
}

#[test]
fn lights_on_a_sphere_of_glass_send_half_of_their_light_into_it() {
    let places = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
    for place in places {
        let light = point(0.25 * place);
        let mut scene = Scene::new(
            [(sphere(DVec3::ZERO, 0.25), GLASS), (sphere(DVec3::new(30.0, 0.0, 5.0), 0.5), PAPER)],
            [light],
            10_000,
        )
        .to_depth(0);
        // In which all coordinates are exact: a light beside the sphere is outside or inside.
        scene.frame.origin = -4.0 * DVec3::Z;
        let ledger = scene.ledger(1);
        close("4 pi I", ledger.emitted, 8.0 * PI, ROUNDING * 8.0 * PI);
        // A great circle is 177 cells long; half of each may be on the wrong side at most.
        let tolerance = 0.5 * 177.0 / 10_000.0;
        report("into the glass", (ledger.truncated / ledger.emitted - 0.5).abs(), tolerance);
        close("into the glass", ledger.truncated / ledger.emitted, 0.5, tolerance);
    }
}

/// Directions of the photons of a light in the middle of a ball that is white inside, pass by pass.
fn all_around(photons: u32, passes: usize) -> Vec<Vec<DVec3>> {
    let air = SurfaceMaterial::Dielectric { cauchy: [1.0, 0.0, 0.0], absorption: [0.0; 3] };
    let balls = [(sphere(DVec3::ZERO, 1.0), air), (sphere(DVec3::ZERO, 2.0), PAPER)];
    let (stored, ledger) = Scene::new(balls, [point(DVec3::ZERO)], photons).passes(passes as u32);
    let exact = 8.0 * PI * passes as f64;
    close("4 pi I", ledger.emitted, exact, ROUNDING * exact);
    assert_eq!(stored.len(), photons as usize * passes);
    stored.chunks(photons as usize).map(|pass| pass.iter().map(|p| p.direction).collect()).collect()
}

#[test]
fn light_all_around_is_even() {
    // A square, some rows a cell longer than others, and hardly any cells.
    for (photons, passes) in [(10_000, 16), (4_999, 16), (37, 512)] {
        let directions: Vec<DVec3> = all_around(photons, passes).concat();
        let count = directions.len() as f64;
        // Photons of a pass are all off the middles of their cells alike, which are sqrt(4 pi / photons) wide. Over passes, the
        // offsets' mean is half a cell within 2 / passes. Directions are packed to 7e-5.
        let tolerance = 1e-4 + (4.0 * PI / f64::from(photons)).sqrt() * 2.0 / passes as f64;
        let mean = |f: fn(&DVec3) -> f64| directions.iter().map(f).sum::<f64>() / count;
        let moments: [(&str, f64, f64); 12] = [
            ("x", mean(|d| d.x), 0.0),
            ("y", mean(|d| d.y), 0.0),
            ("z", mean(|d| d.z), 0.0),
            ("x x", mean(|d| d.x * d.x), 1.0 / 3.0),
            ("y y", mean(|d| d.y * d.y), 1.0 / 3.0),
            ("x y", mean(|d| d.x * d.y), 0.0),
            ("y z", mean(|d| d.y * d.z), 0.0),
            ("z x", mean(|d| d.z * d.x), 0.0),
            ("x x y y", mean(|d| d.x * d.x * d.y * d.y), 1.0 / 15.0),
            ("y y z z", mean(|d| d.y * d.y * d.z * d.z), 1.0 / 15.0),
            ("z^4", mean(|d| d.z.powi(4)), 0.2),
            ("x y z", mean(|d| d.x * d.y * d.z), 0.0),
        ];
        for (name, found, exact) in moments {
            report(&format!("{name} of {photons}"), (found - exact).abs(), tolerance);
            close(&format!("{name} of {photons}"), found, exact, tolerance);
        }
    }
}

#[test]
fn light_all_around_has_no_poles() {
    let photons = 10_000;
    // A hundred photons of a pass: along each axis, and about the edges and corners of a cube.
    let share = 0.01;
    let steps = || [-1.0, 0.0, 1.0].into_iter();
    let axes: Vec<DVec3> = steps()
        .flat_map(|x| steps().flat_map(move |y| steps().map(move |z| DVec3::new(x, y, z))))
        .filter_map(DVec3::try_normalize)
        .collect();
    for pass in all_around(photons, 4) {
        for axis in &axes {
            let found = pass.iter().filter(|d| d.dot(*axis) > 1.0 - 2.0 * share).count() as f64;
            let expected = share * f64::from(photons);
            // Its edge is 2 sqrt(100 pi) = 35 cells long; half of each may be on the wrong side at most, and a little at ends.
            let tolerance = 20.0;
            report(&format!("towards {axis}"), (found - expected).abs(), tolerance);
            close(&format!("towards {axis}"), found, expected, tolerance);
        }
    }
}
