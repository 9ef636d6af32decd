//! What others published beside what was measured.

use super::results::{Case, Measure, Ours, Published, Spread};
use super::suite::PublishedSpec;
use super::summary::inverse;

/// Every published number with ours, device by device.
pub fn published(specs: &[PublishedSpec], cases: &[Case]) -> Vec<Published> {
    let with_ours = |spec: &PublishedSpec| {
        let PublishedSpec { source, label, case, measure, value, unit, note } = spec.clone();
        let ours = cases.iter().filter(|found| found.name == case).filter_map(|found| ours(found, measure));
        Published { source, label, measure, value, unit, note, ours: ours.collect(), case }
    };
    specs.iter().map(with_ours).collect()
}

fn ours(case: &Case, measure: Measure) -> Option<Ours> {
    let spread = |spread: Spread| (spread.median, Some([spread.low, spread.high]));
    let last = case.summary.points.last()?;
    let (value, quartiles) = match measure {
        Measure::SamplesPerSecond => spread(case.summary.samples_per_second?),
        Measure::SecondsPerSample => spread(inverse(case.summary.samples_per_second?)),
        Measure::IterationsPerSecond => spread(case.summary.light_iterations_per_second?),
        Measure::SortMilliseconds => {
            let Spread { median, low, high, .. } = case.summary.sort_seconds?;
            (1e3 * median, Some([1e3 * low, 1e3 * high]))
        }
        Measure::Psnr => (last.psnr_linear_db?, None),
        Measure::Rmse => (last.rmse?.value, None),
    };
    Some(Ours { device: case.device.selector.clone(), value, quartiles })
}
