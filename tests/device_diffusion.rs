//! The diffusion solver against closed forms and against its twin in double precision.

mod common;
#[path = "common/diffusion.rs"]
mod diffusion;

use common::{EPS, close, largest, log_slope, noise, report, rms};
use diffusion::{MIRROR, Medium, media, wide};
use glam::DVec3;
use std::f64::consts::PI;
use svetlo::diffusion::{Method, Settings};

const METHODS: [Method; 4] = [
    Method::Explicit,
    Method::OverRelaxation { factor: None },
    Method::ConjugateGradients,
    Method::Multigrid,
];

/// ‖φ − φ'‖ that a relative residual of `tolerance` allows: A⁻¹ is symmetric and has no negative entries, so its norm
/// is at most its largest row sum, which is the largest fluence for a source of 1. Float32 coefficients and their sums
/// are off by a few roundings, and so is φ, cell by cell.
fn allowed(medium: &Medium, source: &[f32], exact: &[f64], tolerance: f64) -> f64 {
    let amplified = largest(medium.twin().solve(&vec![1.0; source.len()]));
    let norm = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>().sqrt();
    amplified * tolerance * norm(&wide(source)) + 16.0 * EPS * norm(exact)
}

#[test]
fn every_method_solves_the_twins_equation() {
    for (dims, spacing) in [
        ([9, 6, 5], DVec3::new(1.0, 0.7, 1.9)),
        ([12, 13, 11], DVec3::new(0.1, 0.1, 0.3)),
        ([1, 17, 16], DVec3::ONE),
        ([1, 1, 1], DVec3::new(3.0, 2.0, 1.0)),
    ] {
        let mut random = noise(2 * dims.iter().product::<usize>(), 3).into_iter();
        let mut decades = |low: f64, high: f64| 10_f64.powf(low + (high - low) * random.next().unwrap());
        let medium =
            Medium::new(dims, spacing, |_| [decades(-2.0, 0.0), decades(-1.0, 2.0)]).between([1.0, 2.5, 0.0]);
        let source: Vec<f32> = noise(medium.absorption.len(), 4).into_iter().map(|u| u as f32).collect();
        let exact = medium.twin().solve(&wide(&source));
        for method in METHODS {
            let settings = Settings::new(method);
            let solved = medium.solve(&source, &settings);
            let found: f64 = solved.phi.iter().zip(&exact).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
            let bound = allowed(&medium, &source, &exact, settings.tolerance);
            report(&format!("{dims:?} {method:?}, {} iterations", solved.outcome.iterations), found, bound);
            assert!(found <= bound, "{dims:?} {method:?}: {found:e} > {bound:e}");
        }
    }
}

#[test]
fn the_residual_that_is_reported_is_that_of_the_equation() {
    let (_, medium) = media(20).into_iter().next_back().unwrap();
    let source = vec![1.0; medium.absorption.len()];
    for tolerance in [1e-2, 1e-4] {
        let settings = Settings { tolerance, ..Settings::new(Method::Multigrid) };
        let solved = medium.solve(&source, &settings);
        let exact = medium.twin().residual(&solved.phi, &wide(&source));
        // Float32 moves φ by half a unit in the last place in each cell, and with it what leaves.
        let roundings = 2.0
            * EPS
            * largest(medium.diffusivity.iter().map(|&d| 12.0 * f64::from(d) * 400.0))
            * rms(solved.phi.iter().copied());
        report(
            "residual beside the twin's",
            (exact - solved.outcome.residual).abs(),
            roundings + 1e-2 * exact,
        );
        close("residual", solved.outcome.residual, exact, roundings + 1e-2 * exact);
    }
}

#[test]
fn slabs_converge_with_the_second_order_to_the_closed_form() {
    let truths: serde_json::Value = serde_json::from_str(include_str!("truths.json")).unwrap();
    for row in truths["diffusion_slab"]["rows"].as_array().unwrap() {
        let number = |key: &str| row[key].as_f64().unwrap();
        let [sa, ss, a, b, c, k] = ["sa", "ss", "a", "b", "C", "k"].map(number);
        let st = sa + ss;
        let closed = |z: f64| a * (-k * z).exp() + b * (-k * (1.0 - z)).exp() + c * (-st * z).exp();
        for (i, phi) in row["phi"].as_array().unwrap().iter().enumerate() {
            close("closed form", closed(0.25 * i as f64), phi.as_f64().unwrap(), 1e-12);
        }
        let mut errors = Vec::new();
        for cells in [16, 32, 64] {
            let slab = Medium::slab(cells, |_| [sa, st]);
            let h = 1.0 / cells as f64;
            // The mean of the source over each cell.
            let mean = |z: f64| ss * (-st * z).exp() * (0.5 * st * h).sinh() / (0.5 * st * h);
            let source: Vec<f32> = slab.centres().map(|p| mean(p.z) as f32).collect();
            let phi = slab.solve(&source, &Settings::new(Method::Multigrid)).phi;
            let error = rms(slab.centres().zip(phi).map(|(p, phi)| phi - closed(p.z)));
            errors.push((h, error));
        }
        let slope = log_slope(&errors);
        println!("σ_a {sa}: rms errors {errors:?}, order {slope:.3}");
        // The next term is h⁴: at 16 cells it is (σ_t h)²/12 ≈ 3 % of the first, which moves the slope by less than
        // ln(1.03) / ln 4.
        assert!((slope - 2.0).abs() < 0.05, "{slope}");
        let (h, most) = (1.0 / 64.0, largest((0..=100).map(|i| closed(0.01 * f64::from(i)))));
        assert!(errors[2].1 < (st * h).powi(2) / 12.0 * most, "{errors:?}");
    }
}

#[test]
fn a_point_source_in_a_wide_box_converges_to_the_infinite_medium() {
    let truths: serde_json::Value = serde_json::from_str(include_str!("truths.json")).unwrap();
    let rows = truths["point_source_infinite"]["rows"].as_array().unwrap().clone();
    let absorbing =
        rows.iter().filter(|row| row["w"] == 0.5 && [2.0, 5.0].contains(&row["r"].as_f64().unwrap()));
    for row in absorbing {
        let (r, exact) = (row["r"].as_f64().unwrap(), row["diffusion"].as_f64().unwrap());
        let errors: Vec<f64> = [0.5, 0.25]
            .into_iter()
            .map(|h| {
                // 16.5 and 16.25 wide: what the boundary sends back is e^-16 of what is here.
                let cells = (16.0 / h) as usize + 1;
                let medium = Medium::new([cells; 3], DVec3::splat(h), |_| [0.5, 1.0]);
                let middle = cells / 2;
                let at = |x: usize| x + cells * (middle + cells * middle);
                let mut source = vec![0.0; cells.pow(3)];
                source[at(middle)] = (1.0 / h.powi(3)) as f32;
                // The residual of a cell may be as large as that of the source's: it must be small beside φ out here.
                let settings = Settings { tolerance: 1e-9, ..Settings::new(Method::Multigrid) };
                let phi = medium.solve(&source, &settings).phi;
                phi[at(middle + (r / h) as usize)] / exact - 1.0
            })
            .collect();
        // The lattice multiplies p² by 1 − h² Σp⁴/12p²: to first order that adds h²/12 Σ∂⁴ e^-kr/8πk to e^-kr/4πr,
        // on an axis. The next order is taken out by two grids, the third is a few percent of the first.
        let k = 1.5_f64.sqrt();
        let expected = k.powi(3) * r / 24.0 + k / (4.0 * r) + 1.0 / (4.0 * r * r);
        let found = (16.0 * errors[1] - errors[0]) / (3.0 * 0.25);
        println!("r {r}: errors {errors:?}; of second order {found:.4}, expected {expected:.4}");
        close("second order", found, expected, 0.05 * expected);
    }
}

#[test]
fn a_uniform_source_gives_source_over_absorption() {
    let (absorption, q) = (0.3, 2.0);
    let between_mirrors =
        Medium::new([7, 8, 20], DVec3::new(0.1, 0.2, 0.3), |p| [absorption, 1.0 + 9.0 * p.z])
            .between([MIRROR; 3]);
    let source = vec![q as f32; 7 * 8 * 20];
    let solved = between_mirrors.solve(&source, &Settings::new(Method::Multigrid));
    for phi in solved.phi {
        // A⁻¹ has row sums 1/σ_a, so each cell is off by at most ‖r‖ = 10⁻⁶ ‖Q‖ over σ_a.
        close("between mirrors", phi, q / absorption, 1e-6 * q * 1120_f64.sqrt() / absorption);
    }
    // Deep in an open box: the boundary is felt as e^-kz, here e^-30.
    let slab = Medium::slab(61, |_| [60.0, 20.0]);
    let solved = slab.solve(&[q as f32; 61], &Settings::new(Method::Multigrid));
    close("deep inside", solved.phi[30], q / 60.0, 1e-6 * q / 60.0 * 61_f64.sqrt());
}

#[test]
fn layers_without_sources_are_straight_lines_and_exact() {
    // Light from the first cell flows through both layers; nothing is absorbed. As in a circuit, φ is the flux times
    // the resistance ahead.
    let (cells, interface) = (40, 24);
    let sigma = |z: f64| if z < interface as f64 / 40.0 { 5.0 } else { 5e4 };
    let slab = Medium::slab(cells, |p| [0.0, sigma(p.z)]);
    let mut source = vec![0.0; cells];
    source[0] = 40.0;
    let settings = Settings { tolerance: 1e-7, ..Settings::new(Method::Multigrid) };
    let phi = slab.solve(&source, &settings).phi;
    let h = 1.0 / cells as f64;
    let ahead = |z: f64| {
        let first = (0.6 - z).max(0.0) * 3.0 * 5.0;
        first + (1.0 - z.max(0.6)) * 3.0 * 5e4 + 2.0
    };
    let (left, right) = (2.0 + 0.5 * h * 3.0 * 5.0, ahead(0.5 * h));
    let flux = left / (left + right);
    for (p, phi) in slab.centres().zip(phi) {
        let exact = flux * ahead(p.z);
        // A residual of 10⁻⁷ of the source's 1 is carried by at most the resistance to the nearer side.
        close(&format!("z {}", p.z), phi, exact, 1e-7 * right + 16.0 * EPS * exact);
    }
}

#[test]
fn power_is_absorbed_or_escapes() {
    for (name, medium) in media(24) {
        let mut source: Vec<f32> = medium.centres().map(|p| p.x as f32).collect();
        source[5 * 24 * 24 + 77] = 1000.0;
        let solved = medium.solve(&source, &Settings::new(Method::Multigrid));
        let balance = medium.twin().balance(&solved.phi);
        let power = wide(&source).iter().sum::<f64>() * medium.spacing.element_product();
        let error = (balance.absorbed + balance.escaped) / power - 1.0;
        report(&format!("{name}: power"), error.abs(), 1e-5);
        close("imbalance", solved.outcome.imbalance, error.abs(), 1e-6);
        assert!(error.abs() < 1e-5, "{name}: {error:e}");
    }
}

#[test]
fn multigrid_takes_few_iterations_whatever_the_size() {
    let mut counts = Vec::new();
    for cells in [32, 64] {
        for (name, medium) in media(cells) {
            let source = vec![1.0; cells.pow(3)];
            let solved = medium.solve(&source, &Settings::new(Method::Multigrid));
            println!("{name} {cells}³: {} iterations", solved.outcome.iterations);
            assert!(solved.outcome.iterations <= 20, "{name} {cells}³: {}", solved.outcome.iterations);
            counts.push(solved.outcome.iterations as f64);
        }
    }
    for k in 0..4 {
        // 30 % from one size to the next, and whole iterations.
        assert!(counts[4 + k] <= (1.3 * counts[k]).ceil(), "{counts:?}");
    }
}

/// Waves decay in a slab as the scheme's own closed form says, to the solver's tolerance.
#[test]
fn waves_decay_as_the_scheme_says() {
    let (cells, sigma_a, sigma) = (48, 3.0, 40.0);
    let slab = Medium::slab(cells, |_| [sigma_a, sigma]);
    let mut source = vec![0.0; cells];
    source[0] = 1.0;
    let settings = Settings { tolerance: 1e-10, ..Settings::new(Method::Multigrid) };
    let phi = slab.solve(&source, &settings).phi;
    let h = 1.0 / cells as f64;
    let k = 2.0 / h * (0.5 * h * (3.0 * sigma_a * sigma).sqrt()).asinh();
    // In the middle the wave from the far side is e^-k of this one.
    close("decay", (phi[10] / phi[20]).ln() / (10.0 * h), k, 1e-5 * k);
    assert!(k > PI);
}
