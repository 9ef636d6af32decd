use proptest::prelude::*;

use super::{
    drawing::{Anchor, Drawing, Place, Shape},
    *,
};

/// The boxes of all shapes: left, top, right, bottom.
fn boxes(drawing: &Drawing) -> Vec<[f64; 4]> {
    let around = |points: &[Place]| {
        let of = |axis: usize| points.iter().map(move |place| place[axis]);
        let (left, top) = (of(0).fold(f64::INFINITY, f64::min), of(1).fold(f64::INFINITY, f64::min));
        [left, top, of(0).fold(f64::NEG_INFINITY, f64::max), of(1).fold(f64::NEG_INFINITY, f64::max)]
    };
    let one = |shape: &Shape| match shape {
        Shape::Line { points, .. } | Shape::Area { points, .. } => {
            (!points.is_empty()).then(|| around(points))
        }
        Shape::Text { at: [x, y], text, size, anchor, turned, .. } => {
            let width = font::width(text, *size);
            let before = match anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => 0.5 * width,
                Anchor::End => width,
            };
            Some(match turned {
                true => [x - size, y - (width - before), *x, y + before],
                false => [x - before, y - size, x - before + width, *y],
            })
        }
    };
    drawing.shapes.iter().filter_map(one).collect()
}

/// Nothing may lie outside, and no coordinate may be anything but a number.
fn assert_inside(drawing: &Drawing) {
    for [left, top, right, bottom] in boxes(drawing) {
        let inside =
            left >= -0.5 && top >= -0.5 && right <= drawing.width + 0.5 && bottom <= drawing.height + 0.5;
        assert!(inside, "{left} {top} {right} {bottom} of {}×{}", drawing.width, drawing.height);
    }
}

fn texts(drawing: &Drawing) -> Vec<&str> {
    let text = |shape: &'_ Shape| match shape {
        Shape::Text { .. } => true,
        Shape::Line { .. } | Shape::Area { .. } => false,
    };
    let shapes = drawing.shapes.iter().filter(|shape| text(shape));
    shapes.map(|shape| if let Shape::Text { text, .. } = shape { text.as_str() } else { "" }).collect()
}

/// A series that falls as x^−1/2 from `error` at 1.
fn falling(series: usize, name: &str, error: f64) -> Curve {
    let point = |k: i32| {
        let x = 0.1 * 4_f64.powi(k);
        let y = error / x.sqrt();
        let (low, high) = (Some(0.9 * y), Some(1.1 * y));
        CurvePoint {
            x,
            x_range: Some([0.95 * x, 1.08 * x]),
            y: Some(y),
            low,
            high,
            plain: false,
            hint: format!("{name} {k}"),
        }
    };
    let note = "slope −0.500 [−0.512, −0.488]".into();
    Curve { series, name: name.into(), note, points: (0..6).map(point).collect(), slope: Some(-0.5) }
}

fn curves(curves: Vec<Curve>) -> Curves {
    Curves {
        title: "cloud: error against time".into(),
        x_title: "wall time (s)".into(),
        y_title: "RMSE / mean of the reference (%)".into(),
        curves,
        guide: Some("the same efficiency all along".into()),
        levels: vec![Level { y: 0.5, label: "the reference's own noise".into() }],
    }
}

/// The lines of a series' colour, but for those of the legend.
fn lines_of(drawing: &Drawing, series: usize) -> Vec<&Vec<Place>> {
    let ink = drawing::Ink::Series(series);
    let line = |shape: &'_ Shape| matches!(shape, Shape::Line { ink: found, .. } if *found == ink);
    let lines = drawing.shapes.iter().filter(|shape| line(shape));
    lines
        .filter_map(|shape| if let Shape::Line { points, .. } = shape { Some(points) } else { None })
        .collect()
}

#[test]
fn a_power_law_is_a_straight_line_and_its_fit_lies_on_it() {
    let drawing = Plot::Curves(curves(vec![falling(0, "auto", 3.0)])).drawing();
    let lines = lines_of(&drawing, 0);
    let (curve, fit) = (lines[0], lines[1]);
    assert_eq!((curve.len(), fit.len()), (6, 2));
    let off = |[x, y]: Place, [a, b]: [Place; 2]| y - a[1] - (x - a[0]) * (b[1] - a[1]) / (b[0] - a[0]);
    for &place in curve {
        // Rounding of logarithms, in pixels.
        assert!(off(place, [curve[0], curve[5]]).abs() < 1e-9);
        assert!(off(place, [fit[0], fit[1]]).abs() < 1e-9);
    }
    // Grey dashes of slope −½ run parallel to it.
    let slope = |[a, b]: [Place; 2]| (b[1] - a[1]) / (b[0] - a[0]);
    let guides = drawing.shapes.iter().filter_map(|shape| match shape {
        Shape::Line { points, ink: drawing::Ink::Guide, .. } => Some(slope([points[0], points[1]])),
        _ => None,
    });
    let guides: Vec<f64> = guides.collect();
    assert!(guides.len() > 2);
    assert!(guides.iter().all(|guide| (guide - slope([curve[0], curve[5]])).abs() < 1e-9));
}

#[test]
fn everything_stays_inside_whatever_is_plotted() {
    let long =
        "a very long name of a case that goes on and on, residual-ratio, majorant scale 2, on a device";
    let many: Vec<Curve> =
        (0..20).map(|i| falling(i, &format!("{long} {i}"), 1.3_f64.powi(i as i32))).collect();
    let mut one = falling(0, "one", 3.0);
    one.points.truncate(1);
    let mut level = falling(1, "level", 3.0);
    level.points.iter_mut().for_each(|point| (point.x, point.y, point.low) = (1.0, Some(2.0), Some(0.0)));
    for case in [many, vec![one], vec![level], vec![]] {
        let count = case.len();
        let drawing = Plot::Curves(Curves { title: long.repeat(3), ..curves(case) }).drawing();
        assert_inside(&drawing);
        let named = texts(&drawing).into_iter().filter(|text| text.starts_with("slope")).count();
        assert_eq!(named, count, "every series has its line in the legend");
        raster::pixels(&drawing, 0.5).unwrap();
    }
}

#[test]
fn errors_below_the_noise_are_hollow_at_the_lower_edge() {
    let mut curve = falling(0, "a", 3.0);
    curve.points[5].y = None;
    curve.points[4].y = Some(-1.0);
    let drawing = Plot::Curves(curves(vec![curve])).drawing();
    assert_eq!(lines_of(&drawing, 0)[0].len(), 4);
    assert!(texts(&drawing).iter().any(|text| text.starts_with("hollow")));
    // The hollow ones are as low as the axis: 38 + 330 pixels.
    let hollow = |shape: &&Shape| {
        matches!(shape, Shape::Area { points, hint: Some(_), .. } if {
            let y = points.iter().map(|place| place[1]).sum::<f64>() / points.len() as f64;
            (y - 368.0).abs() < 1e-6
        })
    };
    assert_eq!(drawing.shapes.iter().filter(hollow).count(), 2);
    assert!(
        !texts(&Plot::Curves(curves(vec![falling(0, "a", 3.0)])).drawing())
            .iter()
            .any(|t| t.starts_with("hollow"))
    );
}

fn bar(series: usize, value: f64, range: Option<[f64; 2]>) -> Bar {
    let (name, label) = (format!("case {series} with a name that is rather long"), format!("{value:.2} ms"));
    Bar { series, name, value, range, label }
}

#[test]
fn bars_are_in_proportion_until_they_differ_too_much() {
    let widths = |values: &[f64]| -> Vec<f64> {
        let bars =
            values.iter().enumerate().map(|(i, &value)| bar(i, value, Some([0.9 * value, 1.1 * value])));
        let drawing =
            Plot::Bars(Bars { title: "t".into(), x_title: "ms".into(), bars: bars.collect() }).drawing();
        assert_inside(&drawing);
        let width = |shape: &Shape| match shape {
            Shape::Area { points, hint: Some(_), .. } => Some(points[1][0] - points[0][0]),
            _ => None,
        };
        drawing.shapes.iter().filter_map(width).collect()
    };
    let linear = widths(&[1.0, 2.0, 5.0]);
    assert!((linear[1] / linear[0] - 2.0).abs() < 1e-9 && (linear[2] / linear[0] - 5.0).abs() < 1e-9);
    // Marks instead of bars: all of them small.
    assert!(widths(&[1.0, 2.0, 5000.0]).iter().all(|width| width.abs() < 10.0));
    assert_eq!(widths(&[f64::NAN, 0.0, -1.0, f64::INFINITY]).len(), 0);
    assert_eq!(widths(&[]).len(), 0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn any_numbers_give_a_drawing(
        values in prop::collection::vec(
            (any::<f64>(), any::<f64>(), any::<f64>(), prop::option::of(any::<f64>()), prop::option::of(any::<f64>())),
            0..6,
        ),
        slope in prop::option::of(any::<f64>()),
    ) {
        let point = |&(x, from, to, y, low): &(f64, f64, f64, Option<f64>, Option<f64>)| {
            CurvePoint { x, x_range: Some([from, to]), y, low, high: y, plain: false, hint: "h".into() }
        };
        let points = values.iter().map(point).collect();
        let curve = Curve { series: 0, name: "n".into(), note: "s".into(), points, slope };
        let levels = values.iter().map(|value| Level { y: value.1, label: "level".into() }).collect();
        let drawing = Plot::Curves(Curves { levels, ..curves(vec![curve]) }).drawing();
        assert_inside(&drawing);
        let bars = values.iter().map(|&(value, from, to, ..)| bar(0, value, Some([from, to])));
        let bars = bars.map(|bar| Bar { label: "l".into(), ..bar }).collect();
        assert_inside(&Plot::Bars(Bars { title: "t".into(), x_title: "x".into(), bars }).drawing());
    }
}
