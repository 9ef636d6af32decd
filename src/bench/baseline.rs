//! Results against those of an earlier run.

use super::findings::about;
use super::results::{Case, Finding, FindingKind, Point, Results, Severity};

/// Look-ups hardly depend on the seed: a larger change is a change of the program or of the scene.
const WORK: f64 = 0.02;

/// What became worse since `old`: cases are the same when their names and their devices' names are.
///
/// Slower is a case whose time grew by more than the fraction `slower` and beyond its spread: the quartiles do not
/// overlap. Noisier is one whose RMSE at the same number of samples grew by as much, beyond both intervals. What cannot
/// be compared is a warning: a renamed case must not pass in silence.
pub fn compare(new: &Results, old: &Results, slower: f64) -> Vec<Finding> {
    let mut found = Vec::new();
    for case in &new.cases {
        let same = |other: &&Case| other.name == case.name && other.device.name == case.device.name;
        let mut unlike = |what: &str| {
            let text = format!("{what}: neither its speed nor its noise was compared");
            found.push(about(case, Severity::Warning, FindingKind::Baseline, text));
        };
        let Some(before) = old.cases.iter().find(same) else {
            unlike("not in the baseline on this device");
            continue;
        };
        let Some((now, then)) = last_common(case, before) else {
            unlike("no checkpoint has as many samples as one of the baseline");
            continue;
        };
        let changed =
            if case.scene_hash == before.scene_hash { "" } else { "; the scene is not the same as then" };
        let mut add = |severity: Severity, kind: FindingKind, text: String| {
            found.push(about(case, severity, kind, text + changed));
        };
        let ratio = now.seconds.median / then.seconds.median;
        if ratio > 1.0 + slower && now.seconds.low > then.seconds.high {
            let text = format!(
                "slower: {} samples take {:.3} s, {ratio:.2} times the {:.3} s of the baseline",
                now.samples, now.seconds.median, then.seconds.median
            );
            add(Severity::Failure, FindingKind::Slower, text);
        }
        if let Some(text) = noisier(now, then, slower) {
            add(Severity::Failure, FindingKind::Noisier, text);
        }
        let work = now.lookups / then.lookups;
        if work > 1.0 + WORK {
            let text = format!("more work: {work:.2} times the look-ups of the baseline");
            add(Severity::Warning, FindingKind::Work, text);
        }
    }
    found
}

/// The last checkpoint at the same number of samples in both.
fn last_common<'a>(new: &'a Case, old: &'a Case) -> Option<(&'a Point, &'a Point)> {
    let of_old = |now: &Point| old.summary.points.iter().find(|then| then.samples == now.samples);
    new.summary.points.iter().rev().find_map(|now| Some((now, of_old(now)?)))
}

fn noisier(now: &Point, then: &Point, slower: f64) -> Option<String> {
    let (new, old) = (now.rmse?, then.rmse?);
    let ratio = new.value / old.value;
    (ratio > 1.0 + slower && new.low? > old.high?).then(|| {
        format!("noisier: the RMSE of {} samples is {ratio:.2} times that of the baseline", now.samples)
    })
}
