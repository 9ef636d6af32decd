//! The table of what is known.

use super::{made::*, *};
use crate::bench::results::*;
use crate::bench::table::table;

fn known() -> Results {
    let mut elsewhere = true_case("white", "furnace", -7.5);
    elsewhere.device = device("1:0");
    let failed = Case { truth: None, failed: Some("no memory".into()), ..true_case("dense", "furnace", 0.0) };
    Results {
        refusals: vec![refusal("bad size", Some("`image.width` is out of range")), refusal("taken", None)],
        ..results(vec![true_case("white", "furnace", 1.25), elsewhere, failed])
    }
}

#[test]
fn rows_are_cases_and_columns_devices() {
    let text = table(&known());
    let lines: Vec<&str> = text.lines().collect();
    let words = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        words(lines[0]).starts_with("case method truth 0:0 z deviation seconds 1:0 z deviation seconds"),
        "{text}"
    );
    assert_eq!(lines[1], "-- furnace");
    let white = words(lines[2]);
    assert!(white.starts_with("white multiple-scattering 0.500 right +1.2 σ +2.500 %"), "{white}");
    assert!(white.contains("OFF -7.5 σ -15.000 %"), "{white}");
    assert!(words(lines[3]).contains("FAILED") && words(lines[3]).ends_with("not run"), "{text}");
    assert_eq!(words(lines[5]), "bad size refused refused");
    assert_eq!(words(lines[6]), "taken refused NOT REFUSED");
    assert_eq!(lines[7], "1 right, 1 refused, 1 OFF, 1 FAILED, 1 NOT REFUSED, 1 not run");
}

#[test]
fn the_page_has_what_is_known_and_no_curves() {
    let page = page_of(&known());
    let section = page.section("truths");
    for text in [
        "white",
        "why it is hard",
        "+1.2 σ, +2.500 %",
        "-7.5 σ",
        "no memory",
        "“out of range”",
        "NOT REFUSED",
    ] {
        assert!(section.contains(text), "no {text} in {section}");
    }
    let text = page.text();
    for absent in ["What to use", "All cases", "Case by case"] {
        assert!(!text.contains(absent), "{absent}");
    }
    // With others, both are there.
    let both = page_of(&results(vec![true_case("white", "furnace", 1.0), case("rough", "one", 0.1, 0.8)]));
    assert!(both.section("truths").contains("white") && both.section("cases").contains("rough"));
    assert!(!both.section("cases").contains("white"));
}
