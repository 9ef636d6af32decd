//! The diffusion solver where it could go wrong: vacuum, extreme contrast, thin boxes, no light, wrong numbers.

mod common;
#[path = "common/diffusion.rs"]
mod diffusion;

use common::{EPS, close, device, largest, noise, rms};
use diffusion::{MIRROR, Medium, wide};
use glam::DVec3;
use std::ops::ControlFlow;
use svetlo::Error;
use svetlo::device::{Buffer, Device};
use svetlo::diffusion::{Boundary, Coefficients, Method, Observer, Outcome, Settings, Solver};

const MULTIGRID: Method = Method::Multigrid;

#[test]
fn contrast_of_a_million_and_albedo_0_and_1_are_solved() {
    let checks = |p: DVec3| (p.x * 4.0).floor() + (p.y * 4.0).floor() + (p.z * 4.0).floor();
    for albedo in [0.0, 0.5, 1.0] {
        let medium = Medium::new([20, 18, 22], DVec3::splat(0.05), |p| {
            let sigma = if checks(p) % 2.0 == 0.0 { 1e3 } else { 1e-3 };
            [(1.0 - albedo) * sigma, sigma]
        });
        let mut source = vec![0.0; 20 * 18 * 22];
        source[3333] = 1.0;
        source[77] = 1e-6;
        for method in [Method::ConjugateGradients, MULTIGRID] {
            let settings = Settings { floor: 1e-12, ..Settings::new(method) };
            let solved = medium.solve(&source, &settings);
            assert_eq!(solved.outcome.floor_cells, 0);
            let balance = medium.twin().balance(&solved.phi);
            let power = (1.0 + 1e-6) * 0.05_f64.powi(3);
            // What is demanded of the imbalance, and float32 φ.
            close("power", (balance.absorbed + balance.escaped) / power, 1.0, 1e-5 + EPS);
            println!("albedo {albedo} {method:?}: {} iterations", solved.outcome.iterations);
        }
    }
}

#[test]
fn vacuum_is_limited_and_counted() {
    let mut medium = Medium::cube(16, |_| 20.0);
    for (d, p) in medium.diffusivity.iter_mut().zip(Medium::cube(16, |_| 20.0).centres()) {
        if p.z > 0.5 {
            *d = f32::INFINITY;
        }
    }
    let source = vec![1.0; 4096];
    for floor in [1e-2, 0.5] {
        let settings = Settings { floor, ..Settings::new(MULTIGRID) };
        let solved = medium.solve(&source, &settings);
        assert_eq!(solved.outcome.floor_cells, 2048);
        let limit = (1.0 / (3.0 * floor)) as f32;
        let diffusivity = medium.diffusivity.iter().map(|d| d.min(limit)).collect();
        let limited = Medium { diffusivity, ..Medium::cube(16, |_| 20.0) };
        let exact = limited.twin().solve(&wide(&source));
        // Row sums of A⁻¹ are the fluence itself, for this source.
        let bound = (1e-6 * 64.0 + 16.0 * EPS) * largest(exact.iter().copied());
        for (found, exact) in solved.phi.into_iter().zip(exact) {
            close("vacuum", found, exact, bound);
        }
    }
    // Nothing but vacuum: what is emitted flies out.
    let empty = Medium { diffusivity: vec![f32::INFINITY; 4096], absorption: vec![0.0; 4096], ..medium };
    let solved = empty.solve(&source, &Settings::new(MULTIGRID));
    let balance = Medium { diffusivity: vec![1.0 / 0.03; 4096], ..empty }.twin().balance(&solved.phi);
    close("escaped", balance.escaped, 1.0, 1e-5);
}

#[test]
fn boxes_one_cell_thick_and_stretched_cells_are_solved() {
    for (dims, spacing) in [
        ([1, 40, 30], DVec3::ONE),
        ([33, 1, 31], DVec3::new(1.0, 1e-3, 2.0)),
        ([300, 7, 1], DVec3::new(1e-6, 3e-6, 1e-5)),
        ([400, 1, 1], DVec3::splat(1e6)),
        ([2, 2, 2], DVec3::new(1.0, 100.0, 1e4)),
    ] {
        let sigma = 0.5 / spacing.min_element();
        let mut random = noise(dims.iter().product(), 8).into_iter();
        let medium = Medium::new(dims, spacing, |_| [0.02 * sigma, sigma * (0.1 + random.next().unwrap())]);
        let source = vec![1.0; medium.absorption.len()];
        let solved = medium.solve(&source, &Settings::new(MULTIGRID));
        let exact = medium.twin().solve(&wide(&source));
        let bound = (1e-6 * (source.len() as f64).sqrt() + 16.0 * EPS) * largest(exact.iter().copied());
        for (found, exact) in solved.phi.into_iter().zip(exact) {
            close(&format!("{dims:?}"), found, exact, bound);
        }
        println!("{dims:?}: {} iterations", solved.outcome.iterations);
        assert!(solved.outcome.iterations <= 20, "{dims:?}: {}", solved.outcome.iterations);
    }
}

#[test]
fn no_source_gives_darkness_and_a_faint_one_light() {
    let medium = Medium::cube(9, |_| 10.0);
    for method in [Method::Explicit, Method::OverRelaxation { factor: None }, MULTIGRID] {
        let solved = medium.solve(&[0.0; 729], &Settings::new(method));
        assert_eq!((solved.outcome.iterations, solved.outcome.residual), (0, 0.0));
        assert!(solved.phi.iter().all(|&phi| phi == 0.0));
    }
    // Scale: φ is linear in the source, to the last bits.
    let [one, faint] = [1.0, 2.0_f32.powi(-90)].map(|q| {
        medium.solve(&[q; 729], &Settings::new(MULTIGRID)).phi.into_iter().map(move |phi| phi / f64::from(q))
    });
    for (one, faint) in one.zip(faint) {
        close("faint", faint, one, 2.0 * EPS * one);
    }
}

#[test]
fn the_same_solve_gives_the_same_bits_and_a_solver_can_be_used_again() {
    let device = device();
    let medium = Medium::new([13, 12, 11], DVec3::ONE, |p| [0.01 + 0.001 * p.x, 1.0 + p.y]);
    let buffer = |values: &[f32]| Buffer::from_slice(&device, values).unwrap();
    let (absorption, diffusivity) = (buffer(&medium.absorption), buffer(&medium.diffusivity));
    let coefficients = Coefficients { absorption: &absorption, diffusivity: &diffusivity };
    let other = Coefficients { absorption: &diffusivity, diffusivity: &absorption };
    let source = buffer(&vec![1.0; medium.absorption.len()]);
    let mut solver = Solver::new(&device, medium.dims, medium.spacing, Boundary::OPEN).unwrap();
    let settings = Settings::new(MULTIGRID);
    let mut solve = |coefficients| {
        let solution = solver.solve(&device, coefficients, &source, &settings).unwrap();
        (solution.phi.read(&device).unwrap(), solution.outcome.history)
    };
    let first = solve(&coefficients);
    let between = solve(&other);
    let again = solve(&coefficients);
    assert_eq!(first, again);
    assert_ne!(first.0, between.0);
}

#[test]
fn iterations_end_at_their_limit_and_say_so() {
    let medium = Medium::cube(16, |_| 5.0);
    let source = vec![1.0; 4096];
    for (method, max_iterations) in [(Method::Explicit, 50), (Method::ConjugateGradients, 7), (MULTIGRID, 2)]
    {
        let settings = Settings { max_iterations, ..Settings::new(method) };
        let device = device();
        let solution = medium.try_solve(&device, &source, &settings).unwrap();
        assert!(!solution.outcome.converged && solution.outcome.residual > 1e-6);
        assert_eq!(solution.outcome.iterations, max_iterations);
        assert_eq!(solution.outcome.history.last(), Some(&(max_iterations, solution.outcome.residual)));
        assert!(solution.phi.read(&device).unwrap().iter().all(|&phi| phi >= 0.0));
    }
}

#[track_caller]
fn refused(medium: &Medium, source: &[f32], settings: &Settings, expected: &str) {
    match medium.try_solve(&device(), source, settings) {
        Err(Error::Input(text)) => assert!(text.contains(expected), "{text}"),
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("not refused: {expected}"),
    }
}

#[test]
fn what_makes_no_sense_is_refused_with_the_reason() {
    let settings = Settings::new(MULTIGRID);
    let medium = || Medium::cube(4, |_| 1.0);
    let with = |change: fn(&mut Medium)| {
        let mut medium = medium();
        change(&mut medium);
        medium
    };
    let source = [1.0; 64];
    let refuse = |change: fn(&mut Medium), text: &str| refused(&with(change), &source, &settings, text);
    refuse(|m| m.absorption[5] = -1.0, "the absorption of 1 cells is not a finite number");
    refuse(|m| m.absorption[5] = f32::INFINITY, "the absorption of 1 cells is not");
    refuse(|m| m.diffusivity[3..5].fill(f32::NAN), "2 cells have a diffusivity that is not above 0");
    refuse(|m| m.diffusivity[3] = 0.0, "1 cells have a diffusivity that is not above 0");
    refuse(|m| m.diffusivity[3] = -2.0, "1 cells have a diffusivity that is not above 0");
    refuse(|m| m.absorption.truncate(60), "the absorption has 60 numbers, the box has 64 cells");
    refuse(|m| m.dims[1] = 0, "[4, 0, 4] cells: each axis needs at least 1");
    refuse(|m| m.spacing.y = -1.0, "lengths are finite and above 0");
    refuse(|m| m.boundary.reflection[2] = -1.0, "boundary factors");
    refuse(
        |m| {
            m.boundary.reflection = [MIRROR; 3];
            m.absorption.fill(0.0);
        },
        "nothing is absorbed and all sides are mirrors",
    );
    refuse(
        |m| {
            m.boundary.reflection = [MIRROR; 3];
            m.absorption.fill(1e-30);
        },
        "next to nothing is absorbed",
    );
    let mut wrong = source;
    wrong[9] = f32::NAN;
    refused(&medium(), &wrong, &settings, "the source of 1 cells is not");
    for (settings, text) in [
        (Settings { tolerance: 0.0, ..settings }, "tolerance 0"),
        (Settings { floor: f64::NAN, ..settings }, "floor NaN"),
        (Settings::new(Method::OverRelaxation { factor: Some(2.0) }), "between 0 and 2"),
    ] {
        refused(&medium(), &source, &settings, text);
    }
}

/// A medium on the device, for several solves of one solver.
struct OnDevice {
    device: Device,
    absorption: Buffer<f32>,
    diffusivity: Buffer<f32>,
    solver: Solver,
}

impl OnDevice {
    fn new(medium: &Medium) -> Self {
        let device = device();
        let absorption = Buffer::from_slice(&device, &medium.absorption).unwrap();
        let diffusivity = Buffer::from_slice(&device, &medium.diffusivity).unwrap();
        let solver = Solver::new(&device, medium.dims, medium.spacing, medium.boundary).unwrap();
        Self { device, absorption, diffusivity, solver }
    }

    /// From `phi` on, to `phi`.
    fn improve(
        &mut self,
        source: &[f32],
        phi: &mut Vec<f32>,
        settings: &Settings,
        observer: &mut Observer<'_>,
    ) -> svetlo::Result<Outcome> {
        let device = &self.device;
        let coefficients = Coefficients { absorption: &self.absorption, diffusivity: &self.diffusivity };
        let [source, field] = [source, phi].map(|values| Buffer::from_slice(device, values).unwrap());
        let outcome = self.solver.improve(device, &coefficients, &source, &field, settings, observer);
        *phi = field.read(device).unwrap();
        outcome
    }
}

#[test]
fn a_solve_goes_on_from_what_is_known() {
    let medium = Medium::cube(20, |p| if p.x < 0.5 { 200.0 } else { 0.5 });
    let mut on_device = OnDevice::new(&medium);
    let source = vec![1.0; 8000];
    let exact = medium.twin().solve(&wide(&source));
    let mut patient = |_, _| ControlFlow::Continue(());
    for method in [Method::OverRelaxation { factor: None }, Method::ConjugateGradients, MULTIGRID] {
        let settings = Settings::new(method);
        let mut phi = vec![0.0; 8000];
        let mut improve = |source: &[f32], phi: &mut Vec<f32>, tolerance| {
            let settings = Settings { tolerance, ..settings };
            on_device.improve(source, phi, &settings, &mut patient).unwrap()
        };
        let first = improve(&source, &mut phi, 1e-4);
        // What is solved takes no iteration, and loses its last bits at most.
        let known = phi.clone();
        let again = improve(&source, &mut phi, 2e-4);
        assert_eq!(again.iterations, 0);
        // The fluence was rounded to float32 in between: that moves what leaves each cell through six faces.
        let roundings = 2.0 * EPS * 12.0 * 400.0 / 1.5 * rms(phi.iter().copied().map(f64::from));
        close("residual", again.history[0].1, first.residual, roundings);
        for (after, before) in phi.iter().zip(&known) {
            close("kept", f64::from(*after), f64::from(*before), 4.0 * EPS * f64::from(*before));
        }
        let onward = improve(&source, &mut phi, 1e-6);
        let whole = improve(&source, &mut vec![0.0; 8000], 1e-6);
        println!(
            "{method:?}: {} + {} iterations, {} from darkness",
            first.iterations, onward.iterations, whole.iterations
        );
        assert!(onward.converged && onward.iterations < whole.iterations);
        // Row sums of A⁻¹ are the fluence itself, for this source; ‖Q‖ is that of 8000 ones.
        let bound = (1e-6 * 8000_f64.sqrt() + 16.0 * EPS) * largest(exact.iter().copied());
        for (found, exact) in phi.iter().zip(&exact) {
            close("solution", f64::from(*found), *exact, bound);
        }
        // A start that has nothing to do with the solution is no worse than darkness, and none leads astray.
        let mut far = vec![1e9; 8000];
        assert_eq!(improve(&source, &mut far, 1e-6).iterations, whole.iterations);
        let mut absurd = vec![1e30; 8000];
        assert!(improve(&vec![1e-20; 8000], &mut absurd, 1e-6).converged);
        let mut dark = vec![1.0; 8000];
        assert!(improve(&vec![0.0; 8000], &mut dark, 1e-6).converged);
        assert!(dark.iter().all(|&phi| phi == 0.0));
    }
}

#[test]
fn an_observer_sees_the_solve_and_can_end_it() {
    let medium = Medium::cube(24, |_| 50.0);
    let mut on_device = OnDevice::new(&medium);
    let source = vec![1.0; 13824];
    for (method, looks, per_look) in
        [(Method::Explicit, 3, 20), (Method::ConjugateGradients, 5, 1), (MULTIGRID, 2, 1)]
    {
        let mut seen = Vec::new();
        let mut watch = |iterations, residual: f64| {
            seen.push(iterations);
            assert!(residual > 0.0 && residual.is_finite());
            if seen.len() == looks { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let mut phi = vec![0.5; 13824];
        let ended = on_device.improve(&source, &mut phi, &Settings::new(method), &mut watch);
        assert!(matches!(ended, Err(Error::Interrupted)));
        assert_eq!(seen, (1..=looks).map(|k| k * per_look).collect::<Vec<_>>());
        assert!(phi.iter().all(|&phi| phi == 0.5));
    }
}
