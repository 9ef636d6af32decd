//! From opacity to extinction.

use crate::scene::Medium;

/// Opacities above this, 1 − 2⁻²⁰, count as this in opacity mode: opacity 1 would need infinite extinction.
pub const MOST_OPACITY: f64 = 1.0 - 1.0 / 1_048_576.0;

/// Extinction σₜ (per scene unit) at an opacity in 0..=1.
///
/// Extinction mode: σₜ = α·`sigma_max`. Opacity mode: σₜ = −log1p(−α)/ℓ with α ≤ [`MOST_OPACITY`], where ℓ is
/// the reference length, else `smallest_spacing` (scene units, > 0).
pub fn extinction(opacity: f64, medium: &Medium, smallest_spacing: f64) -> f64 {
    match *medium {
        Medium::Extinction { sigma_max } => opacity * sigma_max,
        Medium::Opacity { reference_length } => {
            -(-opacity.min(MOST_OPACITY)).ln_1p() / reference_length.unwrap_or(smallest_spacing)
        }
    }
}

/// `[r, g, b, σₜ]` for every `[r, g, b, opacity]`; σₜ per scene unit.
///
/// The conversion is per entry, and the renderer interpolates σₜ linearly between entries.
pub fn sigma_table(rgba: &[[f64; 4]], medium: &Medium, smallest_spacing: f64) -> Vec<[f64; 4]> {
    rgba.iter().map(|&[r, g, b, a]| [r, g, b, extinction(a, medium, smallest_spacing)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extinction_mode_is_proportional() {
        let medium = Medium::Extinction { sigma_max: 40.0 };
        assert_eq!([0.0, 0.25, 1.0].map(|a| extinction(a, &medium, 1.0)), [0.0, 10.0, 40.0]);
    }

    #[test]
    fn a_layer_of_the_reference_length_has_the_opacity() {
        let medium = Medium::Opacity { reference_length: Some(0.5) };
        // Opacity 1 - 1/e in half a unit: two per unit.
        let sigma = extinction(1.0 - (-1.0f64).exp(), &medium, 9.0);
        assert!((sigma - 2.0).abs() < 1e-15, "{sigma}");
        assert_eq!(extinction(0.0, &medium, 9.0), 0.0);
        // Tiny opacities keep their digits: -ln(1 - a) = a + a²/2.
        assert_eq!(extinction(1e-12, &Medium::Opacity { reference_length: None }, 1.0), 1e-12 + 5e-25);
    }

    #[test]
    fn opacity_one_is_bounded_and_the_default_length_is_the_spacing() {
        let medium = Medium::Opacity { reference_length: None };
        // -ln 2^-20 = 20 ln 2.
        let sigma = extinction(1.0, &medium, 0.25);
        assert!((sigma - 80.0 * std::f64::consts::LN_2).abs() < 1e-12, "{sigma}");
    }

    #[test]
    fn tables_keep_their_colours() {
        let table = sigma_table(&[[0.1, 0.2, 0.3, 0.5]], &Medium::Extinction { sigma_max: 2.0 }, 1.0);
        assert_eq!(table, [[0.1, 0.2, 0.3, 1.0]]);
    }
}
