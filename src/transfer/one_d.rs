//! Transfer functions of the value alone.

use super::colormap::map_color;
use super::{lerp, some_if_any};
use crate::scene::{ColorMap, Domain, Point, Transfer1d};

/// A table over the windowed value: entry k of K at v = k/(K−1).
#[derive(Debug, Clone, PartialEq)]
pub struct TransferFunction1d {
    /// Straight-alpha `[r, g, b, opacity]`, linear sRGB, all in 0..=1; at least 2 entries.
    pub rgba: Vec<[f64; 4]>,
    /// Emission Lₑ of each entry, a radiance ≥ 0; `None` if all are 0.
    pub emission: Option<Vec<[f64; 3]>>,
}

impl TransferFunction1d {
    /// The table of a scene's transfer function for a window `(lo, hi)` in data units, hi > lo.
    pub fn from_settings(settings: &Transfer1d, window: (f64, f64)) -> Self {
        match settings.domain {
            Domain::Normalized => Self::from_points(&settings.points, settings.colormap, settings.resolution),
            Domain::Data => {
                let points: Vec<_> = settings.points.iter().map(|point| windowed(point, window)).collect();
                Self::from_points(&points, settings.colormap, settings.resolution)
            }
        }
    }

    /// Samples points (strictly increasing; windowed values, which may lie outside 0..=1) at `resolution` entries.
    ///
    /// Between two points opacity, emission and colour are linear, except that the colour follows the colour map
    /// where both points have no colour of their own. Beyond the ends all are constant. Without any points
    /// the table is transparent; a `resolution` below 2 counts as 2.
    pub fn from_points(points: &[Point], colormap: Option<ColorMap>, resolution: usize) -> Self {
        let entries = resolution.max(2);
        let last = (entries - 1) as f64;
        let positions = || (0..entries).map(|k| k as f64 / last);
        Self {
            rgba: positions().map(|v| evaluate(points, colormap, v)).collect(),
            emission: some_if_any(positions().map(|v| emission(points, v)).collect()),
        }
    }
}

/// The same point with its value windowed. Kept in a range whose differences are finite.
fn windowed(point: &Point, (lo, hi): (f64, f64)) -> Point {
    Point { value: ((point.value - lo) / (hi - lo)).clamp(-1e300, 1e300), ..*point }
}

/// The points before and after a value.
fn neighbours(points: &[Point], v: f64) -> (Option<&Point>, Option<&Point>) {
    let after = points.partition_point(|point| point.value <= v);
    (after.checked_sub(1).and_then(|index| points.get(index)), points.get(after))
}

fn emission(points: &[Point], v: f64) -> [f64; 3] {
    match neighbours(points, v) {
        (None, None) => [0.0; 3],
        (Some(end), None) | (None, Some(end)) => end.emission,
        (Some(a), Some(b)) => lerp(a.emission, b.emission, (v - a.value) / (b.value - a.value)),
    }
}

fn evaluate(points: &[Point], colormap: Option<ColorMap>, v: f64) -> [f64; 4] {
    match neighbours(points, v) {
        (None, None) => [0.0; 4],
        (Some(end), None) | (None, Some(end)) => own(end, colormap),
        (Some(a), Some(b)) => {
            let mixed = lerp(own(a, colormap), own(b, colormap), (v - a.value) / (b.value - a.value));
            match (a.color, b.color, colormap) {
                (None, None, Some(map)) => {
                    let [r, g, b] = map_color(map, v);
                    [r, g, b, mixed[3]]
                }
                _ => mixed,
            }
        }
    }
}

/// Colour and opacity at a point.
fn own(point: &Point, colormap: Option<ColorMap>) -> [f64; 4] {
    let mapped = || colormap.map_or([1.0; 3], |map| map_color(map, point.value));
    let [r, g, b] = point.color.unwrap_or_else(mapped);
    [r, g, b, point.opacity]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(value: f64, opacity: f64, color: Option<[f64; 3]>) -> Point {
        Point { value, opacity, color, emission: [0.0; 3] }
    }

    #[test]
    fn linear_between_and_constant_beyond() {
        let points = [point(0.25, 0.0, Some([1.0, 0.0, 0.0])), point(0.75, 0.5, Some([0.0, 0.0, 1.0]))];
        let table = TransferFunction1d::from_points(&points, None, 5).rgba;
        assert_eq!(
            table,
            [
                [1.0, 0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0, 0.0],
                [0.5, 0.0, 0.5, 0.25],
                [0.0, 0.0, 1.0, 0.5],
                [0.0, 0.0, 1.0, 0.5]
            ]
        );
    }

    #[test]
    fn the_default_is_a_white_ramp() {
        let points = [point(0.0, 0.0, None), point(1.0, 1.0, None)];
        let table = TransferFunction1d::from_points(&points, None, 3).rgba;
        assert_eq!(table, [[1.0, 1.0, 1.0, 0.0], [1.0, 1.0, 1.0, 0.5], [1.0; 4]]);
    }

    #[test]
    fn the_colour_map_is_followed_between_points_without_colours() {
        let points = [point(0.0, 0.0, None), point(1.0, 1.0, None)];
        let table = TransferFunction1d::from_points(&points, Some(ColorMap::Viridis), 1024).rgba;
        for (k, [r, g, b, a]) in table.into_iter().enumerate() {
            let v = k as f64 / 1023.0;
            assert_eq!([r, g, b], map_color(ColorMap::Viridis, v));
            assert!((a - v).abs() < 1e-15);
        }
    }

    #[test]
    fn a_point_with_a_colour_is_joined_by_a_straight_line() {
        let points = [point(0.0, 1.0, None), point(1.0, 1.0, Some([1.0, 0.0, 0.0]))];
        let table = TransferFunction1d::from_points(&points, Some(ColorMap::Grey), 3).rgba;
        assert_eq!(table[1], [0.5, 0.0, 0.0, 1.0]);
    }

    #[test]
    fn emission_is_joined_like_colours() {
        let glowing = |value, emission| Point { emission, ..point(value, 1.0, None) };
        let points = [glowing(0.25, [0.0; 3]), glowing(0.75, [8.0, 2.0, 0.0])];
        let table = TransferFunction1d::from_points(&points, Some(ColorMap::Hot), 5);
        let top = [8.0, 2.0, 0.0];
        assert_eq!(table.emission, Some(vec![[0.0; 3], [0.0; 3], [4.0, 1.0, 0.0], top, top]));
        assert_eq!(TransferFunction1d::from_points(&points[..1], None, 5).emission, None, "nothing glows");
        // In data units: window 0..4, so that the points stand at data values 1 and 3.
        let points = [glowing(1.0, [0.0; 3]), glowing(3.0, [8.0, 2.0, 0.0])].to_vec();
        let settings = Transfer1d { domain: Domain::Data, colormap: None, points, resolution: 5 };
        assert_eq!(TransferFunction1d::from_settings(&settings, (0.0, 4.0)).emission, table.emission);
    }

    #[test]
    fn data_units_use_the_window() {
        // Window -100..300: 0 is at 0.25, 100 at 0.5; the points reach beyond the window.
        let settings = Transfer1d {
            domain: Domain::Data,
            colormap: None,
            points: vec![point(-300.0, 0.0, None), point(500.0, 1.0, None)],
            resolution: 5,
        };
        let table = TransferFunction1d::from_settings(&settings, (-100.0, 300.0)).rgba;
        assert_eq!(table.map_opacity(), [0.25, 0.375, 0.5, 0.625, 0.75]);
    }

    #[test]
    fn extreme_windows_and_points_stay_finite() {
        let settings = Transfer1d {
            domain: Domain::Data,
            colormap: Some(ColorMap::Hot),
            points: vec![point(-1e308, 0.0, None), point(0.0, 0.3, None), point(1e308, 1.0, None)],
            resolution: 64,
        };
        for window in [(0.0, f64::MIN_POSITIVE), (-1e307, 1e307), (0.0, 1e-300)] {
            let table = TransferFunction1d::from_settings(&settings, window).rgba;
            assert!(table.iter().flatten().all(|c| (0.0..=1.0).contains(c)), "{window:?}: {table:?}");
        }
    }

    #[test]
    fn no_points_are_transparent() {
        assert_eq!(TransferFunction1d::from_points(&[], None, 0).rgba, [[0.0; 4]; 2]);
    }

    trait Opacities {
        fn map_opacity(&self) -> Vec<f64>;
    }

    impl Opacities for Vec<[f64; 4]> {
        fn map_opacity(&self) -> Vec<f64> {
            self.iter().map(|entry| entry[3]).collect()
        }
    }
}
