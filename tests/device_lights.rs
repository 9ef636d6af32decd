//! Light sampling on the device: every sample against the twin, and places where numbers could break.

mod common;
#[path = "common/lights.rs"]
mod lights;

use common::{EPS, close, largest, report};
use glam::DVec3;
use lights::{INTENSITY, Lit, environment, every_light, float4, maps, numbers, points, studio, vector};
use std::f64::consts::TAU;
use svetlo::reference::lights::{LightSample, sample};
use svetlo::scene::Light;

/// The table's entry in which a number falls, and where in it, as `sums` are told.
fn choose(sums: &[f32], u: f64) -> (usize, f64, f64) {
    let index = sums.iter().position(|&sum| f64::from(sum) > u).unwrap();
    let before = if index == 0 { 0.0 } else { f64::from(sums[index - 1]) };
    let share = f64::from(sums[index]) - before;
    (index, share, (u - before + 0.5 * EPS) / share)
}

#[test]
fn every_sample_of_a_light_is_that_of_the_twin() {
    let lit = Lit::new(every_light(), None);
    let table = lit.table();
    assert_eq!(table.sources, [2, 5, 0, 1, 4], "rectangles first, no black light");
    let sums: Vec<f32> = table.lights.iter().map(|light| light.edge_u[3]).collect();
    let pairs: Vec<_> = points(&lit.local, 20_000, 1).into_iter().zip(numbers(20_000, 2)).collect();
    let mut errors = Vec::new();
    let mut behind = 0;
    for (&(point, u), found) in pairs.iter().zip(lit.samples(&pairs)) {
        let (index, pick, _) = choose(&sums, u[0]);
        let light = &lit.lights[table.sources[index]];
        let exact = sample(light, point, [u[1], u[2]]);
        // Positions are rounded to float32 in local units, a few times: at most this far in scene units.
        let moved = match *light {
            Light::Directional { .. } => 0.0,
            Light::Point { position, .. } => (position - lit.local.origin).length() + 6.0,
            Light::Rectangle { centre, edge_u, edge_v, .. } => {
                (centre - lit.local.origin).length() + edge_u.length() + edge_v.length() + 6.0
            }
        } * 2.0
            * EPS;
        let Some(exact) = exact else {
            behind += 1;
            assert!(found.weight == [0.0; 4] || vector(found.weight).length() < 1e-4, "{found:?}");
            continue;
        };
        let turned = if exact.distance.is_finite() { moved / exact.distance } else { 0.0 } + 4.0 * EPS;
        let cosine = match *light {
            Light::Rectangle { edge_u, edge_v, .. } => -edge_u.cross(edge_v).normalize().dot(exact.direction),
            _ => 1.0,
        };
        // The square of the distance, and the cosine, which turns with the direction and the rounded normal.
        let relative = 2.0 * turned + 2.0 * turned / cosine + 16.0 * EPS;
        close("direction", vector(found.direction).distance(exact.direction), 0.0, 2.0 * turned);
        assert_eq!([found.direction[3], found.weight[3]], [0.0; 2]);
        if exact.distance.is_finite() {
            let distance = f64::from(found.distance) * lit.local.unit;
            close("distance", distance / exact.distance, 1.0, turned + 4.0 * EPS);
        } else {
            assert_eq!(found.distance, f32::INFINITY);
        }
        for (found, exact) in found.weight.into_iter().zip(exact.weight) {
            close("weight", f64::from(found), exact / pick, relative * exact / pick);
        }
        close("pdf", f64::from(found.pdf), exact.pdf * pick, relative * exact.pdf * pick);
        let error = (f64::from(found.weight[0]) * pick / exact.weight[0] - 1.0).abs();
        errors.push(error / relative);
    }
    assert!(behind > 100 && errors.len() > 10_000, "{behind} {}", errors.len());
    report("samples of lights, of their bound", largest(errors), 1.0);
}

#[test]
fn every_sample_of_the_environment_is_that_of_the_twin() {
    let mut maps = maps();
    maps.push(("studio".into(), studio()));
    for (name, map) in maps {
        // A light beside it, so that picking counts.
        let sun = Light::Directional { direction: DVec3::NEG_Y, irradiance: [5.0; 3] };
        let lit = Lit::new(vec![sun], Some(map));
        let (table, sky) = (lit.table(), lit.sky().unwrap());
        let (width, height) = (sky.map.width, sky.map.height);
        let pick = f64::from(table.environment_pick);
        let brightest = largest(sky.map.rgb.iter().flatten().map(|&v| INTENSITY * f64::from(v)));
        let pairs: Vec<_> = numbers(4000, 3).map(|u| (lit.local.origin, u)).collect();
        let (mut count, mut skipped) = (0, 0);
        for ((_, u), found) in pairs.iter().zip(lit.samples(&pairs)) {
            if u[0] < 1.0 - pick {
                assert_eq!(found.pdf, 0.0, "{name}: the sun");
                continue;
            }
            let (y, of_row, rest_y) = choose(&table.environment_sums[..height], u[1]);
            let in_row = &table.environment_sums[height + y * width..][..width];
            let (x, of_column, rest_x) = choose(in_row, u[2]);
            let place = sky.place_in_texel([x, y], [rest_x, rest_y]);
            let exact = LightSample {
                direction: sky.direction(place),
                distance: f64::INFINITY,
                weight: sky.radiance(place),
                pdf: of_row * of_column / sky.solid_angle(y),
            };
            // Sines and cosines of 4 ulp of an angle that is rounded to 2^-24 turns; the place in the row is rounded
            // to 2^-24 of its cosines, which over the sine is an angle.
            let sine = exact.direction.x.hypot(exact.direction.z);
            let cosines = sky.solid_angle(y) * width as f64 / TAU;
            let bound = EPS * (32.0 + 2.0 * cosines / sine);
            close(&name, vector(found.direction).distance(exact.direction), 0.0, bound);
            assert_eq!((found.distance, found.weight[3]), (f32::INFINITY, 0.0));
            // Around the pole, the azimuth turns by that over the sine; radiance changes by its slope, at most the
            // brightest texel per texel, along both axes.
            let (across, down) = (16.0 * EPS * width as f64, 16.0 * EPS * height as f64 / sine.max(1e-3));
            let density = exact.pdf * pick;
            for (found, exact) in found.weight.into_iter().zip(exact.weight) {
                let bound = (brightest * (across + down) + 32.0 * EPS * exact) / density;
                close(&name, f64::from(found), exact / density, bound);
            }
            // Where rounding may move the direction to another texel, so may its density.
            let edge = |rest: f64, error: f64| rest < error || rest > 1.0 - error;
            if edge(rest_x, across) || edge(place[1].fract(), down) {
                skipped += 1;
                continue;
            }
            close(&name, f64::from(found.pdf), density, 32.0 * EPS * density);
            count += 1;
        }
        assert!(count > 500 && 50 * skipped < count, "{name}: {count} {skipped}");
    }
}

#[test]
fn segments_end_before_what_they_do_not_reach() {
    let lamp = |height: f64, radiance: f64| Light::Rectangle {
        centre: DVec3::new(5.0, height, 2.0),
        edge_u: DVec3::X,
        edge_v: DVec3::Z,
        radiance: [radiance; 3],
    };
    // X × Z points down: seen from below at distances 4 and 8 local units, not seen from above.
    let lit = Lit::new(vec![lamp(2.0, 1.0), lamp(4.0, 10.0)], None);
    let below = (DVec3::new(5.2, 0.0, 2.3), DVec3::Y);
    let radiance =
        |ray, t_max| lit.rays(&[ray], t_max, "-1.0f")[0].weight.map(|w| (w * 4.0).round() / 4.0)[0];
    assert_eq!(["3.99f", "4.01f", "7.99f", "8.01f"].map(|t| radiance(below, t)), [0.0, 1.0, 1.0, 11.0]);
    assert_eq!(radiance((DVec3::new(5.2, 6.0, 2.3), DVec3::NEG_Y), "INFINITY"), 0.0, "from behind");
    assert_eq!(radiance((DVec3::new(5.6, 0.0, 2.3), DVec3::Y), "INFINITY"), 0.0, "past the edge");
}

#[test]
fn impossible_places_give_finite_numbers() {
    let at = DVec3::new(5.0, 0.0, 2.5);
    let rectangle = Light::Rectangle { centre: at, edge_u: DVec3::X, edge_v: DVec3::Z, radiance: [1.0; 3] };
    let lit = Lit::new(vec![rectangle, Light::Point { position: at, intensity: [1.0; 3] }], None);
    let mut pairs = Vec::new();
    for u in numbers(2000, 12).chain([[0.0; 3], [0.0, 0.5, 0.5], [1.0 - EPS; 3]]) {
        // On the light, in its plane, a hair off it on either side, and far away in the plane.
        for offset in [
            DVec3::ZERO,
            DVec3::X * 0.3,
            DVec3::X * 2.0,
            DVec3::NEG_Y * 1e-7,
            DVec3::NEG_Y * 1e-30,
            DVec3::Y * 1e-7,
            DVec3::new(2.0, -1e-12, 0.0),
            DVec3::new(1e7, -1e-6, 0.0),
        ] {
            pairs.push((at + offset, u));
        }
    }
    for ((point, u), found) in pairs.iter().zip(lit.samples(&pairs)) {
        let finite = found.weight.into_iter().chain(found.direction).chain([found.pdf]).all(f32::is_finite);
        assert!(finite && found.pdf >= 0.0 && found.weight[0] >= 0.0, "{point} {u:?} {found:?}");
        close("unit", vector(found.direction).length(), 1.0, 4.0 * EPS);
    }
    let on_the_point: Vec<_> = numbers(500, 13).map(|[_, v, w]| (at, [1.0 - EPS, v, w])).collect();
    assert!(lit.samples(&on_the_point).iter().all(|found| found.weight == [0.0; 4]));
    // Rays in the plane, along it, against it, from points on it.
    let offsets = [DVec3::ZERO, DVec3::X * 3.0, DVec3::NEG_Y * 1e-30, DVec3::NEG_Y, DVec3::NEG_Y * 1e-12];
    let towards = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::new(1.0, 1e-20, 0.0)];
    let rays: Vec<_> = offsets.iter().flat_map(|o| towards.map(|d| (at + *o, d))).collect();
    for (ray, found) in rays.iter().zip(lit.rays(&rays, "INFINITY", "0.1f")) {
        assert!(found.weight.iter().all(|w| (0.0..=1.0).contains(w)), "{ray:?} {found:?}");
    }
}

#[test]
fn the_poles_of_the_map_are_sharp() {
    // 2048 rows: the first row's texels lie within 0.0015 of the pole, where the cosine is 1 in float32.
    let (width, height) = (8, 2048);
    let map = environment(width, height, |x, y| [(y + 1) as f32, (height - y) as f32, x as f32 + 1.0]);
    let lit = Lit::new(Vec::new(), Some(map));
    let sky = lit.sky().unwrap();
    let places: Vec<[f64; 2]> = (0..2 * 64)
        .map(|i| {
            [
                0.37 + (i % 8) as f64,
                if i < 64 { 0.2 + 0.1 * i as f64 } else { height as f64 - 0.2 - 0.1 * (i - 64) as f64 },
            ]
        })
        .collect();
    let pairs: Vec<_> = places.iter().map(|&place| [[0.0; 4], float4(sky.direction(place), 0.0)]).collect();
    let found = lit.probe("found.weight.xyz = environment_radiance(frame, map, b.xyz);", &pairs);
    for (place, found) in places.iter().zip(found) {
        let exact = sky.radiance(*place);
        for (found, exact) in found.weight.into_iter().zip(exact) {
            let exact = exact / INTENSITY;
            // Near the lower pole, pi is rounded to 2^-22: by texels, (2^-22 / pi) 2048, and atan2 errs by 6 ulp. One
            // texel is one unit of red and green. The azimuth is good to 2^-21 turns of 8 texels with slopes up to 7.
            let bound = 8.0 * EPS * height as f64 + 16.0 * EPS * width as f64 * 7.0 + 4.0 * EPS * exact;
            close(&format!("{place:?}"), f64::from(found), exact, bound);
        }
    }
}
