//! What is known of the cases and what of it holds: one line per case, one column per device.

use super::results::{Case, Judged, Refusal, Results};
use super::table::short;
use std::fmt::Write;

/// A case by all devices, or one that must be refused.
pub enum Row<'a> {
    /// In the order of [`devices`]; `None` where it was not tried.
    Case(Vec<Option<&'a Case>>),
    /// Devices make no difference.
    Refusal(&'a Refusal),
}

/// Whether a case is as it must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It agrees with what is known.
    Right,
    /// It does not.
    Off,
    /// It was refused, as it must be.
    Refused,
    /// It was refused or failed, and must not be.
    Failed,
    /// It was taken, and must not be, or refused for another reason.
    Taken,
    /// Nothing was measured.
    None,
}

impl Verdict {
    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Off => "OFF",
            Self::Refused => "refused",
            Self::Failed => "FAILED",
            Self::Taken => "NOT REFUSED",
            Self::None => "not run",
        }
    }

    /// Of a case that is rendered.
    pub fn of(case: &Case) -> Self {
        match (&case.failed, &case.truth) {
            (Some(_), _) => Self::Failed,
            (None, None) => Self::None,
            (None, Some(judged)) if judged.right && !case.is_faulty() => Self::Right,
            (None, Some(_)) => Self::Off,
        }
    }

    /// Of a case that must be refused.
    pub fn of_refusal(refusal: &Refusal) -> Self {
        if refusal.right() { Self::Refused } else { Self::Taken }
    }
}

/// Selectors of the devices, in their order.
pub fn devices(results: &Results) -> Vec<&str> {
    let mut devices: Vec<&str> = Vec::new();
    for case in &results.cases {
        if !devices.contains(&case.device.selector.as_str()) {
            devices.push(&case.device.selector);
        }
    }
    devices
}

/// All cases of which something is known, by groups in the order of their first ones.
pub fn rows(results: &Results) -> Vec<(&str, Vec<Row<'_>>)> {
    let devices = devices(results);
    let mut groups: Vec<(&str, Vec<Row<'_>>)> = Vec::new();
    let mut add = |group, row| match groups.iter_mut().find(|(name, _)| *name == group) {
        Some((_, rows)) => rows.push(row),
        None => groups.push((group, vec![row])),
    };
    let known = |case: &&Case| case.truth.is_some() || case.is_only_truth();
    for first in results
        .cases
        .iter()
        .filter(known)
        .filter(|case| Some(&case.device.selector.as_str()) == devices.first())
    {
        let on = |selector: &&str| {
            results.cases.iter().find(|case| case.name == first.name && case.device.selector == *selector)
        };
        add(&first.group, Row::Case(devices.iter().map(on).collect()));
    }
    for refusal in &results.refusals {
        add(&refusal.group, Row::Refusal(refusal));
    }
    groups
}

/// Writes the table, if there is any truth.
pub fn truths(results: &Results, text: &mut String) {
    let groups = rows(results);
    let names = groups.iter().flat_map(|(_, rows)| rows).map(|row| name(row).chars().count());
    let Some(width) = names.max() else { return };
    let devices = devices(results);
    let _ = write!(text, "{:<width$}  {:<20} {:>10}", "case", "method", "truth");
    for device in &devices {
        let _ = write!(text, "  {device:<12}{:>8} {:>10} {:>8}", "z", "deviation", "seconds");
    }
    let _ = writeln!(text);
    for (group, rows) in &groups {
        let _ = writeln!(text, "-- {group}");
        for row in rows {
            let _ = writeln!(text, "{:<width$}  {}", name(row), line(row).trim_end());
        }
    }
    let _ = writeln!(text, "{}", count(&groups));
}

fn name<'a>(row: &Row<'a>) -> &'a str {
    match row {
        Row::Case(cases) => cases.iter().flatten().next().map_or("", |case| &case.name),
        Row::Refusal(refusal) => &refusal.name,
    }
}

fn line(row: &Row<'_>) -> String {
    let cases = match row {
        Row::Refusal(refusal) => {
            return format!("{:<20} {:>10}  {}", "", "refused", Verdict::of_refusal(refusal).word());
        }
        Row::Case(cases) => cases,
    };
    let first = cases.iter().flatten().next();
    let truth = first.and_then(|case| case.truth.as_ref());
    let mut text = format!(
        "{:<20} {:>10}",
        first.map_or("", |case| &case.method),
        truth.map_or("–".into(), |judged| number(judged.value))
    );
    for case in cases {
        let Some(case) = case else {
            let _ = write!(text, "  {:<40}", Verdict::None.word());
            continue;
        };
        let (z, off) = case.truth.as_ref().map_or(("–".into(), "–".into()), deviations);
        let seconds = case.summary.points.last().map_or("–".into(), |last| short(last.seconds.median));
        let _ = write!(text, "  {:<12}{z:>8} {off:>10} {seconds:>8}", Verdict::of(case).word());
    }
    text
}

/// In standard errors, and as a share of the truth.
pub fn deviations(judged: &Judged) -> (String, String) {
    let z = judged.z.map_or("–".into(), |z| format!("{z:+.1} σ"));
    let share = judged.relative.map_or("–".into(), |share| {
        let percent = 100.0 * share;
        if percent.abs() < 1e-3 { format!("{percent:+.0e} %") } else { format!("{percent:+.3} %") }
    });
    (z, share)
}

/// One number for three that are equal.
pub fn number(of: [f64; 3]) -> String {
    let plain = |value: f64| {
        let magnitude = value.abs();
        if magnitude == 0.0 || (1e-3..1e5).contains(&magnitude) {
            short(value)
        } else {
            format!("{value:.2e}")
        }
    };
    match of {
        [r, g, b] if r == g && g == b => plain(r),
        of => of.map(plain).join(" "),
    }
}

fn count(groups: &[(&str, Vec<Row<'_>>)]) -> String {
    let of = |row: &Row<'_>| match row {
        Row::Refusal(refusal) => vec![Verdict::of_refusal(refusal)],
        Row::Case(cases) => {
            cases.iter().map(|case| case.map_or(Verdict::None, Verdict::of)).collect::<Vec<_>>()
        }
    };
    let all: Vec<Verdict> = groups.iter().flat_map(|(_, rows)| rows).flat_map(of).collect();
    let words =
        [Verdict::Right, Verdict::Refused, Verdict::Off, Verdict::Failed, Verdict::Taken, Verdict::None];
    let parts = words.into_iter().filter_map(|word| {
        let count = all.iter().filter(|verdict| **verdict == word).count();
        (count > 0).then(|| format!("{count} {}", word.word()))
    });
    parts.collect::<Vec<_>>().join(", ")
}
