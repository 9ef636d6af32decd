//! How pictures of photons converge: the bias of each kernel by the radius, the variance of a photon, and what both do over
//! passes whose radius shrinks (physics: bias k ε² ∇²E, variance ΔΦ E ∫K²; after n passes their means).

mod common;

use common::{close, device, report};
use std::f64::consts::PI;
use std::path::Path;
use svetlo::film::FilmPixel;
use svetlo::render::{BRICK_SHIFT, Plan, SceneData, Session};
use svetlo::scene::Scene;

/// A kernel: its second and fourth moments over those powers of the radius, and π ε² ∫K².
struct Kernel {
    name: &'static str,
    second: f64,
    fourth: f64,
    square: f64,
}

const CONE: Kernel = Kernel { name: "cone", second: 3.0 / 10.0, fourth: 1.0 / 7.0, square: 3.0 / 2.0 };
const KERNELS: [Kernel; 3] = [
    Kernel { name: "constant", second: 1.0 / 2.0, fourth: 1.0 / 3.0, square: 1.0 },
    CONE,
    Kernel { name: "smoothstep", second: 5.0 / 21.0, fourth: 5.0 / 54.0, square: 40.0 / 21.0 },
];

impl Kernel {
    /// What is gathered beyond E in the middle of a field: moments over 4 and 64 of its Laplacian and bilaplacian.
    fn bias(&self, radius: f64, laplacian: f64, bilaplacian: f64) -> f64 {
        let square = radius * radius;
        self.second / 4.0 * square * laplacian + self.fourth / 64.0 * square * square * bilaplacian
    }
}

/// Squares of the radii of the first passes.
fn squares(first: f64, alpha: f64, passes: u32) -> Vec<f64> {
    let mut square = first * first;
    (1..=passes)
        .map(|pass| {
            let now = square;
            square *= (f64::from(pass) + alpha) / f64::from(pass + 1);
            now
        })
        .collect()
}

fn session(text: &str) -> Session {
    let loaded = svetlo::config::parse("test.toml", text, &[]).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let scene = Scene::from_loaded(&loaded, Path::new("/")).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let data = SceneData::load(&scene).unwrap();
    Session::new(device(), &Plan::new(&scene, &data, BRICK_SHIFT).unwrap()).unwrap()
}

/// The irradiance that a white surface's pixels show.
fn irradiances(film: &[FilmPixel]) -> Vec<f64> {
    film.iter().map(|pixel| PI * pixel.mean()[0]).collect()
}

fn mean_square(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values.into_iter().fold((0.0, 0), |(sum, count), x| (sum + x * x, count + 1));
    sum / f64::from(count)
}

/// The slope of a line through points, by least squares in their logarithms.
fn slope(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let count = logs.len() as f64;
    let [x, y] =
        [logs.iter().map(|p| p.0).sum::<f64>() / count, logs.iter().map(|p| p.1).sum::<f64>() / count];
    let along: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    along / logs.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}

const WHITE: &str = "[[material]]\nname = \"white\"\nkind = \"diffuse\"\ncolor = 1\n";

/// The floor below a lamp of 1 W/sr at height 1, whose light comes by photons alone, seen in so many pixels of a square.
/// There E = (1 + r²)^(-3/2) = 1 − 3/2 r² + 15/8 r⁴ …, so that its Laplacian is −6 and its bilaplacian 120.
fn below_a_lamp(
    kernel: &str,
    (radius, alpha): (f64, f64),
    photons: u32,
    (pixels, extent): (u32, f64),
    seed: u32,
) -> Session {
    session(&format!(
        "seed = {seed}\n[image]\nwidth = {pixels}\nheight = {pixels}\nfilter = \"point\"\n\
         [camera]\nkind = \"orthographic\"\nposition = [0, 0, 0.5]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\nheight = {extent}\n\
         {WHITE}[[surface]]\nkind = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nmaterial = \"white\"\n\
         [[light]]\nkind = \"point\"\nposition = [0, 0, 1]\nintensity = 1\n\
         [method]\nkind = \"caustics\"\ndirect = \"photons\"\nbounces = 0\nphotons = {photons}\nradius = {radius}\n\
         alpha = {alpha}\ngather = {{ kernel = \"{kernel}\" }}\n\
         emission = {{ target = {{ centre = [0, 0, 0], edge_u = [1.2, 0, 0], edge_v = [0, 1.2, 0] }} }}\n"
    ))
}
/// The solid angle of a square of 1.2 seen from 1 above its middle.
fn below_a_lamp_flux() -> f64 {
    4.0 * (0.36 / (1.0 + 0.36 + 0.36_f64).sqrt()).atan()
}

#[test]
fn bias_and_variance_are_those_of_the_table() {
    const PHOTONS: u32 = 1 << 15;
    const PASSES: u32 = 16;
    for kernel in &KERNELS {
        for radius in [0.15, 0.3] {
            let mut session = below_a_lamp(kernel.name, (radius, 1.0), PHOTONS, (1, 1e-6), 1);
            session.render(PASSES).unwrap();
            let film = session.film().unwrap();
            let variance = film[0].variance().unwrap()[0] * PI * PI;
            let sigma = (variance / f64::from(PASSES)).sqrt();
            let (found, expected) = (irradiances(&film)[0] - 1.0, kernel.bias(radius, -6.0, 120.0));
            // The next term, of the sixth derivatives (−35/16 r⁶): at most that of the constant kernel, 1/4.
            let bound = 5.0 * sigma + 35.0 / 16.0 / 4.0 * radius.powi(6);
            let what = format!("bias of {} at {radius}", kernel.name);
            report(&what, (found - expected).abs() / expected.abs(), bound / expected.abs());
            close(&what, found, expected, bound);
            // Kernels differ by more than a quarter.
            assert!(bound < 0.1 * expected.abs(), "{what}: {bound} of {expected}");
            // Photons of a grid lie evenly: much less than by chance.
            let flux = below_a_lamp_flux() / f64::from(PHOTONS);
            let by_chance = flux * kernel.square / (PI * radius * radius);
            println!(
                "variance of {} at {radius}: {:.4} of that by chance",
                kernel.name,
                variance / by_chance
            );
            assert!(variance < 0.2 * by_chance, "{variance} of {by_chance}");
        }
    }
}

/// A sphere of white paint about a lamp of 1 W/sr, whose light is seen after one reflection: photons lie anywhere on the
/// sphere with the same chance, each for itself, and E = 1 everywhere.
fn globe(kernel: &str, alpha: f64, photons: u32, seed: u32) -> Session {
    session(&format!(
        "seed = {seed}\n[image]\nwidth = 10\nheight = 10\nfilter = \"point\"\n\
         [camera]\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nup = [0, 1, 0]\nfov = 100\n\
         {WHITE}[[surface]]\nkind = \"sphere\"\ncentre = [0, 0, 0]\nradius = 1\nmaterial = \"white\"\n\
         [[light]]\nkind = \"point\"\nposition = [0, 0, 0]\nintensity = 1\n\
         [method]\nkind = \"caustics\"\ndirect = \"none\"\nbounces = 1\nphotons = {photons}\nradius = 0.01\nbounce_radius = 0.05\n\
         alpha = {alpha}\ngather = {{ kernel = \"{kernel}\" }}\n"
    ))
}

/// Photons that lie by chance: the variance of a pass is that of the table, and that of the mean of n passes falls as their
/// radii say, n^-alpha in the end.
fn variance_falls(photons: u32, seeds: u32, stops: &[u32], kernels: &[Kernel], alphas: &[f64]) {
    for kernel in kernels {
        for &alpha in alphas {
            let last = *stops.last().unwrap();
            let squares = squares(0.05, alpha, last);
            let mut errors = vec![Vec::new(); stops.len()];
            for seed in 1..=seeds {
                let mut session = globe(kernel.name, alpha, photons, seed);
                for (&stop, errors) in stops.iter().zip(&mut errors) {
                    session.render(stop).unwrap();
                    errors.extend(irradiances(&session.film().unwrap()).into_iter().map(|found| found - 1.0));
                }
            }
            let mut points = Vec::new();
            for (&stop, errors) in stops.iter().zip(&errors) {
                let flux = 4.0 * PI / f64::from(photons);
                let passes = &squares[..stop as usize];
                let one_over: f64 = passes.iter().map(|square| 1.0 / square).sum();
                let expected = flux * kernel.square / PI * one_over / f64::from(stop).powi(2);
                let found = mean_square(errors.iter().copied());
                // Squares of what is nearly normal have the variance 2, and 3 over the photons in the radius more, of which
                // there are 5. Pixels are further apart than twice the radius, but for the corners.
                let sigma = (2.6 / errors.len() as f64).sqrt();
                let what = format!("variance of {} after {stop} passes, alpha {alpha:.2}", kernel.name);
                report(&what, (found / expected - 1.0).abs(), 5.0 * sigma);
                close(&what, found / expected, 1.0, 5.0 * sigma);
                points.push((f64::from(stop), found));
            }
            println!("{}, alpha {alpha:.2}: variance falls as n^{:.3}", kernel.name, slope(&points));
        }
    }
}

#[test]
fn variance_falls_as_the_radii_say() {
    // That of the other kernels is in device_photon_estimates.
    variance_falls(1 << 13, 5, &[1, 4, 16], &[CONE], &[2.0 / 3.0]);
}

#[test]
#[ignore = "minutes"]
fn variance_falls_as_the_radii_say_for_long() {
    variance_falls(1 << 14, 8, &[1, 2, 4, 8, 16, 32, 64, 128, 256], &KERNELS, &[2.0 / 3.0, 1.0]);
}

/// Below a lamp: the mean error of the middle is the bias of all radii so far, and the mean squared error falls as its square,
/// n^(2 alpha - 2) in the end, since that of photons from a grid is small beside it.
fn bias_falls(photons: u32, stops: &[u32]) {
    const ALPHA: f64 = 2.0 / 3.0;
    let last = *stops.last().unwrap();
    let squares = squares(0.3, ALPHA, last);
    let mut session = below_a_lamp(CONE.name, (0.3, ALPHA), photons, (4, 0.01), 5);
    let [mut found, mut expected] = [Vec::new(), Vec::new()];
    for &stop in stops {
        session.render(stop).unwrap();
        let film = session.film().unwrap();
        let errors: Vec<f64> = irradiances(&film).into_iter().map(|irradiance| irradiance - 1.0).collect();
        let passes = &squares[..stop as usize];
        let bias =
            passes.iter().map(|square| CONE.bias(square.sqrt(), -6.0, 120.0)).sum::<f64>() / f64::from(stop);
        found.push((f64::from(stop), mean_square(errors.iter().copied())));
        expected.push((f64::from(stop), bias * bias));
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        println!("after {stop}: error {mean:.5}, bias {bias:.5}, rms {:.5}", mean_square(errors).sqrt());
        // All pixels see the same photons, and the radius differs from pass to pass: by those by chance, a tenth of which
        // are too many (see above). Up to 1 - 3/2 0.005² of E besides.
        let flux = below_a_lamp_flux() / f64::from(photons);
        let by_chance = flux * CONE.square / PI * passes.iter().map(|square| 1.0 / square).sum::<f64>();
        let sigma = (0.2 * by_chance).sqrt() / f64::from(stop);
        close(&format!("error after {stop}"), mean, bias, 5.0 * sigma + 1e-4);
    }
    let [of_found, of_expected] = [slope(&found), slope(&expected)];
    println!("mean squared error falls as n^{of_found:.3}, squared bias as n^{of_expected:.3}");
    close("slope", of_found, of_expected, 0.1);
}

#[test]
fn bias_falls_as_the_radii_say() {
    bias_falls(1 << 14, &[1, 2, 4, 8, 16, 32]);
}

#[test]
#[ignore = "minutes"]
fn bias_falls_as_the_radii_say_for_long() {
    bias_falls(1 << 18, &[1, 2, 4, 8, 16, 32, 64, 128, 256]);
}
