//! Light between diffuse surfaces, by photons: furnaces and exchanges with closed forms, and that each path has its photons
//! once.

mod common;
#[path = "common/photons.rs"]
mod photons;

use common::{close, report};
use glam::DVec3;
use photons::{GLASS, PAPER, Scene, Stored, floor, sphere, sun};
use std::f64::consts::PI;
use svetlo::caustics::{BouncedLedger, Photon};
use svetlo::scene::{Light, SurfaceMaterial, SurfaceShape};

const COLOR: [f64; 3] = [0.9, 0.5, 0.2];
const PAINT: SurfaceMaterial = SurfaceMaterial::Diffuse { color: COLOR };
const MIRROR: SurfaceMaterial = SurfaceMaterial::Mirror { color: [1.0; 3] };
const BLACK: SurfaceMaterial = SurfaceMaterial::Diffuse { color: [0.0; 3] };

/// Renders of other seeds, of whose spread the error is known.
const SEEDS: u32 = 24;

/// The scene with so many diffuse reflections.
fn bouncing(mut scene: Scene, bounces: u32) -> Scene {
    scene.settings.bounces = bounces;
    scene.settings.emission.bounces = bounces > 0;
    scene
}

/// What photons of each role bring in a pass of each seed, and the ledgers of those that are reflected.
fn received(scene: &Scene) -> Vec<([Vec<Stored>; 3], BouncedLedger)> {
    let device = common::device();
    let emitters = scene.emitters();
    (0..SEEDS)
        .map(|seed| {
            let mut scene = scene.clone();
            scene.settings.seed = u64::from(seed);
            let mut tracer = scene.tracer(&device).unwrap();
            tracer.trace(&device, seed, 0, tracer.capacity()).unwrap();
            let photons = tracer.photons().read(&device).unwrap();
            let mut stored = [const { Vec::new() }; 3];
            for emitter in &emitters {
                let of = &photons[emitter.first as usize..][..emitter.count as usize];
                stored[emitter.role as usize].extend(of.iter().filter_map(|photon| scene.stored(photon)));
            }
            let ledger = tracer.bounced(&device).unwrap();
            // Each photon's parts are rounded a few times.
            close("ledger", ledger.imbalance(), 0.0, 1e-6);
            (stored, ledger)
        })
        .collect()
}

/// The mean of what is measured in each, which must be within 5 sigma of the truth; sigma may be so much of it at most.
#[track_caller]
fn expect(what: &str, values: impl Iterator<Item = f64>, truth: f64, coarsest: f64) {
    let values: Vec<f64> = values.collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let sigma = (variance / n).sqrt();
    report(what, (mean - truth).abs() / truth, 5.0 * sigma / truth);
    assert!(sigma < coarsest * truth, "{what}: sigma {sigma} of {truth}");
    close(what, mean, truth, 5.0 * sigma);
}

fn flux(stored: &[Stored], channel: usize, wanted: impl Fn(&Stored) -> bool) -> f64 {
    stored.iter().filter(|photon| wanted(photon)).map(|photon| photon.flux[channel]).sum()
}

#[test]
fn inside_a_sphere_diffuse_light_is_the_same_everywhere() {
    // Of an integrating sphere: each reflection spreads evenly, wherever the light is.
    let lamp = Light::Point { position: DVec3::new(0.9, 0.2, -0.1), intensity: [1.0; 3] };
    let scene = Scene::new([(sphere(DVec3::ZERO, 1.5), PAINT)], [lamp], 1 << 12);
    let found = received(&bouncing(scene, 5));
    for (channel, albedo) in COLOR.into_iter().enumerate() {
        let sum: f64 = (1..=5).map(|k| albedo.powi(k)).sum();
        let truth = 4.0 * PI * sum;
        let total = |wanted: fn(&Stored) -> bool| {
            found.iter().map(move |(stored, _)| flux(&stored[2], channel, wanted))
        };
        expect(&format!("sphere, channel {channel}"), total(|_| true), truth, 0.01);
        // By Archimedes, slices get as much as they are thick.
        expect("towards the light", total(|p| p.position.x > 0.75), truth / 4.0, 0.02);
        expect("away from it", total(|p| p.position.x < -0.75), truth / 4.0, 0.02);
        expect("aside", total(|p| p.position.z.abs() < 0.5), truth / 3.0, 0.02);
    }
    let escaped: f64 = found.iter().map(|(_, ledger)| ledger.escaped / ledger.emitted).sum();
    assert!(escaped < 1e-4 * f64::from(SEEDS), "{escaped}");
}

#[test]
fn a_furnace_multiplies_light_by_one_over_what_is_absorbed() {
    // A box, and all orders: 0.5^60 is nothing.
    let grey = SurfaceMaterial::Diffuse { color: [0.5; 3] };
    let room = SurfaceShape::Box { low: DVec3::new(-1.0, -0.5, -2.0), high: DVec3::new(1.0, 0.7, 0.3) };
    let panel = Light::Rectangle {
        centre: DVec3::new(0.0, 0.0, -0.5),
        edge_u: DVec3::X * 0.4,
        edge_v: DVec3::Y * 0.3,
        radiance: [2.0; 3],
    };
    let found = received(&bouncing(Scene::new([(room, grey)], [panel], 1 << 12), 60));
    let power = 2.0 * PI * 0.12;
    // Direct light is `power`, and all of it twice that.
    expect("received", found.iter().map(|(_, l)| l.received), power, 0.01);
    for (_, l) in found {
        // All ends there; sums of pairs of floats.
        close("absorbed", l.absorbed, power, 1e-6 * power);
        assert!(l.beyond < 1e-12 && l.escaped < 1e-6 * power && l.truncated == 0.0);
    }
}

/// The part of a disk's diffuse light that a like disk gets, coaxial and parallel at a distance in radii.
fn disk_to_disk(distance: f64) -> f64 {
    let x = 2.0 + distance * distance;
    0.5 * (x - (x * x - 4.0).sqrt())
}

#[test]
fn a_mirror_shows_a_disk_its_image() {
    // At twice the mirror's distance. Half a mirror as wide as the disk is enough for all that comes back.
    let radius = 0.5;
    let gets = PI * radius * radius * 0.5_f64.sqrt();
    let disk = |z: f64, radius| SurfaceShape::Disk { centre: DVec3::Z * z, normal: DVec3::Z, radius };
    // Under a small mirror, where diffuse light goes to it by intent; and by way of one so near and large that it would be
    // vain to aim.
    for (what, height, mirror, up, role) in
        [("lit directly", 1.5, 0.6, -1.0, 2), ("lit by the mirror", 0.6, 1.2, 1.0, 1)]
    {
        let light = Light::Directional { direction: DVec3::new(1.0, 0.0, up), irradiance: [1.0; 3] };
        let parts = [(disk(0.0, radius), PAINT), (disk(height, mirror), MIRROR)];
        let found = received(&bouncing(Scene::new(parts, [light], 1 << 15), 1));
        let factor = disk_to_disk(2.0 * height / radius);
        for (channel, albedo) in COLOR.into_iter().enumerate() {
            let fluxes = found.iter().map(|(stored, _)| flux(&stored[role], channel, |p| p.surface == 0));
            expect(&format!("{what}, channel {channel}"), fluxes, gets * albedo * factor, 0.05);
        }
        assert!(found.iter().all(|(stored, _)| stored[3 - role].is_empty()), "{what}: of one role alone");
    }
}

/// The midpoint rule.
fn integral(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    const STEPS: u32 = 20_000;
    let step = (to - from) / f64::from(STEPS);
    (0..STEPS).map(|i| f(from + step * (f64::from(i) + 0.5))).sum::<f64>() * step
}

#[test]
fn a_ball_and_the_floor_light_each_other() {
    // A lamp at height 3 over a ball of radius 0.4 at height 1, above an endless floor.
    let (lamp, height, radius) = (3.0, 1.0, 0.4_f64);
    let light = Light::Point { position: DVec3::Z * lamp, intensity: [1.0; 3] };
    let parts = [(sphere(DVec3::Z * height, radius), PAINT), floor(0.0)];
    let found = received(&bouncing(Scene::new(parts, [light], 1 << 15), 1));
    // The floor beyond the ball's shadow; a place sends the ball (r/d)^2 cos of its light (Howell's catalogue, B-43). With
    // t = the angle from the lamp, the floor's flux is 2 pi sin t dt.
    let shadow = (radius / (lamp - height)).asin();
    let to_ball = integral(shadow, 0.5 * PI, |t| {
        let d2 = (lamp * t.tan()).powi(2) + height * height;
        2.0 * PI * t.sin() * radius * radius * height / d2.powf(1.5)
    });
    // What the ball's lit cap sends below the horizon: (1 - n_z) / 2 of the light at each place.
    let edge = radius / (lamp - height);
    let to_floor = integral(edge, 1.0, |z| {
        let d2 = (lamp - height).powi(2) + radius * radius - 2.0 * (lamp - height) * radius * z;
        let cosine = ((lamp - height) * z - radius) / d2.sqrt();
        cosine / d2 * 0.5 * (1.0 - z) * 2.0 * PI * radius * radius
    });
    let on =
        |surface: usize| found.iter().map(move |(stored, _)| flux(&stored[2], 1, |p| p.surface == surface));
    expect("the ball", on(0), to_ball, 0.02);
    expect("the floor", on(1), COLOR[1] * to_floor, 0.02);
}

#[test]
fn photons_near_and_elsewhere_share_all_directions() {
    let lamp = Light::Point { position: DVec3::new(0.4, -0.2, 3.0), intensity: [1.0; 3] };
    let panel = Light::Rectangle {
        centre: DVec3::new(0.4, -0.2, 3.0),
        edge_u: DVec3::Y * 0.5,
        edge_v: DVec3::X * 0.7,
        radiance: [1.0; 3],
    };
    for light in [lamp, panel, sun()] {
        let parts = [(sphere(DVec3::Z * 0.6, 0.4), PAINT), floor(0.0)];
        let scene = bouncing(Scene::new(parts, [light], 1 << 14), 1);
        let emitters = scene.emitters();
        assert_eq!(emitters.iter().map(|e| (e.role, e.except)).collect::<Vec<_>>(), [(2, 0), (2, 1)]);
        // Nothing is specular: of others is what is near alone.
        let near = f64::from(emitters[0].count) * f64::from(emitters[0].power[0]) * scene.frame.unit.powi(2);
        let all = match light {
            Light::Point { .. } => 4.0 * PI,
            Light::Rectangle { .. } => PI * 0.35,
            // 16 times as wide.
            Light::Directional { .. } => 256.0 * near,
        };
        expect("others", received(&scene).iter().map(|(_, l)| l.emitted - l.others), all, 0.01);
    }
}

fn bits(photons: &[Photon]) -> &[u8] {
    bytemuck::cast_slice(photons)
}

/// What a tracer stores in pass 3, launched in pieces.
fn traced(scene: &Scene, cuts: &[u32]) -> (Vec<Photon>, BouncedLedger) {
    let device = common::device();
    let mut tracer = scene.tracer(&device).unwrap();
    for ends in cuts.windows(2) {
        tracer.trace(&device, 3, ends[0], ends[1] - ends[0]).unwrap();
    }
    (tracer.photons().read(&device).unwrap(), tracer.bounced(&device).unwrap())
}

#[test]
fn other_photons_are_what_they_are_without_bounces() {
    let scene = |paper, photons, bounces| {
        let parts = [(sphere(DVec3::Z, 0.6), GLASS), (floor(0.0).0, paper)];
        bouncing(Scene::new(parts, [sun()], photons), bounces)
    };
    let many = scene(PAPER, 20_000, 4);
    let caustic = many.emitters()[0].count;
    assert!((10_000..20_000).contains(&caustic), "{caustic}");
    let (both, ledger) = traced(&many, &[0, 20_000]);
    let (alone, none) = traced(&scene(PAPER, caustic, 0), &[0, caustic]);
    assert!(bits(&both[..caustic as usize]) == bits(&alone));
    assert_eq!((ledger.photons, none), (u64::from(20_000 - caustic), BouncedLedger::default()));
    assert!(ledger.received > 0.0);
    // Where nothing is reflected, all photons are for caustics.
    assert_eq!(scene(BLACK, 20_000, 4).emitters(), scene(BLACK, 20_000, 0).emitters());
}

#[test]
fn reflected_photons_do_not_depend_on_how_launches_are_cut() {
    let parts = [(sphere(DVec3::Z, 0.6), GLASS), floor(0.0)];
    let lamp = Light::Point { position: DVec3::Z * 3.0, intensity: [1.0; 3] };
    let scene = bouncing(Scene::new(parts, [lamp], 150_001), 4);
    let second = scene.emitters()[1].first;
    let whole = traced(&scene, &[0, 150_001]);
    let pieces = traced(&scene, &[0, 1, 1, second - 5, second + 7, 140_000, 150_001]);
    assert!(bits(&whole.0) == bits(&pieces.0) && whole.1 == pieces.1);
}

#[test]
fn too_few_photons_are_refused_in_words() {
    let parts = [(sphere(DVec3::Z, 0.6), GLASS), floor(0.0)];
    let lamp = Light::Point { position: DVec3::Z * 3.0, intensity: [1.0; 3] };
    let scene = bouncing(Scene::new(parts, [lamp], 3), 4);
    let message = scene.tracer(&common::device()).map(|_| ()).unwrap_err().to_string();
    assert_eq!(
        message,
        "3 photons are too few for 1 lights: each light that shines needs one at least, and 3 for light that diffuse \
         surfaces reflect (bounces = 0 is without)"
    );
}
