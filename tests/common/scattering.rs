//! What the tests of the scattering methods share: the twin of a case, statistics of films, environment maps.

use super::Case;
use glam::DVec3;
use std::path::{Path, PathBuf};
use svetlo::film::FilmPixel;
use svetlo::picture::{Picture, write_exr};
use svetlo::reference::field::Field;
use svetlo::reference::scattering::{Estimate, Media, Tracer};
use svetlo::scene::Origin;

/// A case as the plain path tracer sees it; the scene must name its window.
pub struct Twin<'a> {
    case: &'a Case,
    field: Field,
    media: Media,
}

impl<'a> Twin<'a> {
    pub fn new(case: &'a Case) -> Self {
        let (scene, volume) = (&case.scene, &case.volume);
        let settings = scene.volume.as_ref().expect("a volume");
        let window = settings.window.expect("a window");
        let spacing = settings.spacing.unwrap_or(volume.spacing);
        let size = spacing * DVec3::from_array(volume.dims.map(|n| n as f64));
        let origin = match settings.origin {
            Origin::Corner(corner) => corner,
            Origin::Centre => size * -0.5,
        };
        let field = Field::new(volume, origin, spacing, window);
        let media = Media::new(scene, window, spacing.min_element()).unwrap();
        Self { case, field, media }
    }

    pub fn tracer(&self) -> Tracer<'_> {
        Tracer::new(&self.case.scene, &self.field, &self.media).unwrap()
    }

    /// Every pixel from some paths.
    pub fn image(&self, paths: u32) -> Vec<Estimate> {
        self.tracer().image(paths, 0x7717)
    }
}

/// A number with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    pub value: f64,
    pub error: f64,
}

impl Measured {
    /// Deviations from another number in units of both standard errors, and `slack` of known systematic error.
    pub fn deviation(&self, other: Measured, slack: f64) -> f64 {
        let difference = ((self.value - other.value).abs() - slack).max(0.0);
        let sigma = self.error.hypot(other.error);
        if difference == 0.0 { 0.0 } else { difference / sigma }
    }

    /// Asserts that it is `exact` within k standard errors and a systematic error, and prints how far it is.
    #[track_caller]
    pub fn agrees(&self, what: &str, exact: f64, k: f64, slack: f64) -> f64 {
        let z = self.deviation(Measured { value: exact, error: 0.0 }, slack);
        println!("{what}: {:.7} ± {:.1e}, exact {exact:.7}: {z:.2} σ of {k:.2}", self.value, self.error);
        assert!(z <= k, "{what}: found {self:?}, exact {exact}: {z:.2} σ > {k:.2} σ");
        z
    }
}

/// The mean over the pixels of a film and its standard error by their spread: for films whose pixels all estimate the
/// same number with independent random numbers. Every sample must have been finite.
#[track_caller]
pub fn over_pixels(film: &[FilmPixel], channel: usize) -> Measured {
    all_finite(film);
    of_values(&film.iter().map(|pixel| pixel.mean()[channel]).collect::<Vec<_>>())
}

/// Mean and its standard error by the spread of independent values.
pub fn of_values(values: &[f64]) -> Measured {
    let count = values.len() as f64;
    let value = values.iter().sum::<f64>() / count;
    let spread = values.iter().map(|x| (x - value).powi(2)).sum::<f64>() / (count - 1.0);
    Measured { value, error: (spread / count).sqrt() }
}

/// The mean over a film whose pixels differ; its standard error from the pixels' own variances, which stratified samples
/// make a little too large.
#[track_caller]
pub fn of_film<'a>(pixels: impl IntoIterator<Item = &'a FilmPixel>, channel: usize) -> Measured {
    let (mut value, mut square, mut count) = (0.0, 0.0, 0.0);
    for pixel in pixels {
        let variance = pixel.variance().expect("more than one sample")[channel];
        value += pixel.mean()[channel];
        square += variance / f64::from(pixel.count);
        count += 1.0;
    }
    Measured { value: value / count, error: square.sqrt() / count }
}

/// The mean over pixels of the twin.
pub fn of_twin<'a>(pixels: impl IntoIterator<Item = &'a Estimate>, channel: usize) -> Measured {
    let (mut value, mut square, mut count) = (0.0, 0.0, 0.0);
    for pixel in pixels {
        value += pixel.mean[channel];
        square += pixel.error[channel].powi(2);
        count += 1.0;
    }
    Measured { value: value / count, error: f64::sqrt(square) / count }
}

/// Asserts that no sample was refused and every mean is finite.
#[track_caller]
pub fn all_finite(film: &[FilmPixel]) {
    let refused = film.iter().map(|pixel| u64::from(pixel.rejected)).sum::<u64>();
    assert_eq!(refused, 0, "samples that are not finite");
    assert!(film.iter().all(|pixel| pixel.mean().iter().all(|x| x.is_finite())));
}

/// The indices of the pixels of each of n×n blocks of a square image.
pub fn blocks(side: usize, n: usize) -> Vec<Vec<usize>> {
    let edge = side / n;
    let block = |b: usize| {
        let (left, top) = (b % n * edge, b / n * edge);
        (0..edge * edge).map(|i| (top + i / edge) * side + left + i % edge).collect()
    };
    (0..n * n).map(block).collect()
}

/// Compares a film with the twin's image, both `side`² pixels, in n×n blocks of three channels: each within the k of as
/// many comparisons, and the blocks' sum of squares in each channel within what chance allows. Prints the result.
#[track_caller]
pub fn compare_blocks(what: &str, film: &[FilmPixel], twin: &[Estimate], side: usize, n: usize) {
    all_finite(film);
    let k = family(3 * n * n);
    let degrees = (n * n) as f64;
    let bound = chi_square(degrees, 4.0);
    let (mut squares, mut worst) = ([0.0; 3], 0.0_f64);
    for block in blocks(side, n) {
        for (channel, sum) in squares.iter_mut().enumerate() {
            let found = of_film(block.iter().map(|&i| &film[i]), channel);
            let exact = of_twin(block.iter().map(|&i| &twin[i]), channel);
            // Float32 sums of a sample: 32 roundings at most are systematic.
            let z = found.deviation(exact, 32.0 * super::EPS * exact.value);
            worst = worst.max(z);
            *sum += z * z;
            assert!(z <= k, "{what}, channel {channel}: {found:?} against {exact:?}: {z:.2} σ > {k:.2} σ");
        }
    }
    println!("{what}: worst {worst:.2} σ of {k:.2}, χ² {squares:.1?} of {bound:.1} at {degrees} degrees");
    assert!(squares.iter().all(|sum| *sum <= bound), "{what}: χ² {squares:?} > {bound} at {degrees} degrees");
}

/// The k for which one of n comparisons exceeds k standard errors by chance as rarely as a single one exceeds 3: in
/// 0.27 % of all runs.
pub fn family(comparisons: usize) -> f64 {
    let aim = 0.002_699_796 / comparisons as f64;
    let (mut low, mut high) = (2.0, 10.0);
    for _ in 0..60 {
        let k = 0.5 * (low + high);
        // The normal tail by its continued fraction.
        let fraction = (1..=40).rev().fold(k, |tail, i| k + f64::from(i) / tail);
        let tail = (-0.5 * k * k).exp() / (std::f64::consts::TAU.sqrt() * fraction);
        if 2.0 * tail > aim {
            low = k;
        } else {
            high = k;
        }
    }
    0.5 * (low + high)
}

/// The value that χ² exceeds as rarely as a normal number exceeds k, by Wilson and Hilferty (1931).
pub fn chi_square(degrees: f64, k: f64) -> f64 {
    let spread = 2.0 / (9.0 * degrees);
    degrees * (1.0 - spread + k * spread.sqrt()).powi(3)
}

/// Writes a map of `width` × `height` texels into a folder and returns its path.
pub fn write_map(
    folder: &Path,
    width: usize,
    height: usize,
    texel: impl Fn(usize, usize) -> [f32; 3],
) -> PathBuf {
    let texels: Vec<[f32; 3]> =
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).collect();
    let plane = |c: usize| texels.iter().map(|texel| texel[c]).collect::<Vec<f32>>();
    let picture = Picture::new(width, height)
        .with_channel("R", plane(0))
        .with_channel("G", plane(1))
        .with_channel("B", plane(2));
    let path = folder.join(format!("map_{width}x{height}.exr"));
    write_exr(&path, &picture).unwrap();
    path
}

/// A table of the published truths.
pub fn rows(table: &str) -> Vec<serde_json::Value> {
    let truths: serde_json::Value = serde_json::from_str(include_str!("../truths.json")).unwrap();
    truths[table]["rows"].as_array().unwrap().clone()
}
