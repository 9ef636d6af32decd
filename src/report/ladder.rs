//! The picture of a model ladder: what each model's error comes to over time, noise and model together.

use std::path::Path;

use super::{
    numbers,
    plot::{self, Curve, CurvePoint, Curves, Level, Plot},
};
use crate::{
    bench::ladder::{Ladder, Rung},
    error::Result,
};

/// Points of a line: enough for its bend to look round.
const STEPS: usize = 40;

/// Writes `ladder.svg` and `ladder.png` into a folder, each whole or not at all.
///
/// # Errors
/// [`crate::Error::Failed`] where the disk refuses.
pub fn write_ladder(ladder: &Ladder, folder: &Path) -> Result<()> {
    plot::write(&Plot::Curves(picture(ladder)).drawing(), folder, "ladder")
}

fn picture(ladder: &Ladder) -> Curves {
    let limit = numbers::share(ladder.tolerance);
    // Beyond the last arrival there is nothing to choose any more.
    let arrivals = ladder.rungs.iter().filter_map(|rung| rung.seconds_to_tolerance);
    let end = 4.0
        * arrivals
            .chain(ladder.rungs.iter().map(|rung| start(rung).max(16.0 * rung.seconds_per_sample)))
            .fold(0.0, f64::max);
    Curves {
        title: "Model ladder: error of model and noise together".into(),
        x_title: "wall time (s)".into(),
        y_title: "RMSE / mean of the last model (%)".into(),
        curves: ladder
            .rungs
            .iter()
            .enumerate()
            .map(|(series, rung)| curve(ladder, series, rung, end))
            .collect(),
        guide: None,
        levels: vec![Level { y: 100.0 * ladder.tolerance, label: format!("tolerance {limit}") }],
    }
}

/// When the first sample is done.
fn start(rung: &Rung) -> f64 {
    rung.light_seconds + rung.seconds_per_sample
}

/// A line from the first sample, which is marked, to `end`, marked where it comes down to the tolerance.
fn curve(ladder: &Ladder, series: usize, rung: &Rung, end: f64) -> Curve {
    let arrival = rung.seconds_to_tolerance;
    let note = match arrival {
        Some(seconds) if ladder.cheapest.as_ref() == Some(&rung.method) => {
            format!("{}: the cheapest within {}", numbers::seconds(seconds), numbers::share(ladder.tolerance))
        }
        Some(seconds) => format!("within it after {}", numbers::seconds(seconds)),
        None => format!("never: the model is off by {}", numbers::share(rung.model_error.value)),
    };
    let start = start(rung);
    let step = (end / start).ln() / STEPS as f64;
    let mut times: Vec<f64> = (0..=STEPS).map(|k| start * (k as f64 * step).exp()).chain(arrival).collect();
    times.sort_unstable_by(f64::total_cmp);
    let point = |seconds: f64| {
        let marked = arrival == Some(seconds) || seconds == start;
        let hint = if marked { format!("{}: {note}", rung.method) } else { String::new() };
        point(rung, seconds, !marked, hint)
    };
    Curve {
        series,
        name: rung.method.clone(),
        points: times.into_iter().map(point).collect(),
        note: note.clone(),
        slope: None,
    }
}

fn point(rung: &Rung, seconds: f64, plain: bool, hint: String) -> CurvePoint {
    let falling = rung.noise_in_a_second.map_or(0.0, |noise| noise * noise / (seconds - rung.light_seconds));
    let noise = rung.light_noise * rung.light_noise + falling;
    let total = |model: f64| 100.0 * (model * model + noise).sqrt();
    let model = rung.model_error;
    // The last model has no error of its own: the interval around its 0 is noise.
    let known = |end: Option<f64>| end.filter(|_| model.value > 0.0).map(total);
    CurvePoint {
        x: seconds,
        x_range: None,
        y: Some(total(model.value)),
        low: known(model.low),
        high: known(model.high),
        plain,
        hint,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::results::Interval;

    fn rung(method: &str, model: f64, noise: Option<f64>, seconds_to_tolerance: Option<f64>) -> Rung {
        Rung {
            method: method.into(),
            overrides: Vec::new(),
            model_error: Interval { value: model, low: Some(0.9 * model), high: Some(1.1 * model) },
            single_error: None,
            light_seconds: 0.0,
            light_noise: 0.0,
            noise_in_a_second: noise,
            seconds_per_sample: 0.01,
            seconds_to_tolerance,
            lookups_per_sample: None,
        }
    }

    fn ladder() -> Ladder {
        let rungs = vec![
            rung("emission-absorption", 0.6, None, None),
            // 0.05² = 0.03² + 0.04²/t at t = 1.
            rung("single-scattering", 0.03, Some(0.04), Some(1.0)),
            rung("multiple-scattering", 0.0, Some(0.1), Some(4.0)),
        ];
        let cheapest = Some("single-scattering".into());
        Ladder {
            scene: "a.toml".into(),
            tolerance: 0.05,
            rungs,
            left_out: Vec::new(),
            cheapest,
            reference_error: Some(0.01),
            single_reference_error: Some(0.01),
            complete: true,
        }
    }

    #[test]
    fn lines_meet_the_tolerance_where_they_arrive() {
        let curves = picture(&ladder()).curves;
        let marks: Vec<Vec<(f64, f64)>> = curves
            .iter()
            .map(|curve| {
                assert!(!curve.points[0].plain, "a line is known by its first marker");
                curve
                    .points
                    .iter()
                    .skip(1)
                    .filter(|point| !point.plain)
                    .map(|point| (point.x, point.y.unwrap()))
                    .collect()
            })
            .collect();
        assert_eq!(marks[0], []);
        for (mark, seconds) in [(&marks[1], 1.0), (&marks[2], 4.0)] {
            assert!(mark.len() == 1 && mark[0].0 == seconds && (mark[0].1 - 5.0).abs() < 1e-12, "{mark:?}");
        }
        let ends =
            |curve: &Curve| (curve.points[0].y.unwrap(), curve.points[curve.points.len() - 1].y.unwrap());
        assert_eq!(ends(&curves[0]), (60.0, 60.0));
        // From 0.01 s to four times the last arrival.
        let (first, last) = ends(&curves[2]);
        assert!((first - 100.0).abs() < 1e-9 && (last - 2.5).abs() < 1e-9, "{first} {last}");
        let notes: Vec<&str> = curves.iter().map(|curve| curve.note.as_str()).collect();
        assert_eq!(notes[0], "never: the model is off by 60.0\u{a0}%");
        assert_eq!(notes[1], "1.00\u{a0}s: the cheapest within 5.00\u{a0}%");
        assert_eq!(notes[2], "within it after 4.00\u{a0}s");
    }

    #[test]
    fn the_picture_is_a_file_twice() {
        let folder = tempfile::tempdir().unwrap();
        write_ladder(&ladder(), folder.path()).unwrap();
        let svg = std::fs::read_to_string(folder.path().join("ladder.svg")).unwrap();
        let texts = ["tolerance 5.00\u{a0}%", ">emission-absorption<", ">multiple-scattering<"];
        assert!(texts.iter().all(|text| svg.contains(text)), "{svg}");
        assert_eq!(image::open(folder.path().join("ladder.png")).unwrap().width(), 1280);
        // One that was interrupted at once.
        let none = Ladder { rungs: Vec::new(), cheapest: None, complete: false, ..ladder() };
        write_ladder(&none, folder.path()).unwrap();
    }
}
