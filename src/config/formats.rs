//! Texts with a meaning: colours, durations, percentages. Each is parsed here and nowhere else.

use std::time::Duration;

/// The texts the scene language gives a meaning to, by their JSON Schema `format`.
pub(super) struct Format {
    /// What a text of this format looks like, to follow "must be".
    pub description: &'static str,
    /// Says what is wrong with a text, if anything.
    pub check: fn(&str) -> Result<(), String>,
}

/// The format with this JSON Schema name, if it is one of ours.
pub(super) fn by_name(name: &str) -> Option<Format> {
    match name {
        "colour" => Some(Format {
            description: "a colour like \"#ff8000\"",
            check: |text| parse_colour(text).map(drop),
        }),
        "time-limit" => {
            Some(Format { description: "a time like \"30s\"", check: |text| parse_duration(text).map(drop) })
        }
        "percentage" => Some(Format {
            description: "a percentage like \"1%\"",
            check: |text| parse_percentage(text).map(drop),
        }),
        _ => None,
    }
}

/// Parses `"#rrggbb"` (sRGB) into linear components in 0..=1.
///
/// # Errors
/// A sentence that says what is expected.
pub fn parse_colour(text: &str) -> Result<[f64; 3], String> {
    let digits = text.strip_prefix('#').filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()));
    let code = digits
        .and_then(|digits| u32::from_str_radix(digits, 16).ok())
        .ok_or("a colour is written \"#rrggbb\" with six hexadecimal digits")?;
    Ok(srgb_code_to_linear(code))
}

/// Converts an sRGB colour 0xRRGGBB to linear components in 0..=1.
pub fn srgb_code_to_linear(code: u32) -> [f64; 3] {
    [16, 8, 0].map(|shift| srgb_to_linear(f64::from((code >> shift) & 0xff) / 255.0))
}

/// The inverse of the sRGB transfer curve (IEC 61966-2-1) for one component in 0..=1.
pub fn srgb_to_linear(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Parses `"500ms"`, `"30s"`, `"2m"`, `"1h"` (decimals allowed); longer than zero.
///
/// # Errors
/// A sentence that says what is expected.
pub fn parse_duration(text: &str) -> Result<Duration, String> {
    const SHAPE: &str = "a time is written with its unit: \"500ms\", \"30s\", \"2m\" or \"1h\"";
    let split = text.find(|c: char| c.is_ascii_alphabetic()).ok_or(SHAPE)?;
    let (number, unit) = text.split_at(split);
    let seconds = match unit {
        "ms" => 1e-3,
        "s" => 1.0,
        "m" => 60.0,
        "h" => 3600.0,
        _ => return Err(SHAPE.into()),
    };
    let value = plain_decimal(number).ok_or(SHAPE)?;
    let duration = Duration::try_from_secs_f64(value * seconds).map_err(|_| "this time is too long")?;
    if duration.is_zero() { Err("a time must be longer than zero".into()) } else { Ok(duration) }
}

/// Parses `"1%"` into a fraction (0.01), more than 0.
///
/// # Errors
/// A sentence that says what is expected.
pub fn parse_percentage(text: &str) -> Result<f64, String> {
    let value = text
        .strip_suffix('%')
        .and_then(plain_decimal)
        .ok_or("a percentage is written as a number and a percent sign: \"1%\"")?;
    let fraction = value / 100.0;
    if fraction > 0.0 { Ok(fraction) } else { Err("a percentage must be more than 0".into()) }
}

/// Digits with at most one point inside: no sign, exponent, blanks, `inf` or `nan`.
fn plain_decimal(text: &str) -> Option<f64> {
    let (whole, fraction) = text.split_once('.').unwrap_or((text, "0"));
    let digits = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
    (digits(whole) && digits(fraction)).then(|| text.parse().ok()).flatten().filter(|v: &f64| v.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_converted_to_linear() {
        assert_eq!(parse_colour("#ff0000"), Ok([1.0, 0.0, 0.0]));
        // 0xbc = 188: ((188/255 + 0.055)/1.055)^2.4 = 0.502886458...
        let [_, g, b] = parse_colour("#00BC0a").expect("valid");
        assert!((g - 0.502_886_458_032_568_8).abs() < 1e-12, "{g}");
        assert!((b - 10.0 / 255.0 / 12.92).abs() < 1e-15);
        for wrong in ["", "#", "ff0000", "#ff00", "#ff00000", "#ff000g", "#+f0000", "#é0000"] {
            assert!(parse_colour(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn durations() {
        assert_eq!(parse_duration("500ms"), Ok(Duration::from_millis(500)));
        assert_eq!(parse_duration("30s"), Ok(Duration::from_secs(30)));
        assert_eq!(parse_duration("2m"), Ok(Duration::from_secs(120)));
        assert_eq!(parse_duration("1.5h"), Ok(Duration::from_secs(5400)));
        for wrong in [
            "",
            "30",
            "s",
            "-1s",
            "1e3s",
            "0s",
            "0.0ms",
            "1 s",
            "nans",
            "1..2s",
            "1d",
            "9999999999999999999999h",
        ] {
            assert!(parse_duration(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn percentages() {
        assert_eq!(parse_percentage("1%"), Ok(0.01));
        assert_eq!(parse_percentage("0.5%"), Ok(0.005));
        for wrong in ["", "%", "1", "0%", "-1%", "1%%", "inf%"] {
            assert!(parse_percentage(wrong).is_err(), "{wrong}");
        }
    }
}
