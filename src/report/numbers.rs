//! Numbers as people read them: as many digits as mean something, with units and true minus signs.

use crate::bench::results::Interval;

/// What stands where a number is not known.
pub const UNKNOWN: &str = "–";

/// A number with `digits` significant digits, 1 to 15, in powers of ten where it is very large or small.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return UNKNOWN.into();
    }
    let scientific = format!("{value:.*e}", digits - 1);
    let (mantissa, exponent) = scientific.split_once('e').expect("an exponent");
    let exponent: i32 = exponent.parse().expect("an integer exponent");
    if (-4..6).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        let rounded: f64 = scientific.parse().expect("a number");
        return format!("{rounded:.decimals$}").replace('-', "−");
    }
    format!("{mantissa}·10{}", superscript(exponent)).replace('-', "−")
}

/// A number at a tick: without zeros behind the point.
pub fn tick(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let exponent = value.abs().log10();
    if !(-3.001..5.999).contains(&exponent) {
        let power = (exponent + 1e-9).floor() as i32;
        let mantissa = value / 10_f64.powi(power);
        let factor = if (mantissa - 1.0).abs() < 1e-6 { String::new() } else { format!("{mantissa:.0}·") };
        return format!("{factor}10{}", superscript(power));
    }
    // Through a short text, so that 3 · 0.1 is 0.3.
    let rounded: f64 = format!("{value:.6e}").parse().expect("a number");
    rounded.to_string().replace('-', "−")
}

fn superscript(exponent: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digit = |c: char| c.to_digit(10).map_or('⁻', |digit| DIGITS[digit as usize]);
    exponent.to_string().chars().map(digit).collect()
}

/// A duration in the unit that suits it, three digits.
pub fn seconds(value: f64) -> String {
    let scaled = |factor: f64, unit: &str| format!("{}\u{a0}{unit}", significant(value * factor, 3));
    match value.abs() {
        size if !size.is_finite() => UNKNOWN.into(),
        0.0 => "0\u{a0}s".into(),
        size if size < 0.9995e-3 => scaled(1e6, "µs"),
        size if size < 0.9995 => scaled(1e3, "ms"),
        size if size < 119.5 => scaled(1.0, "s"),
        size if size < 7170.0 => scaled(1.0 / 60.0, "min"),
        _ => scaled(1.0 / 3600.0, "h"),
    }
}

/// Bytes in binary units, three digits.
pub fn bytes(value: f64) -> String {
    let units = ["B", "KiB", "MiB", "GiB", "TiB", "PiB"];
    let power = (value.max(1.0).log2() / 10.0).floor().min(5.0);
    if !value.is_finite() {
        return UNKNOWN.into();
    }
    if power < 1.0 {
        return format!("{value:.0}\u{a0}B");
    }
    format!("{}\u{a0}{}", significant(value / 1024_f64.powf(power), 3), units[power as usize])
}

/// A count: exact below a million, with thin spaces; beyond in words' steps.
pub fn count(value: f64) -> String {
    match value.abs() {
        size if !size.is_finite() => UNKNOWN.into(),
        size if size < 999_999.5 => grouped(value.round() as i64),
        size if size < 1e9 => format!("{}\u{a0}million", significant(value / 1e6, 3)),
        size if size < 1e12 => format!("{}\u{a0}billion", significant(value / 1e9, 3)),
        _ => significant(value, 3),
    }
}

fn grouped(value: i64) -> String {
    let digits = value.unsigned_abs().to_string();
    let mut text = if value < 0 { "−".to_owned() } else { String::new() };
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) && digits.len() > 4 {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

/// A share in percent, without the sign.
pub fn percent(value: f64, digits: usize) -> String {
    significant(100.0 * value, digits)
}

/// A share in percent, with the sign.
pub fn share(value: f64) -> String {
    format!("{}\u{a0}%", percent(value, 3))
}

/// A value with its interval in brackets; both ends have as many decimals as tell them apart.
pub fn interval(of: &Interval, show: impl Fn(f64) -> String) -> String {
    let value = show(of.value);
    match range(of, show) {
        Some(range) => format!("{value} {range}"),
        None => value,
    }
}

/// The interval alone.
pub fn range(of: &Interval, show: impl Fn(f64) -> String) -> Option<String> {
    let (low, high) = of.low.zip(of.high)?;
    Some(format!("[{}, {}]", show(low), show(high)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_significant() {
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1.00"),
            (-0.012345, "−0.0123"),
            (999.6, "1000"),
            (12345.6, "12300"),
            (0.99999, "1.00"),
            (1.5e-7, "1.50·10⁻⁷"),
            (-2.5e12, "−2.50·10¹²"),
            (f64::NAN, "–"),
            (f64::INFINITY, "–"),
        ] {
            assert_eq!(significant(value, 3), text, "{value}");
        }
    }

    #[test]
    fn ticks_are_plain() {
        for (value, text) in [
            (3.0 * 0.1, "0.3"),
            (0.001, "0.001"),
            (1e-4, "10⁻⁴"),
            (2e-5, "2·10⁻⁵"),
            (50000.0, "50000"),
            (1e5, "100000"),
            (2e6, "2·10⁶"),
            (1e-300, "10⁻³⁰⁰"),
        ] {
            assert_eq!(tick(value), text, "{value}");
        }
    }

    #[test]
    fn units_suit_the_size() {
        assert_eq!(
            [0.0, 2.5e-6, 0.0123, 0.9999, 65.0, 600.0, 1e4].map(seconds).join(", ").replace('\u{a0}', " "),
            "0 s, 2.50 µs, 12.3 ms, 1.00 s, 65.0 s, 10.0 min, 2.78 h"
        );
        assert_eq!(
            [0.0, 1023.0, 2048.0, 3.5 * 1_073_741_824.0].map(bytes).join(", ").replace('\u{a0}', " "),
            "0 B, 1023 B, 2.00 KiB, 3.50 GiB"
        );
        assert_eq!(
            [7.0, -4096.0, 123456.0, 2.5e6, 3e9, 1e15].map(count).join(", ").replace('\u{a0}', " "),
            "7, −4096, 123\u{202f}456, 2.50 million, 3.00 billion, 1.00·10¹⁵"
        );
        assert_eq!(share(0.01234), "1.23\u{a0}%");
    }

    #[test]
    fn intervals_are_in_brackets() {
        let known = Interval { value: -0.5, low: Some(-0.52), high: Some(-0.48) };
        assert_eq!(interval(&known, |v| significant(v, 2)), "−0.50 [−0.52, −0.48]");
        assert_eq!(interval(&Interval { low: None, ..known }, |v| significant(v, 2)), "−0.50");
    }
}
