//! Radiance that a volume scatters, by a plain Monte Carlo path tracer.
//!
//! It is another estimator than the kernels', so that the two agree only when both are right: free flights by delta
//! tracking under one majorant for the whole volume, the transmittance to lights by quadrature (for transfer functions of
//! the value), the environment only by
//! rays that leave, textbook phase functions, and where the extinction differs between channels, a path per channel.

mod directions;
mod environment;
mod homogeneous;

pub use directions::{phase_value, sample_phase};
pub use environment::EnvironmentMap;
pub use homogeneous::HomogeneousBox;

use super::camera::{Ray, ray as camera_ray};
use super::emission_absorption::Integrator;
use super::field::Field;
use super::medium::Medium;
use super::random::philox4x32;
use crate::Result;
use crate::scene::{Background, Filter, Light, Method, Orders, ScatteringMedium, Scene, Transfer};
use crate::transfer::{TransferFunction1d, TransferFunction2d};
use glam::DVec3;
use rayon::prelude::*;

/// Paths whose weights are all below this are ended at random, three of four.
const LIGHT: f64 = 0.02;

/// Independent numbers in [0, 1), 32 bits each: a counter per path.
pub struct Random {
    key: [u32; 2],
    counter: [u32; 4],
    words: Vec<u32>,
}

impl Random {
    /// The numbers of a path of a pixel.
    pub fn new(seed: u32, pixel: u32, path: u32) -> Self {
        Self { key: [seed, 0x7721], counter: [0, pixel, path, 0], words: Vec::new() }
    }

    /// The next number.
    pub fn uniform(&mut self) -> f64 {
        if self.words.is_empty() {
            self.words = philox4x32(self.counter, self.key).to_vec();
            self.counter[0] += 1;
        }
        let word = self.words.pop().unwrap_or_default();
        (f64::from(word) + 0.5) / 4_294_967_296.0
    }
}

/// Radiance per channel.
type Rgb = [f64; 3];

fn add(sum: &mut Rgb, weight: Rgb, value: Rgb) {
    for c in 0..3 {
        sum[c] += weight[c] * value[c];
    }
}

/// Mean of many paths and its standard error, per channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The mean.
    pub mean: Rgb,
    /// Its standard error.
    pub error: Rgb,
}

/// What is behind everything.
enum Surroundings {
    Constant(Rgb),
    Map(EnvironmentMap),
}

/// The media of a scene: its transfer function as colour and extinction, as extinction alone, and as emission.
pub struct Media {
    scattering: Medium,
    /// Without colour: only depths are integrated along it.
    black: Medium,
    /// Emission Lₑ, as the colour of a medium of extinction 1.
    emission: Option<Medium>,
}

impl Media {
    /// The media of a scene: `window` in data units, `smallest_spacing` in scene units.
    ///
    /// # Errors
    /// [`crate::Error::Input`] when a table cannot be read.
    pub fn new(scene: &Scene, window: (f64, f64), smallest_spacing: f64) -> Result<Self> {
        let scattering = Medium::new(&scene.transfer, &scene.medium, window, smallest_spacing)?;
        let emission = match &scene.transfer {
            Transfer::OneD(settings) => TransferFunction1d::from_settings(settings, window).emission,
            Transfer::TwoD(settings) => TransferFunction2d::from_settings(settings)?.emission,
        };
        let with = |entries: Vec<[f64; 4]>| Medium { entries, ..scattering.clone() };
        let black = with(scattering.entries.iter().map(|entry| [0.0, 0.0, 0.0, entry[3]]).collect());
        let emission = emission.map(|table| with(table.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect()));
        Ok(Self { scattering, black, emission })
    }
}

/// A scene to be traced.
pub struct Tracer<'a> {
    scene: &'a Scene,
    field: &'a Field,
    media: &'a Media,
    depths: Integrator<'a>,
    surroundings: Surroundings,
    majorant: f64,
    most_scatterings: u32,
}

impl<'a> Tracer<'a> {
    /// Prepares `scene`, which must have a scattering method.
    ///
    /// # Errors
    /// [`crate::Error::Input`] when the method is another or the environment map cannot be read.
    pub fn new(scene: &'a Scene, field: &'a Field, media: &'a Media) -> Result<Self> {
        let Method::Scattering(method) = &scene.method else {
            return Err(crate::Error::Input("the path tracer is for scattering methods".into()));
        };
        let surroundings = match &scene.background {
            Background::Constant(color) => Surroundings::Constant(*color),
            Background::Environment { path, intensity, rotation, .. } => {
                Surroundings::Map(EnvironmentMap::read(path, *intensity, *rotation)?)
            }
        };
        Ok(Self {
            scene,
            field,
            media,
            depths: Integrator::new(field, &media.black),
            surroundings,
            majorant: media.scattering.entries.iter().map(|entry| entry[3]).fold(0.0, f64::max),
            most_scatterings: match method.orders {
                Orders::Single => 1,
                Orders::Multiple { max } => max.unwrap_or(u32::MAX),
            },
        })
    }

    /// Every pixel of the scene's image from `paths` paths (at least 2), row by row.
    pub fn image(&self, paths: u32, seed: u32) -> Vec<Estimate> {
        let image = self.scene.image;
        (0..image.width * image.height)
            .into_par_iter()
            .map(|pixel| {
                let samples = (0..paths).map(|path| {
                    let mut random = Random::new(seed, pixel, path);
                    let at = match image.filter {
                        Filter::Box => [random.uniform(), random.uniform()],
                        Filter::Point => [0.5; 2],
                    };
                    let place = [pixel % image.width, pixel / image.width];
                    self.radiance(camera_ray(&self.scene.camera, &image, place, at, [0.0; 2]), &mut random)
                });
                estimate(samples)
            })
            .collect()
    }

    /// One sample of the radiance that comes along a camera ray.
    pub fn radiance(&self, ray: Ray, random: &mut Random) -> Rgb {
        match self.scene.scattering.extinction_color {
            None => self.path(ray, 1.0, [1.0; 3], random),
            Some(factors) => {
                let mut sum = [0.0; 3];
                for (c, factor) in factors.into_iter().enumerate() {
                    let only = std::array::from_fn(|k| if k == c { 1.0 } else { 0.0 });
                    add(&mut sum, [1.0; 3], self.path(ray, factor, only, random));
                }
                sum
            }
        }
    }

    /// A path through a medium of `factor` times the extinction, that carries `weight`.
    fn path(&self, mut ray: Ray, factor: f64, mut weight: Rgb, random: &mut Random) -> Rgb {
        let ScatteringMedium { albedo: scale, .. } = self.scene.scattering;
        let mut sum = [0.0; 3];
        for scatterings in 0.. {
            for light in &self.scene.lights {
                add(&mut sum, weight, self.seen(light, &ray, factor, random));
            }
            let Some(point) = self.collision(&ray, factor, random) else {
                add(&mut sum, weight, self.background(ray.direction));
                return sum;
            };
            let gradient = self.gradient(point);
            let value = self.field.value(point);
            let [r, g, b, sigma] = self.media.scattering.at(value, gradient);
            let albedo: Rgb = std::array::from_fn(|c| scale[c] * [r, g, b][c] / sigma);
            if let Some(emission) = &self.media.emission {
                let [r, g, b, _] = emission.at(value, gradient);
                let absorbed: Rgb = std::array::from_fn(|c| weight[c] * (1.0 - albedo[c]));
                add(&mut sum, absorbed, [r, g, b]);
            }
            if scatterings == self.most_scatterings {
                return sum;
            }
            for c in 0..3 {
                weight[c] *= albedo[c];
            }
            for light in &self.scene.lights {
                add(&mut sum, weight, self.lit(light, point, ray.direction, factor, random));
            }
            let most = weight.into_iter().fold(0.0, f64::max);
            if most < LIGHT {
                if random.uniform() < 0.75 || most == 0.0 {
                    return sum;
                }
                weight = weight.map(|w| 4.0 * w);
            }
            let direction = sample_phase(&self.scene.phase, ray.direction, random);
            ray = Ray { origin: point, direction, start: 0.0 };
        }
        sum
    }

    /// Where the ray collides with the medium: delta tracking (Woodcock and others 1965).
    fn collision(&self, ray: &Ray, factor: f64, random: &mut Random) -> Option<DVec3> {
        let (mut t, end) = self.field.clip(ray)?;
        loop {
            t -= random.uniform().ln() / (self.majorant * factor);
            // Nothing is dense enough where the majorant is 0: t is infinite.
            if t >= end {
                return None;
            }
            let point = ray.at(t);
            if random.uniform() * self.majorant
                < self.media.scattering.at(self.field.value(point), self.gradient(point))[3]
            {
                return Some(point);
            }
        }
    }

    fn gradient(&self, point: DVec3) -> f64 {
        if self.media.scattering.gradients == 1 { 0.0 } else { self.field.gradient(point).length() }
    }

    /// exp(−∫σ) along a ray over a distance, which may be infinite. A depth through a function of the gradient takes
    /// thousands of gradients: there, whether a collision happens.
    fn transmittance(&self, ray: &Ray, distance: f64, factor: f64, random: &mut Random) -> f64 {
        if self.media.scattering.gradients > 1 {
            let hit = self.collision(ray, factor, random);
            return if hit.is_some_and(|point| point.distance(ray.origin) < distance) { 0.0 } else { 1.0 };
        }
        let behind = if distance.is_finite() { self.depth(&Ray { start: distance, ..*ray }) } else { 0.0 };
        (-factor * (self.depth(ray) - behind)).exp()
    }

    /// ∫σ along a ray, without the factors of channels.
    pub fn depth(&self, ray: &Ray) -> f64 {
        self.depths.ray(ray).depth
    }

    /// Radiance of a light that a ray looks at, through what lies between: only rectangles have a face.
    fn seen(&self, light: &Light, ray: &Ray, factor: f64, random: &mut Random) -> Rgb {
        let Light::Rectangle { centre, edge_u, edge_v, radiance } = *light else { return [0.0; 3] };
        let normal = edge_u.cross(edge_v);
        let t = (centre - ray.origin).dot(normal) / ray.direction.dot(normal);
        if ray.direction.dot(normal) >= 0.0 || t <= ray.start {
            return [0.0; 3];
        }
        // Coordinates in the plane from −½ to ½, also for edges that are not perpendicular.
        let place = ray.at(t) - centre;
        let square = normal.length_squared();
        let (u, v) = (place.cross(edge_v).dot(normal) / square, edge_u.cross(place).dot(normal) / square);
        if u.abs() > 0.5 || v.abs() > 0.5 {
            return [0.0; 3];
        }
        let transmittance = self.transmittance(ray, t, factor, random);
        radiance.map(|l| l * transmittance)
    }

    /// What a light without a face adds to the radiance that leaves `point` against `direction`, per albedo. Rectangles
    /// are seen by the rays that go on: next to one, the light of a place chosen on it has an infinite variance.
    fn lit(&self, light: &Light, point: DVec3, direction: DVec3, factor: f64, random: &mut Random) -> Rgb {
        let (to_light, distance, irradiance) = match *light {
            Light::Point { position, intensity } => {
                let to = position - point;
                (to.normalize(), to.length(), intensity.map(|i| i / to.length_squared()))
            }
            Light::Directional { direction, irradiance } => (-direction, f64::INFINITY, irradiance),
            Light::Rectangle { .. } => return [0.0; 3],
        };
        let phase = phase_value(&self.scene.phase, direction.dot(to_light));
        let way = Ray { origin: point, direction: to_light, start: 0.0 };
        let part = phase * self.transmittance(&way, distance, factor, random);
        irradiance.map(|e| e * part)
    }

    fn background(&self, direction: DVec3) -> Rgb {
        match &self.surroundings {
            Surroundings::Constant(color) => *color,
            Surroundings::Map(map) => map.radiance(direction),
        }
    }
}

/// Mean and standard error of samples.
pub fn estimate(samples: impl Iterator<Item = Rgb>) -> Estimate {
    let (mut count, mut mean, mut m2) = (0.0, [0.0; 3], [0.0; 3]);
    for sample in samples {
        count += 1.0;
        for c in 0..3 {
            let delta = sample[c] - mean[c];
            mean[c] += delta / count;
            m2[c] += delta * (sample[c] - mean[c]);
        }
    }
    Estimate { mean, error: m2.map(|m2: f64| (m2 / (count * (count - 1.0))).sqrt()) }
}
