//! A bench that is interrupted keeps what is finished, and goes on from there.

use crate::support::{interrupt, wait_until};
use crate::{bench, folder, results};
use std::process::Stdio;

const SUITE: &str = r#"
title = "Resume"
repeats = 2
reference = { kind = "constant", value = 0.5 }
[[case]]
name = "short"
scene = "scene.toml"
checkpoints = { samples = [1, 2] }
[[case]]
name = "long"
scene = "scene.toml"
checkpoints = { samples = [1, LONG] }
"#;

#[test]
fn an_interrupted_bench_keeps_what_is_finished_and_goes_on() {
    let folder = folder(&SUITE.replace("LONG", "100000000"));
    let mut child = folder
        .svetlo(&["bench", "suite.toml", "-o", "out", "--quiet", "--no-selftest"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let pieces = || {
        let names = std::fs::read_dir(folder.path("out/runs")).into_iter().flatten();
        let mut names: Vec<_> = names.map(|entry| entry.unwrap().file_name()).collect();
        names.retain(|name| name.to_string_lossy().ends_with(".json"));
        names.sort();
        names
    };
    wait_until(|| pieces().len() == 1 || child.try_wait().unwrap().is_some());
    let first = pieces();
    // Into the middle of the long piece.
    std::thread::sleep(std::time::Duration::from_millis(300));
    interrupt(&child);
    let took = wait_until(|| child.try_wait().unwrap().is_some());
    assert!(took.as_secs() < 10, "an interrupt is answered at once, not after {took:?}");
    let output = child.wait_with_output().unwrap();
    let err = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{err}");
    assert!(err.contains("run it again with the same folder to go on"), "{err}");
    let partial = results(&folder, "out/results.json");
    assert!(!partial.complete);
    let finished: Vec<usize> = partial.cases.iter().map(|case| case.repeats.len()).collect();
    assert_eq!(finished, [1, 0]);
    assert!(csv::Reader::from_path(folder.path("out/results.csv")).unwrap().records().count() == 2);

    // The other case has become short: its pieces are new, the finished one is not measured again.
    folder.write("suite.toml", SUITE.replace("LONG", "3"));
    let ran = bench(&folder, &[]);
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert!(ran.err.contains("1/4 short on ") && ran.err.contains("there already"), "{}", ran.err);
    assert_eq!(ran.err.matches("there already").count(), 1, "{}", ran.err);
    assert!(pieces().contains(&first[0]) && pieces().len() == 4);
    let whole = results(&folder, "out/results.json");
    assert!(whole.complete);
    assert_eq!(whole.cases[0].repeats[0], partial.cases[0].repeats[0]);

    // Everything is there.
    let again = bench(&folder, &[]);
    assert_eq!(again.err.matches("there already").count(), 4, "{}", again.err);
    assert!(results(&folder, "out/results.json").cases == whole.cases);

    // A damaged picture is measured again.
    let picture = folder.path("out/runs").join(&first[0]).with_extension("exr");
    std::fs::write(&picture, "").unwrap();
    let repaired = bench(&folder, &[]);
    assert_eq!(repaired.code, Some(0), "{}", repaired.err);
    assert_eq!(repaired.err.matches("there already").count(), 3, "{}", repaired.err);

    // Another scene is another piece.
    folder.write("scene.toml", crate::support::SCENE.replace("sigma_max = 5", "sigma_max = 6"));
    assert_eq!(bench(&folder, &[]).err.matches("there already").count(), 0);
}

#[test]
fn a_reference_is_rendered_once_and_goes_on_to_a_smaller_error() {
    let suite = |error: &str| {
        format!(
            "title = \"x\"\nrepeats = 1\ncheckpoints = {{ samples = [1] }}\nreference = {{ error = \"{error}\" }}\n\
             set = [\"background.color=1\", \"medium.albedo=0.5\", 'method={{kind=\"multiple-scattering\",paths=1}}']\n\
             [[case]]\nname = \"a\"\nscene = \"scene.toml\"\nvary = [[{{ name = \"p\", set = [] }}, {{ name = \"q\", \
             set = [\"film.exposure=2\"] }}]]\n"
        )
    };
    let folder = folder(&suite("3%"));
    let streams = || {
        let names = std::fs::read_dir(folder.path("out/references")).unwrap();
        let mut files: Vec<_> = names.map(|entry| entry.unwrap().path()).collect();
        files.sort();
        files.into_iter().map(|path| (std::fs::read(&path).unwrap(), path)).collect::<Vec<_>>()
    };
    bench(&folder, &["--quiet"]);
    // Both cases have the same pixels, hence one reference: its streams and their mean.
    let before = streams();
    assert_eq!(before.len(), 5);
    let first = results(&folder, "out/results.json").cases[0].reference.clone();
    bench(&folder, &["--quiet"]);
    assert!(before == streams(), "nothing was rendered again");
    folder.write("suite.toml", suite("1%"));
    let ran = bench(&folder, &[]);
    // Errors against another reference are others; but the second case renders what the first did.
    assert_eq!(ran.err.matches("there already").count(), 1, "{}", ran.err);
    let second = &results(&folder, "out/results.json").cases[0].reference;
    assert_eq!(first.image, second.image);
    assert!(second.samples > first.samples && second.relative_error.unwrap() <= 0.01, "{second:?}");
}
