//! What is wrong in a suite is said with its place, all at once, before anything runs.

use crate::{bench, folder};

#[track_caller]
fn fails(suite: &str, needles: &[&str]) {
    let folder = folder(suite);
    let ran = bench(&folder, &[]);
    assert_eq!(ran.code, Some(2), "{}", ran.err);
    for needle in needles {
        assert!(ran.err.contains(needle), "no {needle:?} in\n{}", ran.err);
    }
    assert!(!folder.path("out").exists(), "nothing was begun");
}

const CASE: &str = "[[case]]\nname = \"a\"\nscene = \"scene.toml\"\n";

#[test]
fn keys_and_types() {
    fails(
        &format!("title = 3\nrepeat = 2\n{CASE}"),
        &[
            "suite.toml:1:9",
            "`title` must be a text in quotes",
            "did you mean `repeats`?",
            "2 problems in suite.toml",
        ],
    );
    fails("title = \"x\"\n", &["missing key `case`"]);
    fails("title = \"x\"\ncase = []\n", &["the suite has no case"]);
    fails(
        &format!("title = \"x\"\n{CASE}reference = {{ kind = \"constnt\", value = 1 }}\n"),
        &["did you mean \"constant\"?"],
    );
    // Without a kind it is computed.
    fails(
        &format!("title = \"x\"\n{CASE}reference = {{ value = 1 }}\n"),
        &["`case.0.reference.value` does not go with kind = \"computed\"", "only with kind = \"constant\""],
    );
}

#[test]
fn what_is_wrong_together() {
    fails(
        &format!("title = \"x\"\n{CASE}checkpoints = {{ samples = [4, 4] }}\n"),
        &["suite.toml:5:", "`case.0.checkpoints.samples` must ascend"],
    );
    fails(
        &format!("title = \"x\"\ncheckpoints = {{ samples = [1], times = [\"1s\"] }}\n{CASE}"),
        &["checkpoints are samples or times"],
    );
    fails(&format!("title = \"x\"\n{CASE}{CASE}"), &["two cases are called \"a\"", "suite.toml:6:8"]);
    fails(
        "title = \"x\"\n[[case]]\nname = \"a\"\nscene = \"scen.toml\"\nreference = { kind = \"file\", path = \"r.exr\" }\n",
        &["there is no file \"scen.toml\"", "there is no file \"r.exr\"", "2 problems"],
    );
    fails(
        &format!(
            "title = \"x\"\n{CASE}vary = [[{{ name = \"small\", set = [] }}]]\n[[published]]\nsource = \"s\"\n\
             label = \"l\"\ncase = \"a, smal\"\nmeasure = \"psnr\"\nvalue = 1\nunit = \"dB\"\n"
        ),
        &["there is no case \"a, smal\"", "did you mean \"a, small\"?"],
    );
}

#[test]
fn scenes_of_cases_say_which_case() {
    let vary = "vary = [[{ name = \"p\", set = [\"image.width=0\"] }, { name = \"q\", set = [\"imag.width=1\"] }]]\n";
    fails(
        &format!("title = \"x\"\n{CASE}{vary}"),
        &["`image.width` is out of range", "in case \"a, p\"", "did you mean `image`?", "in case \"a, q\""],
    );
}

#[test]
fn a_reference_of_another_size_and_a_baseline_that_is_none() {
    let folder =
        folder(&format!("title = \"x\"\n{CASE}reference = {{ kind = \"file\", path = \"r.exr\" }}\n"));
    let small =
        ["render", "scene.toml", "-o", "r.exr", "--samples", "1", "--set", "image.width=8", "--quiet"];
    folder.succeed(&small);
    bench(&folder, &["--quiet"]).fails_with(2, "the reference has 8×16 pixels, the case 24×16");
    folder.write("old.json", "{}");
    bench(&folder, &["--baseline", "old.json"]).fails_with(2, "this is not a results.json of svetlo bench");
    bench(&folder, &["--baseline", "none.json"]).fails_with(2, "cannot be read");
    let sets = format!("title = \"x\"\n{CASE}reference = {{ set = [\"image.width=8\"] }}\n");
    fails(&sets, &["the reference has 8×16 pixels, its case 24×16", "in case \"a\""]);
}

#[test]
fn names_that_no_table_can_show() {
    for name in ["", " ", "a\\nb"] {
        fails(
            &format!("title = \"x\"\n[[case]]\nname = \"{name}\"\nscene = \"scene.toml\"\n"),
            &["a case cannot be called", "suite.toml:3:8"],
        );
    }
}
