//! Upwind convection of direct light against closed forms and against its twin in double precision.

#[path = "common/cells.rs"]
mod cells;
mod common;

use cells::Medium;
use common::{EPS, close, largest, log_slope, scene};
use glam::DVec3;
use svetlo::device::Device;
use svetlo::irradiance::{
    Carrying, Convection, SteadyLight, check_courant, crossing_steps, largest_courant, refusal, steady_light,
    steady_memory, unlit_by,
};
use svetlo::reference::convection::{Convection as Twin, Source};
use svetlo::scene::Light;

const GREY: Carrying = Carrying { chromatic: false, mean_cosine: 0.0, directed: false };
const CHROMATIC: Carrying = Carrying { chromatic: true, ..GREY };

/// Roundings of a steady cell, relative: each rate has those of the direction (offset, squares, root, quotient, the last
/// two up to 3 ulps), sums and the quotient of both add theirs.
const SETTLED: f64 = 54.0 * EPS;
/// Roundings of an explicit step, in units of the largest share, 1: rates (20), differences and sums (9), exp (3 ulps and
/// its argument), the product.
const STEPPED: f64 = 40.0 * EPS;
/// What light has not crossed the box by then.
const CROSSED: f64 = 3.36e-4; // e^-8

fn parallel(direction: DVec3) -> Light {
    Light::Directional { direction: direction.normalize(), irradiance: [1.0, 2.0, 0.5] }
}

fn point(medium: &Medium, local: DVec3) -> Light {
    Light::Point { position: medium.point(local), intensity: [1.0, 2.0, 0.5] }
}

fn source(medium: &Medium, light: &Light) -> Source {
    match *light {
        Light::Directional { direction, .. } => Source::Parallel(direction),
        Light::Point { position, .. } => Source::Point(medium.local.point(position)),
        Light::Rectangle { .. } => unreachable!("no rectangles here"),
    }
}

/// The device, opened once by each test's thread.
fn device() -> &'static Device {
    thread_local!(static DEVICE: &'static Device = Box::leak(Box::new(common::device())));
    DEVICE.with(|device| *device)
}

fn steady(medium: &Medium, lights: &[Light], carrying: Carrying) -> SteadyLight {
    let device = device();
    steady_light(device, &medium.grid, &medium.cells(device), lights, &medium.local, carrying).unwrap()
}

fn steady_fluence(medium: &Medium, lights: &[Light], carrying: Carrying) -> Vec<[f32; 4]> {
    steady(medium, lights, carrying).direct.fluence.read(device()).unwrap()
}

fn explicit(
    medium: &Medium,
    lights: &[Light],
    carrying: Carrying,
    courant: f64,
    steps: u32,
) -> Vec<[f32; 4]> {
    let device = device();
    let cells = medium.cells(device);
    let mut convection =
        Convection::new(device, &medium.grid, &cells, lights, &medium.local, carrying, courant).unwrap();
    // In two parts, with a look in between: the same steps.
    convection.advance(device, steps / 3).unwrap();
    convection.direct(device).unwrap();
    convection.advance(device, steps - steps / 3).unwrap();
    assert_eq!(convection.steps(), u64::from(steps));
    convection.direct(device).unwrap().fluence.read(device).unwrap()
}

/// The fluence that a light of full share would bring, per channel: E, or I/r² beyond the cell's own mean.
fn unattenuated(medium: &Medium, light: &Light, i: usize) -> [f64; 3] {
    match *light {
        Light::Directional { irradiance, .. } => irradiance,
        Light::Point { position, intensity } => {
            let volume = medium.grid.cell.element_product();
            let ball = (0.75 * volume / std::f64::consts::PI).cbrt();
            let r2 =
                (medium.centre(i) - medium.local.point(position)).length_squared().max(ball * ball / 3.0);
            intensity.map(|intensity| intensity / (r2 * medium.local.unit.powi(2)))
        }
        Light::Rectangle { .. } => unreachable!("no rectangles here"),
    }
}

/// Shares of one channel.
fn shares(medium: &Medium, light: &Light, fluence: &[[f32; 4]], channel: usize) -> Vec<f64> {
    let share = |(i, f): (usize, &[f32; 4])| f64::from(f[channel]) / unattenuated(medium, light, i)[channel];
    fluence.iter().enumerate().map(share).collect()
}

fn twin(medium: &Medium, channel: usize, counted: f64) -> Twin {
    let grid = &medium.grid;
    Twin { dims: grid.dims, cell: grid.cell, extinction: medium.extinction(channel, counted) }
}

/// Boxes with odd sizes, unlike edges, and one cell thick.
fn boxes() -> [([usize; 3], DVec3); 5] {
    [
        ([7, 9, 5], DVec3::ONE),
        ([12, 5, 11], DVec3::new(1.0, 1.3, 1.7)),
        ([1, 13, 8], DVec3::new(2.0, 1.0, 1.5)),
        ([19, 1, 1], DVec3::ONE),
        ([1, 1, 1], DVec3::new(1.0, 3.0, 1.2)),
    ]
}

/// Lights from everywhere: along axes, oblique, points near, far, level with the box, in it and in its corner.
fn lights(medium: &Medium) -> Vec<Light> {
    let size = medium.grid.cell * DVec3::from_array(medium.grid.dims.map(|n| n as f64));
    let at = |x: f64, y: f64, z: f64| point(medium, (size * DVec3::new(x, y, z) * 8.0).round() / 8.0);
    vec![
        parallel(DVec3::NEG_Y),
        parallel(DVec3::new(0.0, 0.6, -0.8)),
        parallel(DVec3::new(-1.0, 2.0, 3.0)),
        at(0.5, 0.5, 0.5),
        at(0.2, 0.9, 0.4),
        at(0.0, 0.0, 0.0),
        at(0.3, 0.6, 1.4),
        at(-2.0, 0.4, -1.0),
        at(40.0, -30.0, 50.0),
    ]
}

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
                    let mut exact = vec![0.0; medium.grid.cells()];
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
fn shares_stay_between_0_and_1_up_to_the_largest_courant_number() {
    const STEPS: u32 = 40;
    for (dims, cell) in boxes() {
        let medium = Medium::random(dims, cell, false, 5);
        let twin = twin(&medium, 0, 1.0);
        for light in lights(&medium) {
            let courant = largest_courant(&[light], &medium.grid, &medium.local);
            let fluence = explicit(&medium, &[light], GREY, courant, STEPS);
            let mut exact = vec![0.0; medium.grid.cells()];
            for _ in 0..STEPS {
                exact = twin.step(source(&medium, &light), &exact, courant * medium.grid.cell.min_element());
            }
            for (share, exact) in shares(&medium, &light, &fluence, 0).into_iter().zip(exact) {
                // The twin's own rounding aside.
                assert!((-1e-12..=1.0 + 1e-12).contains(&exact), "{dims:?} {light:?}: {exact}");
                assert!(share >= 0.0, "{dims:?} {light:?}: {share}");
                close("share", share, exact, f64::from(STEPS + 1) * STEPPED);
            }
            let above = check_courant(courant * 1.001, &[light], &medium.grid, &medium.local).unwrap_err();
            assert_eq!(above.exit_code(), 2);
            let shown = (courant * 1e4).floor() / 1e4;
            let said = format!("with this volume and these lights it must be at most {shown:.4}");
            assert!(above.to_string().ends_with(&said), "{above}");
            check_courant(shown, &[light], &medium.grid, &medium.local).unwrap();
        }
    }
}

#[test]
fn the_largest_courant_number_is_that_of_the_fastest_direction() {
    for (dims, cell) in boxes() {
        let medium = Medium::grey(dims, cell, |_| [0.0; 2]);
        let twin = twin(&medium, 0, 1.0);
        for light in lights(&medium) {
            let unit = medium.grid.cell.min_element();
            let found = 1.0 / (unit * largest_courant(&[light], &medium.grid, &medium.local));
            let rates = (0..medium.grid.cells()).map(|i| twin.rate(source(&medium, &light), i));
            let fastest = largest(rates);
            assert!(fastest <= found * (1.0 + 1e-12), "{dims:?} {light:?}: {fastest} above {found}");
            let Source::Point(p) = source(&medium, &light) else {
                close("parallel light", fastest, found, 1e-12 * found);
                continue;
            };
            // By looking at a lattice over what |r| can be, 0 where cells are level with the light.
            let size = medium.grid.cell * DVec3::from_array(dims.map(|n| n as f64));
            let [first, last] = [0.5 * medium.grid.cell - p, size - 0.5 * medium.grid.cell - p];
            let most = first.abs().max(last.abs());
            let outside = p.cmplt(DVec3::ZERO) | p.cmpge(size);
            let least = DVec3::select(outside, first.abs().min(last.abs()), DVec3::ZERO);
            const LATTICE: usize = 61;
            let at = |k: usize| {
                let [x, y, z] = [k % LATTICE, k / LATTICE % LATTICE, k / LATTICE / LATTICE];
                // Denser where r is small and directions change fast.
                (DVec3::new(x as f64, y as f64, z as f64) / (LATTICE - 1) as f64).powf(2.0)
            };
            let rate = |r: DVec3| {
                if r == DVec3::ZERO { 0.0 } else { (r.normalize() / medium.grid.cell).element_sum() }
            };
            let seen = largest((0..LATTICE.pow(3)).map(|k| rate(least + at(k) * (most - least))));
            // Directions of the lattice are closer than 1/10 to each other; the rate falls with half the angle's square.
            let message = format!("{dims:?} {light:?}: {seen} {found}");
            assert!(seen <= found * (1.0 + 1e-12) && seen >= found * 0.995, "{message}");
        }
    }
    let medium = Medium::grey([2, 2, 2], DVec3::ONE, |_| [0.0; 2]);
    let message = check_courant(0.0, &[], &medium.grid, &medium.local).unwrap_err().to_string();
    assert!(message.contains("`courant` = 0 must be above 0"), "{message}");
    assert!(check_courant(f64::NAN, &[], &medium.grid, &medium.local).is_err());
}

#[test]
fn a_point_light_in_a_vacuum_falls_with_the_squared_distance() {
    let medium = Medium::grey([11, 8, 9], DVec3::new(1.0, 1.25, 1.0), |_| [0.0; 2]);
    for place in [DVec3::new(5.5, 5.0, 4.5), DVec3::new(2.3, 7.1, 6.6), DVec3::new(-7.0, 20.0, 3.0)] {
        let light = point(&medium, place);
        let fluence = steady_fluence(&medium, &[light], GREY);
        for (i, found) in fluence.iter().enumerate() {
            let r2 = (medium.centre(i) - place).length_squared() * medium.local.unit.powi(2);
            if r2 < 4.0 * medium.local.unit.powi(2) {
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
fn a_point_lights_own_cell_has_the_mean_over_a_ball_of_its_volume() {
    let medium = Medium::grey([5, 5, 5], DVec3::ONE, |_| [0.0, 1e3]);
    let light = point(&medium, DVec3::splat(2.5));
    let found = steady_fluence(&medium, &[light], GREY)[62];
    // 3 / R² with 4π/3 R³ = 1, per local unit squared.
    let exact = 3.0 * (4.0 * std::f64::consts::PI / 3.0_f64).powf(2.0 / 3.0) / medium.local.unit.powi(2);
    close("own cell", f64::from(found[0]), exact, 16.0 * EPS * exact);
}

#[test]
fn cells_near_a_point_light_in_the_box_keep_its_light_however_dense_the_medium() {
    let medium = Medium::grey([9, 9, 9], DVec3::ONE, |_| [0.0, 50.0]);
    let light = point(&medium, DVec3::splat(4.5));
    let courant = largest_courant(&[light], &medium.grid, &medium.local);
    let forms = [steady_fluence(&medium, &[light], GREY), explicit(&medium, &[light], GREY, courant, 40)];
    for fluence in forms {
        for (i, share) in shares(&medium, &light, &fluence, 1).into_iter().enumerate() {
            let cells = (medium.centre(i) - 4.5).length_squared();
            if cells <= 4.0 {
                close("held", share, 1.0, 16.0 * EPS);
            } else {
                assert!(share < 1.0 / 20.0, "{share} at {cells}");
            }
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
fn no_light_and_black_lights_leave_darkness() {
    let medium = Medium::grey([3, 4, 5], DVec3::ONE, |_| [1.0, 1.0]);
    let black = Light::Directional { direction: DVec3::X, irradiance: [0.0; 3] };
    let directed = Carrying { mean_cosine: 0.5, directed: true, ..GREY };
    for lights in [&[][..], &[black]] {
        let SteadyLight { direct, launches } = steady(&medium, lights, directed);
        assert_eq!(launches, 0);
        for field in [&direct.fluence, direct.reduced.as_ref().unwrap(), direct.flow.as_ref().unwrap()] {
            assert!(field.read(device()).unwrap().iter().all(|cell| *cell == [0.0; 4]));
        }
        assert!(explicit(&medium, lights, GREY, 0.5, 3).iter().all(|cell| *cell == [0.0; 4]));
    }
}

#[test]
fn extinctions_of_twelve_decades_give_numbers() {
    let medium = Medium::grey([9, 9, 9], DVec3::ONE, |i| [0.0, if i % 3 == 0 { 1e6 } else { 1e-6 }]);
    for light in lights(&medium) {
        let courant = largest_courant(&[light], &medium.grid, &medium.local);
        for fluence in
            [steady_fluence(&medium, &[light], GREY), explicit(&medium, &[light], GREY, courant, 30)]
        {
            let shares = shares(&medium, &light, &fluence, 0);
            assert!(shares.iter().all(|share| (0.0..=1.0 + STEPPED).contains(share)), "{light:?}");
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

#[test]
fn a_sweep_launches_once_for_each_level() {
    let medium = Medium::grey([10, 6, 8], DVec3::ONE, |_| [0.0, 0.1]);
    let launches = |light: Light| steady(&medium, &[light], GREY).launches;
    assert_eq!(launches(parallel(DVec3::new(1.0, -2.0, 3.0))), 10 + 6 + 8 - 2);
    // From cell (5, 3, 4), the farthest corner is 5 + 3 + 4 cells away.
    assert_eq!(launches(point(&medium, DVec3::new(5.5, 3.5, 4.5))), 13);
}

#[test]
fn rectangles_are_refused_and_backgrounds_are_spoken_of() {
    let text = "[camera]\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\nfov = 20\n[volume]\n[medium]\nsigma_max = 1\n\
                [method]\nkind = \"single-scattering\"\n\
                [[light]]\nkind = \"point\"\nposition = [0, 0, 2]\nintensity = 1\n";
    let rectangle = "[[light]]\nkind = \"rectangle\"\ncentre = [0, 0, 3]\nedge_u = [1, 0, 0]\nedge_v = [0, 1, 0]\n\
                     radiance = 1\n";
    refusal(&scene(text)).unwrap();
    let error = refusal(&scene(&format!("{text}{rectangle}"))).unwrap_err();
    assert_eq!(error.exit_code(), 2);
    assert_eq!(
        error.to_string(),
        "`light.1` is a rectangle: convection-diffusion carries the light of directional and point lights only; the \
         method hybrid-diffusion takes all kinds"
    );
    assert_eq!(unlit_by(&scene(text).background), None);
    let lit = scene(&format!("{text}[background]\ncolor = [0, 0.5, 0]\n"));
    assert!(unlit_by(&lit.background).unwrap().contains("the background is seen, but lights nothing"));
}

#[test]
fn the_memory_that_is_announced_is_what_is_allocated() {
    let medium = Medium::grey([4, 5, 6], DVec3::ONE, |_| [0.0; 2]);
    let (cells, padded) = (4 * 5 * 6_u64, 6 * 7 * 8_u64);
    // Two shares per light, the extinction, the fluence.
    assert_eq!(Convection::memory(&medium.grid, 3, GREY).total(), 4 * (6 * padded + cells) + 16 * cells);
    assert_eq!(Convection::memory(&medium.grid, 1, CHROMATIC).total(), 16 * (2 * padded + 2 * cells));
    let directed = Carrying { mean_cosine: 0.1, directed: true, ..GREY };
    assert_eq!(steady_memory(&medium.grid, directed).total(), 4 * padded + 16 * padded + 3 * 16 * cells);
}
