//! Upwind convection of direct light against closed forms and against its twin in double precision.

#[path = "common/cells.rs"]
mod cells;
mod common;
#[path = "common/convection.rs"]
mod convection;

use cells::Medium;
use common::{EPS, close, largest, log_slope};
use convection::*;
use glam::DVec3;
use svetlo::irradiance::{Carrying, SteadyLight, crossing_steps, largest_courant};
use svetlo::reference::convection::Source;
use svetlo::scene::Light;

#[test]
fn steady_light_along_an_axis_has_its_closed_form() {
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let medium = Medium::grey([6, 8, 7], DVec3::new(1.0, 1.25, 2.0), |_| [0.125, 0.5]);
            let light = parallel(DVec3::AXES[axis] * sign);
            let found = shares(&medium, &light, &steady_fluence(&medium, &[light], GREY), 1);
            let (n, h) = (medium.grid.dims[axis], medium.grid.cell[axis]);
            for (i, found) in found.into_iter().enumerate() {
                let k = (medium.centre(i)[axis] / h) as usize;
                let k = if sign > 0.0 { k } else { n - 1 - k } as i32;
                let exact = (1.0 + 0.625 * h).powi(-(k + 1));
                close("share", found, exact, f64::from(k + 2) * SETTLED * exact);
            }
        }
    }
}

#[test]
fn steady_light_converges_to_the_exponential_with_the_first_order() {
    const THICKNESS: f64 = 2.0;
    let errors = [16_usize, 32, 64].map(|cells| {
        let sigma = THICKNESS / cells as f64;
        let medium = Medium::grey([2, 3, cells], DVec3::ONE, |_| [0.0, sigma]);
        let light = parallel(DVec3::Z);
        let found = shares(&medium, &light, &steady_fluence(&medium, &[light], GREY), 0);
        let error = |(i, share): (usize, f64)| (share - (-sigma * medium.centre(i).z).exp()).abs();
        (1.0 / cells as f64, largest(found.into_iter().enumerate().map(error)))
    });
    let slope = log_slope(&errors);
    println!("largest errors {errors:?}, order {slope:.3}");
    // The largest error is the first cell's, s/2 - 7s²/8 + ... with s = σh: 1/8 at 16 cells, 1/32 at 64.
    let next = |s: f64| 1.0 - 1.75 * s;
    assert!((slope - 1.0).abs() < (next(1.0 / 32.0) / next(1.0 / 8.0)).ln() / f64::ln(4.0), "{slope}");
}

#[test]
fn steps_come_to_rest_at_their_closed_form() {
    let medium = Medium::grey([2, 24, 3], DVec3::ONE, |_| [0.05, 0.1]);
    let light = parallel(DVec3::Y);
    for courant in [0.25, 0.5, 1.0] {
        let steps = 2 * crossing_steps(&medium.grid, courant);
        let fluence = explicit(&medium, &[light], GREY, courant, steps);
        // T_k = e ((1 - λ) T_k + λ T_{k-1}) with e = exp(-σ λ h).
        let decay = (-0.15 * courant).exp();
        let ratio = courant * decay / (1.0 - (1.0 - courant) * decay);
        for (i, found) in shares(&medium, &light, &fluence, 2).into_iter().enumerate() {
            let exact = ratio.powi(medium.centre(i).y as i32 + 1);
            // What has not arrived, by Bernstein: the time is twice that of e^-8, so the exponent is more than twice 8.
            close("share", found, exact, f64::exp(-16.0) + f64::from(steps) * STEPPED);
        }
    }
}

#[test]
fn light_has_crossed_a_vacuum_after_the_steps_that_are_said() {
    let medium = Medium::grey([17, 6, 9], DVec3::new(1.0, 1.5, 1.0), |_| [0.0; 2]);
    let directions =
        [DVec3::X, DVec3::new(1.0, -1.0, 1.0), DVec3::new(0.2, 1.0, -0.1), DVec3::new(-1.0, 0.0, 2.0)];
    for courant in [0.2, 0.5] {
        let steps = crossing_steps(&medium.grid, courant);
        for direction in directions {
            let light = parallel(direction);
            let fluence = explicit(&medium, &[light], GREY, courant, steps);
            let least = shares(&medium, &light, &fluence, 0).into_iter().fold(f64::INFINITY, f64::min);
            assert!(least >= 1.0 - CROSSED - f64::from(steps) * STEPPED, "{direction}: {least}");
            let settled = shares(&medium, &light, &steady_fluence(&medium, &[light], GREY), 0);
            for share in settled {
                close("steady share", share, 1.0, 33.0 * SETTLED);
            }
            let early = explicit(&medium, &[light], GREY, courant, 3);
            let dark = early.iter().filter(|share| share[0] == 0.0).count();
            assert!(dark > 0, "no step crosses more than a cell");
        }
    }
}

#[test]
fn both_forms_follow_their_twins() {
    for (dims, cell) in boxes() {
        for coloured in [false, true] {
            let medium = Medium::random(dims, cell, coloured, 11);
            let carrying = if coloured { CHROMATIC } else { GREY };
            let levels = dims.iter().sum::<usize>() as f64;
            for light in lights(&medium) {
                let courant = largest_courant(&[light], &medium.grid, &medium.local).min(0.5);
                let settled = steady_fluence(&medium, &[light], carrying);
                let stepped = explicit(&medium, &[light], carrying, courant, 12);
                for channel in if coloured { 0..3 } else { 1..2 } {
                    let twin = twin(&medium, channel, 1.0);
                    let source = source(&medium, &light);
                    let exact = twin.steady(source);
                    let found = shares(&medium, &light, &settled, channel);
                    for (found, exact) in found.into_iter().zip(exact) {
                        close("steady", found, exact, levels * SETTLED * exact);
                    }
                    let mut exact = twin.begin(source);
                    for _ in 0..12 {
                        exact = twin.step(source, &exact, courant * medium.grid.cell.min_element());
                    }
                    let found = shares(&medium, &light, &stepped, channel);
                    for (found, exact) in found.into_iter().zip(exact) {
                        close("explicit", found, exact, 13.0 * STEPPED);
                    }
                }
            }
        }
    }
}

#[test]
fn a_point_light_in_a_vacuum_falls_with_the_squared_distance() {
    let medium = Medium::grey([11, 8, 9], DVec3::new(1.0, 1.25, 1.0), |_| [0.0; 2]);
    for place in [DVec3::new(5.5, 5.0, 4.5), DVec3::new(2.3, 7.1, 6.6), DVec3::new(-7.0, 20.0, 3.0)] {
        let light = point(&medium, place);
        let fluence = steady_fluence(&medium, &[light], GREY);
        for (i, found) in fluence.iter().enumerate() {
            let r2 = (medium.centre(i) - place).length_squared() * medium.local.unit.powi(2);
            if twin(&medium, 0, 1.0).is_held(source(&medium, &light), i) {
                continue;
            }
            for channel in 0..3 {
                let exact = [1.0, 2.0, 0.5][channel] / r2;
                close("fluence", f64::from(found[channel]), exact, 30.0 * SETTLED * exact);
            }
            assert_eq!(found[3], 0.0);
        }
    }
}

#[test]
fn a_point_light_in_the_box_loses_to_the_cells_what_does_not_leave_it() {
    // Cells of 0.1 to 2.5 mean free paths.
    for sigma in [0.1, 0.625, 1.25, 2.5] {
        for place in [DVec3::splat(5.5), DVec3::splat(5.0), DVec3::new(5.1, 5.7, 5.0)] {
            let medium = Medium::grey([11, 11, 11], DVec3::ONE, |_| [0.0, sigma]);
            let light = point(&medium, place);
            let taken: f64 = steady_fluence(&medium, &[light], GREY).iter().map(|f| f64::from(f[0])).sum();
            // A spiral of directions, each of which leaves e^-way of its light.
            let left = |k: usize| {
                let height = 1.0 - (k as f64 + 0.5) / 5000.0;
                let (sin, cos) = (2.399963 * k as f64).sin_cos();
                let u = (1.0 - height * height).sqrt() * DVec3::new(cos, sin, 0.0) + height * DVec3::Z;
                let ways = DVec3::select(u.cmpgt(DVec3::ZERO), 11.0 - place, place) / u.abs();
                (-sigma * ways.min_element()).exp()
            };
            let escapes = (0..10_000).map(left).sum::<f64>() / 10_000.0;
            let exact = 4.0 * std::f64::consts::PI * (1.0 - escapes);
            let found = sigma * taken * medium.local.unit.powi(2);
            println!("sigma {sigma}, {place}: {found:.3} of {exact:.3}");
            assert!((found / exact - 1.0).abs() < 0.1, "{sigma}, {place}: {found} of {exact}");
        }
    }
}

#[test]
fn lights_add_up() {
    let medium = Medium::random([9, 7, 8], DVec3::new(1.0, 1.0, 1.5), true, 23);
    let all: Vec<Light> = lights(&medium).into_iter().take(5).collect();
    for form in [
        &(|lights: &[Light]| steady_fluence(&medium, lights, CHROMATIC))
            as &dyn Fn(&[Light]) -> Vec<[f32; 4]>,
        &|lights: &[Light]| explicit(&medium, lights, CHROMATIC, 0.4, 30),
    ] {
        let together = form(&all);
        let alone: Vec<Vec<[f32; 4]>> = all.iter().map(|&light| form(&[light])).collect();
        for i in 0..together.len() {
            for channel in 0..3 {
                let sum: f64 = alone.iter().map(|fluence| f64::from(fluence[i][channel])).sum();
                close("sum", f64::from(together[i][channel]), sum, 5.0 * EPS * sum);
            }
        }
    }
}

#[test]
fn the_reduced_fluence_counts_scattering_by_what_does_not_go_on() {
    let medium = Medium::random([8, 7, 6], DVec3::ONE, false, 31);
    let light = parallel(DVec3::new(2.0, -1.0, 1.0));
    for mean_cosine in [0.75, -0.5] {
        let SteadyLight { direct, launches } =
            steady(&medium, &[light], Carrying { mean_cosine, directed: true, ..GREY });
        assert_eq!(launches, 2 * (8 + 7 + 6 - 2));
        let fluence = direct.reduced.unwrap().read(device()).unwrap();
        for channel in 0..3 {
            let exact = twin(&medium, channel, 1.0 - mean_cosine).steady(source(&medium, &light));
            let found = shares(&medium, &light, &fluence, channel);
            for (found, exact) in found.into_iter().zip(exact) {
                close("reduced", found, exact, 21.0 * SETTLED * exact);
            }
        }
    }
    let direct = steady(&medium, &[light], Carrying { directed: true, ..GREY }).direct;
    assert!(direct.reduced.is_none() && direct.flow.is_some());
}

#[test]
fn the_flow_is_the_mean_direction_of_the_fluence() {
    let medium = Medium::random([9, 6, 7], DVec3::new(1.0, 1.2, 1.0), false, 41);
    let directed = Carrying { directed: true, ..GREY };
    let lights = [
        parallel(DVec3::new(1.0, 0.0, 0.0)),
        parallel(DVec3::new(-1.0, 2.0, 1.0)),
        point(&medium, DVec3::new(4.5, 3.0, -6.0)),
    ];
    let fluences = lights.map(|light| steady_fluence(&medium, &[light], GREY));
    let mean = |cell: [f32; 4]| (f64::from(cell[0]) + f64::from(cell[1]) + f64::from(cell[2])) / 3.0;
    let direct = steady(&medium, &lights, directed).direct;
    let flow = direct.flow.unwrap().read(device()).unwrap();
    for (i, found) in flow.iter().enumerate() {
        let (mut flux, mut fluence) = (DVec3::ZERO, 0.0);
        for (light, cells) in lights.iter().zip(&fluences) {
            let u = match source(&medium, light) {
                Source::Parallel(u) => u,
                Source::Point(p) => (medium.centre(i) - p).normalize(),
            };
            flux += u * mean(cells[i]);
            fluence += mean(cells[i]);
        }
        let found = DVec3::new(found[0].into(), found[1].into(), found[2].into());
        // What is divided by is 1 + 10⁻⁶ of the fluence.
        close("flow", (found - flux / fluence).length(), 0.0, 2e-6 + 32.0 * EPS);
        assert!(found.length() <= 1.0, "{found}");
    }
}
