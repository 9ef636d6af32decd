//! Scattered light where it could go wrong: vacuum, extreme contrast, thin boxes, coarse grids, no light, wrong input.

mod common;
#[path = "common/irradiance.rs"]
mod irradiance;

use common::{EPS, close, largest, noise, report, rms};
use glam::DVec3;
use irradiance::{Lit, MIRROR};
use std::ops::ControlFlow;
use svetlo::Error;
use svetlo::device::Buffer;
use svetlo::diffusion::Method;
use svetlo::irradiance::{DirectLight, Limiter};

/// Bumps with empty space between, between 0 and 1.
fn cloud(p: DVec3) -> f64 {
    let waves = (7.0 * p.x + 1.0).sin() * (6.0 * p.y).sin() * (8.0 * p.z + 2.0).sin();
    (1.1 * (0.5 + 0.5 * waves - 0.45)).clamp(0.0, 1.0)
}

fn cube(cells: usize, sigma_max: f64, more: &str, extinction: impl FnMut(DVec3) -> f64) -> Lit {
    Lit::new([cells; 3], DVec3::splat(1.0 / cells as f64), sigma_max, more, extinction)
}

#[test]
fn light_in_vacuum_flows_no_faster_than_it_can() {
    let gap = |p: DVec3| if (p.z - 0.5).abs() > 0.2 { 20.0 } else { 0.0 };
    for limiter in Limiter::ALL {
        let scenes =
            [cube(12, 20.0, "albedo = 0.99", gap), cube(14, 40.0, "albedo = 0.9", |p| 40.0 * cloud(p))];
        for (mut lit, name) in scenes.into_iter().zip(["gap", "cloud"]) {
            lit.settings.limiter = limiter;
            let facts = lit.solve(|p| [(-p.z).exp(); 3]).channels[0];
            println!("{name}, {limiter:?}: {facts:?}");
            assert!(facts.floor_cells > 0 && facts.imbalance <= 1e-5 && facts.residual <= 1e-6);
            match limiter {
                Limiter::None => assert!(facts.largest_flux > 1.05 && facts.outer == 0),
                // What the nonlinear residual leaves, and what is made of it.
                _ => {
                    assert!(facts.solved_flux < 1.01 && facts.nonlinear <= 1e-2, "{facts:?}");
                    assert!(facts.largest_flux <= 1.0, "{facts:?}");
                }
            }
        }
    }
}

#[test]
fn power_is_absorbed_between_mirrors_whatever_limits_the_flux() {
    let values = noise(16 * 12 * 8, 31);
    for (coarsening, limiter) in
        [(1, Limiter::None), (1, Limiter::LevermorePomraning), (2, Limiter::Sum), (4, Limiter::Kershaw)]
    {
        // Scattering differs from cell to cell, absorption does not: power is the mean fluence then. Each channel's
        // extinction is the sum of both.
        let mut voxels = values.iter();
        let mut lit = Lit::new([16, 12, 8], DVec3::new(0.1, 0.2, 0.1), 1.0, "albedo = 0.5", |_| {
            10.0_f64.powf(2.0 * voxels.next().unwrap() - 2.0)
        });
        lit.settings.reflection = [MIRROR; 3];
        lit.settings.limiter = limiter;
        lit.coarsening = [coarsening; 2];
        let light = |p: DVec3| p.x * p.z + 0.1;
        let found = lit.solve(|p| [light(p); 3]);
        let (twin, source) = lit.twin(0.5, 0.0, 1.0, light);
        let absorbed: f64 = found.grey().iter().zip(&twin.absorption).map(|(phi, sigma)| phi * sigma).sum();
        let power: f64 = source.iter().sum();
        report("balance", (absorbed / power - 1.0).abs(), 1e-5);
        close("balance", absorbed / power, 1.0, 1e-5);
    }
}

#[test]
fn without_absorption_a_slab_is_a_parabola_and_without_scattering_dark() {
    let white = Lit::slab(24, 30.0, "albedo = 1", |_| 30.0);
    let (q, d, h) = (30.0, 1.0 / 90.0, 1.0 / 24.0);
    for (i, phi) in white.solve(|_| [1.0; 3]).grey().into_iter().enumerate() {
        let z = (i as f64 + 0.5) * h;
        // QH + Qz(H − z)/2D, and the scheme's Qh²/8D more.
        let exact = q + q * z * (1.0 - z) / (2.0 * d) + q * h * h / (8.0 * d);
        // A residual of 10⁻⁶ of the power is carried by at most half the slab's resistance.
        close("parabola", phi, exact, 1e-6 * q * 24_f64.sqrt() * (1.0 + 0.25 / d) + 32.0 * EPS * exact);
    }
    for limiter in [Limiter::None, Limiter::LevermorePomraning] {
        for (sigma, more) in [(3.0, "albedo = 0"), (0.0, "albedo = 0.9")] {
            let mut lit = cube(9, 3.0, more, |_| sigma);
            lit.settings.limiter = limiter;
            let direct = DirectLight { flow: Some(lit.upload(|_| [0.0; 3])), ..lit.direct(|_| [1.0; 3]) };
            let found = lit.solve_for(&direct);
            assert!(found.fluence.iter().flatten().all(|&phi| phi == 0.0));
            assert!(found.drift.unwrap().iter().all(|&drift| drift == DVec3::ZERO));
            assert!(found.channels.iter().all(|facts| facts.iterations == 0 && facts.largest_flux == 0.0));
        }
    }
}

#[test]
fn boxes_one_voxel_thick_and_stretched_voxels_are_solved() {
    for (dims, spacing) in [
        ([1, 9, 8], DVec3::ONE),
        ([9, 1, 8], DVec3::new(1.0, 0.3, 2.0)),
        ([8, 9, 1], DVec3::new(0.01, 0.03, 1.0)),
        ([30, 1, 1], DVec3::new(1e-3, 1.0, 1.0)),
        ([5, 6, 7], DVec3::new(1.0, 30.0, 900.0)),
    ] {
        let values = noise(dims.iter().product(), 8);
        let mut voxels = values.iter();
        let sigma = 1.0 / spacing.min_element();
        let mut lit = Lit::new(dims, spacing, sigma, "albedo = 0.9", |_| sigma * voxels.next().unwrap());
        let plain = lit.solve(|p| [1.0 + p.x; 3]).grey();
        let (twin, source) = lit.twin(0.9, 0.0, sigma, |p| 1.0 + p.x);
        let exact = twin.solve(&source);
        let bound = largest(twin.solve(&vec![1.0; source.len()]))
            * 1e-6
            * rms(source.iter().copied())
            * (source.len() as f64).sqrt();
        for (found, exact) in plain.iter().zip(&exact) {
            close(&format!("{dims:?}"), *found, *exact, bound + 64.0 * EPS * exact);
        }
        lit.settings.limiter = Limiter::LevermorePomraning;
        for coarsening in [1, 2, 4] {
            lit.coarsening = [coarsening, 1];
            assert!(lit.solve(|p| [1.0 + p.x; 3]).channels[0].largest_flux < 1.01);
        }
    }
    let single = Lit::new([1, 1, 1], DVec3::new(2.0, 1.0, 3.0), 0.5, "albedo = 0.5", |_| 0.5);
    // Power 1.5, absorbed by 0.25 per volume of 6, and six sides of A / (2 + h/2D).
    let sides = |area: f64, h: f64| 2.0 * area / (2.0 + 0.75 * h);
    let leaving = 1.5 + sides(3.0, 2.0) + sides(6.0, 1.0) + sides(2.0, 3.0);
    close("one voxel", single.solve(|_| [1.0; 3]).grey()[0], 1.5 / leaving, 1e-6);
}

#[test]
fn contrast_of_a_million_is_solved() {
    let checks = |p: DVec3| (p.x * 4.0).floor() + (p.y * 4.0).floor() + (p.z * 4.0).floor();
    for limiter in [Limiter::None, Limiter::LevermorePomraning] {
        for albedo in ["0.5", "1"] {
            let mut lit =
                cube(
                    16,
                    1e3,
                    &format!("albedo = {albedo}"),
                    |p| {
                        if checks(p) % 2.0 == 0.0 { 1e3 } else { 1e-3 }
                    },
                );
            lit.settings.limiter = limiter;
            let facts = lit.solve(|p| [(-p.z).exp(); 3]).channels[0];
            println!("{limiter:?}, {albedo}: {facts:?}");
            assert!(facts.imbalance <= 1e-5);
            assert!(limiter == Limiter::None || facts.largest_flux < 1.01);
        }
    }
}

#[test]
fn coarse_grids_lose_as_the_square_of_their_cells() {
    let (cells, albedo) = (32, 0.95);
    let waves = |p: DVec3| 10.0 + 8.0 * (6.0 * p.x).sin() * (5.0 * p.y).cos() * (4.0 * p.z).sin();
    let mut lit = cube(cells, 20.0, &format!("albedo = {albedo}"), waves);
    let [fine, half, quarter] = [1, 2, 4].map(|m| {
        lit.coarsening = [m, 1];
        lit.solve(|p| [(-4.0 * p.z).exp(); 3]).grey()
    });
    let [half, quarter] =
        [half, quarter].map(|phi| rms(phi.iter().zip(&fine).map(|(a, b)| a - b)) / rms(fine.iter().copied()));
    // (mhσ_eff)² for the mean extinction, where the solution bends as σ_eff².
    let square = |m: f64| (m / cells as f64).powi(2) * 3.0 * (1.0 - albedo) * 100.0;
    println!("{half:.4} of {:.4}, {quarter:.4} of {:.4}", square(2.0), square(4.0));
    assert!(half < 0.25 * square(2.0) && quarter < 0.25 * square(4.0));
    assert!((1.5..2.2).contains(&(quarter / half).log2()), "{half} {quarter}");
    // Odd dimensions: cells are no whole voxels.
    let mut odd = Lit::new([19, 23, 17], DVec3::new(0.05, 0.04, 0.06), 20.0, "albedo = 0.9", waves);
    let [fine, half, quarter] = [1, 2, 4].map(|m| {
        odd.coarsening = [m, 1];
        odd.solve(|p| [(-4.0 * p.z).exp(); 3]).grey()
    });
    let error = |phi: &[f64]| rms(phi.iter().zip(&fine).map(|(a, b)| a - b)) / rms(fine.iter().copied());
    let [half, quarter] = [error(&half), error(&quarter)];
    let square = |m: f64| (m * 0.05).powi(2) * 3.0 * 0.1 * 100.0;
    println!("odd: {half:.4} of {:.4}, {quarter:.4} of {:.4}", square(2.0), square(4.0));
    assert!(half < 0.25 * square(2.0) && quarter < 0.25 * square(4.0));
}

#[test]
fn colours_are_solves_of_their_own() {
    let values = noise(7 * 8 * 9, 5);
    let solve = |more: &str, light: [f64; 3]| {
        let mut voxels = values.iter();
        let mut lit = Lit::new([7, 8, 9], DVec3::ONE, 2.0, more, |_| 2.0 * voxels.next().unwrap());
        lit.settings.limiter = Limiter::LevermorePomraning;
        lit.settings.nonlinear = 1e-5;
        lit.solve(|p| light.map(|l| l * (-0.2 * p.z).exp()))
    };
    let coloured = solve("albedo = [0.5, 0.9, 0.99]\nextinction_color = [1, 0.5, 0.25]", [1.0, 2.0, 0.5]);
    assert_eq!(coloured.channels.len(), 3);
    for (c, (albedo, factor, light)) in
        [(0.5, 1.0, 1.0), (0.9, 0.5, 2.0), (0.99, 0.25, 0.5)].into_iter().enumerate()
    {
        let grey = solve(
            &format!("albedo = {albedo}\nextinction_color = [{factor}, {factor}, {factor}]"),
            [light; 3],
        );
        for (coloured, grey) in coloured.fluence.iter().zip(&grey.fluence) {
            // The tables are scaled by the largest channel: roundings of the coefficients, amplified by the solve of
            // 10⁻⁶ and the limiter's end at 10⁻⁵.
            close("colour", coloured[c], grey[c], 1e-4 * grey[c]);
        }
    }
}

#[test]
fn similarity_reduces_anisotropic_scattering() {
    // σ_s (1 − g) and the light attenuated by σ_tr, of albedo σ_s (1 − g) / σ_tr.
    let solve = |sigma: f64, more: &str, reduced: bool| {
        let lit = cube(10, sigma, more, |p| sigma * (0.2 + 0.8 * p.x));
        let light = |p: DVec3| [(-p.z).exp(); 3];
        let wrong = lit.upload(|_| [7.0; 3]);
        let direct =
            DirectLight { fluence: wrong, reduced: Some(lit.upload(light)), flow: None, extent: None };
        if reduced { lit.solve_for(&direct) } else { lit.solve(light) }.grey()
    };
    // 0.9 of 10, of which 2/3 count with g = 1/3: 1 absorbed, 6 scattered.
    let whole =
        solve(10.0, "albedo = 0.9\n[phase]\nkind = \"henyey-greenstein\"\ng = 0.3333333333333333", true);
    let isotropic = solve(7.0, &format!("albedo = {}", 6.0 / 7.0), false);
    for (a, b) in whole.into_iter().zip(isotropic) {
        close("similar", a, b, 4e-6 * 32.0 * b.max(0.1));
    }
}

#[test]
fn drift_is_flux_over_fluence_of_what_is_not_scattered_once() {
    let forward = "albedo = 1\n[phase]\nkind = \"henyey-greenstein\"\ng = 0.5";
    // Nothing but the difference to reduced light: it goes as light does, at any length of flow.
    let black = cube(4, 1.0, &forward.replace('1', "0"), |_| 1.0);
    let along = DVec3::new(0.6, 0.0, -0.5);
    let direct = |lit: &Lit, more: f64| DirectLight {
        reduced: Some(lit.upload(|_| [1.0 + more; 3])),
        flow: Some(lit.upload(|_| along.to_array())),
        ..lit.direct(|_| [1.0; 3])
    };
    for drift in black.solve_for(&direct(&black, 2.0)).drift.unwrap() {
        assert!((drift - along).length() < 8.0 * EPS, "{drift}");
    }
    // Uniformly lit slab without absorption: F = Q (z − ½), φ as in the parabola; both linear in the light.
    let mut slab = Lit::slab(20, 30.0, forward, |_| 30.0);
    slab.settings.tolerance = 1e-7;
    let (h, q, d) = (1.0 / 20.0, 15.0, 1.0 / 45.0);
    let found = slab.solve_for(&direct(&slab, 0.0));
    for (i, drift) in found.drift.unwrap().into_iter().enumerate() {
        let z = (i as f64 + 0.5) * h;
        let phi = q + q * z * (1.0 - z) / (2.0 * d) + q * h * h / (8.0 * d);
        // Each cell's power is missing or too much by a residual of 10⁻⁷.
        let exact = DVec3::new(0.0, 0.0, q * (z - 0.5) / phi);
        assert!((drift - exact).length() < 1e-5, "{z}: {drift} {exact}");
    }
}

#[test]
fn better_direct_light_goes_on_from_the_last_solution() {
    for limiter in [Limiter::None, Limiter::LevermorePomraning] {
        let mut lit = cube(16, 30.0, "albedo = 0.98", |p| 30.0 * cloud(p));
        lit.settings.limiter = limiter;
        let (medium, mut solver) = lit.solver().unwrap();
        let light = |p: DVec3| (-3.0 * p.z).exp();
        let random = noise(4096, 77);
        let mut noisy = random.iter();
        let first = lit.direct(|p| [light(p) * (0.95 + 0.1 * noisy.next().unwrap()); 3]);
        let second = lit.direct(|p| [light(p); 3]);
        let mut solve = |direct| {
            let light =
                solver.solve(&lit.device, &medium, direct, &mut |_| ControlFlow::Continue(())).unwrap();
            lit.read(&light)
        };
        let before = solve(&first).channels[0];
        let after = solve(&second);
        let afresh = lit.solve_for(&second);
        println!("{before:?}\n{:?}\n{:?}", after.channels[0], afresh.channels[0]);
        assert!(after.channels[0].iterations < afresh.channels[0].iterations);
        let scale = rms(afresh.grey());
        let apart = rms(after.grey().iter().zip(afresh.grey()).map(|(a, b)| a - b)) / scale;
        // Within what the tolerance allows, and with a limiter, what its end at 10⁻² does.
        let bound = if limiter == Limiter::None { 1e-5 } else { 2e-3 };
        report("apart", apart, bound);
        assert!(apart < bound);
    }
}

#[test]
fn observers_see_every_stage_and_can_end_it() {
    let mut lit = cube(10, 30.0, "albedo = [0.5, 0.9, 0.99]", |p| 30.0 * cloud(p));
    lit.settings.limiter = Limiter::Sum;
    let direct = lit.direct(|_| [1.0; 3]);
    let mut seen = Vec::new();
    lit.try_solve(&direct, &mut |progress| {
        seen.push((progress.channel, progress.outer));
        ControlFlow::Continue(())
    })
    .unwrap();
    assert!((0..3).all(|c| seen.contains(&([c, 3], 0)) && seen.contains(&([c, 3], 2))));
    assert!(seen.is_sorted_by_key(|([channel, _], outer)| (*channel, *outer)));
    for method in [Method::Explicit, Method::OverRelaxation { factor: None }, Method::Multigrid] {
        lit.settings.method = method;
        let mut looks = 0;
        let ended = lit.try_solve(&direct, &mut |_| {
            looks += 1;
            if looks == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert!(matches!(ended, Err(Error::Interrupted)) && looks == 3);
    }
}

#[test]
fn light_of_any_unit_is_scattered_alike() {
    let mut lit =
        cube(8, 20.0, "albedo = 0.9\n[phase]\nkind = \"henyey-greenstein\"\ng = 0.5", |p| 20.0 * cloud(p));
    lit.settings.limiter = Limiter::LevermorePomraning;
    let solve = |unit: f64| {
        let light = |p: DVec3| [unit * p.x; 3];
        let direct = DirectLight {
            reduced: Some(lit.upload(light)),
            flow: Some(lit.upload(|_| [0.0, 0.0, 1.0])),
            ..lit.direct(light)
        };
        lit.solve_for(&direct)
    };
    let usual = solve(1.0);
    // Powers of two: the same bits.
    for unit in [66, -63].map(|exponent| 2.0_f64.powi(exponent)) {
        let found = solve(unit);
        assert_eq!(found.channels, usual.channels);
        for (found, usual) in found.grey().into_iter().zip(usual.grey()) {
            assert_eq!(found, unit * usual);
        }
        assert_eq!(found.drift, usual.drift);
    }
}

#[test]
fn fine_tolerances_of_the_limiter_are_reached() {
    let mut lit = cube(10, 20.0, "albedo = 0.9", |p| 20.0 * cloud(p));
    lit.settings.limiter = Limiter::LevermorePomraning;
    lit.settings.tolerance = 1e-5;
    lit.settings.nonlinear = 1e-5;
    let facts = lit.solve(|p| [p.x; 3]).channels[0];
    assert!(facts.nonlinear <= 1e-5 && facts.solved_flux <= 1.0 + 1e-5, "{facts:?}");
}

#[test]
fn sources_are_where_light_is_scattered_in_thick_cells() {
    // A slab of cells of 10 mean free paths, all of whose power is scattered at the depth t from the surface: without
    // absorption, fluence in the depth is that of the way out, Q (2 + 3 sigma t) by Marshak's condition.
    let (cells, sigma) = (8, 80.0);
    let mut slab = Lit::slab(cells, sigma, "albedo = 1", |_| sigma);
    slab.settings.tolerance = 1e-7;
    let h = 1.0 / cells as f64;
    for depth in [0.0, 0.02, 0.05, 0.0625] {
        let light = |p: DVec3| if p.z < h { [1.0; 3] } else { [0.0; 3] };
        let place = depth / (0.5 * h) - 1.0;
        let first = slab.grid().dims[0] * slab.grid().dims[1];
        let extent: Vec<[f32; 4]> = (0..slab.grid().cells())
            .map(|i| [0.0, 0.0, if i < first { place as f32 } else { 0.0 }, 1.0])
            .collect();
        let direct = DirectLight {
            extent: Some(Buffer::from_slice(&slab.device, &extent).unwrap()),
            ..slab.direct(light)
        };
        let found = slab.solve_for(&direct).grey();
        // Through the whole slab the fluence falls in a straight line, from the source on.
        let power = sigma * h;
        let whole = 4.0 + 3.0 * sigma;
        for (i, phi) in found.into_iter().enumerate() {
            let z = (i as f64 + 0.5) * h;
            let [near, far] = [z.min(depth), z.max(depth)];
            let exact = power * (2.0 + 3.0 * sigma * near) * (2.0 + 3.0 * sigma * (1.0 - far)) / whole;
            close(&format!("depth {depth}, cell {i}"), phi, exact, 1e-5 * power * whole / 4.0);
        }
    }
}

#[test]
fn every_method_finds_the_same() {
    let mut lit = cube(8, 20.0, "albedo = 0.9", |p| 20.0 * cloud(p));
    lit.settings.limiter = Limiter::LevermorePomraning;
    let exact = lit.solve(|p| [p.x; 3]).grey();
    for method in [Method::Explicit, Method::OverRelaxation { factor: None }, Method::ConjugateGradients] {
        lit.settings.method = method;
        let found = lit.solve(|p| [p.x; 3]).grey();
        let apart = rms(found.iter().zip(&exact).map(|(a, b)| a - b)) / rms(exact.iter().copied());
        report(&format!("{method:?}"), apart, 2e-3);
        assert!(apart < 2e-3);
    }
}

#[test]
fn what_makes_no_sense_is_refused_with_the_reason() {
    let good = || cube(3, 1.0, "albedo = 0.9", |_| 1.0);
    let refused = |lit: &Lit, direct: &DirectLight, text: &str| match lit
        .try_solve(direct, &mut |_| ControlFlow::Continue(()))
        .map(drop)
    {
        Err(error) => assert!(error.to_string().contains(text), "{error}"),
        Ok(()) => panic!("not refused: {text}"),
    };
    let with = |change: fn(&mut Lit), text: &str| {
        let mut lit = good();
        let direct = lit.direct(|_| [1.0; 3]);
        change(&mut lit);
        refused(&lit, &direct, text);
    };
    with(|lit| lit.settings.tolerance = 0.0, "tolerance 0");
    with(|lit| lit.settings.floor = -1.0, "floor -1");
    with(|lit| lit.settings.reflection[1] = -1.0, "boundary factors");
    with(|lit| lit.coarsening[1] = 3, "direct light has 27 cells, its grid 1");
    let lit = good();
    refused(&lit, &lit.direct(|p| [if p.x < 0.4 { f64::NAN } else { 1.0 }; 3]), "the source of ");
    let mut closed = cube(3, 1.0, "albedo = 1", |_| 1.0);
    closed.settings.reflection = [MIRROR; 3];
    refused(&closed, &closed.direct(|_| [1.0; 3]), "nothing is absorbed and all sides are mirrors");
}
