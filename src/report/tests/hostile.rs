//! Names and numbers that could break a page.

use super::{made::*, *};
use crate::bench::results::*;

const HOSTILE: &str = "</title></style><script>alert(\"1\")</script><img src=x onerror='y'>&amp;&#60; ' \" ` \
                       \u{0}\u{1b}[31m\u{202e}]]> <!-- 日本 Ünïcödé ../../x $(rm) \n\ttail";

/// Replaces every text of the results, wherever it is.
fn poisoned(results: &Results) -> Results {
    fn poison(value: &mut serde_json::Value, path: &str) {
        // These are no texts of anybody's but words of the format.
        let words = ["kind", "severity", "measure", "of"];
        match value {
            serde_json::Value::String(text) if !words.contains(&path) => *text = format!("{text}{HOSTILE}"),
            serde_json::Value::Array(values) => values.iter_mut().for_each(|value| poison(value, path)),
            serde_json::Value::Object(fields) => {
                fields.iter_mut().for_each(|(key, value)| poison(value, key))
            }
            _ => {}
        }
    }
    let mut value = serde_json::to_value(results).unwrap();
    poison(&mut value, "");
    serde_json::from_value(value).unwrap()
}

/// Results with something in every list.
fn full() -> Results {
    let mut first = case("a", "one", 0.1, 0.8);
    let picture = || Some("images/a.png".to_owned());
    first.images = Images {
        image: picture(),
        preview: picture(),
        reference_preview: picture(),
        difference: picture(),
        difference_scale: Some(0.1),
    };
    let mut second = case("b", "one", 0.2, 0.4);
    second.device = DeviceDescription {
        selftest: Some(false),
        selftest_failures: vec!["furnace".into()],
        ..device("1:0")
    };
    let published = Published {
        source: "table 1".into(),
        label: "a laptop".into(),
        case: "a".into(),
        measure: Measure::SamplesPerSecond,
        value: 36.0,
        unit: "iterations/s".into(),
        ours: vec![Ours { device: "0:0".into(), value: 10.0, quartiles: Some([9.0, 12.0]) }],
        note: "other data".into(),
    };
    let findings = vec![
        finding(Severity::Failure, FindingKind::Selftest, Some("b"), "the self-test failed"),
        finding(Severity::Warning, FindingKind::Bias, Some("a"), "biased; ask for `more`"),
        finding(Severity::Note, FindingKind::Spread, None, "times vary"),
    ];
    let failed = Case { truth: None, failed: Some("no memory".into()), ..true_case("f", "three", 0.0) };
    Results {
        published: vec![published],
        findings,
        refusals: vec![refusal("r", None), refusal("s", Some("out of memory"))],
        ..results(vec![first, second, case("c", "two", 1.0, 1.0), true_case("t", "three", 7.0), failed])
    }
}

#[test]
fn hostile_texts_stay_texts() {
    let folder = tempfile::tempdir().unwrap();
    let page = page_in(&poisoned(&full()), folder.path());
    page.assert_stands_alone();
    // It is on the page, as it was written, but for what no page can show.
    let shown = plot::printable(HOSTILE);
    assert!(shown.contains("<script>") && !shown.contains('\u{1b}'));
    assert!(page.text().matches(&shown).count() > 30, "{}", page.text());
    // No text became an element: there are as many as without it.
    let tame = page_of(&full());
    let names = |page: &Document, name: &str| page.all(name).count();
    for name in ["img", "script", "style", "title", "section", "table", "td", "svg", "a"] {
        assert_eq!(names(&page, name), names(&tame, name), "<{name}>");
    }
    for entry in std::fs::read_dir(folder.path().join("plots")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "svg") {
            let text = std::fs::read_to_string(&path).unwrap();
            roxmltree::Document::parse(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        }
    }
}

#[test]
fn numbers_that_are_none_are_shown_as_unknown() {
    for spoilt in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -1.0, f64::MAX, f64::MIN_POSITIVE] {
        let mut case = case("a", "one", 0.1, 0.8);
        let of = Interval { value: spoilt, low: Some(spoilt), high: Some(spoilt) };
        let times = Spread { median: spoilt, low: spoilt, high: spoilt, count: 3 };
        for point in &mut case.summary.points {
            (point.seconds, point.rmse, point.relative_rmse) = (times, Some(of), Some(of));
            (point.psnr_linear_db, point.relmse) = (Some(spoilt), Some(spoilt));
            (point.samples, point.launches, point.lookups) = (spoilt, spoilt, spoilt);
        }
        let summary = &mut case.summary;
        (summary.slope, summary.efficiency, summary.samples_per_second) = (Some(of), Some(of), Some(times));
        summary.time_to_error.iter_mut().for_each(|time| time.seconds = spoilt);
        (case.reference.relative_error, case.reference.mean) = (Some(spoilt), spoilt);
        case.pooled =
            Some(Metrics { mse: of, rmse: Some(of), bias: of, relative_bias: Some(spoilt), ..metrics(0.1) });
        let page = page_of(&Results { seconds: spoilt, ..results(vec![case]) });
        page.assert_stands_alone();
        for word in ["NaN", "inf", "Infinity"] {
            let found = page.text().split(|c: char| !c.is_alphanumeric()).any(|part| part == word);
            assert!(!found, "{word} for {spoilt}");
        }
    }
}

#[test]
fn empty_and_partial_results_have_a_report() {
    let nothing = page_of(&Results { complete: false, ..results(Vec::new()) });
    nothing.assert_stands_alone();
    assert!(nothing.section("findings").contains("Nothing was measured"));
    let mut begun = case("begun", "one", 0.1, 0.8);
    (begun.repeats, begun.pooled, begun.summary) = (Vec::new(), None, Summary::default());
    let mut nameless = case("", "", 0.1, 0.8);
    nameless.scene.clear();
    let page = page_of(&Results { complete: false, ..results(vec![begun, nameless]) });
    page.assert_stands_alone();
    assert!(page.section("findings").contains("interrupted"));
    assert!(page.section("cases").contains("not run"));
    assert!(page.section("details").contains("Nothing of this case has been measured"));
}

#[test]
fn a_folder_that_takes_no_files_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("plots"), "in the way").unwrap();
    let error = write(&results(vec![case("a", "one", 0.1, 0.8)]), folder.path()).unwrap_err();
    assert!(error.to_string().contains("plots") && error.exit_code() == 1, "{error}");
}
