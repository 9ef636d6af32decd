use super::*;

/// A box of 4×4×2 from (10, 0, 0): its sphere has its centre at (12, 2, 1) and radius 3.
fn local() -> LocalFrame {
    LocalFrame::new(DVec3::new(10.0, 0.0, 0.0), DVec3::splat(0.5), [8, 8, 4])
}

const CENTRE: DVec3 = DVec3::new(12.0, 2.0, 1.0);
const DISC: f64 = 9.0 * PI;

fn background(sampling: EnvironmentSampling) -> Background {
    Background::Environment { path: "unread".into(), intensity: 2.0, rotation: 0.0, sampling }
}

/// A constant map whose first texel of the middle row is brighter by a factor.
fn map(factor: f32) -> Environment {
    let mut rgb = vec![[0.5, 1.0, 1.5]; 16 * 9];
    rgb[16 * 4] = rgb[16 * 4].map(|v| v * factor);
    Environment { width: 16, height: 9, rgb, notes: Vec::new() }
}

fn point(position: DVec3, intensity: f64) -> Light {
    Light::Point { position, intensity: [intensity, 0.0, 2.0 * intensity] }
}

fn lamp(centre: DVec3, edge: f64, radiance: f64) -> Light {
    let (edge_u, edge_v) = (edge * DVec3::Y, edge * DVec3::Z); // shines towards +x
    Light::Rectangle { centre, edge_u, edge_v, radiance: [radiance; 3] }
}

#[test]
fn lights_are_picked_by_the_flux_that_reaches_the_volume() {
    let far = CENTRE - 300.0 * DVec3::X;
    let near = CENTRE - 5.0 * DVec3::X;
    let cases = [
        (lamp(far, 2.0, 5e5), 5e5 * 4.0 / 90_000.0 * DISC),
        (point(CENTRE + DVec3::X, 7.0), 4.0 * PI * 7.0),
        // sin = 3/5, cos = 4/5.
        (point(near, 30.0), 30.0 * 2.0 * PI * (1.0 - 0.8)),
        (Light::Directional { direction: DVec3::X, irradiance: [1.0, 2.0, 6.0] }, 3.0 * DISC),
    ];
    // A constant sky of mean 1, times its factor.
    let sky = 4.0 * PI * DISC * 2.0;
    let total = sky + cases.iter().map(|case| case.1).sum::<f64>();
    let scene = cases.map(|case| case.0);
    let lights = Lights::new(&scene, &background(EnvironmentSampling::Importance), Some(&map(1.0)), &local());
    assert_eq!(lights.sources, [0, 1, 2, 3]);
    // Multiples of 2^-24: two roundings by a half, one unit for each of five.
    let bound = 6.0 * 2_f64.powi(-24);
    // The sum over latitudes of a constant map is 1 but for rounding.
    for (light, (_, flux)) in lights.lights.iter().zip(cases) {
        assert!((f64::from(light.power[3]) - flux / total).abs() < bound, "{light:?} {}", flux / total);
    }
    assert!((f64::from(lights.environment_pick) - sky / total).abs() < bound);
    let sum = lights.lights.iter().map(|light| light.power[3]).sum::<f32>() + lights.environment_pick;
    assert_eq!(sum, 1.0, "exactly: all are multiples of 2^-24");
    assert_eq!(lights.lights.last().unwrap().edge_u[3], 1.0 - lights.environment_pick);
    let last = lights.details.last().unwrap();
    assert!(last.contains("rectangle ") && last.contains("environment "), "{last}");
}

#[test]
fn every_light_that_shines_can_be_picked() {
    let behind = lamp(CENTRE + 4.0 * DVec3::X, 1.0, 1e-9);
    let faint = point(CENTRE, 1e-30);
    let black = [point(CENTRE, 0.0), lamp(CENTRE, 1.0, 0.0)];
    let bright = Light::Directional { direction: DVec3::Y, irradiance: [1e6; 3] };
    let lights = Lights::new(
        &[black[0], bright, faint, black[1], behind],
        &Background::Constant([1.0; 3]),
        None,
        &local(),
    );
    assert_eq!(lights.sources, [4, 1, 2]);
    assert!(lights.lights.iter().all(|light| light.power[3] >= 2_f32.powi(-24)));
    assert!(lights.sampled() && lights.has_rectangles());
    let dark = Lights::new(&black, &Background::Constant([1.0; 3]), None, &local());
    assert!(!dark.sampled() && !dark.has_rectangles());
    assert!(dark.buffers().iter().all(|buffer| !buffer.bytes.is_empty()));
}

#[test]
fn the_flux_of_a_rectangle_has_bounds() {
    let bounds = Bounds::new(&local());
    assert_eq!((bounds.centre, bounds.radius), (CENTRE, 3.0));
    for distance in [-50.0, -4.0, -3.0, 0.0, 2.9, 3.1, 10.0, 1e6] {
        for edge in [1e-3, 1.0, 100.0] {
            let flux = bounds.flux(&lamp(CENTRE - distance * DVec3::X, edge, 2.0));
            let all = 2.0 * PI * edge * edge;
            let most = all.min(2.0 * PI * 2.0 * DISC) * (1.0 + 1e-15);
            assert!(flux > 0.0 && flux <= most, "{distance} {edge}: {flux} {most}");
        }
    }
}

#[test]
fn maps_are_sampled_where_their_contrast_asks_for_it() {
    let lights = |sampling, map: &Environment| Lights::new(&[], &background(sampling), Some(map), &local());
    let pick = |sampling, factor| lights(sampling, &map(factor)).environment_pick;
    // The bright texel has sin(pi/18)/16 of the sphere: a contrast of 20/(1 + 19 · 0.0109) = 16.6, or 4.8.
    assert_eq!(pick(EnvironmentSampling::Auto, 20.0), 1.0);
    assert_eq!(pick(EnvironmentSampling::Auto, 5.0), 0.0);
    assert_eq!(pick(EnvironmentSampling::Importance, 1.0), 1.0);
    assert_eq!(pick(EnvironmentSampling::Escape, 1e6), 0.0);
    let escape = lights(EnvironmentSampling::Escape, &map(1.0));
    assert!(!escape.sampled() && escape.environment_sums.is_empty());
    let black =
        lights(EnvironmentSampling::Importance, &Environment { rgb: vec![[0.0; 3]; 144], ..map(1.0) });
    assert!(!black.sampled() && black.details[0].contains("black"), "{:?}", black.details);
}
