//! The rendering method.

use super::caustics::{self, Caustics};
use super::context::Context;
use super::light_volume::{self, LightVolume};
use crate::config::types::{ColorMap, Compositing, Domain, MethodConfig, QuadratureConfig, Transmittance};

/// A rendering method and its parameters.
#[derive(Debug, Clone, PartialEq)]
pub enum Method {
    /// The largest value along each ray.
    Mip {
        /// How that value becomes a colour.
        color: MipColor,
    },
    /// The first surface of constant value along each ray.
    Isosurface {
        /// The value of the surface, in the unit of `domain`.
        value: f64,
        /// The unit of `value`.
        domain: Domain,
        /// How the surface is shaded.
        material: Material,
    },
    /// The volume glows and absorbs.
    EmissionAbsorption {
        /// L₀: the radiance that the transfer function's colours are scaled by, ≥ 0.
        radiance: f64,
        /// How the integral along a ray is computed.
        quadrature: Quadrature,
        /// A ray stops when its transmittance is below this, 0..1 exclusive of 1; 0 is never.
        termination: f64,
    },
    /// The volume scatters light.
    Scattering(Scattering),
    /// The volume scatters light, which is computed in its cells and projected.
    LightVolume(LightVolume),
    /// Surfaces, and the light that mirrors and glass bring together.
    Caustics(Caustics),
}

/// What the scattering methods share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scattering {
    /// How often light is scattered.
    pub orders: Orders,
    /// How the transmittance between two points is estimated.
    pub transmittance: Transmittance,
    /// Factor on the majorants, 1..=64.
    pub majorant_scale: f64,
    /// Paths per sample, 1..=64; the renderer's choice if `None`.
    pub paths: Option<u32>,
}

/// How often light is scattered on its way to the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Orders {
    /// Once.
    Single,
    /// Any number of times.
    Multiple {
        /// At most this often, ≥ 1; without limit if `None`.
        max: Option<u32>,
    },
}

/// How a maximum projection is coloured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MipColor {
    /// The value times this linear colour, components 0..1.
    Scaled([f64; 3]),
    /// The value looked up in a map.
    Map(ColorMap),
}

/// Local shading of a surface: ambient, Lambert and Blinn–Phong terms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Linear albedo, components 0..1.
    pub color: [f64; 3],
    /// Factor of the constant term, ≥ 0.
    pub ambient: f64,
    /// Factor of the Lambertian term, ≥ 0.
    pub diffuse: f64,
    /// Factor of the Blinn–Phong term, ≥ 0.
    pub specular: f64,
    /// Exponent of the Blinn–Phong term, ≥ 0.
    pub shininess: f64,
}

/// How the emission–absorption integral along a ray is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Quadrature {
    /// Exactly per cell of the trilinear field.
    Cell,
    /// Midpoint rule.
    Step {
        /// In units of the smallest spacing, 0 < step ≤ 64.
        step: f64,
        /// A random phase per ray.
        jitter: bool,
        /// How extinction and step become opacity.
        compositing: Compositing,
    },
}

pub(super) fn method(config: &MethodConfig, cx: &mut Context<'_>) -> Method {
    if let Some(settings) = caustics::caustics(config, cx) {
        return Method::Caustics(settings);
    }
    match *config {
        MethodConfig::EmissionAbsorption { radiance, quadrature, step, jitter, compositing, termination } => {
            let quadrature = match quadrature {
                QuadratureConfig::Cell => cell(cx),
                QuadratureConfig::Step => Quadrature::Step {
                    step: step.unwrap_or(0.5),
                    jitter: jitter.unwrap_or(true),
                    compositing: compositing.unwrap_or_default(),
                },
            };
            Method::EmissionAbsorption { radiance, quadrature, termination }
        }
        MethodConfig::Mip { color, colormap } => {
            if colormap.is_some() {
                cx.useless("method.color", "does not go with `method.colormap`", "give one of the two");
            }
            let white = MipColor::Scaled(color.map_or([1.0; 3], |color| color.0));
            Method::Mip { color: colormap.map_or(white, MipColor::Map) }
        }
        MethodConfig::Isosurface { value, domain, color, ambient, diffuse, specular, shininess } => {
            normalized_value(value, domain, "method.value", "method.domain", cx);
            let material = Material { color: color.0, ambient, diffuse, specular, shininess };
            Method::Isosurface { value, domain, material }
        }
        MethodConfig::SingleScattering { transmittance, majorant_scale, paths } => {
            Method::Scattering(Scattering { orders: Orders::Single, transmittance, majorant_scale, paths })
        }
        MethodConfig::MultipleScattering { max_order: max, transmittance, majorant_scale, paths } => {
            let orders = Orders::Multiple { max };
            Method::Scattering(Scattering { orders, transmittance, majorant_scale, paths })
        }
        MethodConfig::ConvectionDiffusion { .. } | MethodConfig::HybridDiffusion { .. } => {
            Method::LightVolume(light_volume::light_volume(config, cx))
        }
        MethodConfig::Caustics { .. } => unreachable!("handled above"),
    }
}

/// True if the method follows paths from the camera, and so can make auxiliary images.
pub(super) fn follows_paths(config: &MethodConfig) -> bool {
    matches!(config, MethodConfig::SingleScattering { .. } | MethodConfig::MultipleScattering { .. })
}

fn cell(cx: &mut Context<'_>) -> Quadrature {
    for key in ["method.step", "method.jitter", "method.compositing"] {
        cx.useless(key, "needs `method.quadrature = \"step\"`", "the quadrature per cell has no steps");
    }
    Quadrature::Cell
}

/// Data units written where 0..1 is meant are the commonest mistake with windows: say so.
pub(super) fn normalized_value(
    value: f64,
    domain: Domain,
    path: &str,
    domain_path: &str,
    cx: &mut Context<'_>,
) {
    if domain == Domain::Normalized && !(0.0..=1.0).contains(&value) {
        let help = format!("for values in data units, set `{domain_path}` to \"data\"");
        cx.wrong_with_help(
            path,
            format!("`{path}` is outside the window"),
            "must be at least 0 and at most 1",
            &help,
        );
    }
}
