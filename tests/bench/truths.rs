//! Cases that state what is known of them: right, off, refused, too slow; and the hard cases.

use crate::support::Folder;
use crate::{bench, folder, results};
use std::path::{Path, PathBuf};
use svetlo::bench::results::FindingKind;
use svetlo::bench::suite::Suite;
use svetlo::bench::truth_table::Verdict;

fn suite(cases: &str) -> String {
    format!("title = \"x\"\nrepeats = 1\nwarmup = 0\ncheckpoints = {{ samples = [4] }}\n{cases}")
}

/// A case of which nothing but the background is seen: radiance 0.5 in every pixel.
fn empty(name: &str, keys: &str) -> String {
    format!(
        "[[case]]\nname = \"{name}\"\nscene = \"scene.toml\"\nset = [\"medium.sigma_max=0\", \"background.color=0.5\"]\n{keys}\n"
    )
}

#[test]
fn a_truth_that_holds_is_right_and_one_that_does_not_is_exit_code_3() {
    let cases = [
        empty("holds", "truth = { value = 0.5, of = \"each\", source = \"closed form\" }"),
        empty("off by 2 %", "truth = { value = 0.51 }"),
        empty("off by less than its error", "truth = { value = 0.51, error = 0.003 }"),
        empty("off by less than its tolerance", "truth = { value = 0.51, tolerance = \"2%\" }"),
        empty(
            "off in one pixel",
            "truth = { value = [0.5, 0.5, 0.49], of = \"each\", region = [3, 2, 4, 3] }",
        ),
    ];
    let folder = folder(&suite(&cases.concat()));
    let ran = bench(&folder, &["--quiet"]);
    assert_eq!(ran.code, Some(3), "{}", ran.err);
    assert!(ran.err.contains("off by 2 %: off: the mean is 5.000000e-1, not 5.100000e-1"), "{}", ran.err);
    assert!(ran.err.contains("off in one pixel: off: a pixel is "), "{}", ran.err);
    assert!(ran.out.contains("3 right, 2 OFF"), "{}", ran.out);
    let found = results(&folder, "out/results.json");
    let verdicts: Vec<Verdict> = found.cases.iter().map(Verdict::of).collect();
    let (right, off) = (Verdict::Right, Verdict::Off);
    assert_eq!(verdicts, [right, off, right, right, off]);
    let kinds: Vec<FindingKind> = found.findings.iter().map(|finding| finding.kind).collect();
    assert_eq!(kinds, [FindingKind::Truth, FindingKind::Truth, FindingKind::Selftest]);
    // Without the two that are off, all is well.
    let ran = bench(&folder, &["--quiet", "--case", "holds", "--case", "less than"]);
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert!(ran.out.contains("3 right\n"), "{}", ran.out);
    bench(&folder, &["--case", "hold "]).fails_with(2, "no case has \"hold \" in its name");
}

#[test]
fn noise_is_allowed_for_and_a_bias_beyond_it_is_not() {
    let case = |name: &str, value: f64| {
        format!(
            "[[case]]\nname = \"{name}\"\nscene = \"scene.toml\"\ncheckpoints = {{ samples = [64] }}\n\
             set = [\"method={{kind=\\\"multiple-scattering\\\"}}\", \"medium.albedo=0\", \"background.color=1\", \"camera.fov=1\"]\n\
             truth = {{ value = {value} }}\n"
        )
    };
    // The ray through the middle of the sphere: opacity = value, 0.3 - r on the axis but for the voxels. What it is, the
    // first run tells; the second asks for it, and for a tenth more.
    let folder = folder(&suite(&case("unknown", 2.0)));
    assert_eq!(bench(&folder, &["--quiet"]).code, Some(3));
    let judged = results(&folder, "out/results.json").cases[0].truth.clone().unwrap();
    let (found, sigma) = (judged.found[0], judged.standard_error.unwrap()[0]);
    assert!(sigma > 1e-5 * found && sigma < 0.05 * found, "{found} ± {sigma}");
    let close = case("within", found + 4.0 * sigma) + &case("beyond", found + 6.0 * sigma);
    folder.write("suite.toml", suite(&close));
    let ran = bench(&folder, &["--quiet"]);
    assert_eq!(ran.code, Some(3), "{}", ran.err);
    let cases = results(&folder, "out/results.json").cases;
    let z = |index: usize| cases[index].truth.as_ref().unwrap().z.unwrap();
    assert!((z(0) + 4.0).abs() < 1e-6 && (z(1) + 6.0).abs() < 1e-6, "{} {}", z(0), z(1));
    assert_eq!((Verdict::of(&cases[0]), Verdict::of(&cases[1])), (Verdict::Right, Verdict::Off));
}

#[test]
fn what_must_be_refused_is_refused_for_its_reason() {
    let case = |name: &str, set: &str, message: &str| {
        format!(
            "[[case]]\nname = \"{name}\"\nscene = \"scene.toml\"\nset = [\"{set}\"]\nrefuses = \"{message}\"\n"
        )
    };
    let good = case("bad width", "image.width=0", "`image.width` is out of range");
    let folder = folder(&suite(&good));
    let ran = bench(&folder, &["--quiet"]);
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert!(ran.out.contains("1 refused"), "{}", ran.out);
    let taken = case("good width", "image.width=8", "out of range");
    let other = case("no key", "image.widht=8", "out of range");
    folder.write("suite.toml", suite(&[good, taken, other].concat()));
    let ran = bench(&folder, &["--quiet"]);
    assert_eq!(ran.code, Some(3), "{}", ran.err);
    assert!(ran.err.contains("good width: not refused"), "{}", ran.err);
    assert!(ran.err.contains("no key: refused for another reason than \"out of range\""), "{}", ran.err);
}

#[test]
fn a_case_that_fails_or_takes_too_long_leaves_the_others() {
    let cases = [
        empty("slow", "limit = \"150ms\"\ncheckpoints = { samples = [1000000000] }\ntruth = { value = 0.5 }"),
        // Found out when the data are read.
        "[[case]]\nname = \"thick\"\nscene = \"scene.toml\"\ntruth = { value = 0.5 }\n\
         set = [\"medium.sigma_max=1e30\", \"method={kind=\\\"multiple-scattering\\\"}\"]\n"
            .into(),
        empty("fine", "truth = { value = 0.5 }"),
    ];
    let folder = folder(&suite(&cases.concat()));
    let ran = bench(&folder, &["--quiet"]);
    assert_eq!(ran.code, Some(3), "{}", ran.err);
    assert!(
        ran.err.contains("slow: not measured:") && ran.err.contains("longer than its limit"),
        "{}",
        ran.err
    );
    assert!(ran.err.contains("thick: not measured:") && ran.err.contains("mean free paths"), "{}", ran.err);
    assert!(ran.out.contains("1 right, 2 FAILED"), "{}", ran.out);
}

#[test]
fn regions_lie_in_the_image() {
    let folder = folder(&suite(&empty("a", "truth = { value = 0.5, region = [0, 0, 25, 16] }")));
    bench(&folder, &[])
        .fails_with(2, "the region [0, 0, 25, 16] of the truth is not in the image of 24×16 pixels");
}

fn hard_cases() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/hard");
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut suites: Vec<_> =
        entries.filter(|path| path.extension().is_some_and(|extension| extension == "toml")).collect();
    suites.sort();
    suites
}

#[test]
fn hard_cases_say_why_they_are_hard_and_whence_their_truth_is() {
    let mut count = 0;
    for path in hard_cases() {
        assert!(std::fs::read_to_string(&path).unwrap().starts_with("# "), "{}", path.display());
        let suite = Suite::load(&path).unwrap();
        for case in &suite.cases {
            let truth = case.truth.as_ref().unwrap_or_else(|| panic!("{} has no truth", case.name));
            assert!(!case.about.is_empty() && !truth.source.is_empty(), "{}", case.name);
            assert!(case.limit.is_some(), "{} may take for ever", case.name);
        }
        count += suite.cases.len() + suite.refusals.len();
    }
    assert!(count > 150, "{count} cases");
}

/// The quick ones of every suite; all of them are for people, by `svetlo bench`.
#[test]
fn some_hard_cases_are_right() {
    let quick: [(&str, &[&str]); 4] = [
        (
            "absorption",
            &["constant, thin", "ramp, ", "needle", "maximum of one voxel", "window", "extinction"],
        ),
        (
            "scattering",
            &["τ 2, g 0.75", "furnace, g -0.99", "ramp in the sun, analog", "τ 10^6", "to follow"],
        ),
        ("diffusion", &["near vacuum, convection", "in larger cells"]),
        ("caustics", &["lamp over a floor", "lamp under", "two materials"]),
    ];
    let folder = Folder::new();
    for path in hard_cases() {
        let name = path.file_stem().unwrap().to_string_lossy();
        let (_, cases) = quick.iter().find(|(suite, _)| *suite == name).unwrap();
        let mut arguments = vec!["bench", path.to_str().unwrap(), "-o", "out", "--no-selftest", "--quiet"];
        arguments.extend(cases.iter().flat_map(|case| ["--case", case]));
        let ran = folder.run(&arguments);
        assert_eq!(ran.code, Some(0), "{}\n{}", ran.err, ran.out);
    }
}
