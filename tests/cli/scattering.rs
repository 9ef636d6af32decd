//! What `svetlo` says of scattering renders: the ledger in words, in JSON and in the image.

use crate::support::Folder;
use serde_json::Value;

const MEDIUM: &str =
    "transfer={ points = [{ value = 0, opacity = 0 }, { value = 1, opacity = 1, color = [0.9, 0.6, 0.3] }] }";

fn sets<'a>(method: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let scene = ["render", "scene.toml", "--set", MEDIUM, "--set", "background.color=1", "--set", method];
    [&scene, more].concat()
}

#[test]
fn the_summary_tells_where_the_energy_went() {
    let folder = Folder::new();
    let ran = folder.succeed(&sets("method={ kind = \"multiple-scattering\" }", &[]));
    let line = ran.err.lines().find(|line| line.starts_with("energy: ")).expect(&ran.err);
    for part in [" % escaped, ", " % absorbed; ", " look-ups per path, ", " % of them null collisions"] {
        assert!(line.contains(part), "{part}: {line}");
    }
    assert!(!ran.err.contains("max_order"), "{}", ran.err);
    let limited = folder.succeed(&sets("method={ kind = \"multiple-scattering\", max_order = 1 }", &[]));
    assert!(limited.err.contains(" % cut by max_order; "), "{}", limited.err);
    assert!(limited.err.contains("note: method.max_order = 1 cuts "), "{}", limited.err);
    let single = folder.succeed(&sets("method={ kind = \"single-scattering\" }", &[]));
    assert!(single.err.contains(" % left out beyond the first scattering"), "{}", single.err);
    let quiet = folder.succeed(&sets("method={ kind = \"single-scattering\" }", &["--quiet"]));
    assert_eq!(quiet.err, "");
    assert!(!folder.succeed(&["render", "scene.toml"]).err.contains("energy"));
}

#[test]
fn an_error_that_cannot_be_estimated_ends_a_render_that_waits_for_it() {
    let folder = Folder::new();
    // All samples are infinite, or their squares are.
    for (radiance, needle) in [("1e39", "samples were not finite"), ("1e25", "the error cannot be estimated")]
    {
        let background = format!("background.color={radiance}");
        let set = sets(
            "method={ kind = \"multiple-scattering\" }",
            &["--set", &background, "--error", "50%", "--quiet"],
        );
        folder.run(&set).fails_with(1, needle);
    }
    let noted = sets("method={ kind = \"multiple-scattering\" }", &["--set", "background.color=1e25"]);
    let ran = folder.succeed(&noted);
    assert!(ran.err.contains("note: the error is not known"), "{}", ran.err);
    assert!(!ran.err.contains("estimated error"), "{}", ran.err);
}

#[test]
fn check_tells_what_tracking_costs() {
    let folder = Folder::new();
    let check = |transfer: &str, more: &[&str]| {
        let method = ["--set", "method={ kind = \"multiple-scattering\" }", "--set", transfer];
        folder.succeed(&[&["check", "scene.toml"], &method[..], more].concat()).out
    };
    let flat = "transfer={ points = [{ value = 0, opacity = 0.5 }] }";
    let out = check(flat, &[]);
    assert!(out.contains("the extinction is 2.5 per scene unit everywhere: rays take no look-ups"), "{out}");
    // The majorant of a constant medium is its extinction, but for rounding.
    let out = check(flat, &["--set", "method.majorant_scale=3"]);
    assert!(
        out.contains(
            "no brick is empty; mean extinction 2.5 per scene unit; 3.00 look-ups per unit of optical depth"
        ),
        "{out}"
    );
    assert!(out.contains("transmittance auto: "), "{out}");
    let out = check("transfer={ points = [{ value = 0, opacity = 0 }] }", &[]);
    assert!(out.contains("nothing has extinction: rays pass") && !out.contains("transmittance"), "{out}");
    // Eight bricks per edge, and nothing but a ball in the middle.
    let ball = ["--set", "volume.dims=[64, 64, 64]", "--set", "volume.spacing=0.015625"];
    let out =
        check("transfer={ points = [{ value = 0.9, opacity = 0 }, { value = 1, opacity = 1 }] }", &ball);
    let line = out.lines().find(|line| line.contains(" % of the box is in empty bricks; ")).expect(&out);
    let empty: f64 = line.trim_start_matches("note").trim().split(' ').next().unwrap().parse().unwrap();
    assert!(empty > 20.0 && empty < 99.0, "{line}");
}

#[test]
fn json_and_header_hold_the_same_ledger() {
    let folder = Folder::new();
    let method = "method={ kind = \"multiple-scattering\", max_order = 3, paths = 2 }";
    let ran = folder.succeed(&sets(method, &["--json", "--quiet", "--samples", "5"]));
    let summary: Value = serde_json::from_str(&ran.out).unwrap();
    let paths = &summary["paths"];
    let header = folder.image("scene.exr").metadata;
    let number = |key: &str| header[&format!("svetlo.{key}")].parse::<f64>().unwrap();
    let count = 24.0 * 16.0 * 5.0 * 2.0;
    assert_eq!((number("paths"), paths["count"].as_f64().unwrap()), (count, count));
    for key in ["lookups", "null_collisions", "above_majorant", "unfinished"] {
        assert_eq!(paths[key].as_f64().unwrap(), number(key), "{key}");
    }
    assert_eq!(summary["lookups"], paths["lookups"]);
    let mut total = 0.0;
    for (key, sign) in [("escaped", 1.0), ("absorbed", 1.0), ("cut", 1.0), ("gained", -1.0)] {
        let share = paths[key].as_f64().unwrap();
        assert!((share - number(key) / count).abs() < 1e-12, "{key}");
        total += sign * share;
    }
    assert!((total - 1.0 - paths["imbalance"].as_f64().unwrap()).abs() < 1e-12);
    assert!(paths["meaning"].as_str().unwrap().contains("escaped + absorbed + cut"));
    let other: Value =
        serde_json::from_str(&folder.succeed(&["render", "scene.toml", "--json", "--quiet"]).out).unwrap();
    assert_eq!(other["paths"], Value::Null);
}
