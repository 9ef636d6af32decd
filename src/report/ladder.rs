//! The picture of a model ladder: one scene by models of growing cost, the error of each against the last.

use std::path::Path;

use super::{
    numbers,
    plot::{self, Curve, CurvePoint, Curves, Level, Plot},
};
use crate::{
    bench::results::{Interval, Spread},
    error::Result,
};

/// One model of a ladder.
#[derive(Clone, Debug, PartialEq)]
pub struct Rung {
    /// Its name.
    pub name: String,
    /// Wall time.
    pub seconds: Spread,
    /// RMSE against the last rung over the mean of that; 0 for the last itself, `None` below the noise.
    pub error: Option<Interval>,
    /// Whether it is the cheapest within the tolerance.
    pub chosen: bool,
}

/// Draws error against cost as `NAME.svg` and `NAME.png` in a folder; `tolerance` is a share of the mean.
///
/// # Errors
/// [`crate::Error::Failed`] where the disk refuses.
pub fn write_ladder(rungs: &[Rung], tolerance: f64, folder: &Path, name: &str) -> Result<()> {
    plot::write(&picture(rungs, tolerance).drawing(), folder, name)
}

fn picture(rungs: &[Rung], tolerance: f64) -> Plot {
    let limit = numbers::tick(100.0 * tolerance);
    Plot::Curves(Curves {
        title: "Model ladder: error against cost".into(),
        x_title: "wall time (s)".into(),
        y_title: "RMSE / mean of the last model (%)".into(),
        curves: rungs.iter().enumerate().map(|(series, rung)| curve(series, rung, &limit)).collect(),
        guide: None,
        levels: vec![Level { y: 100.0 * tolerance, label: format!("tolerance {limit} %") }],
    })
}

fn curve(series: usize, rung: &Rung, limit: &str) -> Curve {
    let time = numbers::seconds(rung.seconds.median);
    let error = match rung.error {
        Some(error) if error.value > 0.0 => numbers::share(error.value),
        Some(_) => "what the others are compared with".into(),
        None => "below the noise".into(),
    };
    let chosen = if rung.chosen { format!(": the cheapest within {limit} %") } else { String::new() };
    let note = format!("{error}, {time}{chosen}");
    let scaled = |end: Option<f64>| end.map(|end| 100.0 * end);
    let point = CurvePoint {
        x: rung.seconds.median,
        x_range: (rung.seconds.count > 1).then_some([rung.seconds.low, rung.seconds.high]),
        y: scaled(rung.error.map(|error| error.value)),
        low: scaled(rung.error.and_then(|error| error.low)),
        high: scaled(rung.error.and_then(|error| error.high)),
        hint: format!("{}: {note}", rung.name),
    };
    Curve { series, name: rung.name.clone(), note, points: vec![point], slope: None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ladder_names_the_chosen_rung_and_keeps_the_last() {
        let rung = |name: &str, median: f64, error: f64, chosen| Rung {
            name: name.into(),
            seconds: Spread { median, low: 0.9 * median, high: 1.2 * median, count: 3 },
            error: Some(Interval { value: error, low: Some(0.9 * error), high: Some(1.1 * error) }),
            chosen,
        };
        let rungs = [
            rung("emission-absorption", 0.02, 0.6, false),
            rung("single-scattering", 0.5, 0.04, true),
            rung("multiple-scattering", 4.0, 0.0, false),
        ];
        let Plot::Curves(curves) = picture(&rungs, 0.05) else { panic!("curves") };
        let notes: Vec<&str> = curves.curves.iter().map(|curve| curve.note.as_str()).collect();
        assert_eq!(notes[0], "60.0\u{a0}%, 20.0\u{a0}ms");
        assert_eq!(notes[1], "4.00\u{a0}%, 500\u{a0}ms: the cheapest within 5 %");
        assert_eq!(notes[2], "what the others are compared with, 4.00\u{a0}s");
        let folder = tempfile::tempdir().unwrap();
        write_ladder(&rungs, 0.05, folder.path(), "ladder").unwrap();
        let svg = std::fs::read_to_string(folder.path().join("ladder.svg")).unwrap();
        let texts = ["tolerance 5 %", "emission-absorption", "single-scattering", "multiple-scattering"];
        assert!(texts.iter().all(|text| svg.contains(text)), "{svg}");
        assert!(folder.path().join("ladder.png").metadata().unwrap().len() > 1000);
    }
}
