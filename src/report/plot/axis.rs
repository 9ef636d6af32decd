//! Axes: from values to pixels, and where the ticks are.

use crate::report::numbers;

/// How values are spread over an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal steps are equally long.
    Linear,
    /// Equal ratios are equally long.
    Log,
}

/// A range of values on a range of pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    scale: Scale,
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

/// A mark on an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// Where, in pixels.
    pub at: f64,
    /// What it says; nothing at the marks in between.
    pub label: Option<String>,
}

/// No logarithmic axis shows less than this ratio: identical values are a level line, not noise blown up.
const LEAST_RATIO: f64 = 4.0;
/// More labels do not fit.
const MOST_LABELS: f64 = 8.0;

impl Axis {
    /// A logarithmic axis around the values that are positive and finite; a decade where there are none.
    pub fn log(values: impl IntoIterator<Item = f64>) -> Self {
        let plottable = values.into_iter().filter(|&value| is_plottable(value));
        let (low, high) = plottable.fold((f64::INFINITY, 0.0), |(low, high), v| (v.min(low), v.max(high)));
        let (low, high) = if low <= high { (low.ln(), high.ln()) } else { (0.0, 10_f64.ln()) };
        let middle = 0.5 * (low + high);
        let half = 0.5 * (1.1 * (high - low)).max(high - low + 0.4).max(LEAST_RATIO.ln());
        let (low, high) = ((middle - half).exp().max(f64::MIN_POSITIVE), (middle + half).exp().min(f64::MAX));
        Self { scale: Scale::Log, low, high, from: 0.0, to: 1.0 }
    }

    /// A linear axis from 0 to a little beyond the largest of the values.
    pub fn from_zero(values: impl IntoIterator<Item = f64>) -> Self {
        let high = values.into_iter().filter(|&value| is_plottable(value)).fold(0.0, f64::max);
        let high = if high > 0.0 { (1.04 * high).min(f64::MAX) } else { 1.0 };
        Self { scale: Scale::Linear, low: 0.0, high, from: 0.0, to: 1.0 }
    }

    /// The same axis between two places.
    #[must_use]
    pub fn between(self, from: f64, to: f64) -> Self {
        Self { from, to, ..self }
    }

    /// The values at the ends.
    pub fn range(&self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// The pixel of a value; values beyond the ends, and those that have no place, are put at the ends.
    pub fn place(&self, value: f64) -> f64 {
        let share = match self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Log => (value.ln() - self.low.ln()) / (self.high.ln() - self.low.ln()),
        };
        let share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
        self.from + share * (self.to - self.from)
    }

    /// Where the marks are.
    pub fn ticks(&self) -> Vec<Tick> {
        let values = match self.scale {
            Scale::Linear => self.linear_ticks(),
            Scale::Log => self.log_ticks(),
        };
        let tick = |(value, labelled): (f64, bool)| Tick {
            at: self.place(value),
            label: labelled.then(|| numbers::tick(value)),
        };
        values.into_iter().map(tick).collect()
    }

    fn linear_ticks(&self) -> Vec<(f64, bool)> {
        let rough = (self.high - self.low) / 5.0;
        let power = 10_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|&step| step >= rough);
        let step = step.unwrap_or(10.0 * power);
        (0..=(self.high / step).floor() as usize).map(|k| (k as f64 * step, true)).collect()
    }

    /// Decades, all or every second and so on; their ninths in between, where there is room; and of these the
    /// labels that an axis of few decades needs.
    fn log_ticks(&self) -> Vec<(f64, bool)> {
        let decades = self.high.log10() - self.low.log10();
        let labels: &[i32] = match decades {
            d if d < 1.0 => &[1, 2, 3, 4, 5, 6, 7, 8, 9],
            d if d < 2.5 => &[1, 2, 5],
            _ => &[1],
        };
        let every = (decades / MOST_LABELS).ceil().max(1.0) as i32;
        let ninths = if every > 1 { 1 } else { 9 };
        let exponents = self.low.log10().floor() as i32..=self.high.log10().ceil() as i32;
        let all = exponents.flat_map(|exponent| (1..=ninths).map(move |ninth| (exponent, ninth)));
        all.map(|(exponent, ninth)| {
            let labelled = labels.contains(&ninth) && exponent.rem_euclid(every) == 0;
            (f64::from(ninth) * 10_f64.powi(exponent), labelled)
        })
        .filter(|(value, _)| (self.low..=self.high).contains(value))
        .collect()
    }
}

/// Whether a value has a place on a logarithmic axis. The smallest numbers of all have none: their reciprocals overflow.
pub fn is_plottable(value: f64) -> bool {
    value.is_normal() && value > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<String> {
        axis.ticks().into_iter().filter_map(|tick| tick.label).collect()
    }

    #[test]
    fn values_go_where_they_belong() {
        let axis = Axis { scale: Scale::Log, low: 0.1, high: 1000.0, from: 100.0, to: 500.0 };
        for (value, place) in [(0.1, 100.0), (1.0, 200.0), (1000.0, 500.0), (10.0, 300.0), (1e9, 500.0)] {
            assert!((axis.place(value) - place).abs() < 1e-9, "{value}");
        }
        for value in [0.0, -1.0, f64::NAN, f64::NEG_INFINITY] {
            assert_eq!(axis.place(value), 100.0, "{value}");
        }
        let down = Axis::from_zero([0.0, 3.0]).between(200.0, 0.0);
        assert_eq!((down.place(0.0), down.place(f64::INFINITY)), (200.0, 0.0));
        assert!((down.place(3.0) - 200.0 * (1.0 - 1.0 / 1.04)).abs() < 1e-9);
    }

    #[test]
    fn ranges_hold_for_any_values() {
        let none = Axis::log([0.0, -3.0, f64::NAN, f64::INFINITY]);
        assert!(none.low < 1.0 && none.high > 10.0);
        let same = Axis::log([7.0, 7.0]);
        assert!(
            (same.high / same.low - LEAST_RATIO).abs() < 1e-9 && (same.low * same.high - 49.0).abs() < 1e-9
        );
        let extreme = Axis::log([f64::MIN_POSITIVE, f64::MAX / 1e9]);
        assert!(extreme.low >= 0.0 && extreme.high.is_finite());
        assert!(labels(&extreme).len() <= 10, "{:?}", labels(&extreme));
    }

    #[test]
    fn labels_are_few_and_enough() {
        assert_eq!(labels(&Axis::log([0.02, 30.0])), ["0.1", "1", "10"]);
        assert_eq!(labels(&Axis::log([1.0, 8.0])), ["1", "2", "5"]);
        assert_eq!(labels(&Axis::log([3.0])), ["2", "3", "4", "5", "6"]);
        assert_eq!(labels(&Axis::log([1e-9, 1e9]))[..2], ["10⁻⁹", "10⁻⁶"]);
        assert_eq!(labels(&Axis::from_zero([0.9])), ["0", "0.2", "0.4", "0.6", "0.8"]);
        assert_eq!(labels(&Axis::from_zero([0.0, f64::NAN])), ["0", "0.2", "0.4", "0.6", "0.8", "1"]);
    }
}
