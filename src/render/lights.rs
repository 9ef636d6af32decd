//! Lights as the kernels see them; see `cl/types/light.cl`.

use super::local::{LocalFrame, float4};
use crate::device_struct;
use crate::scene::Light;
use bytemuck::Zeroable;
use glam::DVec3;

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
