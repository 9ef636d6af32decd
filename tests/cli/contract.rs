//! Commands and options: exit codes, JSON, overrides, stop rules, seeds, devices.

use crate::support::{Folder, run};
use serde_json::Value;
use svetlo::picture::Picture;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

fn metadata(picture: &Picture, key: &str) -> String {
    picture.metadata.get(&format!("svetlo.{key}")).unwrap_or_else(|| panic!("no svetlo.{key}")).clone()
}

#[test]
fn render_writes_an_image_and_a_preview_and_says_where() {
    let folder = Folder::new();
    let ran = folder.succeed(&["render", "scene.toml"]);
    assert_eq!(ran.out, "wrote scene.exr and its preview scene.png\n");
    assert!(ran.err.contains("3 samples in "), "{}", ran.err);
    assert_eq!(folder.names(), ["scene.exr", "scene.png", "scene.toml"]);
}

#[test]
fn json_is_one_document_and_all_of_stdout() {
    let folder = Folder::new();
    let ran = folder.succeed(&["render", "scene.toml", "--json", "-o", "a.exr"]);
    let summary = json(&ran.out);
    assert_eq!(summary["output"], "a.exr");
    assert_eq!(summary["preview"], "a.png");
    assert_eq!(summary["samples"], 3);
    assert_eq!(summary["ended"], "samples");
    assert_eq!(summary["method"], "emission-absorption");
    assert!(summary["seconds"]["wall"].as_f64().unwrap() >= summary["seconds"]["device"].as_f64().unwrap());
    assert_eq!(summary["rejected_samples"], 0);
    assert!(ran.err.contains("note: "), "notes go to stderr: {}", ran.err);

    let devices = json(&folder.succeed(&["devices", "--json"]).out);
    assert!(!devices["devices"].as_array().unwrap().is_empty());
    let comparison = folder.succeed(&["compare", "a.exr", "a.exr", "--json"]);
    assert_eq!(json(&comparison.out)["image"], "a.exr");
    let schema = json(&folder.succeed(&["schema"]).out);
    assert!(schema["properties"]["camera"].is_object());
}

#[test]
fn quiet_prints_nothing_and_still_reports_json() {
    let folder = Folder::new();
    let ran = folder.succeed(&["render", "scene.toml", "--quiet"]);
    assert_eq!((ran.out.as_str(), ran.err.as_str()), ("", ""));
    let ran = folder.succeed(&["render", "scene.toml", "--quiet", "--json"]);
    assert_eq!(json(&ran.out)["samples"], 3);
    assert_eq!(ran.err, "");
}

#[test]
fn metadata_say_how_the_image_came_to_be() {
    let folder = Folder::new();
    folder.succeed(&["render", "scene.toml", "--seed", "7", "--quiet"]);
    let image = folder.image("scene.exr");
    for (key, value) in [
        ("version", env!("CARGO_PKG_VERSION")),
        ("method", "emission-absorption"),
        ("seed", "7"),
        ("samples", "3"),
        ("rejected_samples", "0"),
    ] {
        assert_eq!(metadata(&image, key), value, "{key}");
    }
    for key in ["seconds_wall", "seconds_device", "seconds_build", "estimated_error", "lookups", "launches"] {
        assert!(metadata(&image, key).parse::<f64>().is_ok_and(|number| number >= 0.0), "{key}");
    }
    for key in ["device", "platform", "driver", "scene_hash"] {
        assert!(!metadata(&image, key).is_empty(), "{key}");
    }
    for channel in ["R", "G", "B", "A", "variance.R", "samples"] {
        assert!(image.channel(channel).is_some(), "{channel}");
    }
}

#[test]
fn set_overrides_numbers_tables_words_and_entries_of_lists() {
    let folder = Folder::new();
    let sets = [
        "image.width=9",
        "volume.dims.2=5",
        "volume.field={ kind = \"ramp\", axis = \"x\" }",
        "camera.target=[0.5, 0.5, 0.25]",
        "image.filter=point",
        "stop.samples=1",
    ];
    let arguments: Vec<&str> = ["render", "scene.toml", "--quiet"]
        .into_iter()
        .chain(sets.iter().flat_map(|set| ["--set", set]))
        .collect();
    folder.succeed(&arguments);
    let image = folder.image("scene.exr");
    assert_eq!((image.width, image.height), (9, 16));
    let checked = folder.succeed(&["check", "scene.toml", "--set", sets[1]]).out;
    assert!(checked.contains("8×8×5 float32"), "{checked}");
}

#[test]
fn wrong_overrides_are_shown_where_they_are_wrong() {
    let folder = Folder::new();
    for (set, needle) in [
        ("image.widht=9", "`width`"),
        ("image.width=wide", "`image.width` must be a whole number"),
        ("image.width", "--set image.width=256"),
        ("volume.dims.7=4", "its entries are 0 to 2"),
        ("seed.x=1", "`seed` "),
        (".=1", "empty part"),
    ] {
        folder.run(&["render", "scene.toml", "--set", set]).fails_with(2, needle);
        folder.run(&["check", "scene.toml", "--set", set]).fails_with(2, needle);
    }
    assert_eq!(folder.names(), ["scene.toml"]);
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_one_does_not() {
    let folder = Folder::new();
    for (seed, name) in [("5", "a.exr"), ("5", "b.exr"), ("6", "c.exr")] {
        folder.succeed(&["render", "scene.toml", "--seed", seed, "-o", name, "--quiet"]);
    }
    assert_eq!(folder.image("a.exr").channels, folder.image("b.exr").channels);
    let red = |name| folder.image(name).channel("R").unwrap().to_f32().into_owned();
    assert_ne!(red("a.exr"), red("c.exr"));
    assert_ne!(
        metadata(&folder.image("a.exr"), "scene_hash"),
        metadata(&folder.image("c.exr"), "scene_hash")
    );
}

#[test]
fn stop_rules_of_the_command_line_replace_those_of_the_scene() {
    let folder = Folder::new();
    let summary = |more: &[&str]| {
        let arguments = [&["render", "scene.toml", "--json", "--quiet"], more].concat();
        json(&folder.succeed(&arguments).out)
    };
    assert_eq!(summary(&["--samples", "5"])["samples"], 5);
    let timed = summary(&["--time", "300ms"]);
    assert_eq!(timed["ended"], "time");
    assert!(timed["samples"].as_u64().unwrap() > 3, "the scene's own limit still holds: {timed}");
    let accurate = summary(&["--error", "5%"]);
    assert_eq!(accurate["ended"], "error");
    assert!(accurate["estimated_error"].as_f64().unwrap() <= 0.05, "{accurate}");
    assert!(accurate["samples"].as_u64().unwrap() > 3, "{accurate}");
    // Whichever comes first.
    assert_eq!(summary(&["--samples", "2", "--time", "1h"])["ended"], "samples");
}

#[test]
fn a_scene_without_randomness_stops_after_one_sample_and_says_why() {
    let folder = Folder::new();
    let ran = folder.succeed(&["render", "scene.toml", "--set", "image.filter=point"]);
    assert!(
        ran.err.contains("1 sample in ") && ran.err.contains("nothing in this scene is random"),
        "{}",
        ran.err
    );
    let checked = folder.succeed(&["check", "scene.toml", "--set", "image.filter=point"]).out;
    assert!(checked.contains("after 1 sample"), "{checked}");
}

#[test]
fn options_out_of_range_are_named() {
    let folder = Folder::new();
    for (option, value, needle) in [
        ("--samples", "0", "0 is not in 1..=1000000000"),
        ("--samples", "-1", "--samples"),
        ("--time", "0s", "longer than zero"),
        ("--time", "30", "with its unit"),
        ("--error", "0%", "more than 0"),
        ("--error", "0.01", "percent sign"),
        ("--seed", "-1", "--seed"),
        ("--seed", "18446744073709551616", "--seed"),
    ] {
        folder.run(&["render", "scene.toml", option, value]).fails_with(2, needle);
    }
    folder.run(&["rendr", "scene.toml"]).fails_with(2, "'render'");
    folder.run(&["render"]).fails_with(2, "<SCENE>");
    assert_eq!(folder.names(), ["scene.toml"]);
}

#[test]
fn devices_are_picked_by_selector_kind_and_name() {
    let folder = Folder::new();
    let devices = json(&folder.succeed(&["devices", "--json"]).out);
    let first = &devices["devices"][0];
    let (selector, name) = (first["selector"].as_str().unwrap(), first["name"].as_str().unwrap());
    for wanted in [selector, "0", &name.to_uppercase()] {
        let ran = folder.succeed(&["render", "scene.toml", "--json", "--quiet", "--device", wanted]);
        assert_eq!(json(&ran.out)["device"]["selector"], selector);
    }
    let listed = folder.succeed(&["devices"]).out;
    assert!(listed.contains(selector) && listed.contains("default: "), "{listed}");
}

#[test]
fn a_device_that_is_not_there_lists_those_that_are() {
    let folder = Folder::new();
    let listed = format!(
        "\n  {}",
        json(&folder.succeed(&["devices", "--json"]).out)["devices"][0]["selector"].as_str().unwrap()
    );
    folder.run(&["render", "scene.toml", "--device", "nonsense"]).fails_with(2, &listed);
    folder.run(&["render", "scene.toml", "--device", "99"]).fails_with(2, "'99'");
    let by_variable = |value: &str, more: &[&str]| {
        let arguments = [&["render", "scene.toml", "--quiet"], more].concat();
        run(folder.svetlo(&arguments).env("SVETLO_DEVICE", value))
    };
    by_variable("nonsense", &[]).fails_with(2, "'nonsense'");
    assert_eq!(by_variable("", &[]).code, Some(0), "an empty variable is no choice");
    assert_eq!(by_variable("nonsense", &["--device", "0"]).code, Some(0), "the option comes first");
}

#[test]
fn compare_ends_with_3_out_of_tolerance() {
    let folder = Folder::new();
    folder.succeed(&["render", "scene.toml", "-o", "a.exr", "--quiet"]);
    folder.succeed(&["render", "scene.toml", "-o", "b.exr", "--quiet", "--seed", "2"]);
    folder.succeed(&["compare", "a.exr", "b.exr", "--max-rmse", "10", "--diff", "d.png"]);
    assert!(folder.path("d.png").exists());
    let ran = folder.run(&["compare", "a.exr", "b.exr", "--max-rmse", "1e-9"]);
    assert_eq!(ran.code, Some(3));
    assert!(ran.out.contains("RMSE"), "the report is printed all the same: {}", ran.out);
    assert!(ran.err.starts_with("error: a.exr: out of tolerance: "), "{}", ran.err);
    folder.run(&["compare", "a.exr", "none.exr"]).fails_with(2, "none.exr");
    folder.succeed(&["render", "scene.toml", "-o", "c.exr", "--quiet", "--set", "image.width=8"]);
    folder.run(&["compare", "a.exr", "c.exr"]).fails_with(2, "a.exr and c.exr");
}

#[test]
fn help_is_on_stdout_and_names_the_exit_codes() {
    let folder = Folder::new();
    let help = folder.succeed(&["--help"]);
    for word in ["render", "check", "devices", "compare", "schema", "130"] {
        assert!(help.out.contains(word), "{word}");
    }
    assert_eq!(help.err, "");
    assert_eq!(folder.succeed(&["--version"]).out, concat!("svetlo ", env!("CARGO_PKG_VERSION"), "\n"));
}
