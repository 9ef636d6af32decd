//! Lights as the kernels see them, and how likely each is to be sampled; see `cl/types/light.cl`, `cl/lights/`.

mod environment;
#[cfg(test)]
mod tests;

use super::local::{LocalFrame, float4};
use super::method::{DeviceFrame, HostBuffer};
use crate::device_struct;
use crate::picture::Environment;
use crate::scene::{Background, EnvironmentSampling, Light};
use bytemuck::Zeroable;
use environment::mean;
use glam::DVec3;
use std::f64::consts::PI;

/// A map whose brightest texel exceeds its mean by this factor is sampled, others are left to the rays that escape:
/// the relative variance of a direction drawn blindly is at most that factor less one, so up to here a few dozen paths
/// even it out, and each spares a search of the table and a shadow ray.
const IMPORTANCE_CONTRAST: f64 = 8.0;

device_struct! {
    "types/light.cl",
    /// A light, in local units; see `cl/types/light.cl`.
    pub struct DeviceLight {
        /// Position or direction of travel; w: the kind of light.
        pub position: [f32; 4],
        /// Intensity over local units squared, radiance or irradiance; w: the probability that it is picked.
        pub power: [f32; 4],
        /// Rectangle: an edge; w, any light: the sum of the probabilities up to this light.
        pub edge_u: [f32; 4],
        /// Rectangle: the other edge; w: the area.
        pub edge_v: [f32; 4],
        /// Rectangle: the unit normal of the side that shines; w: 0.
        pub normal: [f32; 4],
    }
}

impl DeviceLight {
    const DIRECTIONAL: f64 = 0.0;
    const POINT: f64 = 1.0;
    const HEADLIGHT: f64 = 2.0;
    const RECTANGLE: f64 = 3.0;

    /// The light in local units; no kernel picks it yet.
    pub fn new(light: &Light, local: &LocalFrame) -> Self {
        let color = |c: &[f64; 3]| float4(DVec3::from_array(*c), 0.0);
        let none = Self::zeroed();
        match light {
            Light::Point { position, intensity } => Self {
                position: float4(local.point(*position), Self::POINT),
                power: color(&intensity.map(|i| i / (local.unit * local.unit))),
                ..none
            },
            Light::Directional { direction, irradiance } => Self {
                position: float4(direction.normalize(), Self::DIRECTIONAL),
                power: color(irradiance),
                ..none
            },
            Light::Rectangle { centre, edge_u, edge_v, radiance } => {
                let (u, v) = (*edge_u / local.unit, *edge_v / local.unit);
                let normal = u.cross(v);
                Self {
                    position: float4(local.point(*centre), Self::RECTANGLE),
                    power: color(radiance),
                    edge_u: float4(u, 0.0),
                    edge_v: float4(v, normal.length()),
                    normal: float4(normal.normalize(), 0.0),
                }
            }
        }
    }

    /// A light that shines along each view ray.
    pub fn headlight(irradiance: f32) -> Self {
        Self {
            position: float4(DVec3::ZERO, Self::HEADLIGHT),
            power: [irradiance, irradiance, irradiance, 0.0],
            ..Self::zeroed()
        }
    }
}

/// What a scattering kernel reads to sample lights.
///
/// Kernels take the two buffers of [`Lights::buffers`] and the fields that [`Lights::describe`] sets in the frame.
/// They may call `light_sample` where [`Lights::sampled`], and need `RECTANGLES` defined where
/// [`Lights::has_rectangles`] and `ENVIRONMENT` where the scene has a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Lights {
    /// The lights that shine, rectangles first.
    pub lights: Vec<DeviceLight>,
    /// Which of the scene's lights each of them is.
    pub sources: Vec<usize>,
    /// The environment map's table; empty where the map is not sampled.
    pub environment_sums: Vec<f32>,
    /// The probability of picking the environment map; 0 where it is not sampled.
    pub environment_pick: f32,
    /// How the scene is lit, one sentence each.
    pub details: Vec<String>,
}

impl Lights {
    /// The lights of a scene: `environment` is the map that its `background` names.
    pub fn new(
        lights: &[Light],
        background: &Background,
        environment: Option<&Environment>,
        local: &LocalFrame,
    ) -> Self {
        let mut details = Vec::new();
        let sky = environment.and_then(|map| sampled_environment(background, map, &mut details));
        let bounds = Bounds::new(local);
        let mut shining: Vec<(usize, f64)> =
            lights.iter().map(|light| bounds.flux(light)).enumerate().collect();
        shining.retain(|(_, flux)| *flux > 0.0);
        shining.sort_by_key(|(source, _)| !matches!(lights[*source], Light::Rectangle { .. }));
        let mut fluxes: Vec<f64> = shining.iter().map(|(_, flux)| *flux).collect();
        fluxes.extend(sky.map(|(_, radiance)| bounds.flux_of_sky(radiance)));
        let sums = if fluxes.is_empty() { Vec::new() } else { environment::probability_sums(&fluxes) };
        let before = |i: usize| if i == 0 { 0.0 } else { sums[i - 1] };
        let device_light = |(i, &(source, _)): (usize, &(usize, f64))| {
            let mut light = DeviceLight::new(&lights[source], local);
            light.power[3] = sums[i] - before(i);
            light.edge_u[3] = sums[i];
            light
        };
        let device: Vec<DeviceLight> = shining.iter().enumerate().map(device_light).collect();
        let environment_pick = sky.map_or(0.0, |_| 1.0 - before(shining.len()));
        if !device.is_empty() {
            details.push(shares(&device, environment_pick));
        }
        Self {
            sources: shining.iter().map(|(source, _)| *source).collect(),
            lights: device,
            environment_sums: sky.map_or_else(Vec::new, |(map, _)| environment::table(map)),
            environment_pick,
            details,
        }
    }

    /// Whether there is anything to sample.
    pub fn sampled(&self) -> bool {
        !self.lights.is_empty() || self.environment_pick > 0.0
    }

    /// Whether rays can meet a rectangle.
    pub fn has_rectangles(&self) -> bool {
        self.rectangle_count() > 0
    }

    fn rectangle_count(&self) -> usize {
        self.lights.iter().take_while(|light| f64::from(light.position[3]) == DeviceLight::RECTANGLE).count()
    }

    /// Tells the kernels how many lights there are.
    pub fn describe(&self, frame: &mut DeviceFrame) {
        frame.light_count = self.lights.len() as u32;
        frame.rectangle_count = self.rectangle_count() as u32;
        frame.environment_pick = self.environment_pick;
    }

    /// The lights and the environment map's table; one unused entry where there is none, as buffers are not empty.
    pub fn buffers(&self) -> [HostBuffer; 2] {
        let lights = if self.lights.is_empty() { &[DeviceLight::zeroed()] } else { &self.lights[..] };
        let sums = if self.environment_sums.is_empty() { &[0.0] } else { &self.environment_sums[..] };
        [HostBuffer::new("lights", lights), HostBuffer::new("environment map's probabilities", sums)]
    }
}

/// The map and its mean radiance, when kernels shall sample it.
fn sampled_environment<'a>(
    background: &Background,
    map: &'a Environment,
    details: &mut Vec<String>,
) -> Option<(&'a Environment, f64)> {
    let &Background::Environment { intensity, sampling, .. } = background else { return None };
    let brightness = environment::brightness(map);
    let radiance = intensity * brightness.mean;
    if radiance <= 0.0 {
        details.push("the environment map is black".into());
        return None;
    }
    let contrast = brightness.largest / brightness.mean;
    let sampled = match sampling {
        EnvironmentSampling::Auto => contrast > IMPORTANCE_CONTRAST,
        EnvironmentSampling::Escape => false,
        EnvironmentSampling::Importance => true,
    };
    let way =
        if sampled { "directions are drawn from it" } else { "it lights by the rays that escape alone" };
    details.push(format!("the environment map's brightest texel has {contrast:.1} times its mean: {way}"));
    sampled.then_some((map, radiance))
}

/// The sphere around the volume, scene units.
struct Bounds {
    centre: DVec3,
    radius: f64,
}

impl Bounds {
    fn new(local: &LocalFrame) -> Self {
        let half = 0.5 * local.unit * local.size();
        Self { centre: local.origin + half, radius: half.length() }
    }

    /// The flux of a light that reaches the sphere, roughly: 0 only for a light that is black.
    fn flux(&self, light: &Light) -> f64 {
        let disc = PI * self.radius * self.radius;
        match *light {
            Light::Directional { irradiance, .. } => mean(irradiance) * disc,
            Light::Point { position, intensity } => {
                let sine2 = self.sine2(position);
                // The cone's solid angle 2 pi (1 - cos), without cancellation; all directions from inside.
                let cone =
                    if sine2 < 1.0 { 2.0 * PI * sine2 / (1.0 + (1.0 - sine2).sqrt()) } else { 4.0 * PI };
                mean(intensity) * cone
            }
            Light::Rectangle { centre, edge_u, edge_v, radiance } => {
                let normal = edge_u.cross(edge_v);
                let sine2 = self.sine2(centre);
                // The irradiance of the cone, were its axis the direction to the sphere's centre; a light that is turned
                // away may still light a part of the volume.
                let facing = (self.centre - centre).normalize_or_zero().dot(normal) / normal.length();
                let part = if sine2 < 1.0 { sine2 * facing.max(0.25 * sine2.sqrt()) } else { 1.0 };
                // Half of the directions at most hold the rectangle: pi L of irradiance, on 2 pi R^2 of the sphere.
                PI * mean(radiance) * (normal.length() * part).min(2.0 * disc)
            }
        }
    }

    fn flux_of_sky(&self, radiance: f64) -> f64 {
        4.0 * PI * PI * self.radius * self.radius * radiance
    }

    /// Squared sine of the angle under which the sphere's radius is seen; 1 from inside.
    fn sine2(&self, from: DVec3) -> f64 {
        let distance2 = (self.centre - from).length_squared();
        let radius2 = self.radius * self.radius;
        if distance2 > radius2 { radius2 / distance2 } else { 1.0 }
    }
}

/// How often each light is picked.
fn shares(lights: &[DeviceLight], environment_pick: f32) -> String {
    const MOST: usize = 8;
    let percent = |pick: f32| format!("{:.3} %", 100.0 * pick);
    let mut parts: Vec<String> = lights
        .iter()
        .take(MOST)
        .map(|light| {
            let kind = match f64::from(light.position[3]) {
                DeviceLight::RECTANGLE => "rectangle",
                DeviceLight::POINT => "point",
                _ => "directional",
            };
            format!("{kind} {}", percent(light.power[3]))
        })
        .collect();
    if lights.len() > MOST {
        parts.push(format!(
            "{} more {}",
            lights.len() - MOST,
            percent(lights[MOST..].iter().map(|l| l.power[3]).sum())
        ));
    }
    if environment_pick > 0.0 {
        parts.push(format!("environment {}", percent(environment_pick)));
    }
    format!("light samples by power: {}", parts.join(", "))
}
