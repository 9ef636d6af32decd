//! Colours of wavelengths, as `cl/caustics/spectrum.cl` has them.

/// Wavelengths of photons where an index depends on them, nm.
pub const WAVELENGTHS: [f64; 2] = [380.0, 730.0];

/// Steps of the integral over wavelengths: of 0.1 nm, against bells of 12 nm and more.
const STEPS: u32 = 3500;

/// A bell around `middle` with another width on each side.
fn bell(nanometres: f64, [middle, below, above]: [f64; 3]) -> f64 {
    let x = nanometres - middle;
    (-0.5 * (x / if x < 0.0 { below } else { above }).powi(2)).exp()
}

/// The colour matching functions of the CIE 1931 at a wavelength in nm, by the fits of Wyman, Sloan and Shirley 2013
/// ("Simple Analytic Approximations to the CIE XYZ Color Matching Functions"), as linear sRGB: channels may be negative.
pub fn color_of(nanometres: f64) -> [f64; 3] {
    let bell = |shape| bell(nanometres, shape);
    let x = 1.056 * bell([599.8, 37.9, 31.0]) + 0.362 * bell([442.0, 16.0, 26.7])
        - 0.065 * bell([501.1, 20.4, 26.2]);
    let y = 0.821 * bell([568.8, 46.9, 40.5]) + 0.286 * bell([530.9, 16.3, 31.1]);
    let z = 1.217 * bell([437.0, 11.8, 36.0]) + 0.681 * bell([459.0, 26.0, 13.8]);
    [
        3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
        -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
        0.0556434 * x - 0.2040259 * y + 1.0572252 * z,
    ]
}

/// The mean colour of photons whose wavelengths are spread evenly: what makes them white.
pub fn mean_color() -> [f64; 3] {
    let [low, high] = WAVELENGTHS;
    let mut sum = [0.0; 3];
    for step in 0..STEPS {
        let color = color_of(low + (high - low) * (f64::from(step) + 0.5) / f64::from(STEPS));
        sum = std::array::from_fn(|c| sum[c] + color[c]);
    }
    sum.map(|total| total / f64::from(STEPS))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fits_are_near_the_published_functions() {
        // CIE 1931 at 450, 520, 555 and 600 nm; the fits err by up to 0.03.
        let published = [
            (450.0, [0.3362, 0.0380, 1.7721]),
            (520.0, [0.0633, 0.7100, 0.0782]),
            (555.0, [0.5121, 1.0000, 0.0057]),
            (600.0, [1.0622, 0.6310, 0.0008]),
        ];
        for (nanometres, xyz) in published {
            let [r, g, b] = color_of(nanometres);
            // Linear sRGB back to XYZ (IEC 61966-2-1).
            let found = [
                0.4124564 * r + 0.3575761 * g + 0.1804375 * b,
                0.2126729 * r + 0.7151522 * g + 0.0721750 * b,
                0.0193339 * r + 0.1191920 * g + 0.9503041 * b,
            ];
            for (found, xyz) in found.into_iter().zip(xyz) {
                assert!((found - xyz).abs() < 0.03, "{nanometres} nm: {found}, published {xyz}");
            }
        }
    }

    #[test]
    fn equal_energy_is_nearly_the_white_of_the_cie() {
        // X = Y = Z there, 106.9 nm in all: the linear sRGB of (1, 1, 1) is (1.205, 0.948, 0.909).
        let mean = mean_color();
        for (found, expected) in mean.into_iter().zip([1.2048, 0.9483, 0.9089]) {
            let expected = expected * 106.86 / 350.0;
            assert!((found / expected - 1.0).abs() < 0.02, "{mean:?}");
        }
    }
}
