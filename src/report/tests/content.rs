//! What a report says, where the right answer is known.

use super::{made::*, *};
use crate::{
    bench::results::*,
    report::{
        advice::{self, Choice},
        view::View,
    },
};

/// What to use of one group of cases, level by level.
fn choices(results: &Results) -> Vec<Choice> {
    let view = View::new(results, Path::new(""));
    let targets = view.groups[0].targets();
    assert_eq!(targets.len(), 1, "one reference");
    advice::choices(&view, &targets[0], &advice::levels(results.cases.iter()))
}

/// `rough` is twice as fast a sample and a quarter as good: it takes 2 (that is 16/8) times as long to any error.
fn rough_and_fine() -> Results {
    results(vec![case("rough", "one", 0.1, 0.8), case("fine", "one", 0.8, 0.2)])
}

#[test]
fn the_cheapest_is_named_with_its_lead() {
    let choices = choices(&rough_and_fine());
    // 0.8 s · (0.2/0.01)² = 320 s against 0.1 s · (0.8/0.01)² = 640 s.
    assert_eq!(choices.len(), 1);
    assert_eq!((choices[0].errors, choices[0].first), ([0.1, 0.01], Some(1)));
    let next = choices[0].next.unwrap();
    assert!(next.index == 0 && (next.ratio - 2.0).abs() < 1e-9 && next.certain);
    let arrival = choices[0].arrival.unwrap();
    assert!((arrival.seconds - 320.0).abs() < 1e-9 && !arrival.measured);
    let page = page_of(&rough_and_fine());
    let advice = page.section("use");
    assert!(advice.contains("one: of rough and fine, the cheapest for an error of"), "{advice}");
    let sentence = "10\u{a0}% to 1\u{a0}%: fine, 5.33\u{a0}min for 1\u{a0}% (extrapolated); rough takes 2.0 times as long";
    assert!(advice.contains(sentence), "{advice}");
    assert!(advice.contains("the smallest error measured: fine, 2.50\u{a0}% after 51.2\u{a0}s"), "{advice}");
}

#[test]
fn times_that_overlap_do_not_decide() {
    let mut results = rough_and_fine();
    // From 0.9 to 1.2 times the median reaches the quartiles of every case: 640 · 0.9 > 320 · 1.2, but not > 320 · 2.
    for point in &mut results.cases[1].summary.points {
        point.seconds.high = 2.0 * point.seconds.median;
    }
    assert_eq!(choices(&results)[0].next.map(|next| next.certain), Some(false));
    let page = page_of(&results);
    assert!(
        page.section("use").contains("rough may be as fast: the quartiles overlap"),
        "{}",
        page.section("use")
    );
}

#[test]
fn a_biased_case_is_not_followed_beyond_its_measurement() {
    let mut results = rough_and_fine();
    // At 64 samples `fine` is at 2.5 %.
    results.findings = vec![finding(Severity::Warning, FindingKind::Bias, Some("fine"), "biased")];
    let choices = choices(&results);
    let found: Vec<_> = choices.iter().map(|choice| (choice.errors, choice.first)).collect();
    assert_eq!(found, [([0.1, 0.05], Some(1)), ([0.02, 0.01], Some(0))]);
    assert_eq!(choices[1].next, None);
    assert!(page_of(&results).section("use").contains("fine, 12.8\u{a0}s for 5\u{a0}% (see its warning)"));
}

/// The points of a joined curve are the last checkpoints of its cases, by time, in one colour.
#[test]
fn cases_of_one_curve_are_joined() {
    let mut results = results(vec![
        case("slow", "one", 0.4, 0.2),
        case("alone", "one", 0.2, 0.3),
        case("fast", "one", 0.1, 0.4),
        case("elsewhere", "two", 0.1, 0.4),
    ]);
    for index in [0, 2, 3] {
        results.cases[index].curve = Some("joined".into());
    }
    let view = View::new(&results, Path::new(""));
    let series: Vec<usize> = view.members().map(|member| member.series).collect();
    assert_eq!(series, [0, 1, 0, 0]);
    let figures = figures::figures(&view.groups[0]);
    let curves = |name: &str| match &figures.iter().find(|figure| figure.name == name).unwrap().plot {
        plot::Plot::Curves(curves) => &curves.curves,
        plot::Plot::Bars(_) => panic!("bars"),
    };
    let [joined, alone] = &curves("error-time")[..] else { panic!("two curves") };
    assert_eq!((joined.name.as_str(), alone.name.as_str()), ("joined", "alone"));
    // 64 samples of 0.1 s and of 0.4 s.
    let times: Vec<f64> = joined.points.iter().map(|point| point.x).collect();
    assert!(times.len() == 2 && (times[0] - 6.4).abs() < 1e-9 && (times[1] - 25.6).abs() < 1e-9, "{times:?}");
    assert_eq!(alone.points.len(), results.cases[1].summary.points.len());
    // Samples are not what its points differ by.
    assert_eq!(curves("error-samples").len(), 1);
}

#[test]
fn what_failed_is_not_recommended() {
    let mut rejected = rough_and_fine();
    rejected.findings = vec![finding(Severity::Failure, FindingKind::Rejected, Some("fine"), "not finite")];
    let mut failed = rough_and_fine();
    failed.cases[1].device.selftest = Some(false);
    for results in [rejected, failed] {
        let choices = choices(&results);
        assert_eq!(choices.len(), 1);
        assert_eq!((choices[0].first, choices[0].next), (Some(0), None));
    }
    let mut all = rough_and_fine();
    all.cases.iter_mut().for_each(|case| case.device.selftest = Some(false));
    assert_eq!(choices(&all)[0].first, None);
    assert!(page_of(&all).section("use").contains("none of them gets there"));
}

#[test]
fn an_error_of_zero_is_there_at_once() {
    let mut results = rough_and_fine();
    let exact = Interval { value: 0.0, low: None, high: None };
    for point in &mut results.cases[0].summary.points {
        (point.rmse, point.relative_rmse) = (Some(exact), Some(exact));
    }
    results.cases[0].summary.time_to_error.clear();
    let choices = choices(&results);
    assert_eq!((choices.len(), choices[0].first), (1, Some(0)));
    assert_eq!(choices[0].arrival.map(|arrival| arrival.seconds), Some(0.1));
}

#[test]
fn only_cases_with_the_same_reference_are_compared() {
    let mut results = rough_and_fine();
    results.cases[1].reference.image = Some("references/other.exr".into());
    let view = View::new(&results, Path::new(""));
    assert_eq!(view.groups[0].targets().len(), 2);
    let page = page_of(&results);
    assert!(!page.section("use").contains("times as long"));
    assert!(!page.all("td").any(|cell| cell.has_class("best")));
    // A white furnace of one scene is none of another.
    for case in &mut results.cases {
        (case.reference.kind, case.reference.image) =
            (ReferenceKind::Constant, Some("references/1.exr".into()));
    }
    assert_eq!(View::new(&results, Path::new("")).groups[0].targets().len(), 1);
    results.cases[1].scene = "other.toml".into();
    assert_eq!(View::new(&results, Path::new("")).groups[0].targets().len(), 2);
}

#[test]
fn findings_come_first_and_at_their_case() {
    let mut results = rough_and_fine();
    results.findings = vec![
        finding(Severity::Failure, FindingKind::Slower, Some("fine"), "slower by 30 %"),
        finding(Severity::Warning, FindingKind::Reference, Some("rough"), "unconverged reference"),
    ];
    let page = page_of(&results);
    let sections: Vec<_> = page.all("section").map(|section| section.attribute("id").unwrap()).collect();
    assert_eq!(sections[..3], ["findings", "use", "cases"]);
    let found = page.section("findings");
    assert!(found.contains("1 failure and 1 warning."), "{found}");
    assert!(
        found.contains("Failure fine: slower by 30 %") && found.contains("Warning rough: unconverged"),
        "{found}"
    );
    let articles: Vec<_> =
        page.all("article").map(|article| article.text.contains("slower by 30 %")).collect();
    assert_eq!(articles, [false, true]);
    let badges: Vec<_> =
        page.all("span").filter(|span| span.has_class("badge")).map(|span| span.text.as_str()).collect();
    assert_eq!(badges, ["Warning", "Failure", "passed"]);
    assert!(page_of(&rough_and_fine()).section("findings").contains("Nothing wrong"));
}

#[test]
fn devices_are_told_apart() {
    let mut results = results(vec![case("a", "one", 0.1, 0.8), case("a", "one", 0.2, 0.8)]);
    results.cases[1].device = device("1:0");
    let mut about = finding(Severity::Warning, FindingKind::Spread, Some("a"), "times vary");
    about.device = Some("1:0".into());
    results.findings = vec![about];
    let page = page_of(&results);
    assert!(page.section("findings").contains("a on 1:0: times vary"));
    assert!(page.section("use").contains("a on 0:0"));
    let articles: Vec<_> = page.all("article").map(|article| article.text.contains("times vary")).collect();
    assert_eq!(articles, [false, true]);
    let machine = page.section("machine");
    assert!(machine.contains("Processor 9, 2 cores") && machine.contains("24.0\u{a0}GiB"), "{machine}");
    assert!(machine.contains("Device 0:0") && machine.contains("Device 1:0"));
}

#[test]
fn the_table_has_the_numbers_with_their_intervals() {
    let page = page_of(&rough_and_fine());
    let row = page.all("tr").find(|row| row.text.starts_with("finefine")).expect("the case's row");
    // 64 samples of 0.8 s with an error of 0.2/√64 ± 4 % of it; bias 2e-5 ± 4e-5/0.5; 1/(0.2² · 0.8 s) ± 0.1/4.
    let expected = "finefinemultiple-scattering6451.2\u{a0}s800\u{a0}ms2.50 [2.40, 2.60]44.10.0020 ± 0.0080\
                    −0.500 [−0.512, −0.488]31.2 [31.2, 31.3]± 0.120";
    assert_eq!(row.text, expected);
}

#[test]
fn pictures_are_in_the_page_with_their_scale() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("images")).unwrap();
    image::RgbImage::new(64, 48).save(folder.path().join("images/a.png")).unwrap();
    let mut results = rough_and_fine();
    results.cases[0].images = Images {
        image: Some("images/a.exr".into()),
        preview: Some("images/a.png".into()),
        reference_preview: Some("images/missing.png".into()),
        difference: Some("images/a.png".into()),
        difference_scale: Some(0.0123),
    };
    let page = page_in(&results, folder.path());
    page.assert_stands_alone();
    assert_eq!(page.all("img").count(), 2);
    assert!(page.section("details").contains("−0.012+0.012"));
    let again = page.section("again");
    assert!(again.contains("svetlo bench clouds.toml"));
    assert!(again.contains("svetlo compare images/a.exr references/one.exr"));
    let render = "svetlo render ../cloud.toml --set image.width=64 --set 'method={kind=\"mip\"}' --device 0:0 --samples 64 --seed 1";
    assert!(again.contains(render), "{again}");
}

#[test]
fn plots_are_files_too() {
    let folder = tempfile::tempdir().unwrap();
    let page = page_in(&rough_and_fine(), folder.path());
    assert_eq!(page.all("svg").count(), 4);
    let plots = folder.path().join("plots");
    let mut names: Vec<_> = std::fs::read_dir(&plots)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    let expected = ["efficiency", "error-samples", "error-time", "time"];
    let expected: Vec<_> =
        expected.iter().flat_map(|name| ["png", "svg"].map(|end| format!("01-one-{name}.{end}"))).collect();
    assert_eq!(names, expected);
    for name in names.iter().filter(|name| name.ends_with("png")) {
        let picture = image::open(plots.join(name)).unwrap().to_rgb8();
        assert!(
            picture.width() == 1280 && picture.pixels().any(|pixel| pixel.0 == [0x1a; 3]),
            "{name}: no text"
        );
    }
    // What the plot says of the slope is what was measured.
    let svg = std::fs::read_to_string(plots.join("01-one-error-samples.svg")).unwrap();
    assert_eq!(svg.matches("slope −0.500 [−0.512, −0.488]").count(), 2);
}

#[test]
fn published_numbers_stand_beside_ours() {
    let mut results = rough_and_fine();
    let published = |case: &str, ours: Vec<Ours>| Published {
        source: "table 1".into(),
        label: "laptop".into(),
        case: case.into(),
        measure: Measure::SamplesPerSecond,
        value: 40.0,
        unit: "iterations/s".into(),
        ours,
        note: "other data".into(),
    };
    let ours = Ours { device: "0:0".into(), value: 10.0, quartiles: Some([9.0, 12.0]) };
    results.published = vec![published("rough", vec![ours]), published("not run", Vec::new())];
    let page = page_of(&results);
    let text = page.section("published");
    assert!(
        text.contains("table 1laptoprough40.0iterations/s10.0 [9.00, 12.0]samples/s0.25other data"),
        "{text}"
    );
    assert!(text.contains("not run40.0iterations/s–samples/s–other data"), "{text}");
}
