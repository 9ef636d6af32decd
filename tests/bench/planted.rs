//! Faults that are planted are found: a bias of 1 %, a slow-down, a reference that has not converged.

use crate::support::Folder;
use crate::{bench, folder, results};
use svetlo::bench::baseline;
use svetlo::bench::results::{FindingKind, Interval, Results, Spread};
use svetlo::picture::{Picture, Samples, read_exr, write_exr};

fn kinds(results: &Results) -> Vec<FindingKind> {
    // Times vary on a busy machine, and the self-test is left out to save time.
    let expected = |kind: &FindingKind| !matches!(kind, FindingKind::Spread | FindingKind::Selftest);
    results.findings.iter().map(|finding| finding.kind).filter(expected).collect()
}

fn brighter(picture: Picture, factor: f32) -> Picture {
    let mut picture = picture;
    for channel in
        picture.channels.iter_mut().filter(|channel| ["R", "G", "B"].contains(&channel.name.as_str()))
    {
        if let Samples::F32(values) = &mut channel.data {
            values.iter_mut().for_each(|value| *value *= factor);
        }
    }
    picture
}

const AGAINST_FILE: &str = r#"
title = "Bias"
repeats = 2
checkpoints = { samples = [16, 64] }
gates = { max_bias_z = 5 }
reference = { kind = "file", path = "reference.exr" }
set = ["background.color=1", "medium.albedo=0.9", "method={kind=\"multiple-scattering\",paths=1}", "image.width=64", "image.height=64"]
[[case]]
name = "a"
scene = "scene.toml"
"#;

fn with_reference(factor: f32) -> Folder {
    let folder = folder(AGAINST_FILE);
    let sets = [
        "background.color=1",
        "medium.albedo=0.9",
        "method={kind=\"multiple-scattering\",paths=1}",
        "image.width=64",
        "image.height=64",
    ];
    let render = ["render", "scene.toml", "-o", "r.exr", "--seed", "99", "--samples", "2000", "--quiet"];
    folder.succeed(
        &render.into_iter().chain(sets.into_iter().flat_map(|set| ["--set", set])).collect::<Vec<_>>(),
    );
    let reference = brighter(read_exr(&folder.path("r.exr")).unwrap(), factor);
    write_exr(&folder.path("reference.exr"), &reference).unwrap();
    folder
}

#[test]
fn a_bias_of_one_per_cent_is_found_and_none_is_not() {
    let folder = with_reference(1.01);
    let ran = bench(&folder, &["--quiet"]);
    assert_eq!(ran.code, Some(3), "{}", ran.err);
    assert!(ran.err.contains("|bias| in standard errors is"), "{}", ran.err);
    let found = results(&folder, "out/results.json");
    assert!(kinds(&found).contains(&FindingKind::Bias), "{:?}", found.findings);
    let bias = found.cases[0].pooled.unwrap().relative_bias.unwrap();
    // 1/1.01 − 1, within 5 standard errors.
    let metrics = found.cases[0].pooled.unwrap();
    let error = metrics.bias.value / metrics.bias_z.unwrap() / found.cases[0].reference.mean;
    assert!((bias - (1.0 / 1.01 - 1.0)).abs() < 5.0 * error.abs(), "{bias} ± {error}");

    let folder = with_reference(1.0);
    let ran = bench(&folder, &["--quiet"]);
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert_eq!(kinds(&results(&folder, "out/results.json")), []);
}

#[test]
fn an_unconverged_reference_is_called_out() {
    let suite = "title = \"x\"\nrepeats = 1\ncheckpoints = { samples = [64] }\nreference = { error = \"2%\" }\n\
                 [[case]]\nname = \"a\"\nscene = \"scene.toml\"\n";
    let folder = folder(suite);
    let ran = bench(&folder, &["--quiet"]);
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert!(ran.out.contains("unconverged reference"), "{}", ran.out);
    assert!(kinds(&results(&folder, "out/results.json")).contains(&FindingKind::Reference));
}

#[test]
fn a_slow_down_is_found_against_a_baseline() {
    let suite = |paths: u32| {
        format!(
            "title = \"x\"\nset = [\"image.width=64\", \"image.height=64\", \"background.color=1\", \"medium.albedo=0.5\"]\n\
             checkpoints = {{ samples = [64] }}\nreference = {{ kind = \"constant\", value = 1 }}\n\
             [[case]]\nname = \"a\"\nscene = \"scene.toml\"\n\
             set = [\"method={{kind=\\\"multiple-scattering\\\",paths={paths}}}\"]\n"
        )
    };
    let folder = folder(&suite(1));
    assert_eq!(bench(&folder, &["--quiet"]).code, Some(0));
    std::fs::copy(folder.path("out/results.json"), folder.path("old.json")).unwrap();
    // The same again is not slower: the pieces are kept, so the times are the same too.
    let again = bench(&folder, &["--quiet", "--baseline", "old.json"]);
    assert_eq!(again.code, Some(0), "{}", again.err);
    against_itself(&results(&folder, "old.json"));
    // Eight times the paths take a multiple of the time, whatever else the machine does.
    folder.write("suite.toml", suite(8));
    let slow = bench(&folder, &["--quiet", "--baseline", "old.json"]);
    assert_eq!(slow.code, Some(3), "{}", slow.err);
    assert!(slow.err.contains("slower: 64 samples take"), "{}", slow.err);
    let found = kinds(&results(&folder, "out/results.json"));
    assert!(found.contains(&FindingKind::Slower) && found.contains(&FindingKind::Work), "{found:?}");
}

/// What a baseline finds in results whose numbers were changed.
fn against_itself(old: &Results) {
    let found = |factor: f64, spread: f64| -> Vec<FindingKind> {
        let mut new = old.clone();
        for point in &mut new.cases[0].summary.points {
            let median = point.seconds.median * factor;
            point.seconds =
                Spread { median, low: median * (1.0 - spread), high: median * (1.0 + spread), count: 3 };
        }
        let mut calm = old.clone();
        for point in &mut calm.cases[0].summary.points {
            (point.seconds.low, point.seconds.high) = (point.seconds.median, point.seconds.median);
        }
        baseline::compare(&new, &calm, 0.1).iter().map(|finding| finding.kind).collect()
    };
    let mut renamed = old.clone();
    renamed.cases[0].name.push('b');
    let mut longer = old.clone();
    longer.cases[0].summary.points.iter_mut().for_each(|point| point.samples *= 3.0);
    for unlike in [&renamed, &longer] {
        let kinds: Vec<_> = baseline::compare(unlike, old, 0.1).iter().map(|finding| finding.kind).collect();
        assert_eq!(kinds, [FindingKind::Baseline], "what is not compared does not pass in silence");
    }
    assert_eq!(found(1.3, 0.05), [FindingKind::Slower]);
    assert_eq!(found(1.3, 0.3), [], "within its spread");
    assert_eq!(found(1.05, 0.0), [], "below the limit");
    assert_eq!(found(0.5, 0.0), [], "faster");
    let mut noisy = old.clone();
    for point in &mut noisy.cases[0].summary.points {
        let grown = |end: f64| 1.5 * end;
        let rmse = point.rmse.unwrap();
        let (low, high) = (rmse.low.map(grown), rmse.high.map(grown));
        point.rmse = Some(Interval { value: grown(rmse.value), low, high });
        point.lookups *= 1.03;
    }
    let kinds: Vec<FindingKind> =
        baseline::compare(&noisy, old, 0.1).iter().map(|finding| finding.kind).collect();
    assert_eq!(kinds, [FindingKind::Noisier, FindingKind::Work]);
}
