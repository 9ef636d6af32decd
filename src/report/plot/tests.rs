use super::*;

/// A series that falls as n^−1/2 from `error` at 1 s.
fn falling(series: usize, name: &str, error: f64) -> Curve {
    let point = |k: i32| {
        let x = 4_f64.powi(k) * 0.1;
        let y = error / x.sqrt() * (1.0 + 0.03 * (f64::from(k * 7 + series as i32)).sin());
        CurvePoint {
            x,
            x_range: Some([0.95 * x, 1.08 * x]),
            y: Some(y),
            low: Some(0.9 * y),
            high: Some(1.1 * y),
            hint: format!("{name}: {y:.2} %"),
        }
    };
    Curve {
        series,
        name: name.into(),
        note: "slope −0.498 [−0.512, −0.484]".into(),
        points: (0..6).map(point).collect(),
        slope: Some(-0.498),
    }
}

fn curves(curves: Vec<Curve>) -> Curves {
    Curves {
        title: "cloud: error against time".into(),
        x_title: "wall time (s)".into(),
        y_title: "RMSE / mean of the reference (%)".into(),
        curves,
        guide: Some("equal efficiency along each".into()),
        levels: vec![Level { y: 0.5, label: "the reference's own error".into() }],
    }
}

#[test]
fn look() {
    let dir = std::path::Path::new("/tmp/look");
    std::fs::create_dir_all(dir).unwrap();
    let three = curves(vec![falling(0, "auto", 3.0), falling(1, "analog", 10.0), falling(2, "ratio", 5.0)]);
    write(&Plot::Curves(three).drawing(), dir, "three").unwrap();
    let mut many: Vec<Curve> = (0..20)
        .map(|i| falling(i, &format!("case number {i} with a name"), 1.3_f64.powi(i as i32)))
        .collect();
    for p in &mut many[3].points[3..] {
        p.y = None;
        p.low = None;
        p.high = None;
    }
    for p in &mut many[2].points[3..] {
        p.low = Some(0.0);
    }
    many[1].name = "a very very long name of a case that goes on and on, transmittance = residual-ratio, majorant scale 2, device PoCL".into();
    write(&Plot::Curves(curves(many)).drawing(), dir, "many").unwrap();
    let mut one = falling(0, "one", 3.0);
    one.points.truncate(1);
    write(&Plot::Curves(curves(vec![one])).drawing(), dir, "one").unwrap();
    write(&Plot::Curves(curves(vec![])).drawing(), dir, "none").unwrap();
    let bars = Bars {
        title: "time per sample".into(),
        x_title: "ms per sample of every pixel".into(),
        bars: (0..6)
            .map(|i| Bar {
                series: i,
                name: format!("case {i} some name"),
                value: 3.0 + i as f64,
                range: Some([2.8 + i as f64, 3.4 + i as f64]),
                label: format!("{}.00 ms", 3 + i),
            })
            .collect(),
    };
    write(&Plot::Bars(bars.clone()).drawing(), dir, "bars").unwrap();
    let mut log = bars;
    log.bars[2].value = 3000.0;
    log.bars[2].range = Some([2500.0, 4000.0]);
    log.bars[3].value = f64::NAN;
    write(&Plot::Bars(log).drawing(), dir, "barslog").unwrap();
}
