//! Light volumes in a bench: their time and look-ups count, and cases of one curve are joined.

use crate::{bench, folder, results};
use svetlo::bench::results::{Case, FindingKind};

const SUITE: &str = r#"
title = "Light"
repeats = 2
checkpoints = { samples = [1, 4] }
set = ["light=[{kind=\"directional\",direction=[1,-1,1],irradiance=3}]", "medium.albedo=0.9"]
reference = { error = "2%", set = ["method={kind=\"multiple-scattering\"}"] }
[[case]]
name = "hybrid"
group = "sphere"
curve = "hybrid, 2 and 6 estimates"
scene = "scene.toml"
set = ["method={kind=\"hybrid-diffusion\",model=\"paper\"}"]
vary = [[{ name = "2", set = ["method.iterations=2"] }, { name = "6", set = ["method.iterations=6"] }]]
[[case]]
name = "convection"
group = "sphere"
scene = "scene.toml"
set = ["method={kind=\"convection-diffusion\",iterations=5}"]
[[case]]
name = "itself"
scene = "scene.toml"
set = ["method={kind=\"hybrid-diffusion\",model=\"paper\",iterations=2}", "image.filter=point"]
reference = { error = "0.001%" }
[[published]]
source = "nowhere"
label = "a stone"
case = "hybrid, 6"
measure = "iterations-per-second"
value = 1
unit = "iterations/s"
"#;

#[test]
fn light_volumes_are_part_of_what_is_measured() {
    let folder = folder(SUITE);
    let ran = bench(&folder, &["--quiet"]);
    assert_eq!((ran.code, ran.err.as_str()), (Some(0), ""), "{}", ran.err);
    let results = results(&folder, "out/results.json");
    let [two, six, convection, itself] = &results.cases[..] else { panic!("{} cases", results.cases.len()) };
    for (case, iterations) in [(two, 2), (six, 6), (convection, 5), (itself, 2)] {
        for repeat in &case.repeats {
            let light = repeat.light.expect("a light volume");
            assert_eq!(light.iterations, Some(iterations), "{}", case.name);
            // The clock starts before it, and once: the warm-up has computed one before.
            let seconds: Vec<f64> = repeat.checkpoints.iter().map(|checkpoint| checkpoint.seconds).collect();
            assert!(light.seconds > 0.0 && seconds[0] > light.seconds && seconds.is_sorted(), "{repeat:?}");
            assert!(repeat.checkpoints.iter().all(|checkpoint| checkpoint.faults == 0));
        }
        let errors = &case.summary.time_to_error;
        assert!(errors.iter().all(|time| time.measured), "light's noise stays: {errors:?}");
    }
    for case in [two, six] {
        assert_eq!(case.repeats[0].checkpoints[0].lookups, rendered_lookups(&folder, case), "{}", case.name);
        assert!(case.repeats[0].checkpoints[0].metrics.mse != case.repeats[1].checkpoints[0].metrics.mse);
    }
    assert!(results.published[0].ours[0].value > 0.0);
    // Nothing is random but the light, in which the reference's four streams differ: more samples do not better it, and it
    // ends above what was asked for.
    assert!(itself.deterministic && itself.reference.samples == Some(4), "{:?}", itself.reference);
    assert!(itself.reference.relative_error.unwrap() > 1e-5, "{:?}", itself.reference);
    let models = results.findings.iter().filter(|finding| finding.kind == FindingKind::Bias);
    assert!(models.clone().count() >= 3 && models.clone().all(|f| f.text.contains("the models differ")));
    let plot = std::fs::read_to_string(folder.path("out/plots/01-sphere-error-time.svg")).unwrap();
    assert!(plot.contains(">hybrid, 2 and 6 estimates<") && !plot.contains(">hybrid, 2<"), "{plot}");
}

/// What `svetlo render` says of the first repeat's first checkpoint.
fn rendered_lookups(folder: &crate::support::Folder, case: &Case) -> u64 {
    let seed = case.repeats[0].seed.to_string();
    let mut arguments =
        vec!["render", "scene.toml", "-o", "a.exr", "--json", "--samples", "1", "--seed", &seed];
    case.overrides.iter().for_each(|set| arguments.extend(["--set", set]));
    let report: serde_json::Value = serde_json::from_str(&folder.succeed(&arguments).out).unwrap();
    let of_light = report["light"]["cost"]["lookups"].as_u64().unwrap();
    let all = report["lookups"].as_u64().unwrap();
    assert!(0 < of_light && of_light < all, "{report}");
    all
}
