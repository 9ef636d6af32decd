//! Scattered light from the scene to its fluence: closed forms, the twin in double precision, the balance of power.

mod common;
#[path = "common/irradiance.rs"]
mod irradiance;

use common::{EPS, close, largest, log_slope, noise, report, rms};
use glam::DVec3;
use irradiance::{Lit, MIRROR};
use std::f64::consts::PI;
use svetlo::irradiance::Limiter;

#[test]
fn slabs_converge_with_the_second_order_to_the_closed_form() {
    let truths: serde_json::Value = serde_json::from_str(include_str!("truths.json")).unwrap();
    for row in truths["diffusion_slab"]["rows"].as_array().unwrap() {
        let number = |key: &str| row[key].as_f64().unwrap();
        let [sa, ss, a, b, c, k] = ["sa", "ss", "a", "b", "C", "k"].map(number);
        let st = sa + ss;
        let closed = |z: f64| a * (-k * z).exp() + b * (-k * (1.0 - z)).exp() + c * (-st * z).exp();
        let (albedo, most) = (ss / st, largest((0..=100).map(|i| closed(0.01 * f64::from(i)))));
        let mut errors = Vec::new();
        for cells in [16, 32, 64, 128] {
            let slab = Lit::slab(cells, st, &format!("albedo = {albedo:?}"), |_| st);
            let phi = slab.solve(|p| [(-st * p.z).exp(); 3]).grey();
            let h = 1.0 / cells as f64;
            let centre = |i: usize| (i as f64 + 0.5) * h;
            errors.push((h, rms((0..cells).map(|i| phi[i] - closed(centre(i))))));
            // Between cells, and at the sides by what Marshak's condition makes of the outermost cells.
            let side = 2.0 / (2.0 + 0.5 * h * 3.0 * st);
            for (quarter, exact) in row["phi"].as_array().unwrap().iter().enumerate() {
                let i = quarter * cells / 4;
                let found = match quarter {
                    0 => side * phi[0],
                    4 => side * phi[cells - 1],
                    _ => 0.5 * (phi[i - 1] + phi[i]),
                };
                // The source bends as σ_t², the mean of two cells adds an eighth of that, and the points of a cell as
                // much again.
                let bound = (st * h).powi(2) / 4.0 * most;
                close(&format!("{cells} cells, z {quarter}/4"), found, exact.as_f64().unwrap(), bound);
            }
        }
        let slopes: Vec<f64> = errors.windows(2).map(log_slope).collect();
        println!("σ_a {sa}: rms errors {errors:?}, orders {slopes:.3?}");
        assert!(slopes[0] > 1.5 && slopes[1] > 1.75 && slopes[2] > 1.875, "{slopes:?}");
        assert!(slopes[2] < 2.05);
    }
}

#[test]
fn cubes_between_mirrors_are_slabs() {
    let slab = Lit::slab(12, 10.0, "albedo = 0.9", |_| 10.0);
    let mut cube = Lit::new([5, 4, 12], DVec3::splat(1.0 / 12.0), 10.0, "albedo = 0.9", |_| 10.0);
    cube.settings.reflection = [MIRROR, MIRROR, 1.0];
    let [one, many] = [&slab, &cube].map(|lit| lit.solve(|p| [(-10.0 * p.z).exp(); 3]).grey());
    for (i, phi) in many.into_iter().enumerate() {
        // The tolerance of both, times what a source of 1 may bring about at most: 1/σ_a.
        close("cube", phi, one[i / 20], 2e-6 * 12_f64.sqrt());
    }
}

#[test]
fn the_device_solves_the_twins_equation() {
    let values = noise(9 * 6 * 7, 21);
    let mut voxels = values.iter();
    let more = "albedo = [0.6, 0.95, 1]\n[phase]\nkind = \"two-lobe\"\ng = [0.8, -0.3]\nweight = 0.75";
    let mut lit =
        Lit::new([9, 6, 7], DVec3::new(0.25, 0.5, 0.3), 8.0, more, |_| 8.0 * voxels.next().unwrap());
    lit.settings.reflection = [1.0, 2.5, MIRROR];
    let light = |p: DVec3| (-p.x).exp() + p.y * p.z;
    for coarsening in [1, 2, 4] {
        lit.coarsening = [coarsening; 2];
        let direct = lit.direct(|p| [1.0, 0.5, 2.0].map(|l| l * light(p)));
        let found = lit.solve_for(&direct);
        for (c, (albedo, l)) in [(0.6, 1.0), (0.95, 0.5), (1.0, 2.0)].into_iter().enumerate() {
            // 0.75 · 0.8 − 0.25 · 0.3.
            let (twin, source) = lit.twin(albedo, 0.525, 8.0, |p| l * light(p));
            let exact = twin.solve(&source);
            let norm = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>().sqrt();
            let amplified = largest(twin.solve(&vec![1.0; source.len()]));
            // What the residual allows, and float32 coefficients: sums of up to 512 points.
            let bound = amplified * 1e-6 * norm(&source) + 512.0 * EPS * norm(&exact);
            let off = found
                .fluence
                .iter()
                .zip(&exact)
                .map(|(phi, exact)| (phi[c] - exact).powi(2))
                .sum::<f64>()
                .sqrt();
            report(&format!("channel {c} / {coarsening}"), off, bound);
            assert!(off < bound, "channel {c}: {off:e} > {bound:e}");
        }
    }
}

#[test]
fn a_uniform_source_gives_source_over_absorption() {
    let mut between = Lit::new([6, 5, 4], DVec3::new(0.2, 0.1, 0.3), 7.0, "albedo = 0.75", |_| 7.0);
    between.settings.reflection = [MIRROR; 3];
    for limiter in Limiter::ALL {
        between.settings.limiter = limiter;
        for phi in between.solve(|_| [2.0; 3]).grey() {
            // σ_s φ_ri / σ_a, off by at most ‖r‖ = 10⁻⁶ ‖Q‖ over σ_a.
            close("between mirrors", phi, 6.0, 6.0 * (1e-6 * 120_f64.sqrt() + 16.0 * EPS));
        }
    }
    // Deep in an open box: the boundary is felt as e^-kz, k² = 3 · 20 · 80 and z 0.5: e^-34.
    let slab = Lit::slab(61, 80.0, "albedo = 0.75", |_| 80.0);
    close("deep inside", slab.solve(|_| [2.0; 3]).grey()[30], 6.0, 6.0 * 1e-6 * 61_f64.sqrt());
}

#[test]
fn a_medium_that_glows_between_mirrors_is_a_furnace() {
    // Whatever it scatters: the fluence is that of its radiance from everywhere.
    let glow = "albedo = [0, 0.5, 0.9]\n[transfer]\nresolution = 3\npoints = [\n\
                { value = 0, opacity = 0.2, emission = [1, 2, 0.5] }, { value = 1, opacity = 1, emission = [1, 2, 0.5] }]";
    let values = noise(6 * 7 * 5, 4);
    let mut voxels = values.iter();
    let mut lit = Lit::new([6, 7, 5], DVec3::ONE, 1.0, glow, |_| *voxels.next().unwrap());
    lit.settings.reflection = [MIRROR; 3];
    for limiter in [Limiter::None, Limiter::LevermorePomraning] {
        lit.settings.limiter = limiter;
        lit.coarsening = [2, 1];
        for phi in lit.solve(|_| [0.0; 3]).fluence {
            for (phi, radiance) in phi.into_iter().zip([1.0, 2.0, 0.5]) {
                // The least absorption of a cell is 0.02, which a residual is over at most.
                let bound = 4.0 * PI * radiance * (1e-6 * 210_f64.sqrt() / 0.02 + 32.0 * EPS);
                close("furnace", phi, 4.0 * PI * radiance, bound);
            }
        }
    }
}

#[test]
fn layers_without_sources_are_straight_lines_and_exact() {
    // Nothing is absorbed; light of the first two cells flows through both layers, as in a circuit.
    let (cells, sigma) = (40, |z: f64| if z < 0.6 { 5.0 } else { 400.0 });
    let slab = Lit::slab(cells, 400.0, "albedo = 1", |p| sigma(p.z));
    let h = 1.0 / cells as f64;
    let phi = slab.solve(|p| [f64::from(u8::from(p.z < h)); 3]).grey();
    // Cells average between voxels: an eighth of each neighbour.
    let at = |i: usize| sigma((i as f64 + 0.5) * h);
    let average = |i: usize| 0.75 * at(i) + 0.125 * (at(i.max(1) - 1) + at((i + 1).min(cells - 1)));
    // Light is that of the first cell, whose mean is its own as the slope goes on, and 1/24 of the second.
    let power = [0, 1].map(|i| 5.0 * h * [1.0, 1.0 / 24.0][i]);
    // To the right of the first cells: φ is the flux times the resistance ahead, up to the side's 2.
    let ahead = |i: usize| {
        2.0 + 3.0 * h * (0.5 * average(i) + 0.5 * average(cells - 1))
            + (i + 1..cells).map(|j| 1.5 * h * (average(j - 1) + average(j))).sum::<f64>()
            - 3.0 * h * 0.5 * average(i)
    };
    let left = 2.0 + 1.5 * h * average(0);
    // Each source divides between both sides by their resistances.
    let flux: f64 = [0, 1]
        .into_iter()
        .map(|i| {
            let before = left + if i == 1 { 1.5 * h * (average(0) + average(1)) } else { 0.0 };
            power[i] * before / (before + ahead(i))
        })
        .sum();
    for (i, phi) in phi.into_iter().enumerate().skip(1) {
        // Nothing is lost: a residual of 10⁻⁶ of the power is carried by the resistance to the nearer side.
        close(
            &format!("cell {i}"),
            phi,
            flux * ahead(i),
            1e-6 * (power[0] + power[1]) * left + 64.0 * EPS * flux * ahead(i),
        );
    }
}

#[test]
fn a_point_source_in_a_wide_box_converges_to_the_infinite_medium() {
    let truths: serde_json::Value = serde_json::from_str(include_str!("truths.json")).unwrap();
    let rows = truths["point_source_infinite"]["rows"].as_array().unwrap();
    let solutions = [0.5, 0.25].map(|h| {
        // 16.5 and 16.25 wide: what the boundary sends back is e^-16 of what is here.
        let cells = (16.0 / h) as usize + 1;
        let middle = cells / 2;
        let mut lit = Lit::new([cells; 3], DVec3::splat(h), 1.0, "albedo = 0.5", |_| 1.0);
        lit.settings.tolerance = 1e-9;
        let centre = DVec3::splat((middle as f64 + 0.5) * h);
        // Half of the light that collides is scattered: a power of 1.
        let phi = lit.solve(|p| [if p.distance(centre) < 0.1 * h { 2.0 / h.powi(3) } else { 0.0 }; 3]).grey();
        (h, phi, cells, middle)
    });
    for row in rows.iter().filter(|row| row["w"] == 0.5 && [2.0, 5.0].contains(&row["r"].as_f64().unwrap())) {
        let (r, exact) = (row["r"].as_f64().unwrap(), row["diffusion"].as_f64().unwrap());
        let [coarse, fine] = solutions.each_ref().map(|(h, phi, cells, middle)| {
            let x = middle + (r / h) as usize;
            phi[x + cells * (middle + cells * middle)] / exact - 1.0
        });
        // The lattice multiplies p² by 1 − h² Σp⁴/12p²: to first order that adds h²/12 Σ∂⁴ e^-kr/8πk to e^-kr/4πr,
        // on an axis. The means of cells spread the source: 1/24 to each side, which is h²/24 ∇². The next order is
        // taken out by two grids, the third is a few percent of the first.
        let k = 1.5_f64.sqrt();
        let expected = k.powi(3) * r / 24.0 + k / (4.0 * r) + 1.0 / (4.0 * r * r) + k * k / 24.0;
        let found = (16.0 * fine - coarse) / (3.0 * 0.25);
        println!("r {r}: errors {coarse:e}, {fine:e}; of second order {found:.4}, expected {expected:.4}");
        close("second order", found, expected, 0.05 * expected);
    }
}

/// R at which a limiter lets a share of the fluence flow.
fn ratio(limiter: Limiter, share: f64) -> f64 {
    let flowing = |r: f64| match limiter {
        Limiter::None => r / 3.0,
        Limiter::Sum => r / (3.0 + r),
        Limiter::Max => r / r.max(3.0),
        Limiter::Kershaw => 2.0 * r / (3.0 + (9.0 + 4.0 * r * r).sqrt()),
        Limiter::LevermorePomraning => 1.0 / r.tanh() - 1.0 / r,
        Limiter::Rational => r * (2.0 + r) / (6.0 + 3.0 * r + r * r),
    };
    let (mut low, mut high) = (1e-9, 1e9);
    for _ in 0..200 {
        let middle: f64 = 0.5 * (low + high);
        *(if flowing(middle) < share { &mut low } else { &mut high }) = middle;
    }
    low
}

#[test]
fn limited_flux_follows_its_ordinary_differential_equation() {
    // Nothing is absorbed and the source is uniform, so the flux is known: φ' = −σ R φ with the R at which F / φ flows,
    // from φ = 2F at the side on.
    let sigma = 3.0;
    for limiter in Limiter::ALL {
        let mut errors = Vec::new();
        for cells in [20, 40, 80] {
            let mut slab = Lit::slab(cells, sigma, "albedo = 1", |_| sigma);
            slab.settings.limiter = limiter;
            let h = 1.0 / cells as f64;
            let phi = slab.solve(|_| [1.0; 3]).grey();
            // By symmetry light flows outward from the middle: F(z) = σ (z − ½).
            let steps = 64;
            let slope = |z: f64, phi: f64| {
                let flux = sigma * (z - 0.5);
                if flux <= 0.0 { 0.0 } else { -sigma * phi * ratio(limiter, flux / phi) }
            };
            let (mut z, mut exact) = (1.0, sigma);
            let step = -0.5 * h / f64::from(steps);
            let mut values = vec![0.0; cells / 2];
            for value in values.iter_mut().rev() {
                for part in 0..2 * steps {
                    if part == steps {
                        *value = exact;
                    }
                    let a = slope(z, exact);
                    let b = slope(z + 0.5 * step, exact + 0.5 * step * a);
                    let c = slope(z + 0.5 * step, exact + 0.5 * step * b);
                    let d = slope(z + step, exact + step * c);
                    exact += step * (a + 2.0 * b + 2.0 * c + d) / 6.0;
                    z += step;
                }
            }
            let right = phi[cells / 2..].iter();
            errors.push((h, rms(right.zip(&values).map(|(phi, exact)| phi / exact - 1.0))));
        }
        let slopes: Vec<f64> = errors.windows(2).map(log_slope).collect();
        println!("{limiter:?}: relative errors {errors:?}, orders {slopes:.2?}");
        // Limiters that feel the first power of R feel the middle's cells, where the flux turns: a third-order part.
        assert!(slopes[0] > 1.5 && slopes[1] > 1.75 && slopes[1] < 2.25, "{limiter:?}: {slopes:?}");
    }
}
