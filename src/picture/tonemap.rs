//! From linear radiance to the 8 bits of a screen: exposure, curve, encoding, in this order.
//!
//! | field      | meaning                                   | default  |
//! |------------|-------------------------------------------|----------|
//! | `exposure` | factor on the linear values               | 1        |
//! | `curve`    | [`Curve`], linear to display-linear [0,1] | `Linear` |
//! | `encoding` | [`Encoding`], display-linear to code      | `Srgb`   |
//!
//! The curves act on each channel alone, so very bright colours tend to white.

use std::fmt;
use std::str::FromStr;

/// How unbounded values are brought to [0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Curve {
    /// Cut at 1.
    #[default]
    Linear,
    /// x/(1+x): Reinhard et al., *Photographic Tone Reproduction for Digital Images* (2002), eq. 3.
    Reinhard,
    /// Hable, *Uncharted 2: HDR Lighting* (GDC 2010): f(2x)/f(W) with the talk's constants, its
    /// exposure bias of 2 and its white point W = 11.2, so that x = 5.6 becomes 1.
    Filmic,
}

/// How display-linear values are coded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Encoding {
    /// The piecewise transfer function of IEC 61966-2-1.
    #[default]
    Srgb,
    /// y = x^(1/γ), γ > 0.
    Gamma(f64),
}

/// A tone mapping, applied per pixel to linear RGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tonemap {
    /// How unbounded values are brought to [0, 1].
    pub curve: Curve,
    /// Factor on the linear values, before the curve.
    pub exposure: f64,
    /// How the result is coded.
    pub encoding: Encoding,
}

impl Default for Tonemap {
    fn default() -> Self {
        Self { curve: Curve::Linear, exposure: 1.0, encoding: Encoding::Srgb }
    }
}

/// As headers of images have it: `filmic, exposure 0.5, gamma 2.2`.
impl fmt::Display for Tonemap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let curve = CURVES.iter().find(|(_, curve)| *curve == self.curve).map_or("", |(name, _)| name);
        write!(f, "{curve}, exposure {}, ", self.exposure)?;
        match self.encoding {
            Encoding::Srgb => write!(f, "srgb"),
            Encoding::Gamma(gamma) => write!(f, "gamma {gamma}"),
        }
    }
}

impl FromStr for Tonemap {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = || {
            let (name, rest) = text.split_once(", exposure ")?;
            let (exposure, encoding) = rest.split_once(", ")?;
            let positive = |text: &str| text.parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0);
            let encoding = match encoding.strip_prefix("gamma ") {
                Some(gamma) => Encoding::Gamma(positive(gamma)?),
                None => (encoding == "srgb").then_some(Encoding::Srgb)?,
            };
            let curve = CURVES.iter().find(|(known, _)| *known == name)?.1;
            Some(Self { curve, exposure: positive(exposure)?, encoding })
        };
        parsed().ok_or_else(|| format!("`{text}` is no tone mapping"))
    }
}

const CURVES: [(&str, Curve); 3] =
    [("linear", Curve::Linear), ("reinhard", Curve::Reinhard), ("filmic", Curve::Filmic)];

/// The colour of a pixel with a value that is not finite: magenta, so that it is seen.
pub const BAD_PIXEL: [u8; 3] = [255, 0, 255];

impl Tonemap {
    /// One linear pixel as 8-bit code values. Negative values become 0; a pixel with a value that
    /// is not finite becomes [`BAD_PIXEL`].
    pub fn pixel(&self, linear: [f32; 3]) -> [u8; 3] {
        if linear.iter().all(|value| value.is_finite()) {
            linear.map(|value| quantise(self.encoded(f64::from(value))))
        } else {
            BAD_PIXEL
        }
    }

    /// One linear value as a code value in [0, 1].
    pub fn encoded(&self, linear: f64) -> f64 {
        let exposed = (linear * self.exposure).max(0.0);
        let display = self.curve.apply(exposed).clamp(0.0, 1.0);
        match self.encoding {
            Encoding::Srgb => srgb_encode(display),
            Encoding::Gamma(gamma) => display.powf(gamma.recip()),
        }
    }
}

impl Curve {
    /// The display-linear value of a linear `x` ≥ 0; above 1 where the curve does not bound it.
    pub fn apply(self, x: f64) -> f64 {
        match self {
            Self::Linear => x,
            // x/(1+x) would be ∞/∞ where the exposure made x infinite.
            Self::Reinhard => 1.0 - (1.0 + x).recip(),
            Self::Filmic => hable(2.0 * x) / hable(11.2),
        }
    }
}

/// Hable's curve. Past 10⁶ it is within 10⁻⁵ of its asymptote; stopping there avoids ∞/∞.
fn hable(x: f64) -> f64 {
    const SHOULDER: f64 = 0.15;
    const LINEAR: f64 = 0.50;
    const LINEAR_ANGLE: f64 = 0.10;
    const TOE: f64 = 0.20;
    const TOE_NUMERATOR: f64 = 0.02;
    const TOE_DENOMINATOR: f64 = 0.30;
    let x = x.min(1e6);
    let numerator = x * (SHOULDER * x + LINEAR_ANGLE * LINEAR) + TOE * TOE_NUMERATOR;
    let denominator = x * (SHOULDER * x + LINEAR) + TOE * TOE_DENOMINATOR;
    numerator / denominator - TOE_NUMERATOR / TOE_DENOMINATOR
}

/// A code value in [0, 1] as the nearest of 256; NaN becomes 0.
pub(super) fn quantise(code: f64) -> u8 {
    (code.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// sRGB code value of a display-linear value in [0, 1] (IEC 61966-2-1).
pub fn srgb_encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Display-linear value of an sRGB code value in [0, 1] (IEC 61966-2-1).
pub fn srgb_decode(code: f64) -> f64 {
    if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[track_caller]
    fn close(a: f64, b: f64, tolerance: f64) {
        assert!((a - b).abs() <= tolerance, "{a} and {b}");
    }

    #[test]
    fn tone_mappings_are_written_as_they_are_read() {
        let gamma = Tonemap { curve: Curve::Filmic, exposure: 1.0 / 3.0, encoding: Encoding::Gamma(2.2) };
        assert!(gamma.to_string().ends_with(", gamma 2.2"), "{gamma}");
        let reinhard = Tonemap { curve: Curve::Reinhard, ..Tonemap::default() };
        for tonemap in [Tonemap::default(), reinhard, gamma] {
            assert_eq!(tonemap.to_string().parse(), Ok(tonemap));
        }
        for text in [
            "",
            "linear",
            "cubic, exposure 1, srgb",
            "linear, exposure 0, srgb",
            "linear, exposure 1, gamma x",
        ] {
            assert!(text.parse::<Tonemap>().unwrap_err().contains("is no tone mapping"), "{text}");
        }
    }

    #[test]
    fn srgb_has_its_published_points_and_inverts() {
        assert_eq!(srgb_encode(0.0), 0.0);
        close(srgb_encode(1.0), 1.0, 1e-12);
        // 1.055·0.18^(1/2.4) − 0.055 = 0.461356, and ((128/255 + 0.055)/1.055)^2.4 = 0.2158605.
        close(srgb_encode(0.18), 0.461_356, 1e-6);
        close(srgb_decode(128.0 / 255.0), 0.215_860_5, 1e-6);
        for code in 0..=255_u8 {
            assert_eq!(quantise(srgb_encode(srgb_decode(f64::from(code) / 255.0))), code);
        }
    }

    #[test]
    fn curves_have_their_known_points() {
        assert_eq!(Curve::Linear.apply(0.3), 0.3);
        close(Curve::Reinhard.apply(1.0), 0.5, 1e-15);
        close(Curve::Reinhard.apply(3.0), 0.75, 1e-15);
        assert_eq!(Curve::Reinhard.apply(f64::INFINITY), 1.0);
        close(Curve::Filmic.apply(0.0), 0.0, 1e-15);
        close(Curve::Filmic.apply(5.6), 1.0, 1e-15);
        // By hand at x = ½, f(1): (0.15+0.05+0.004)/(0.15+0.5+0.06) − 1/15 = 0.220657…; the same
        // sum at 11.2: (18.816+0.56+0.004)/(18.816+5.6+0.06) − 1/15 = 0.725128…
        close(Curve::Filmic.apply(0.5), (0.204 / 0.71 - 1.0 / 15.0) / (19.38 / 24.476 - 1.0 / 15.0), 1e-12);
    }

    #[test]
    fn exposure_gamma_and_bad_values() {
        let tonemap = Tonemap { exposure: 2.0, encoding: Encoding::Gamma(2.0), ..Tonemap::default() };
        close(tonemap.encoded(0.125), 0.5, 1e-15);
        assert_eq!(tonemap.pixel([-1.0, 0.0, 9.0]), [0, 0, 255]);
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(tonemap.pixel([0.1, bad, 0.1]), BAD_PIXEL);
        }
    }

    proptest! {
        #[test]
        fn every_curve_is_monotone_and_bounded(
            a in 0.0..1e38_f64,
            b in 0.0..20.0_f64,
            curve in prop::sample::select(vec![Curve::Linear, Curve::Reinhard, Curve::Filmic]),
        ) {
            let tonemap = Tonemap { curve, ..Tonemap::default() };
            let (low, high) = (tonemap.encoded(a.min(b)), tonemap.encoded(a.max(b)));
            prop_assert!(0.0 <= low && low <= high && high <= 1.0 + 1e-12, "{low} {high}");
        }
    }
}
