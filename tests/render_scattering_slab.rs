//! Slabs seen by a camera: hemispherical reflectance and transmittance against published rows.
//!
//! By reciprocity the part of collimated light at the cosine μ₀ that a slab returns equals the radiance that leaves it
//! at μ₀ when radiance 1 comes from the whole hemisphere on that side; with radiance 1 on the far side it is the part
//! that gets through, scattered or not. One picture measures both: the map is red above, green below and blue
//! everywhere, so R = reflectance, G = transmittance, and B = R + G, what is not absorbed.
//!
//! The slab is one voxel of 2·10⁴ × 1 × 2·10⁴. All pixels look at its middle along one direction, so each estimates
//! the same number wherever it lies: light that leaves through a side has gone X = 10⁴ thicknesses first. A single
//! flight of that kind stays within 1/X of the horizontal and is not stopped: probability τ/X·e^{−τX}, at most
//! 1/(e X²) = 4·10⁻⁹; many flights lose a factor e^{−πX/(τ+1.42)τ} by the slowest mode of a slab, below 10⁻¹⁰⁰ even at
//! τ = 1000. The map is bilinear: of its 4096 rows, the middle ones blend over δ = π/8192 of cosine. Light leaves near
//! the horizon with a density below 2μI, I < 3, or τ/2 where τ is small: what is seen in the wrong colour is below
//! max(I δ²/6, τ δ/8) = 10⁻⁷.

mod common;

use common::scattering::{Measured, all_finite, family, over_pixels, rows, write_map};
use common::{Case, report, volume_f32};
use std::path::Path;
use svetlo::film::FilmPixel;
use svetlo::reference::half_space::h_function;
use svetlo::reference::slab::Slab;

/// Sides, and the map's horizon.
const SYSTEMATIC: f64 = 1e-7 + 4e-9;
/// Pixels per side of the picture.
const SIDE: u32 = 64;

/// A row of the table.
#[derive(Debug, Clone, Copy)]
struct Row {
    slab: Slab,
    mu: f64,
    reflected: f64,
    transmitted: f64,
}

fn published() -> Vec<Row> {
    let row = |row: &serde_json::Value| {
        let [tau, albedo, g, mu, reflected, transmitted] =
            ["tau", "albedo", "g", "mu0", "R", "T"].map(|key| row[key].as_f64().unwrap());
        Row { slab: Slab { tau, albedo, g }, mu, reflected, transmitted }
    };
    rows("slab_collimated").iter().map(row).collect()
}

impl Row {
    /// A slab outside the table, by adding–doubling.
    fn computed(tau: f64, albedo: f64, g: f64, mu: f64) -> Self {
        let slab = Slab { tau, albedo, g };
        let response = slab.responses(&[mu])[0];
        Self { slab, mu, reflected: response.reflected, transmitted: response.transmitted }
    }

    fn name(&self) -> String {
        let Slab { tau, albedo, g } = self.slab;
        format!("tau {tau}, albedo {albedo}, g {g}, mu {}", self.mu)
    }

    /// Variances of one path, for R and T: without roulette, and where absorption ends paths. A path's weight is ϖⁿ
    /// after n scatterings, its square that of a path through a slab of albedo ϖ²: R(ϖ²) − R(ϖ)². A path that is absorbed
    /// or not brings 0 or 1: R(1 − R). Roulette lies between.
    fn variances(&self) -> ([f64; 2], [f64; 2]) {
        let squared = Slab { albedo: self.slab.albedo.powi(2), ..self.slab }.responses(&[self.mu])[0];
        let (r, t) = (self.reflected, self.transmitted);
        ([squared.reflected - r * r, squared.transmitted - t * t], [r * (1.0 - r), t * (1.0 - t)])
    }

    /// The standard error that the full-size test goes to.
    fn aim(&self) -> f64 {
        if self.slab.tau >= 100.0 { 1e-4 } else { 2e-5 }
    }

    /// Paths after which the standard error is at most `aim`, by the larger variance.
    fn paths(&self) -> f64 {
        let [r, t] = self.variances().1;
        r.max(t) / self.aim().powi(2)
    }

    /// Collisions of a path, roughly: what is absorbed over 1 − ϖ, or without absorption the mean path through a
    /// convex body in isotropic light, 4V/S.
    fn collisions(&self) -> f64 {
        let Slab { tau, albedo, .. } = self.slab;
        let absorbed = 1.0 - self.reflected - self.transmitted;
        if albedo < 1.0 { absorbed / (1.0 - albedo) } else { 2.0 * tau }
    }

    /// The slab as a scene; rows with seeds of their own have independent errors.
    fn case(&self, map: &Path, seed: usize) -> Case {
        let Slab { tau, albedo, g } = self.slab;
        let sine = f64::sqrt(1.0 - self.mu * self.mu);
        let text = format!(
            "seed = {seed}\n[image]\nwidth = {SIDE}\nheight = {SIDE}\n[camera]\nkind = \"orthographic\"\nposition = {:?}\n\
             target = [0, 0, 0]\nup = [0, 0, 1]\nheight = 1\n\
             [volume]\norigin = \"centre\"\nspacing = [2e4, 1, 2e4]\nwindow = {{ lo = 0, hi = 1 }}\n\
             [medium]\nsigma_max = {tau}\nalbedo = {albedo}\n[phase]\nkind = \"henyey-greenstein\"\ng = {g}\n\
             [transfer]\nresolution = 2\npoints = [{{ value = 0, opacity = 1, color = 1 }}]\n\
             [background]\nenvironment = '{}'\nsampling = \"escape\"\n\
             [method]\nkind = \"multiple-scattering\"\npaths = 1\n",
            [10.0 * sine, 10.0 * self.mu, 0.0],
            map.display()
        );
        Case::new(&text, volume_f32([1, 1, 1], [0.5]))
    }
}

/// A map that is red above, green below and blue everywhere.
fn hemispheres() -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let map =
        write_map(folder.path(), 1, 4096, |_, y| if y < 2048 { [1.0, 0.0, 1.0] } else { [0.0, 1.0, 1.0] });
    (folder, map)
}

/// Reflectance and transmittance of a film, which must be those of the row within `k`; returns the squared deviations.
fn check(row: &Row, film: &[FilmPixel], k: f64) -> f64 {
    let name = row.name();
    let reflected = over_pixels(film, 0).agrees(&format!("{name}: R"), row.reflected, k, SYSTEMATIC);
    let transmitted = over_pixels(film, 1).agrees(&format!("{name}: T"), row.transmitted, k, SYSTEMATIC);
    // What is red or green is blue: rounding of each colour's mean, a two-float sum of float32 samples.
    for pixel in film {
        let [r, g, b, _] = pixel.mean();
        assert!((r + g - b).abs() < 4e-7, "{name}: {r} + {g} is not {b}");
        // Without absorption every path comes out with all its light.
        assert!(row.slab.albedo < 1.0 || (b - 1.0).abs() < 1e-6, "{name}: {b}");
    }
    reflected * reflected + transmitted * transmitted
}

#[test]
fn reflectance_and_transmittance_are_as_published() {
    let (_folder, map) = hemispheres();
    let table = published();
    let k = family(2 * table.len());
    for (seed, row) in table.iter().enumerate() {
        // The same work for each row: 3·10⁷ collisions, at most 2.6·10⁶ paths.
        let pixels = f64::from(SIDE * SIDE);
        let samples = (3e7 / (pixels * (1.0 + row.collisions()))).clamp(4.0, 640.0) as u32;
        let film = row.case(&map, seed).film_of(samples);
        check(row, &film, k);
        // The spread over the pixels is the paths' variance; 5σ of 4095 degrees. Light is counted from the map's mean, so
        // roulette on one colour shows in the other: the larger of the bounds holds for both.
        let (least, most) = row.variances();
        let most = most[0].max(most[1]);
        // Where few paths bring anything, their number is Poisson's.
        let paths = pixels * f64::from(samples);
        let bound = most * (1.0 + 5.0 * (2.0 / (pixels - 1.0)).sqrt()) + 5.0 * (most / paths).sqrt();
        for (channel, least) in least.into_iter().enumerate() {
            let variance = over_pixels(&film, channel).error.powi(2) * paths;
            println!("  variance {variance:.6}, without roulette {least:.6}, bound {bound:.6}");
            assert!(variance <= bound, "{}: {variance} > {bound}", row.name());
        }
    }
}

#[test]
fn slabs_outside_the_table_agree_too() {
    let (_folder, map) = hemispheres();
    let table = [
        Row::computed(3.7, 0.97, -0.6, 0.45),
        Row::computed(0.3, 0.8, 0.9, 0.15),
        Row::computed(8.0, 0.6, 0.3, 0.8),
    ];
    for (seed, row) in table.iter().enumerate() {
        check(row, &row.case(&map, seed).film_of(100), family(6));
    }
}

#[test]
fn thick_slabs_without_absorption_pass_what_the_milne_problem_says() {
    let (_folder, map) = hemispheres();
    for (seed, mu) in [1.0, 0.5, 0.1].into_iter().enumerate() {
        // T(μ) = H(μ) / (√3 (τ + 2·0.710446)), up to terms of e^{−τ}.
        let transmitted = h_function(1.0, mu) / (3f64.sqrt() * (40.0 + 2.0 * 0.710_446_09));
        let slab = Slab { tau: 40.0, albedo: 1.0, g: 0.0 };
        let row = Row { slab, mu, reflected: 1.0 - transmitted, transmitted };
        check(&row, &row.case(&map, seed).film_of(40), family(6));
    }
}

/// The accuracy that the rows are published for: `cargo test --release --test render_scattering_slab -- --ignored`.
#[test]
#[ignore = "minutes"]
fn reflectance_and_transmittance_are_as_published_to_five_digits() {
    let (_folder, map) = hemispheres();
    let table = published();
    let k = family(2 * table.len());
    let mut squares = 0.0;
    for (seed, row) in table.iter().enumerate() {
        println!("{}: {:.1e} paths for a standard error of {:.0e}", row.name(), row.paths(), row.aim());
        let samples = (row.paths() / f64::from(SIDE * SIDE)).ceil() as u32;
        let film = row.case(&map, seed).film_of(samples);
        squares += check(row, &film, k);
        for channel in 0..2 {
            let Measured { error, .. } = over_pixels(&film, channel);
            // The spread of 4096 pixels knows it to 1.1 %.
            report(&format!("{}: standard error", row.name()), error, 1.05 * row.aim());
            assert!(error <= 1.05 * row.aim(), "{error} > {}", row.aim());
        }
        all_finite(&film);
    }
    let bound = common::scattering::chi_square(2.0 * table.len() as f64, 3.0);
    assert!(squares < bound, "χ² {squares} > {bound}");
}
