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
