//! The medium: how it extinguishes light, and how it scatters it.

use super::context::Context;
use crate::config::types::{MediumConfig, MethodConfig, PhaseConfig};

/// How opacity α becomes extinction σₜ (per scene unit).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Medium {
    /// σₜ = α · sigma_max.
    Extinction {
        /// Extinction at opacity 1, per scene unit, ≥ 0. 0 where the scene names none, which only methods
        /// that do not absorb allow.
        sigma_max: f64,
    },
    /// σₜ = −log1p(−α) / reference_length.
    Opacity {
        /// Scene units, > 0; the smallest spacing of the volume if `None`.
        reference_length: Option<f64>,
    },
}

/// What of a medium matters to the methods that scatter, per colour channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScatteringMedium {
    /// Factor on the transfer function's colours, 0..=1; the product is the single-scattering albedo.
    pub albedo: [f64; 3],
    /// Factor on σₜ, each ≥ 0 and one > 0; `None` if all are 1.
    pub extinction_color: Option<[f64; 3]>,
}

/// The phase function: density per steradian of the new direction, where μ is the cosine of the deflection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Phase {
    /// 1/(4π).
    Isotropic,
    /// (1 − g²) / (4π (1 + g² − 2gμ)^(3/2)).
    HenyeyGreenstein {
        /// The mean of μ, −0.999..=0.999.
        g: f64,
    },
    /// 3/(16π) · (1 + μ²).
    Rayleigh,
    /// Two Henyey–Greenstein functions, mixed.
    TwoLobe {
        /// Their means of μ, −0.999..=0.999.
        g: [f64; 2],
        /// Weight of the first, 0..=1; the second has the rest.
        weight: f64,
    },
}

impl Phase {
    /// The mean of μ.
    pub fn mean_cosine(&self) -> f64 {
        match *self {
            Self::Isotropic | Self::Rayleigh => 0.0,
            Self::HenyeyGreenstein { g } => g,
            Self::TwoLobe { g, weight } => weight * g[0] + (1.0 - weight) * g[1],
        }
    }

    /// Whether light is scattered into all directions alike.
    pub fn is_isotropic(&self) -> bool {
        match *self {
            Self::Isotropic => true,
            Self::Rayleigh => false,
            Self::HenyeyGreenstein { g } => g == 0.0,
            Self::TwoLobe { g, weight } => (g[0] == 0.0 || weight == 0.0) && (g[1] == 0.0 || weight == 1.0),
        }
    }
}

pub(super) fn medium(config: &MediumConfig, method: &MethodConfig, cx: &mut Context<'_>) -> Medium {
    match *config {
        MediumConfig::Opacity { reference_length, .. } => Medium::Opacity { reference_length },
        MediumConfig::Extinction { sigma_max, .. } => {
            if sigma_max.is_none() {
                missing_sigma_max(method, cx);
            }
            Medium::Extinction { sigma_max: sigma_max.unwrap_or(0.0) }
        }
    }
}

fn missing_sigma_max(method: &MethodConfig, cx: &mut Context<'_>) {
    let (name, question) = match method {
        MethodConfig::EmissionAbsorption { .. } => ("emission-absorption", "how much does opacity 1 absorb?"),
        MethodConfig::SingleScattering { .. } => ("single-scattering", "how dense is opacity 1?"),
        MethodConfig::MultipleScattering { .. } => ("multiple-scattering", "how dense is opacity 1?"),
        MethodConfig::ConvectionDiffusion { .. } => ("convection-diffusion", "how dense is opacity 1?"),
        MethodConfig::HybridDiffusion { .. } => ("hybrid-diffusion", "how dense is opacity 1?"),
        MethodConfig::Caustics { .. } if cx.has("volume") => {
            ("a volume among surfaces", "how dense is opacity 1?")
        }
        MethodConfig::Mip { .. } | MethodConfig::Isosurface { .. } | MethodConfig::Caustics { .. } => return,
    };
    let place = if cx.has("medium") { "medium" } else { "method.kind" };
    cx.wrong_with_help(
        place,
        format!("{name} needs `medium.sigma_max`"),
        question,
        "give `sigma_max`, the extinction at opacity 1 per scene unit, or `mode = \"opacity\"` in [medium]",
    );
}

pub(super) fn scattering(config: &MediumConfig, cx: &mut Context<'_>) -> ScatteringMedium {
    let (MediumConfig::Extinction { albedo, extinction_color, .. }
    | MediumConfig::Opacity { albedo, extinction_color, .. }) = config;
    let factors = extinction_color.map(|color| color.0);
    if factors == Some([0.0; 3]) {
        let message = "`medium.extinction_color` must not be black";
        cx.wrong("medium.extinction_color", message, "no channel would see the medium");
    }
    ScatteringMedium { albedo: albedo.0, extinction_color: factors.filter(|factors| *factors != [1.0; 3]) }
}

pub(super) fn phase(config: &PhaseConfig) -> Phase {
    match *config {
        PhaseConfig::Isotropic {} => Phase::Isotropic,
        PhaseConfig::HenyeyGreenstein { g } => Phase::HenyeyGreenstein { g },
        PhaseConfig::Rayleigh {} => Phase::Rayleigh,
        PhaseConfig::TwoLobe { g, weight } => Phase::TwoLobe { g, weight },
    }
}
