//! Upwind convection at its limits: stability, dense media, lights in the box, no light, what is refused and announced.

#[path = "common/cells.rs"]
mod cells;
mod common;
#[path = "common/convection.rs"]
mod convection;

use cells::Medium;
use common::{close, largest, scene};
use convection::*;
use glam::DVec3;
use svetlo::irradiance::{
    Carrying, Convection, SteadyLight, check_courant, largest_courant, refusal, steady_memory, unlit_by,
};
use svetlo::reference::convection::Source;
use svetlo::scene::Light;

#[test]
fn shares_stay_between_0_and_1_up_to_the_largest_courant_number() {
    const STEPS: u32 = 40;
    for (dims, cell) in boxes() {
        let medium = Medium::random(dims, cell, false, 5);
        let twin = twin(&medium, 0, 1.0);
        for light in lights(&medium) {
            let courant = largest_courant(&[light], &medium.grid, &medium.local);
            let fluence = explicit(&medium, &[light], GREY, courant, STEPS);
            let place = source(&medium, &light);
            let mut exact = twin.begin(place);
            for _ in 0..STEPS {
                exact = twin.step(place, &exact, courant * medium.grid.cell.min_element());
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
    assert!(message.contains("`method.courant` = 0 must be above 0"), "{message}");
    assert!(check_courant(f64::NAN, &[], &medium.grid, &medium.local).is_err());
}

#[test]
fn cells_near_a_point_light_in_the_box_take_no_more_than_it_sends() {
    let (dims, sigma) = ([9, 9, 9], 50.0);
    let medium = Medium::grey(dims, DVec3::ONE, |_| [0.0, sigma]);
    let light = point(&medium, DVec3::splat(4.5));
    let courant = largest_courant(&[light], &medium.grid, &medium.local);
    for fluence in [steady_fluence(&medium, &[light], GREY), explicit(&medium, &[light], GREY, courant, 40)] {
        let sum: f64 = fluence.iter().map(|f| sigma * f64::from(f[0])).sum();
        let found = sum * medium.local.unit.powi(2) / (4.0 * std::f64::consts::PI);
        // All of it is taken in the light's own cell, by 432 lines of different lengths.
        assert!((found - 1.0).abs() < 1e-3, "{found}");
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
