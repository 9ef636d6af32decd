//! The results as a table for people.

use super::results::{Case, Interval, Measure, Results, Severity, Spread};
use super::truth_table::truths;
use std::fmt::Write;

/// One line per case, then what is known of the cases and what of it holds, what others published, and the findings.
pub fn table(results: &Results) -> String {
    let mut text = String::new();
    let measured: Vec<&Case> = results.cases.iter().filter(|case| !case.is_only_truth()).collect();
    if !measured.is_empty() {
        cases(&measured, &mut text);
    }
    truths(results, &mut text);
    published(results, &mut text);
    for finding in &results.findings {
        let word = match finding.severity {
            Severity::Failure => "FAIL",
            Severity::Warning => "warning",
            Severity::Note => "note",
        };
        let case = finding.case.as_ref().map_or(String::new(), |case| format!("{case}: "));
        let _ = writeln!(text, "{word}: {case}{}", finding.text);
    }
    text.trim_end().into()
}

fn cases(cases: &[&Case], text: &mut String) {
    let width = cases.iter().map(|case| case.name.chars().count()).max().unwrap_or(0).max(4);
    let _ = writeln!(
        text,
        "{:<width$}  {:<6} {:>8} {:>16} {:>18} {:>8} {:>14} {:>11} {:>9} {:>9}",
        "case",
        "device",
        "samples",
        "seconds",
        "error %",
        "bias z",
        "slope",
        "1/(MSE s)",
        "5 % in s",
        "1 % in s"
    );
    for case in cases {
        let Some(last) = case.summary.points.last() else {
            let _ = writeln!(text, "{:<width$}  {:<6} not measured", case.name, case.device.selector);
            continue;
        };
        let time = |error: f64| {
            let found =
                case.summary.time_to_error.iter().find(|time| (time.relative_error - error).abs() < 1e-9);
            found.map_or("–".into(), |time| {
                format!("{}{}", if time.measured { "" } else { "~" }, short(time.seconds))
            })
        };
        let _ = writeln!(
            text,
            "{:<width$}  {:<6} {:>8} {:>16} {:>18} {:>8} {:>14} {:>11} {:>9} {:>9}",
            case.name,
            case.device.selector,
            last.samples,
            spread(last.seconds),
            match (last.rmse, last.relative_rmse) {
                (_, Some(error)) => interval(error, 100.0),
                // A black reference: nothing to be relative to.
                (Some(_), None) => "–".into(),
                (None, None) => "below noise".into(),
            },
            case.pooled.and_then(|p| p.bias_z).map_or("–".into(), |z| format!("{z:.2}")),
            case.summary.slope.map_or("–".into(), |slope| interval(slope, 1.0)),
            case.summary.efficiency.map_or("–".into(), |e| format!("{:.3e}", e.value)),
            time(0.05),
            time(0.01),
        );
    }
}

fn published(results: &Results, text: &mut String) {
    for entry in &results.published {
        let unit = match entry.measure {
            Measure::SamplesPerSecond => "samples/s",
            Measure::SecondsPerSample => "s/sample",
            Measure::IterationsPerSecond => "iterations/s",
            Measure::SortMilliseconds => "ms",
            Measure::Psnr => "dB",
            Measure::Rmse => "RMSE",
        };
        for ours in &entry.ours {
            let _ = writeln!(
                text,
                "{}, {}: {} {} there, {} {unit} here on {} ({})",
                entry.source,
                entry.label,
                entry.value,
                entry.unit,
                short(ours.value),
                ours.device,
                entry.case
            );
        }
    }
}

/// Three significant digits.
pub(super) fn short(value: f64) -> String {
    let digits = (2 - value.abs().max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
    format!("{value:.digits$}")
}

fn spread(spread: Spread) -> String {
    let half = (spread.high - spread.low) / 2.0;
    if spread.count > 1 {
        format!("{} ± {}", short(spread.median), short(half))
    } else {
        short(spread.median)
    }
}

fn interval(interval: Interval, factor: f64) -> String {
    let value = interval.value * factor;
    match interval.low.zip(interval.high) {
        // Nothing is random: the interval is rounding.
        Some((low, high)) if high - low < 1e-3 * interval.value.abs() => short(value),
        Some((low, high)) => format!("{} ± {}", short(value), short((high - low) / 2.0 * factor)),
        None => short(value),
    }
}
