//! The numbers of the results are those of the pictures that are kept.

use crate::{bench, folder, results};
use svetlo::bench::results::{Case, FindingKind, ReferenceKind};

const SUITE: &str = r#"
title = "Pictures"
repeats = 5
checkpoints = { samples = [1, 2, 4, 8, 16] }
reference = { error = "0.3%" }
[[case]]
name = "glow"
scene = "scene.toml"
vary = [[{ name = "small", set = [] }, { name = "large", set = ["image.width=48", "image.height=32"] }]]
[[case]]
name = "scattering"
scene = "scene.toml"
set = ["method={kind=\"multiple-scattering\",paths=1}", "background.color=[1, 0.5, 0.25]", "medium.albedo=0.9"]
reference = { error = "0.5%" }
[[case]]
name = "exact"
scene = "scene.toml"
set = ["image.filter=point", "method.quadrature=step", "method.jitter=false", "method.step=4"]
reference = { set = ["method={kind=\"emission-absorption\",termination=0}"] }
[[published]]
source = "nowhere"
label = "a stone"
case = "glow, large"
measure = "samples-per-second"
value = 2
unit = "pictures/s"
"#;

#[test]
fn numbers_are_those_of_the_kept_pictures() {
    let folder = folder(SUITE);
    let ran = bench(&folder, &["--quiet"]);
    assert_eq!((ran.code, ran.err.as_str()), (Some(0), ""), "{}", ran.err);
    let results = results(&folder, "out/results.json");
    assert!(results.complete);
    let names: Vec<&str> = results.cases.iter().map(|case| case.name.as_str()).collect();
    assert_eq!(names, ["glow, small", "glow, large", "scattering", "exact"]);
    for case in &results.cases {
        assert_eq!(case.reference.kind, ReferenceKind::Computed);
        equals_compare(&folder, case);
    }
    assert!(results.published[0].ours[0].value > 0.0);
    csv_parses(&folder, &results.cases);
    has_report(&folder, &results.cases);
    deterministic(&results.cases[3]);
    unbiased(&results.cases[2]);
    for case in &results.cases[..2] {
        // Points of a pixel are spread evenly: its mean comes nearer faster than that of independent ones.
        assert!(case.summary.slope.unwrap().high.unwrap() < -0.5, "{:?}", case.summary.slope);
    }
    let bad = results.findings.iter().find(|finding| finding.kind == FindingKind::Bias);
    assert_eq!(bad, None);
}

/// `svetlo compare` on the pictures says what the results say.
fn equals_compare(folder: &crate::support::Folder, case: &Case) {
    let path = |name: &Option<String>| format!("out/{}", name.as_ref().expect("a picture"));
    let (image, reference) = (path(&case.images.image), path(&case.reference.image));
    let ran = folder.succeed(&["compare", &image, &reference, "--json"]);
    let compare: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    let pooled = case.pooled.as_ref().expect("pooled metrics");
    let clean = compare["corrected"].as_array().unwrap().iter().find(|c| c["removed"] == "reference");
    let mse = clean.map_or(&compare["mse"], |clean| &clean["mse"]);
    assert_eq!(mse["value"].as_f64().unwrap(), pooled.mse.value, "{}", case.name);
    assert_eq!(compare["bias"]["mean"].as_f64().unwrap(), pooled.bias.value);
    assert_eq!(compare["bias"]["z"].as_f64(), pooled.bias_z);
    assert_eq!(compare["mape"]["value"].as_f64(), pooled.mape.map(|mape| mape.value));
    for name in [&case.images.preview, &case.images.reference_preview, &case.images.difference] {
        let preview = svetlo::picture::read_png(&folder.path(path(name))).unwrap();
        assert_eq!((preview.width, preview.height), (case.width as usize, case.height as usize));
    }
}

fn csv_parses(folder: &crate::support::Folder, cases: &[Case]) {
    let mut reader = csv::Reader::from_path(folder.path("out/results.csv")).unwrap();
    let headers = reader.headers().unwrap().clone();
    let column = |name: &str| headers.iter().position(|header| header == name).unwrap();
    let (name, samples, mse) = (column("case"), column("samples"), column("mse"));
    let rows: Vec<csv::StringRecord> = reader.records().map(|row| row.unwrap()).collect();
    let mut expected = Vec::new();
    for case in cases {
        for checkpoint in case.repeats.iter().flat_map(|repeat| &repeat.checkpoints) {
            expected.push((case.name.clone(), checkpoint.samples, checkpoint.metrics.mse.value));
        }
    }
    let found: Vec<_> = rows
        .iter()
        .map(|row| (row[name].to_owned(), row[samples].parse().unwrap(), row[mse].parse().unwrap()))
        .collect();
    assert_eq!(found, expected);
}

/// Without randomness there is one checkpoint, and the error is that of the quadrature.
fn deterministic(case: &Case) {
    assert!(case.deterministic);
    assert_eq!(case.repeats.len(), 5);
    assert!(case.repeats.iter().all(|repeat| repeat.checkpoints.len() == 1));
    assert_eq!(case.summary.slope, None);
    let error = case.summary.points[0].relative_rmse.unwrap().value;
    assert!(error > 1e-5 && error < 0.05, "{error}");
}

/// The slope of an unbiased estimate is −1/2; the interval is one of 95 %, so twice its width is allowed.
fn unbiased(case: &Case) {
    let slope = case.summary.slope.expect("a slope");
    let half = slope.high.unwrap() - slope.value;
    assert!((slope.value + 0.5).abs() < 2.0 * half, "{}: {slope:?}", case.name);
    assert!(half < 0.2, "{}: {slope:?}", case.name);
    assert_eq!(case.summary.points.len(), 5);
    let samples: Vec<f64> = case.summary.points.iter().map(|point| point.samples).collect();
    assert_eq!(samples, [1.0, 2.0, 4.0, 8.0, 16.0]);
    assert!(case.repeats[0].seed != case.repeats[1].seed);
    let mse: Vec<f64> = case.repeats.iter().map(|repeat| repeat.checkpoints[0].metrics.mse.value).collect();
    assert!(mse[0] != mse[1], "repeats have random numbers of their own");
}

/// The page holds every case with its picture, its reference's and their difference, and the plots are files too.
fn has_report(folder: &crate::support::Folder, cases: &[Case]) {
    let page = std::fs::read_to_string(folder.path("out/report.html")).expect("a report");
    assert!(cases.iter().all(|case| page.contains(&format!("<bdi>{}</bdi>", case.name))));
    assert_eq!(page.matches("<img src=\"data:image/png;base64,").count(), 3 * cases.len());
    for (index, name) in ["glow", "scattering", "exact"].iter().enumerate() {
        let plot = format!("out/plots/{:02}-{name}-error-time", index + 1);
        assert!(["svg", "png"].iter().all(|end| folder.path(format!("{plot}.{end}")).is_file()), "{plot}");
    }
}
