//! Checks of the path tracer: furnaces, slabs, transmittance, sunlight, and what it counts.
//!
//! The slabs are boxes 2·10³ times as wide as they are thick, seen in their middle, so that what leaves through a side
//! is below 10⁻⁶. By reciprocity the radiance that leaves a slab at a cosine, while radiance 1 comes from the whole
//! hemisphere on that side, is the part that it returns of collimated light at that cosine.

use super::workbench::{Case, Measurement, Rendered, Workbench, maximum, noise, volume};
use crate::picture::{Picture, write_exr};
use crate::volume::{Volume, Voxels};
use crate::{Error, Result};
use glam::DVec3;
use std::f64::consts::PI;

/// Pixels per edge of the slabs' pictures, all of which show the same.
const SIDE: usize = 64;
/// Samples of one path per pixel.
const SAMPLES: u32 = 256;
/// Their number.
const PATHS: f64 = (SIDE * SIDE) as f64 * SAMPLES as f64;
/// Layers of an uneven slab: three bricks.
const LAYERS: usize = 24;
/// What sides and the map's horizon let through.
const SYSTEMATIC: f64 = 2e-6;

/// Peaks within a few voxels, and gaps.
const BENT: &str = "points = [{ value = 0.2, opacity = 0 }, { value = 0.5, opacity = 1 }, { value = 0.6, opacity = 0.1 }, \
                    { value = 0.9, opacity = 0.1 }, { value = 1, opacity = 0.7 }]";

fn noisy_scene(rest: &str) -> Result<Case> {
    let text = format!(
        "[image]\nwidth = 24\nheight = 24\n[camera]\nposition = [34, 21, -19]\ntarget = [6, 6, 6]\nfov = 28\n\
         [volume]\nwindow = {{ lo = 0, hi = 1 }}\n[transfer]\n{BENT}\n[phase]\nkind = \"henyey-greenstein\"\n\
         g = 0.8\n[background]\ncolor = 1\n[method]\nkind = \"multiple-scattering\"\n{rest}\n"
    );
    Case::new(&text, volume([12, 13, 11], noise(12 * 13 * 11, 5))?)
}

/// Light of radiance 1 from everywhere, and nothing absorbed: every pixel is 1.
pub fn furnace(bench: &Workbench) -> Result<Vec<Measurement>> {
    let rendered = bench.render(&noisy_scene("[medium]\nsigma_max = 1.5")?, 4)?;
    Ok(vec![Measurement::within(
        "white furnace: largest error of a pixel",
        rendered.largest_error(0..3, 1.0),
        0.0,
        1e-6,
        "rounding of the paths' float32 weights",
    )])
}

/// A published slab: reflectance and transmittance of collimated light at cosine 1 (adding–doubling and discrete
/// ordinates agree to all digits).
struct Published {
    tau: f64,
    albedo: f64,
    g: f64,
    reflected: f64,
    transmitted: f64,
}

const SLAB: Published = Published {
    tau: 2.0,
    albedo: 0.9,
    g: 0.75,
    reflected: 0.097_394_638_671,
    transmitted: 0.660_957_700_163,
};

impl Published {
    /// Seen from above under a map that is red above, green below.
    fn render(&self, bench: &Workbench, layers: &Layers) -> Result<Rendered> {
        let folder = tempfile::tempdir()
            .map_err(|error| Error::Failed(format!("cannot make a temporary folder: {error}")))?;
        let map = folder.path().join("hemispheres.exr");
        write_exr(&map, &hemispheres())?;
        let text = format!(
            "{}[medium]\nsigma_max = {}\nalbedo = {}\n[phase]\nkind = \"henyey-greenstein\"\ng = {}\n\
             [background]\nenvironment = '{}'\nsampling = \"escape\"\n\
             [method]\nkind = \"multiple-scattering\"\npaths = 1\n",
            layers.seen_at(1.0),
            layers.sigma_max(self.tau),
            self.albedo,
            self.g,
            map.display()
        );
        bench.render(&Case::new(&text, layers.volume()?)?, SAMPLES)
    }

    fn measurements(&self, rendered: &Rendered) -> Vec<Measurement> {
        let Self { tau, albedo, g, .. } = self;
        // A path brings at most 1, and roulette on one colour shows in the other: the larger variance holds for both.
        let variance = |mean: f64| mean * (1.0 - mean);
        let sigma = (variance(self.reflected).max(variance(self.transmitted)) / PATHS).sqrt();
        let row = |name: &str, channel: usize, exact: f64| {
            let what = format!("{name} of depth {tau}, albedo {albedo}, g {g}");
            let why = format!("binomial, {:.1} million paths", PATHS / 1e6);
            Measurement::mean(what, rendered.mean(channel), exact, sigma, SYSTEMATIC, &why)
        };
        vec![row("reflectance", 0, self.reflected), row("transmittance", 1, self.transmitted)]
    }
}

/// Red above the horizon, green below; many rows, because texels blend into each other.
fn hemispheres() -> Picture {
    const ROWS: usize = 4096;
    let half = |upper: f32, lower: f32| {
        (0..ROWS).map(|y| if y < ROWS / 2 { upper } else { lower }).collect::<Vec<f32>>()
    };
    Picture::new(1, ROWS)
        .with_channel("R", half(1.0, 0.0))
        .with_channel("G", half(0.0, 1.0))
        .with_channel("B", half(1.0, 1.0))
}

/// A slab of thickness 1 whose extinction depends on its depth alone.
struct Layers {
    values: Vec<f64>,
    /// A transfer function.
    transfer: &'static str,
    /// The opacity in the mean over the depth.
    mean: f64,
}

impl Layers {
    fn even() -> Self {
        Self { values: vec![1.0], transfer: "resolution = 2", mean: 1.0 }
    }

    /// A third is empty, the rest uneven; the opacity is the value.
    fn uneven() -> Self {
        let values: Vec<f64> = noise(LAYERS, 77)
            .iter()
            .enumerate()
            .map(|(i, v)| if (7..16).contains(&i) { 0.0 } else { f64::from((v * v) as f32) })
            .collect();
        // Linear between centres, constant beyond the outer ones: the mean over the depth is that of the values.
        let mean = values.iter().sum::<f64>() / LAYERS as f64;
        Self { values, transfer: "resolution = 2", mean }
    }

    /// Values that run through a transfer function with kinks within a voxel.
    fn bent() -> Self {
        let values: Vec<f64> = (0..LAYERS).map(|i| [0.0, 1.0, 0.25][i % 3]).collect();
        let transfer = "resolution = 5\npoints = [{ value = 0, opacity = 0 }, { value = 0.25, opacity = 1 }, \
                        { value = 0.5, opacity = 0.25 }, { value = 0.75, opacity = 0 }, { value = 1, opacity = 0.5 }]";
        // Trapezoids between 0, ¼, ½, ¾ and 1: from 0 to 1 a mean of 0.375, between 0 and ¼ of ½, from 1 to ¼
        // of (0.25 + 0.125 + 0.625) / 3. The outer half voxels are 0 and 0.25.
        let steps: [f64; 3] = [0.375, (0.25 + 0.125 + 0.625) / 3.0, 0.5];
        let inner: f64 = (0..LAYERS - 1).map(|i| steps[i % 3]).sum();
        let mean = (inner + 0.5 * (0.0 + 1.0)) / LAYERS as f64;
        Self { values, transfer, mean }
    }

    fn sigma_max(&self, tau: f64) -> f64 {
        tau / self.mean
    }

    fn volume(&self) -> Result<Volume> {
        let values: Vec<f32> = self.values.iter().map(|&value| value as f32).collect();
        Volume::new([1, self.values.len(), 1], DVec3::ONE, Voxels::F32(values))
            .map_err(|error| Error::Failed(format!("the self-test's slab: {error}")))
    }

    /// A parallel view of the slab's middle from above, at the cosine `mu` to its normal.
    fn seen_at(&self, mu: f64) -> String {
        let sine = (1.0 - mu * mu).sqrt();
        format!(
            "[image]\nwidth = {SIDE}\nheight = {SIDE}\n[camera]\nkind = \"orthographic\"\nposition = {:?}\n\
             target = [0, 0, 0]\nup = [0, 0, 1]\nheight = 1\n\
             [volume]\norigin = \"centre\"\nspacing = [2e3, {}, 2e3]\nwindow = {{ lo = 0, hi = 1 }}\n\
             [transfer]\n{}\n",
            [10.0 * sine, 10.0 * mu, 0.0],
            1.0 / self.values.len() as f64,
            self.transfer
        )
    }
}

/// The published slab as a constant medium, in closed form.
pub fn slab(bench: &Workbench) -> Result<Vec<Measurement>> {
    Ok(SLAB.measurements(&SLAB.render(bench, &Layers::even())?))
}

/// The published slab as a grid, by null collisions.
pub fn grid(bench: &Workbench) -> Result<Vec<Measurement>> {
    let rendered = SLAB.render(bench, &Layers::uneven())?;
    let null = rendered.paths.null_collisions() as f64 / rendered.paths.paths as f64;
    let mut measurements = SLAB.measurements(&rendered);
    for measurement in &mut measurements {
        measurement.quantity += &format!(", {null:.1} null collisions a path");
    }
    Ok(measurements)
}

/// A black slab with kinks in its transfer function, seen at an angle before light 1.
pub fn tracking(bench: &Workbench) -> Result<Vec<Measurement>> {
    let (layers, tau, mu) = (Layers::bent(), 0.7, 0.6);
    let exact = f64::exp(-tau / mu);
    let sigma = (exact * (1.0 - exact) / PATHS).sqrt();
    let row = |estimator: &str| -> Result<Measurement> {
        let text = format!(
            "{}[medium]\nsigma_max = {}\nalbedo = 0\n[background]\ncolor = 1\n\
             [method]\nkind = \"multiple-scattering\"\ntransmittance = \"{estimator}\"\npaths = 1\n",
            layers.seen_at(mu),
            layers.sigma_max(tau)
        );
        let found = bench.render(&Case::new(&text, layers.volume()?)?, SAMPLES)?.mean(1);
        Ok(Measurement::mean(
            format!("transmittance by {estimator} tracking"),
            found,
            exact,
            sigma,
            SYSTEMATIC,
            "binomial, what rays bring lies between 0 and 1",
        ))
    };
    ["analog", "ratio", "auto"].into_iter().map(row).collect()
}

/// Light straight down into the kinked slab, seen at an angle: L = ϖE/4π (1 − e^(−τ(1 + 1/μ))) / (1 + μ).
pub fn sunlight(bench: &Workbench) -> Result<Vec<Measurement>> {
    let (layers, tau, mu, albedo, irradiance) = (Layers::bent(), 0.8, 0.6, 0.8, 4.0 * PI);
    let text = format!(
        "{}[medium]\nsigma_max = {}\nalbedo = {albedo}\n[[light]]\nkind = \"directional\"\ndirection = [0, -1, 0]\n\
         irradiance = {irradiance}\n[method]\nkind = \"single-scattering\"\npaths = 1\n",
        layers.seen_at(mu),
        layers.sigma_max(tau)
    );
    let found = bench.render(&Case::new(&text, layers.volume()?)?, SAMPLES)?.mean(1);
    // What a path can bring: all of it scattered once, the light not weakened.
    let most = albedo * irradiance / (4.0 * PI);
    let exact = most * -f64::exp_m1(-tau * (1.0 + 1.0 / mu)) / (1.0 + mu);
    Ok(vec![Measurement::mean(
        "radiance at 53° under a sun at the zenith",
        found,
        exact,
        (exact * (most - exact) / PATHS).sqrt(),
        SYSTEMATIC,
        "what paths bring lies between 0 and ϖE/4π",
    )])
}

/// Sun, lamp and rectangle on a noisy medium: what the renderer counts about itself.
pub fn audit(bench: &Workbench) -> Result<Vec<Measurement>> {
    let case = noisy_scene(
        "[medium]\nsigma_max = 1.5\nalbedo = [0.9, 0.5, 0.99]\n\
         [[light]]\nkind = \"directional\"\ndirection = [1, -2, 0.5]\nirradiance = 3\n\
         [[light]]\nkind = \"point\"\nposition = [15, 6, 6]\nintensity = 40\n\
         [[light]]\nkind = \"rectangle\"\ncentre = [6, 18, 6]\nedge_u = [4, 0, 0]\nedge_v = [0, 0, 4]\nradiance = 2",
    )?;
    let rendered = bench.render(&case, 8)?;
    let refused: u64 = rendered.film.iter().map(|pixel| u64::from(pixel.rejected)).sum();
    let paths = &rendered.paths;
    let count = |what: &str, n: u64| Measurement::exact(what, n as f64, 0.0);
    Ok(vec![
        count(&format!("look-ups above the majorant, of {}", paths.lookups), paths.above_majorant),
        count("samples with paths that did not end", paths.unfinished),
        count("samples that are not finite", refused),
        Measurement::within(
            "energy missing per path",
            maximum(paths.imbalance().abs(), 0.0),
            0.0,
            1e-6,
            "rounding of the paths' float32 weights",
        ),
    ])
}
