//! Photons on the device: where glass and mirrors send them, against closed forms, and that nothing is lost on the way.

mod common;
#[path = "common/photons.rs"]
mod photons;

use common::{close, report};
use glam::DVec3;
use photons::{GLASS, PAPER, Scene, Stored, bump, floor, mean, number, sphere, sun, truths};
use std::f64::consts::PI;
use svetlo::caustics::{Emitter, PhotonLedger, color_of, mean_color};
use svetlo::reference::optics::cauchy;
use svetlo::scene::{Light, SurfaceMaterial, SurfaceShape};

/// Ends of a photon's path are sums of a few terms, each rounded twice.
const BALANCE: f64 = 1e-6;

#[track_caller]
fn balanced(ledger: &PhotonLedger) {
    close("ledger", ledger.imbalance(), 0.0, BALANCE);
}

/// 5 sigma of a mean of choices, each of a share of so many photons.
fn choices(share: f64, photons: f64) -> f64 {
    5.0 * (share * (1.0 - share) / photons).sqrt()
}

/// A scene with a diffuse ball and a box far below, so that all scenes have one program.
fn scene<const N: usize>(parts: [(SurfaceShape, SurfaceMaterial); N], light: Light, photons: u32) -> Scene {
    let below = DVec3::Z * -60.0;
    let cube = SurfaceShape::Box { low: below - 0.02, high: below - 0.01 };
    Scene::new(parts.into_iter().chain([(sphere(below, 0.01), PAPER), (cube, PAPER)]), [light], photons)
}

/// A unit sphere of glass around the origin, on which a beam of 2 x 2 shines from above.
fn ball_of_glass(photons: u32) -> Scene {
    scene([(sphere(DVec3::ZERO, 1.0), GLASS), floor(-50.0)], sun(), photons)
}

#[test]
fn a_sphere_of_glass_sends_each_order_what_it_should() {
    const PASSES: u32 = 6;
    let truths = &truths()["glass_sphere"];
    let scene = ball_of_glass(1 << 16).through(DVec3::ZERO, 2.2 * DVec3::X, 2.2 * DVec3::Y);
    // What ends after as many turns as there may be, over the flux that meets the sphere.
    let ends = |depth: u32| {
        let ledger = scene.to_depth(depth).ledger(PASSES);
        balanced(&ledger);
        close("flux", ledger.emitted / f64::from(PASSES), 4.84, 1e-5);
        println!("after {depth}: {:.2e} truncated", ledger.truncated / ledger.emitted);
        (ledger.emitted - ledger.truncated) / f64::from(PASSES) / PI
    };
    let done: Vec<f64> = (0..=5).map(ends).collect();
    // The disk is of cells 2.2 / 256 wide, some 730 of which its rim crosses, of 42 555.
    close("met", 4.84 / PI - done[0], 1.0, 5.0 * 0.5 * 730_f64.sqrt() / 42_555.0);
    let expected = ["flux_reflected_p0", "flux_unpol", "flux_unpol_p2", "flux_unpol_p3"];
    for (order, key) in expected.into_iter().enumerate() {
        let (found, exact) = (done[order + 1] - done[order], number(truths, key));
        let bound = choices(exact, f64::from(PASSES) * 42_555.0);
        report(key, (found - exact).abs(), bound);
        close(key, found, exact, bound);
    }
    let beyond = 4.84 / PI - done[5];
    assert!(beyond > 0.0 && beyond < 0.003, "{beyond}");
}

#[test]
fn a_sphere_of_glass_focuses_as_published() {
    const PASSES: u32 = 8;
    // The plane at distance 2 from the centre; straight through alone.
    let parts = [(sphere(DVec3::ZERO, 1.0), GLASS), floor(-2.0)];
    let scene =
        Scene::new(parts, [sun()], 1 << 16).through(DVec3::ZERO, 1.3 * DVec3::X, 1.3 * DVec3::Y).to_depth(2);
    let (stored, ledger) = scene.passes(PASSES);
    balanced(&ledger);
    for row in truths()["glass_sphere"]["profile_d2"].as_array().unwrap() {
        let Some(exact) = row["encircled_unpol"].as_f64() else { continue };
        let (r, h) = (number(row, "r"), number(row, "h"));
        let inside = |p: &&Stored| p.position.distance(DVec3::new(0.0, 0.0, -2.0)) < r;
        let found = stored.iter().filter(inside).map(|p| p.flux[0]).sum::<f64>() / f64::from(PASSES);
        // Photons that aim at the disk of radius h, of which a twelfth is reflected, and the cells on its rim.
        let share = PI * h * h / 1.69;
        let count = f64::from(PASSES << 16) * share;
        let rim = 2.0 * PI * h / (1.3 / 256.0);
        let bound = exact * (choices(0.083, count) + 5.0 * 0.5 * (rim * f64::from(PASSES)).sqrt() / count);
        report(&format!("encircled flux, r = {r}"), (found - exact).abs() / exact, bound / exact);
        close("encircled flux", found, exact, bound);
    }
    // A photon's own line meets the axis where that of its deviation does.
    for row in truths()["glass_sphere"]["rays"].as_array().unwrap() {
        let h = number(row, "h");
        let beam = scene.clone().through(DVec3::X * h, 1e-4 * DVec3::X, 1e-4 * DVec3::Y);
        let mut narrow = beam.clone();
        narrow.settings.emission.photons = 64;
        let angle = number(row, "deviation_deg").to_radians();
        let (stored, _) = narrow.passes(1);
        let passed: Vec<&Stored> =
            stored.iter().filter(|p| (p.direction.x.atan2(-p.direction.z) + angle).abs() < 1e-3).collect();
        assert!(passed.len() > 32, "{h}: {passed:?} of {stored:?}");
        for photon in passed {
            let tangent = photon.direction.x / photon.direction.z;
            let crossing = photon.position.z - photon.position.x / tangent;
            // Directions are packed within 7e-5, over the angle's sine squared, at this distance from the axis; the beam is
            // 1e-4 wide, and the angle's slope is 4 at most.
            let bound = (7e-5 + 2e-4) * photon.position.x.abs() / angle.sin().powi(2) + 2e-4 / angle.sin();
            close(&format!("crossing, h = {h}"), -crossing, number(row, "crossing"), bound);
        }
    }
}

/// A slab of glass 0.5 thick under a point 2 above the floor.
fn slab(photons: u32) -> Scene {
    let pane = SurfaceShape::Box { low: DVec3::new(-90.0, -90.0, 0.8), high: DVec3::new(90.0, 90.0, 1.3) };
    let lamp = Light::Point { position: DVec3::Z * 2.0, intensity: [1.0; 3] };
    scene([(pane, GLASS), floor(0.0)], lamp, photons)
}

#[test]
fn a_slab_of_glass_lets_pass_what_is_published() {
    const PASSES: u32 = 12;
    let truths = &truths()["glass_slab"];
    let scene = slab(1 << 16).through(DVec3::Z * 1.3, 5.0 * DVec3::X, 5.0 * DVec3::Y).to_depth(12);
    let (stored, ledger) = scene.passes(PASSES);
    balanced(&ledger);
    println!("{:.2e} truncated", ledger.truncated / ledger.emitted);
    assert!(ledger.truncated < 1e-5 * ledger.emitted);
    // Between the published places as without the slab, seen 1/6 nearer, of which it is nearly a constant part.
    let like = |r: f64| {
        let h = 2.0 - 0.5 / 3.0;
        h / (r * r + h * h).powf(1.5)
    };
    let mut places = vec![(0.0, number(truths, "point_E0_all"))];
    places.extend(
        truths["point_profile"]
            .as_array()
            .unwrap()
            .iter()
            .map(|row| (number(row, "r"), number(row, "E_all_unpol"))),
    );
    for (r, exact) in places {
        let width = 0.25;
        let [found, flux] = bump(&stored, DVec3::ZERO, r, width, |at| exact * like(at) / like(r));
        // Photons of this flux that were let pass or not; weights count by the mean of their squares over the square of the
        // mean, 1.6 at most.
        let each = ledger.emitted / ledger.photons as f64;
        let bound = 5.0 * (0.1 * 1.6 * each / (f64::from(PASSES) * flux)).sqrt();
        // What differs in shape: the slab's transmittance falls by 1/20 up to r = 2, as r^4.
        let bound = bound + 3e-4;
        report(&format!("E({r}) below glass"), (found / f64::from(PASSES) / flux - 1.0).abs(), bound);
        close(&format!("E({r}) below glass"), found / f64::from(PASSES) / flux, 1.0, bound);
    }
    // Upright through both faces, with all that goes to and fro between.
    let mut narrow = scene.clone().through(DVec3::Z * 1.3, 1e-3 * DVec3::X, 1e-3 * DVec3::Y);
    narrow.settings.emission.photons = 1 << 14;
    let ledger = narrow.ledger(4);
    let through = ledger.stored / ledger.emitted;
    close("T", through, number(truths, "T_inf"), choices(number(truths, "T_inf"), f64::from(4 << 14)));
    assert_eq!(ledger.direct, 0.0);
}

#[test]
fn light_in_a_box_of_glass_leaves_by_six_cones() {
    // Components of directions only change their signs: those all below the critical cosine never leave.
    let cube = SurfaceShape::Box { low: DVec3::splat(-1.0), high: DVec3::splat(1.0) };
    let lamp = Light::Point { position: DVec3::new(0.3, 0.1, -0.2), intensity: [1.0; 3] };
    let scene = scene([(cube, GLASS), floor(-50.0)], lamp, 1024).to_depth(200);
    let ledger = scene.ledger(64);
    balanced(&ledger);
    let trapped = 1.0 - 3.0 * (1.0 - (1.0 - 1.0 / 2.25_f64).sqrt());
    println!("{:.4} truncated, {trapped:.4} trapped", ledger.truncated / ledger.emitted);
    // Cells of the outline of six caps: 6 x 2 pi 0.667 over a cell's side; those around z follow the 18 rows of cells,
    // which 64 passes move about. What all but grazes, R = 1 - e, is still in with exp(-60 e) after as many hits on the
    // faces of its cone: less than 1e-3 of all.
    let rim = 6.0 * 2.0 * PI * 0.667 / (4.0 * PI / 65536.0_f64).sqrt();
    let bound = 5.0 * 0.5 * rim.sqrt() / 65536.0 + 2.0 * 0.5 / (18.0 * 64.0) + 1e-3;
    report("trapped", (ledger.truncated / ledger.emitted - trapped).abs(), bound);
    close("trapped", ledger.truncated / ledger.emitted, trapped, bound);
    assert!(ledger.stored_photons > 0);
}

#[test]
fn absorption_and_reflectances_take_their_shares() {
    // From the middle of a sphere of radius 1 all rays are upright: exp(-0.7) of the flux arrives at the surface.
    let lamp = Light::Point { position: DVec3::ZERO, intensity: [1.0, 1.0, 4.0] };
    let smoky = SurfaceMaterial::Dielectric { cauchy: [1.0, 0.0, 0.0], absorption: [0.7, 0.1, 2.0] };
    let foggy = scene([(sphere(DVec3::ZERO, 1.0), smoky), floor(-20.0)], lamp, 4000).to_depth(1);
    let (stored, ledger) = foggy.passes(1);
    balanced(&ledger);
    let left = mean([(-0.7_f64).exp(), (-0.1_f64).exp(), 4.0 * (-2.0_f64).exp()]);
    close("absorbed", ledger.absorbed / ledger.emitted, 1.0 - left / 2.0, 1e-6);
    close("half of it upward", ledger.escaped / ledger.emitted, 0.5 * left / 2.0, 0.02);
    for photon in &stored {
        let [r, g, b] = photon.flux;
        close("green", g / r, 0.6_f64.exp(), 1e-5);
        close("blue", b / r, 4.0 * (-1.3_f64).exp(), 1e-5);
    }
    // A coloured mirror; what the floor gets has been turned once.
    let mirror = SurfaceMaterial::Mirror { color: [0.8, 0.5, 0.2] };
    let scene = scene([(sphere(DVec3::ZERO, 1.0), mirror), floor(-2.0)], sun(), 1 << 14);
    let (stored, ledger) = scene.passes(1);
    balanced(&ledger);
    let met = ledger.emitted - ledger.direct;
    close("half is absorbed", ledger.absorbed / met, 0.5, 1e-5);
    assert!(!stored.is_empty());
    for photon in stored {
        close("red", photon.flux[0] / photon.flux[1], 1.6, 1e-5);
        close("blue", photon.flux[2] / photon.flux[1], 0.4, 1e-5);
    }
}

#[test]
fn reflected_rays_are_tangents_of_the_nephroid() {
    // The lines of rays that a convex mirror reflects are those that the concave one does, behind it: they cross the axis
    // at R / (2 cos t).
    let mirror = SurfaceMaterial::Mirror { color: [1.0; 3] };
    let wall = SurfaceShape::Plane { point: DVec3::X * 3.0, normal: DVec3::NEG_X };
    let scene = scene([(sphere(DVec3::ZERO, 1.0), mirror), (wall, PAPER)], sun(), 16);
    for row in truths()["nephroid"]["rows"].as_array().unwrap() {
        let angle = number(row, "t_deg").to_radians();
        if !(0.1..1.5).contains(&angle) {
            continue;
        }
        let (stored, _) =
            scene.clone().through(angle.sin() * DVec3::X, 1e-4 * DVec3::X, 1e-4 * DVec3::Y).passes(1);
        assert_eq!(stored.len(), 16);
        for Stored { position, direction, .. } in stored {
            let crossing = position.z - position.x * direction.z / direction.x;
            // Directions within 7e-5 at distance 3 over their slope to the axis; places within 5e-5, and normals turn by as
            // much over the cosine.
            let slope = (2.0 * angle).sin();
            let bound = (7e-5 + 2e-4 / angle.cos()) * 3.0 / slope.powi(2);
            close(&format!("{row}"), crossing, number(row, "axis_crossing"), bound);
        }
    }
}

#[test]
fn passes_do_not_depend_on_how_they_are_cut() {
    let device = common::device();
    let scene = ball_of_glass(70_001);
    let run = |cuts: &[u32], passes: &[u32]| {
        let mut tracer = scene.tracer(&device).unwrap();
        for &pass in passes {
            for ends in cuts.windows(2) {
                tracer.trace(&device, pass, ends[0], ends[1] - ends[0]).unwrap();
            }
        }
        (tracer.photons().read(&device).unwrap(), tracer.ledger(&device).unwrap())
    };
    let whole = run(&[0, 70_001], &[0, 1]);
    let pieces = run(&[0, 1, 1, 1000, 65_536, 65_537, 70_001], &[0, 1]);
    assert!(
        whole.1 == pieces.1
            && bytemuck::cast_slice::<_, u8>(&whole.0) == bytemuck::cast_slice::<_, u8>(&pieces.0)
    );
    let alone = run(&[0, 70_001], &[1]);
    assert!(
        bytemuck::cast_slice::<_, u8>(&whole.0) == bytemuck::cast_slice::<_, u8>(&alone.0),
        "pass 1 is pass 1"
    );
    let other = run(&[0, 70_001], &[2]);
    assert!(alone.0 != other.0 && alone.1 != other.1);
    let mut tracer = scene.tracer(&device).unwrap();
    let message = tracer.trace(&device, 0, 70_000, 2).unwrap_err().to_string();
    assert_eq!(message, "there are no 2 photons from 70000 on: a pass has 70001");
}

#[test]
fn no_photons_are_no_trouble() {
    let device = common::device();
    let nothing_to_meet = scene([floor(0.0)], sun(), 1000);
    for scene in [ball_of_glass(0), nothing_to_meet] {
        let mut tracer = scene.tracer(&device).unwrap();
        assert_eq!((tracer.capacity(), tracer.photons().len()), (0, 0));
        tracer.trace(&device, 0, 0, 0).unwrap();
        assert_eq!(tracer.ledger(&device).unwrap(), PhotonLedger::default());
    }
    let refused = ball_of_glass(u32::MAX).tracer(&device).map(|_| ()).unwrap_err().to_string();
    assert!(refused.contains("the photons would take 128 GiB"), "{refused}");
}

/// Dense flint, with more dispersion than there is.
const PRISM: [f64; 3] = [1.6, 0.02, 0.0];

#[test]
fn wavelengths_go_their_own_ways() {
    let glass = SurfaceMaterial::Dielectric { cauchy: PRISM, absorption: [0.0; 3] };
    let lamp = Light::Directional { direction: DVec3::NEG_Z, irradiance: [1.0, 2.0, 3.0] };
    let parts = [(sphere(DVec3::ZERO, 1.0), glass), floor(-20.0)];
    let h = 0.6;
    let scene =
        Scene::new(parts, [lamp], 4096).through(DVec3::X * h, 1e-5 * DVec3::X, 1e-5 * DVec3::Y).to_depth(2);
    let (stored, ledger) = scene.passes(1);
    balanced(&ledger);
    let white = mean_color();
    let deviation = |nanometres: f64| 2.0 * (h.asin() - (h / cauchy(PRISM, 1e-3 * nanometres)).asin());
    let each = 1e-10 / 4096.0;
    let mut bins = [0_u32; 7];
    let mut passed = 0;
    for photon in &stored {
        let angle = -photon.direction.x.atan2(-photon.direction.z);
        if !(deviation(730.0) - 1e-3..deviation(380.0) + 1e-3).contains(&angle) {
            continue;
        }
        passed += 1;
        // The wavelength with this deviation.
        let (mut low, mut high) = (300.0, 900.0);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if deviation(middle) > angle { low = middle } else { high = middle }
        }
        bins[(((low - 380.0) / 50.0).clamp(0.0, 6.99)) as usize] += 1;
        // Deviation turns by 2.5e-4 per nm at least at 730 nm, directions are packed within 7e-5 and the beam is 1e-5
        // wide: a nm or two, over which colours change by up to 0.06.
        let slope = (deviation(low - 1.0) - deviation(low + 1.0)) / 2.0;
        let spread = 1.2e-4 / slope;
        let color = color_of(low);
        for c in 0..3 {
            let expected = each * (c + 1) as f64 * color[c] / white[c];
            let bound = each * (c + 1) as f64 * (0.045 * spread / white[c] + 1e-3);
            close(&format!("channel {c} at {low} nm"), photon.flux[c], expected, bound);
        }
    }
    // Wavelengths are spread evenly, but for what is reflected, a tenth.
    assert!(passed > 3000, "{passed} of {}", stored.len());
    let share = f64::from(passed) / 7.0;
    for bin in bins {
        close("evenly", f64::from(bin), share, 5.0 * (0.12 * share).sqrt() + 0.02 * share);
    }
}

#[test]
fn all_wavelengths_together_are_the_light() {
    // Through a ball that parts colours by less than float32 tells, onto the floor.
    let glass = SurfaceMaterial::Dielectric { cauchy: PRISM, absorption: [0.0; 3] };
    let hardly = SurfaceMaterial::Dielectric { cauchy: [1.0, 1e-9, 0.0], absorption: [0.0; 3] };
    let nothing = SurfaceMaterial::Dielectric { cauchy: [1.0, 0.0, 0.0], absorption: [0.0; 3] };
    let lamp = Light::Directional { direction: DVec3::NEG_Z, irradiance: [1.0, 2.0, 3.0] };
    let through = |ball| {
        let parts = [(sphere(DVec3::X * 20.0, 1.0), glass), (sphere(DVec3::ZERO, 1.0), ball), floor(-1.5)];
        scene(parts, lamp, 1 << 14).through(DVec3::ZERO, DVec3::X, DVec3::Y).passes(4)
    };
    // Glass that disperses elsewhere leaves light white.
    let channel = |p: &Stored, c: usize| p.flux[c] * f64::from(1 << 14) / (c + 1) as f64;
    assert!(through(nothing).0.iter().all(|p| (0..3).all(|c| (channel(p, c) - 1.0).abs() < 1e-6)));
    let (stored, ledger) = through(hardly);
    assert_eq!(stored.len(), 4 << 14);
    balanced(&ledger);
    // A lattice of 2^16 places and wavelengths, and the 2600 of them on a small part of the floor: sums over lattices err by
    // a few over their number, times the range of the channels, up to 6 times their mean.
    for (side, bound) in [(1.0, 5e-4), (0.2, 1.2e-2)] {
        let near = |p: &&Stored| p.position.x.abs() < 0.5 * side && p.position.y.abs() < 0.5 * side;
        let near: Vec<&Stored> = stored.iter().filter(near).collect();
        for c in 0..3 {
            let found =
                near.iter().map(|p| p.flux[c]).sum::<f64>() / (near.len() as f64 / f64::from(1 << 14));
            report(&format!("channel {c} within {side}"), (found / (c + 1) as f64 - 1.0).abs(), bound);
            close("channel", found / (c + 1) as f64, 1.0, bound);
        }
    }
    assert!(
        stored.iter().any(|p| p.flux.iter().any(|flux| *flux < 0.0)),
        "spectral colours are out of gamut"
    );
}

#[test]
fn photons_of_several_lights_add_up() {
    let lamp = Light::Point { position: DVec3::new(0.5, 0.0, 4.0), intensity: [1.0; 3] };
    let area = Light::Rectangle {
        centre: DVec3::new(-2.0, 0.0, 5.0),
        edge_u: DVec3::X,
        edge_v: DVec3::NEG_Y,
        radiance: [2.0; 3],
    };
    let glass = || (sphere(DVec3::ZERO, 1.0), GLASS);
    let one = |light: Light| scene([glass(), floor(-3.0)], light, 20_000).ledger(2);
    let alone: Vec<PhotonLedger> = [lamp, area, sun()].map(one).to_vec();
    let mut scene = scene([glass(), floor(-3.0)], lamp, 60_000);
    scene.lights.extend([area, sun()]);
    let together = scene.ledger(2);
    balanced(&together);
    assert_eq!(together.photons, 120_000);
    for (what, part) in [
        ("emitted", (|l| l.emitted) as fn(&PhotonLedger) -> f64),
        ("stored", |l| l.stored),
        ("direct", |l| l.direct),
        ("escaped", |l| l.escaped),
    ] {
        let sum: f64 = alone.iter().map(part).sum();
        let most = alone.iter().map(|l| l.emitted).sum::<f64>();
        // The least bright light has 4000 photons for a tenth of the flux or less.
        close(what, part(&together) / most, sum / most, 5.0 * (0.25 / 40_000.0_f64).sqrt());
    }
    scene.lights.clear();
    assert_eq!(scene.emitters(), Vec::<Emitter>::new());
}
