//! Photons on the device: what lights emit, where it goes, and that nothing is lost on the way.

mod common;
#[path = "common/photons.rs"]
mod photons;

use common::{close, report};
use glam::DVec3;
use photons::{GLASS, Scene, floor, mean};
use serde_json::Value;
use std::f64::consts::PI;
use svetlo::caustics::PhotonLedger;
use svetlo::scene::{Light, SurfaceMaterial, SurfaceShape};

fn truths() -> Value {
    serde_json::from_str(include_str!("truths.json")).unwrap()
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("truths.json lacks {key}"))
}

#[track_caller]
fn balanced(ledger: &PhotonLedger) {
    println!("{ledger:?}");
    close("ledger", ledger.imbalance(), 0.0, 1e-5);
}

#[test]
fn light_of_a_point_on_a_plane() {
    for (h, side) in [(1.0, 6.0), (2.0, 8.0)] {
        let light = Light::Point { position: DVec3::new(0.3, 0.2, h), intensity: [1.0, 2.0, 3.0] };
        let mut scene = Scene::new([floor(0.0)], [light], 1 << 16).through(
            DVec3::new(0.3, 0.2, 0.0),
            side * DVec3::X,
            side * DVec3::Y,
        );
        scene.settings.store_direct = true;
        let (stored, ledger) = scene.passes(4);
        balanced(&ledger);
        assert_eq!(stored.len(), 4 << 16);
        let angle = 4.0 * (side * side / 4.0).atan2(h * (side * side / 2.0 + h * h).sqrt());
        close("flux", ledger.emitted / 4.0 / (2.0 * angle), 1.0, 1e-5);
        for row in truths()["point_light_plane"]["rows"].as_array().unwrap() {
            if number(row, "h") != h {
                continue;
            }
            let r = number(row, "r");
            let (low, high) = (f64::max(r - 0.1, 0.0), r + 0.1);
            let flux: f64 = stored
                .iter()
                .filter(|p| (low..high).contains(&DVec3::new(0.3, 0.2, 0.0).distance(p.position)))
                .map(|p| p.flux[0])
                .sum();
            // The mean over the ring: its flux 2 pi h (1 / sqrt(h^2 + low^2) - 1 / sqrt(h^2 + high^2)).
            let exact = 2.0 * PI * h * (1.0 / h.hypot(low) - 1.0 / h.hypot(high));
            report(&format!("h {h} r {r}"), flux / 4.0 / exact - 1.0, 5e-3);
        }
    }
}

#[test]
fn sphere_of_glass() {
    let truths = truths();
    let sphere = SurfaceShape::Sphere { centre: DVec3::ZERO, radius: 1.0 };
    let sun = Light::Directional { direction: DVec3::NEG_Z, irradiance: [1.0; 3] };
    let mut scene = Scene::new([(sphere, GLASS), floor(-20.0)], [sun], 1 << 16);
    scene.settings.depth = 12;
    let (stored, ledger) = scene.passes(4);
    balanced(&ledger);
    println!("{} {}", ledger.emitted / 4.0, stored.len());
    println!("{}", stored.iter().map(|p| mean(p.flux)).sum::<f64>() / 4.0 / PI);
    println!("{truths}");
    let _ = SurfaceMaterial::Mirror { color: [1.0; 3] };
}
