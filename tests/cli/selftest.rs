//! `svetlo selftest`: its table, its JSON, its exit codes.

use crate::support::{Folder, run};
use serde_json::Value;
use svetlo::selftest::{CHECKS, Verdict};

#[test]
fn a_device_that_computes_what_it_should_passes() {
    let folder = Folder::new();
    let ran = folder.succeed(&["selftest", "--device", "0", "--only", "layout", "--only", "mip"]);
    for text in ["check", "layout", "mip", "tolerance", " ok ", "2 checks, 2 comparisons in ", ": passed"] {
        assert!(ran.out.contains(text), "no {text:?} in\n{}", ran.out);
    }
    assert_eq!(ran.err, "");
    assert_eq!(folder.names(), ["scene.toml"]);
}

#[test]
fn json_holds_every_verdict() {
    let folder = Folder::new();
    let ran = folder.succeed(&["selftest", "--json", "--only", "film", "--only", "random"]);
    let value: Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!(value["passed"], true);
    let device = &value["devices"][0];
    assert_eq!((&device["passed"], &device["device"]["selector"]), (&true.into(), &"0:0".into()));
    let verdicts: Vec<Verdict> = serde_json::from_value(device["verdicts"].clone()).unwrap();
    // In the order in which they run.
    let mut names: Vec<&str> = verdicts.iter().map(|verdict| verdict.check.as_str()).collect();
    names.dedup();
    assert_eq!(names, ["random", "film"]);
    for verdict in verdicts {
        assert!((verdict.measured.unwrap() - verdict.expected).abs() <= verdict.tolerance, "{verdict:?}");
        assert!(!verdict.reason.is_empty() && !verdict.proves.is_empty() && verdict.problem.is_none());
    }
}

/// A compiler that takes liberties: PoCL's own, told to by its environment, in caches of its own.
#[test]
fn a_device_that_does_not_is_exit_code_3() {
    let folder = Folder::new();
    if !folder.succeed(&["devices"]).out.contains("Portable Computing Language") {
        println!("skipped: only PoCL can be told to compile wrongly");
        return;
    }
    std::fs::create_dir(folder.path("pocl")).unwrap();
    let wrong = |arguments: &[&str]| {
        let mut command = folder.svetlo(arguments);
        command.env("POCL_EXTRA_BUILD_FLAGS", "-cl-fast-relaxed-math");
        command.env("POCL_CACHE_DIR", folder.path("pocl")).env("SVETLO_CACHE_DIR", "");
        run(&mut command)
    };
    let ran = wrong(&["selftest", "--device", "portable", "--only", "film"]);
    assert_eq!(ran.code, Some(3), "{}{}", ran.out, ran.err);
    assert!(ran.out.contains("FAILED  their variance") && ran.out.contains(": 1 FAILED"), "{}", ran.out);
    assert!(ran.err.starts_with("error: pictures made on ") && ran.err.lines().count() == 1, "{}", ran.err);
    let ran = wrong(&["selftest", "--device", "portable", "--only", "film", "--json"]);
    assert_eq!(ran.code, Some(3), "{}", ran.err);
    let value: Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!((&value["passed"], &value["devices"][0]["passed"]), (&false.into(), &false.into()));
}

#[test]
fn what_is_not_there_is_a_wrong_argument() {
    let folder = Folder::new();
    folder.run(&["selftest", "--device", "no such"]).fails_with(2, "no OpenCL device matches 'no such'");
    let ran = folder.run(&["selftest", "--only", "luck"]);
    ran.fails_with(2, "invalid value 'luck'");
    for check in CHECKS {
        assert!(ran.err.contains(check.name), "{}", ran.err);
    }
    std::fs::create_dir(folder.path("vendors")).unwrap();
    let ran = run(folder.svetlo(&["selftest"]).env("OCL_ICD_VENDORS", folder.path("vendors")));
    ran.fails_with(1, "apt-get install pocl-opencl-icd");
}
