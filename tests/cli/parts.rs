//! `render --part` and `merge` from the command line: what fits together is added, all else is refused by name.

use crate::support::{Folder, Ran};
use serde_json::Value;
use svetlo::picture::{Picture, Samples, write_exr};

/// `svetlo render scene.toml --part PART --quiet` with more arguments.
fn part(folder: &Folder, part: &str, more: &[&str]) {
    folder.succeed(&[&["render", "scene.toml", "--quiet", "--part", part], more].concat());
}

/// A folder with the parts 1 to 3 of 3 of a picture of 8 samples.
fn three() -> Folder {
    let folder = Folder::new();
    ["1/3", "2/3", "3/3"].iter().for_each(|text| part(&folder, text, &["--samples", "8"]));
    folder
}

fn json(ran: &Ran) -> Value {
    serde_json::from_str(&ran.out).unwrap_or_else(|error| panic!("{error}: {}", ran.out))
}

fn metadata(picture: &Picture, key: &str) -> String {
    picture.metadata.get(&format!("svetlo.{key}")).cloned().unwrap_or_default()
}

/// Refuses and writes nothing.
#[track_caller]
fn refuses(folder: &Folder, arguments: &[&str], needle: &str) {
    let before = folder.names();
    folder.run(arguments).fails_with(2, needle);
    assert_eq!(folder.names(), before);
}

#[test]
fn parts_are_named_rendered_and_merged() {
    let folder = three();
    let images: Vec<String> = folder.names().into_iter().filter(|name| name.ends_with(".exr")).collect();
    assert_eq!(images, ["scene.1-of-3.exr", "scene.2-of-3.exr", "scene.3-of-3.exr"]);
    for (name, text, samples) in
        [("scene.1-of-3.exr", "1/3", "3"), ("scene.2-of-3.exr", "2/3", "3"), ("scene.3-of-3.exr", "3/3", "2")]
    {
        let image = folder.image(name);
        assert_eq!((metadata(&image, "part"), metadata(&image, "samples")), (text.into(), samples.into()));
    }
    let ran = folder.succeed(
        &[&["merge"], &images.iter().map(String::as_str).collect::<Vec<_>>()[..], &["-o", "all.exr"]]
            .concat(),
    );
    assert_eq!(ran.out, "wrote all.exr and its preview all.png\n");
    assert!(ran.err.starts_with("3 of 3 parts, 8 samples, estimated error "), "{}", ran.err);
    assert!(!ran.err.contains("note"), "{}", ran.err);
    let all = folder.image("all.exr");
    assert_eq!((metadata(&all, "part"), metadata(&all, "samples")), ("1,2,3/3: 3,3,2".into(), "8".into()));
    folder.succeed(&["render", "scene.toml", "--quiet", "--samples", "8", "-o", "whole.exr"]);
    let whole = folder.image("whole.exr");
    for key in
        ["lookups", "scene_hash", "data_hash", "seed", "device", "driver", "method", "rejected_samples"]
    {
        assert_eq!(metadata(&all, key), metadata(&whole, key), "{key}");
    }
    let [Some(Samples::U32(found)), Some(Samples::U32(expected))] =
        [&all, &whole].map(|image| image.channel("samples"))
    else {
        panic!("counts")
    };
    assert_eq!(found, expected);
    let sum: f64 =
        images.iter().map(|name| metadata(&folder.image(name), "seconds_wall").parse::<f64>().unwrap()).sum();
    assert!((metadata(&all, "seconds_wall").parse::<f64>().unwrap() - sum).abs() < 1e-9);
    // Both show the same.
    folder.succeed(&["compare", "all.exr", "whole.exr", "--max-rmse", "1e-6"]);
    assert_eq!(
        std::fs::read(folder.path("all.png")).unwrap(),
        std::fs::read(folder.path("whole.png")).unwrap()
    );
    // The whole goes on as one.
    let ran = folder.succeed(&["render", "scene.toml", "--samples", "9", "--resume", "-o", "all.exr"]);
    assert!(ran.err.contains("note: all.exr was merged of parts"), "{}", ran.err);
    assert_eq!(metadata(&folder.image("all.exr"), "part"), "");
}

#[test]
fn the_summary_for_programs_tells_of_parts() {
    let folder = three();
    let summary = json(&folder.succeed(&[
        "merge",
        "scene.3-of-3.exr",
        "scene.1-of-3.exr",
        "-o",
        "all.exr",
        "--json",
        "--quiet",
    ]));
    assert_eq!((&summary["samples"], &summary["parts"]["of"]), (&5.into(), &3.into()));
    assert_eq!(summary["parts"]["missing"], serde_json::json!([2]));
    assert_eq!(summary["parts"]["held"][1], serde_json::json!({ "part": 3, "samples": 2, "more": 0 }));
    assert!(summary["notes"][0].as_str().unwrap().starts_with("part 2 of 3 is missing: "), "{summary}");
    assert!(summary["seconds"]["longest"].as_f64() < summary["seconds"]["wall"].as_f64());
    // With the missing part it is the whole.
    let summary =
        json(&folder.succeed(&["merge", "all.exr", "scene.2-of-3.exr", "-o", "whole.exr", "--json"]));
    assert_eq!((&summary["samples"], &summary["parts"]["missing"]), (&8.into(), &serde_json::json!([])));
    let rendered = json(&folder.succeed(&[
        "render",
        "scene.toml",
        "--part",
        "2/3",
        "--resume",
        "--samples",
        "8",
        "--quiet",
        "--json",
    ]));
    assert_eq!((&rendered["part"], &rendered["samples"]), (&"2/3".into(), &3.into()));
    let ran = folder.succeed(&["merge", "scene.2-of-3.exr", "-o", "one.exr", "--quiet"]);
    assert_eq!((ran.out.as_str(), ran.err.as_str()), ("", ""));
}

#[test]
fn stop_rules_are_those_of_the_whole() {
    let folder = Folder::new();
    let summary = |more: &[&str]| {
        json(
            &folder
                .succeed(&[&["render", "scene.toml", "--quiet", "--json", "--part", "2/4"], more].concat()),
        )
    };
    // The scene's own limit is 3 samples.
    assert_eq!(summary(&[])["samples"], 1);
    assert_eq!(summary(&["--samples", "13"])["samples"], 3);
    let accurate = summary(&["--error", "2%"]);
    assert_eq!(accurate["ended"], "error");
    let error = accurate["estimated_error"].as_f64().unwrap();
    assert!(error <= 0.04, "{error}");
    let whole = json(&folder.succeed(&["render", "scene.toml", "--quiet", "--json", "--error", "2%"]));
    assert!(accurate["samples"].as_u64() < whole["samples"].as_u64(), "{accurate} {whole}");
    assert_eq!(summary(&["--time", "50ms"])["ended"], "time");
    refuses(
        &folder,
        &["render", "scene.toml", "--part", "4/4"],
        "a picture of 3 samples has none for this part",
    );
    let point = ["render", "scene.toml", "--part", "1/4", "--set", "image.filter=point"];
    refuses(&folder, &point, "nothing in this scene is random, so one sample is the whole picture");
    for text in ["0/4", "5/4", "3", "a/b"] {
        refuses(&folder, &["render", "scene.toml", "--part", text], "a part is I/N, such as 2/8");
    }
}

#[test]
fn a_part_is_resumed_as_that_part_alone() {
    let folder = Folder::new();
    fn resume<'a>(more: &[&'a str]) -> Vec<&'a str> {
        [&["render", "scene.toml", "--resume", "--quiet", "--samples", "12", "-o", "a.exr"], more].concat()
    }
    part(&folder, "2/3", &["--samples", "6", "-o", "a.exr"]);
    part(&folder, "2/3", &["--samples", "12", "-o", "b.exr"]);
    refuses(&folder, &resume(&[]), "it is part 2/3 of a picture, not a whole one: --part 2/3 continues it");
    refuses(&folder, &resume(&["--part", "1/3"]), "it is part 2/3 of a picture, this render is part 1/3");
    refuses(&folder, &resume(&["--part", "2/4"]), "it is part 2/3 of a picture, this render is part 2/4");
    folder.succeed(&resume(&["--part", "2/3"]));
    assert_eq!(folder.image("a.exr").channels, folder.image("b.exr").channels);
    folder.succeed(&["render", "scene.toml", "--quiet", "-o", "a.exr"]);
    refuses(&folder, &resume(&["--part", "2/3"]), "it is a whole picture, this render is part 2/3 of one");
    part(&folder, "1/2", &["--samples", "2", "-o", "c.exr"]);
    part(&folder, "2/2", &["--samples", "8", "-o", "d.exr"]);
    folder.succeed(&["merge", "c.exr", "-o", "a.exr", "--quiet"]);
    refuses(&folder, &resume(&[]), "it was merged of parts, and part 2 of 2 is missing");
    refuses(&folder, &resume(&["--part", "1/2"]), "it was merged of parts, this render is part 1/2");
    folder.succeed(&["merge", "c.exr", "d.exr", "-o", "a.exr", "--quiet"]);
    refuses(&folder, &resume(&[]), "parts that are not equally far (svetlo.part is 1,2/2: 1,4)");
}

/// The file `b.exr`, which does not fit to `a.exr`.
#[track_caller]
fn does_not_fit(folder: &Folder, needle: &str) {
    refuses(
        folder,
        &["merge", "a.exr", "b.exr", "-o", "all.exr"],
        &format!("b.exr: cannot be merged: {needle}"),
    );
}

#[test]
fn what_is_no_part_of_the_same_picture_is_refused() {
    let folder = Folder::new();
    part(&folder, "1/2", &["-o", "a.exr"]);
    let other = |more: &[&str], needle: &str| {
        part(&folder, "2/2", &[&["-o", "b.exr"], more].concat());
        does_not_fit(&folder, needle);
    };
    other(&["--seed", "9"], "it and a.exr have different seeds (9 and 1)");
    other(&["--set", "image.width=23"], "it and a.exr have different sizes (23×16 and 24×16 pixels)");
    other(&["--set", "medium.sigma_max=6"], "it and a.exr are of different scenes: their hashes are (");
    let scattering = ["--set", "method={ kind = \"multiple-scattering\" }"];
    other(
        &scattering,
        "it and a.exr were rendered by different methods (multiple-scattering and emission-absorption)",
    );
    part(&folder, "2/3", &["-o", "b.exr"]);
    does_not_fit(&folder, "it and a.exr are of pictures in different numbers of parts (3 and 2)");
    part(&folder, "1/2", &["-o", "b.exr"]);
    does_not_fit(&folder, "part 1 of 2 is in a.exr, too");
    folder.succeed(&["render", "scene.toml", "-o", "b.exr", "--quiet"]);
    does_not_fit(&folder, "it is a whole picture; parts of one are rendered by `svetlo render --part I/N`");
    let plain = Picture::new(24, 16).with_channel("Y", vec![1.0; 24 * 16]);
    write_exr(&folder.path("b.exr"), &plain).unwrap();
    does_not_fit(&folder, "it holds no state of a render (svetlo.state)");
    part(&folder, "1/2", &[&["-o", "a.exr"], &scattering[..]].concat());
    part(&folder, "2/2", &[&["-o", "b.exr", "--set", "film.auxiliary=true"], &scattering[..]].concat());
    does_not_fit(&folder, "it and a.exr were rendered with different film.auxiliary (true and false)");
}

#[test]
fn what_a_header_or_a_channel_says_is_checked() {
    let folder = Folder::new();
    part(&folder, "1/2", &["-o", "a.exr"]);
    part(&folder, "2/2", &["-o", "b.exr"]);
    let good = folder.image("b.exr");
    let with = |key: &str, value: Option<&str>| {
        let mut picture = good.clone();
        picture.metadata.remove(&format!("svetlo.{key}"));
        picture.metadata.extend(value.map(|value| (format!("svetlo.{key}"), value.to_owned())));
        write_exr(&folder.path("b.exr"), &picture).unwrap();
    };
    for (key, value, needle) in [
        (
            "version",
            Some("0.0.1"),
            "it and a.exr were rendered by different versions of svetlo (0.0.1 and 0.1.0)",
        ),
        ("state", Some("999"), "its state has the format 999, this svetlo reads"),
        (
            "data_hash",
            Some("0"),
            "it and a.exr are of the same scene, but the files that it reads held different data",
        ),
        ("light_hash", Some("0"), "it and a.exr have different light volumes"),
        ("part", Some("7"), "svetlo.part in its header is `7`, not parts of a picture"),
        ("part", Some("2/2: 9"), "svetlo.part in its header is `2/2: 9`, not parts of a picture"),
        ("samples", Some("2"), "svetlo.samples in its header is not what its pixels have"),
        ("samples", None, "its header lacks svetlo.samples"),
        ("launches", Some("many"), "svetlo.launches in its header is `many`, not a number"),
        ("seconds_wall", Some("-1"), "svetlo.seconds_wall in its header is -1, not a time"),
        ("preview", None, "svetlo.preview in its header"),
        ("unit", None, "its header lacks svetlo.unit"),
        ("state_hash", None, "its channels are not as svetlo wrote them"),
    ] {
        with(key, value);
        does_not_fit(&folder, needle);
    }
    with("driver", Some("another driver"));
    let ran = folder.succeed(&["merge", "a.exr", "b.exr", "-o", "all.exr"]);
    assert!(ran.err.contains("note: the parts were rendered by different drivers "), "{}", ran.err);
    assert!(
        metadata(&folder.image("all.exr"), "driver").contains("; another driver")
            || metadata(&folder.image("all.exr"), "driver").starts_with("another driver; ")
    );
    std::fs::remove_file(folder.path("all.exr")).unwrap();
    let mut damaged = good.clone();
    if let Some(Samples::F32(values)) =
        damaged.channels.iter_mut().find(|c| c.name == "G").map(|c| &mut c.data)
    {
        values[7] += 1.0;
    }
    write_exr(&folder.path("b.exr"), &damaged).unwrap();
    does_not_fit(&folder, "its channels are not as svetlo wrote them");
    write_exr(&folder.path("b.exr"), &good).unwrap();
    let bytes = std::fs::read(folder.path("b.exr")).unwrap();
    for length in [0, 3, 100, bytes.len() / 2, bytes.len() - 1] {
        folder.write("b.exr", &bytes[..length]);
        refuses(&folder, &["merge", "a.exr", "b.exr", "-o", "all.exr"], "b.exr: ");
    }
}

#[test]
fn files_that_cannot_be_read_or_written_are_named() {
    let folder = three();
    let [a, b] = ["scene.1-of-3.exr", "scene.2-of-3.exr"];
    let state = || std::fs::read(folder.path(a)).unwrap();
    let before = state();
    refuses(&folder, &["merge", a, b], "--output <OUT.exr>");
    refuses(&folder, &["merge", "-o", "all.exr"], "<PART.exr>");
    refuses(&folder, &["merge", a, b, "-o", "all.png"], "all.png: the image is written as EXR");
    refuses(&folder, &["merge", a, b, "-o", a], "it is one of the parts");
    refuses(&folder, &["merge", a, b, "-o", "./scene.2-of-3.exr"], "it is one of the parts");
    refuses(&folder, &["merge", a, b, "-o", "none/all.exr"], "none/all.exr: ");
    refuses(&folder, &["merge", a, "none.exr", "-o", "all.exr"], "none.exr: cannot be read");
    refuses(&folder, &["merge", a, "scene.toml", "-o", "all.exr"], "scene.toml: not an EXR file");
    refuses(&folder, &["merge", a, a, "-o", "all.exr"], "part 1 of 3 is in scene.1-of-3.exr, too");
    std::os::unix::fs::symlink(folder.path(a), folder.path("all.exr")).unwrap();
    refuses(&folder, &["merge", a, b, "-o", "all.exr"], "all.exr: it is one of the parts");
    assert!(state() == before);
    // One that was not refused replaces what was there.
    std::fs::remove_file(folder.path("all.exr")).unwrap();
    folder.write("all.exr", "old");
    folder.succeed(&["merge", a, b, "-o", "all.exr", "--quiet"]);
    assert_eq!(metadata(&folder.image("all.exr"), "part"), "1,2/3: 3,3");
    let ran = folder.succeed(&["merge", a, "-o", "one.exr"]);
    assert!(ran.err.contains("note: parts 2, 3 of 3 are missing"), "{}", ran.err);
}

#[test]
fn other_light_and_views_are_refused() {
    let folder = Folder::new();
    let hybrid = [
        "--set",
        "method={ kind = \"hybrid-diffusion\", iterations = 1, coarsening = 2 }",
        "--set",
        "light=[{ kind = \"directional\", direction = [0, 0, 1], irradiance = 1 }]",
    ];
    part(&folder, "1/2", &[&hybrid[..], &["--save-light", "light.nrrd", "-o", "a.exr"]].concat());
    let arguments = [
        &["render", "scene.toml", "--part", "2/2", "-o", "b.exr", "--load-light", "light.nrrd"],
        &hybrid[..],
    ]
    .concat();
    let ran = folder.succeed(&arguments);
    assert!(ran.err.contains("note: every part computes the light"), "{}", ran.err);
    folder.succeed(&["merge", "a.exr", "b.exr", "-o", "all.exr", "--quiet"]);
    let all = folder.image("all.exr");
    assert_eq!(metadata(&all, "light_source"), "computed");
    assert_eq!(metadata(&all, "light_hash"), metadata(&folder.image("a.exr"), "light_hash"));
    // Views are pictures of their own.
    let views = ["--set", "camera.turntable={ frames = 2 }"];
    part(&folder, "1/2", &[&views[..], &["-o", "around.exr"]].concat());
    part(&folder, "2/2", &[&views[..], &["-o", "around2.exr"]].concat());
    folder.succeed(&["merge", "around.0002.exr", "around2.0002.exr", "-o", "second.exr", "--quiet"]);
    refuses(
        &folder,
        &["merge", "around.0001.exr", "around2.0002.exr", "-o", "no.exr"],
        "are of different scenes",
    );
}
