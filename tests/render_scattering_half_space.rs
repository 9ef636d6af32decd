//! Half spaces, slabs and spheres in uniform light, and a source deep inside a medium: closed forms of transport theory.

mod common;

use common::scattering::{Measured, all_finite, family, of_film, over_pixels, rows};
use common::{Case, volume_f32};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;
use svetlo::film::FilmPixel;
use svetlo::reference::field::Field;
use svetlo::reference::half_space::{diffusion_exponent, fluence, plane_albedo};
use svetlo::reference::quadrature::gauss_legendre;
use svetlo::reference::slab::Slab;
use svetlo::volume::Volume;

const SIDE: u32 = 64;

/// A slab of one voxel, 2·10⁴ thicknesses wide (see `render_scattering_slab.rs` for why that is wide enough), seen
/// at the cosine `mu`; radiance 1 comes from everywhere. Views of the same seed have errors that depend on each other.
fn slab(tau: f64, albedo: f64, mu: f64, samples: u32, seed: usize) -> Vec<FilmPixel> {
    let sine = f64::sqrt(1.0 - mu * mu);
    let text = format!(
        "seed = {seed}\n[image]\nwidth = {SIDE}\nheight = {SIDE}\n[camera]\nkind = \"orthographic\"\nposition = {:?}\n\
         target = [0, 0, 0]\nup = [0, 0, 1]\nheight = 1\n\
         [volume]\norigin = \"centre\"\nspacing = [2e4, 1, 2e4]\nwindow = {{ lo = 0, hi = 1 }}\n\
         [medium]\nsigma_max = {tau}\nalbedo = {albedo}\n\
         [transfer]\nresolution = 2\npoints = [{{ value = 0, opacity = 1, color = 1 }}]\n\
         [background]\ncolor = 1\n[method]\nkind = \"multiple-scattering\"\n",
        [100.0 * sine, 100.0 * mu, 0.0]
    );
    Case::new(&text, volume_f32([1, 1, 1], [0.5])).film_of(samples)
}

#[test]
fn half_spaces_return_their_plane_albedo() {
    let absorbing: Vec<_> =
        rows("semi_infinite_isotropic").into_iter().filter(|row| row["w"] != 1.0).collect();
    for row in &absorbing {
        let [w, mu, exact] = ["w", "mu0", "R"].map(|key| row[key].as_f64().unwrap());
        // Radiance from both sides; τ = 40 lets less than e^{−40κ} through, κ = 0.957 and 0.525: below 10⁻⁹.
        let found = over_pixels(&slab(40.0, w, mu, 200, 1), 1);
        found.agrees(&format!("w {w}, mu {mu}"), exact, family(absorbing.len()), 1e-9);
        assert!((plane_albedo(w, mu) - exact).abs() < 1e-12);
    }
}

#[test]
fn dense_half_spaces_are_no_different() {
    // σ × size up to 10⁶. The grid's coordinates go to 2.5 here, so float32 rounds places by 2⁻²³: 0.12 free paths at 10⁶.
    // Light that scatters deeper by that is returned less by κ times as much, its decay in the medium.
    let cases = [(1e6, 0.999, 1.0), (1e6, 0.999, 0.5), (1e5, 0.9, 1.0), (1e5, 0.9, 0.1), (1e4, 0.9, 0.1)];
    for (sigma, albedo, mu) in cases {
        let found = over_pixels(&slab(sigma, albedo, mu, 20, 1), 1);
        let slack = 0.5_f64.powi(23) * sigma * diffusion_exponent(albedo);
        let what = format!("σ {sigma}, w {albedo}, mu {mu}");
        found.agrees(&what, plane_albedo(albedo, mu), family(cases.len()), slack);
    }
}

#[test]
fn slabs_in_uniform_light_shine_as_published() {
    for row in rows("slab_uniform") {
        let [tau, w, radiance, flux] = ["tau", "w", "L_mu1", "flux"].map(|key| row[key].as_f64().unwrap());
        over_pixels(&slab(tau, w, 1.0, 200, 1), 1).agrees(
            &format!("tau {tau}, mu 1"),
            radiance,
            family(4),
            0.0,
        );
        // The exitance π ∫ 2μ L(μ) dμ by eight views. The rule's own error, from the exact L:
        let rule = gauss_legendre(8);
        let cosines: Vec<f64> = rule.iter().map(|node| node.0).collect();
        let exact: Vec<f64> = Slab { tau, albedo: w, g: 0.0 }
            .responses(&cosines)
            .iter()
            .map(|response| response.reflected + response.transmitted)
            .collect();
        let exitance = |l: &[f64]| PI * rule.iter().zip(l).map(|((mu, w), l)| 2.0 * mu * w * l).sum::<f64>();
        let quadrature = (exitance(&exact) - flux).abs();
        let views: Vec<Measured> =
            (1..).zip(&cosines).map(|(seed, &mu)| over_pixels(&slab(tau, w, mu, 40, seed), 1)).collect();
        let values: Vec<f64> = views.iter().map(|view| view.value).collect();
        let variance: f64 =
            rule.iter().zip(&views).map(|((mu, w), view)| (2.0 * PI * mu * w * view.error).powi(2)).sum();
        let found = Measured { value: exitance(&values), error: variance.sqrt() };
        found.agrees(&format!("tau {tau}, exitance"), flux, family(4), quadrature);
        assert!(quadrature < 1e-3 * flux, "{quadrature}");
    }
}

/// Distances from the middle of the unit cube, at n³ voxels of spacing 1.
fn distances(n: usize) -> Volume {
    let offset = move |i: usize| (i as f64 + 0.5) / n as f64 - 0.5;
    let at = move |i: usize| {
        let [x, y, z] = [i % n, i / n % n, i / (n * n)].map(offset);
        (x * x + y * y + z * z).sqrt()
    };
    volume_f32([n; 3], (0..n * n * n).map(at))
}

#[test]
fn spheres_in_uniform_light_look_as_published() {
    let (n, radius) = (96, 0.45);
    // The boundary is where the trilinear distance is the radius: a line through a convex function lies above it, by
    // h²/4R at most, so the sphere is too small by that at most, and h²/6R in the mean over a cell. Extinction rises
    // over ±10⁻⁴ about it, which changes the sphere in second order only, 10⁻⁷.
    let shrunk = 1.0 / (4.0 * (n as f64).powi(2) * radius * radius);
    for row in rows("sphere_uniform") {
        let [tau, w, chord, absorbed] = ["tauR", "w", "L", "Qabs"].map(|key| row[key].as_f64().unwrap());
        let scene = |height: f64| {
            format!(
                "[image]\nwidth = {SIDE}\nheight = {SIDE}\n[camera]\nkind = \"orthographic\"\nposition = [0.3, 0.5, 3]\n\
                 target = [0, 0, 0]\nheight = {height}\n[volume]\norigin = \"centre\"\nspacing = {}\n\
                 window = {{ lo = {}, hi = {} }}\n[medium]\nsigma_max = {}\nalbedo = {w}\n\
                 [transfer]\nresolution = 2\npoints = [{{ value = 0, opacity = 1 }}, {{ value = 1, opacity = 0 }}]\n\
                 [background]\ncolor = 1\n[method]\nkind = \"multiple-scattering\"\n",
                1.0 / n as f64,
                radius - 1e-4,
                radius + 1e-4,
                tau / radius
            )
        };
        // Rays within 10⁻³ of the middle: chords shorter by 10⁻⁶ relatively.
        let case = Case::new(&scene(1e-3), distances(n));
        let found = over_pixels(&case.film_of(200), 1);
        // 1 − L grows with the radius, more slowly than in proportion.
        found.agrees(&format!("sphere {tau}, chord"), chord, family(4), (shrunk + 1e-6) * (1.0 - chord));
        // The absorbed power is 4π ∫ (1 − L) dA over the disk of one view, and Q = power / (4π² R²).
        let height = 0.95_f64;
        let film = Case::new(&scene(height), distances(n)).film_of(200);
        let mean = of_film(&film, 1);
        let factor = height * height / (PI * radius * radius);
        let found = Measured { value: factor * (1.0 - mean.value), error: factor * mean.error };
        // Q R² grows at most like the volume.
        found.agrees(
            &format!("sphere {tau}, absorbed"),
            absorbed,
            family(4),
            (3.0 * shrunk + 1e-6) * absorbed,
        );
    }
}

/// A camera in the middle of a medium of extinction 1, `2 · half` mean free paths wide, in which the shell between
/// 1/2 and 3/2 of `radius` glows, most in its middle. Returns the fluence there, and what transport theory says.
fn shell(albedo: f64, radius: f64, half: f64, n: usize, samples: u32) -> (Measured, f64) {
    let spacing = 2.0 * half / n as f64;
    // The voxels count distances in widths of the box; the window ends at twice the radius.
    let window = radius / half;
    let text = format!(
        "[image]\nwidth = {SIDE}\nheight = {SIDE}\n[camera]\nposition = [0, 0, 0]\ntarget = [1, 0, 0]\nfov = 90\n\
         [volume]\norigin = \"centre\"\nspacing = {spacing}\nwindow = {{ lo = 0, hi = {window} }}\n\
         [medium]\nsigma_max = 1\nalbedo = {albedo}\n[transfer]\nresolution = 5\npoints = [\n\
         {{ value = 0.25, opacity = 1 }}, {{ value = 0.5, opacity = 1, emission = 1 }},\n\
         {{ value = 0.75, opacity = 1 }}]\n[method]\nkind = \"multiple-scattering\"\n"
    );
    let case = Case::new(&text, distances(n));
    let film = case.film_of(samples);
    all_finite(&film);
    // One face of a cube around the camera; the others look the same. Pixels weigh by their solid angle, cos³.
    let offset = |k: u32| 2.0 * (f64::from(k) + 0.5) / f64::from(SIDE) - 1.0;
    let weight = |i: u32| (1.0 + offset(i % SIDE).powi(2) + offset(i / SIDE).powi(2)).powf(-1.5);
    let total: f64 = (0..SIDE * SIDE).map(weight).sum();
    let (mut value, mut variance) = (0.0, 0.0);
    for (i, pixel) in (0..).zip(&film) {
        let share = 4.0 * PI * weight(i) / total;
        value += share * pixel.mean()[1];
        variance += share * share * pixel.variance().unwrap()[1] / f64::from(pixel.count);
    }
    // The source as the trilinear field has it, σₐ Lₑ in all directions: midpoints of 1/4 voxel over one octant.
    let table: Vec<f64> =
        (0..=2000).map(|k| fluence(albedo, radius * (0.4 + f64::from(k) / 1600.0))).collect();
    let field = Field::new(&case.volume, DVec3::splat(-half), DVec3::splat(spacing), (0.0, window));
    let fine = spacing / 4.0;
    let reach = (1.6 * radius / fine) as usize;
    let at = |k: usize| (k as f64 + 0.5) * fine;
    let cell = |i: usize| {
        let point = DVec3::new(at(i % reach), at(i / reach % reach), at(i / (reach * reach)));
        let glow = 1.0 - (field.value(point) - 0.5).abs() / 0.25;
        if glow <= 0.0 {
            return 0.0;
        }
        let place = (point.length() / radius - 0.4) * 1600.0;
        let k = place as usize;
        glow * (table[k] + (place - k as f64) * (table[k + 1] - table[k]))
    };
    let sum: f64 = (0..reach.pow(3)).into_par_iter().map(cell).sum();
    (Measured { value, error: variance.sqrt() }, 8.0 * fine.powi(3) * 4.0 * PI * (1.0 - albedo) * sum)
}

#[test]
fn sources_deep_inside_a_medium_have_the_fluence_of_transport_theory() {
    // Fluence by reciprocity: light from a shell of isotropic sources reaches its centre from all directions alike, so
    // a camera there sees φ/4π wherever it looks, without the pole of a point source and its infinite variance. At the
    // end of the medium, `half` away, the fluence falls to nothing, and that of the shell by e^{−2κ(half − 3r/2)} of
    // itself at most. The midpoints' error, of second order in a quarter of a voxel, is below 2·10⁻³ (a voxel is
    // at most a third of the shell's half width).
    let published = rows("point_source_infinite");
    let cases = [
        (0.5, 1.0, 6.0, 72, 100),
        (0.5, 2.0, 8.0, 48, 100),
        (0.99, 2.0, 26.0, 160, 16),
        (0.99, 5.0, 32.0, 78, 16),
    ];
    for (albedo, radius, half, n, samples) in cases {
        let row = published.iter().find(|row| row["w"] == albedo && row["r"] == radius).unwrap();
        assert!((fluence(albedo, radius) / row["phi"].as_f64().unwrap() - 1.0).abs() < 1e-12);
        let missing = (-2.0 * diffusion_exponent(albedo) * (half - 1.5 * radius)).exp();
        assert!(missing < 4e-4, "{missing}");
        let (found, exact) = shell(albedo, radius, half, n, samples);
        found.agrees(&format!("shell {albedo} {radius}"), exact, family(4), (2e-3 + missing) * exact);
    }
}
