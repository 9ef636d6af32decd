//! Raw types of `[medium]` and `[phase]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::values::{Albedo, Color, Radiance};

/// How the opacity of the transfer function becomes extinction: `mode = "extinction"` (default) or `"opacity"`;
/// and what of it the scattering methods scatter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "mode", rename_all = "lowercase", deny_unknown_fields)]
#[schemars(transform = super::schema::default_kind_first)]
pub enum MediumConfig {
    /// Extinction = opacity · sigma_max.
    Extinction {
        /// Extinction at opacity 1, per scene unit. Required for emission-absorption and the scattering methods.
        #[schemars(range(min = 0.0))]
        sigma_max: Option<f64>,
        /// Factor on the transfer function's colours, which are the single-scattering albedo (scattering methods only).
        #[serde(default = "white")]
        albedo: Albedo,
        /// Factor on the extinction per colour channel, not all 0 (scattering methods only). Default: 1.
        extinction_color: Option<Radiance>,
    },
    /// Opacity is what a layer of the reference length absorbs: extinction = -ln(1 - opacity) / reference_length.
    Opacity {
        /// Thickness of that layer in scene units. Default: the smallest spacing.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        reference_length: Option<f64>,
        /// Factor on the transfer function's colours, which are the single-scattering albedo (scattering methods only).
        #[serde(default = "white")]
        albedo: Albedo,
        /// Factor on the extinction per colour channel, not all 0 (scattering methods only). Default: 1.
        extinction_color: Option<Radiance>,
    },
}

impl Default for MediumConfig {
    fn default() -> Self {
        Self::Extinction { sigma_max: None, albedo: white(), extinction_color: None }
    }
}

/// Into which directions the medium scatters: `kind = "isotropic"` (default), `"henyey-greenstein"`, `"rayleigh"` or
/// `"two-lobe"`. Only the scattering methods use it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(transform = super::schema::default_kind_first)]
pub enum PhaseConfig {
    /// Into all directions alike.
    Isotropic {},
    /// The function of Henyey and Greenstein (1941).
    HenyeyGreenstein {
        /// Mean cosine of the angle by which light is deflected: more than 0 is forward.
        #[schemars(range(min = -0.999, max = 0.999))]
        g: f64,
    },
    /// By particles much smaller than the wavelength: 3/(16π) · (1 + cos²).
    Rayleigh {},
    /// Two Henyey-Greenstein functions, mixed.
    TwoLobe {
        /// Mean cosines of the two lobes.
        #[schemars(inner(range(min = -0.999, max = 0.999)))]
        g: [f64; 2],
        /// Weight of the first lobe; the second has the rest.
        #[schemars(range(min = 0.0, max = 1.0))]
        weight: f64,
    },
}

impl Default for PhaseConfig {
    fn default() -> Self {
        Self::Isotropic {}
    }
}

fn white() -> Albedo {
    Color([1.0; 3])
}
