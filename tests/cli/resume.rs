//! `--resume`: bit for bit as if the render had never stopped, and a refusal wherever it could not be.

use crate::support::{Folder, Ran, interrupt, wait_until};
use serde_json::Value;
use std::process::{Child, Stdio};
use svetlo::picture::{Channel, Picture, Samples, write_exr, write_png_rgb8};

fn summary(ran: &Ran) -> Value {
    serde_json::from_str(&ran.out).unwrap_or_else(|error| panic!("{error}: {}", ran.out))
}

fn number(picture: &Picture, key: &str) -> f64 {
    picture.metadata[&format!("svetlo.{key}")].parse().unwrap()
}

fn words(samples: &Samples) -> Vec<u32> {
    match samples {
        Samples::F32(values) => values.iter().map(|value| value.to_bits()).collect(),
        Samples::U32(values) => values.clone(),
    }
}

/// The same channels with the same bits; and the state, which may not depend on how the render was cut either.
#[track_caller]
fn assert_same(folder: &Folder, resumed: &str, whole: &str) {
    let (a, b) = (folder.image(resumed), folder.image(whole));
    let names = |picture: &Picture| -> Vec<String> {
        picture.channels.iter().map(|channel| channel.name.clone()).collect()
    };
    assert_eq!(names(&a), names(&b));
    for (x, y) in a.channels.iter().zip(&b.channels) {
        assert_eq!(words(&x.data), words(&y.data), "{}", x.name);
    }
    for key in ["samples", "state_hash", "data_hash", "scene_hash", "estimated_error", "lookups"] {
        let key = format!("svetlo.{key}");
        assert_eq!(a.metadata[&key], b.metadata[&key], "{key}");
    }
}

/// `svetlo render scene.toml --quiet --json` with more arguments.
fn render(folder: &Folder, more: &[&str]) -> Value {
    summary(&folder.succeed(&[&["render", "scene.toml", "--quiet", "--json"], more].concat()))
}

#[test]
fn three_of_eight_samples_and_the_rest_are_one_render() {
    let step = ["--set", "method.quadrature=step", "--set", "method.step=0.05"];
    let lens = ["--set", "camera.aperture=0.1", "--set", "camera.focus=2.5"];
    let mip = ["--set", "method={ kind = \"mip\" }"];
    let folder = Folder::new();
    for sets in [&[][..], &step, &lens, &mip] {
        render(&folder, &[sets, &["--samples", "8", "-o", "whole.exr"]].concat());
        let first = render(&folder, &[sets, &["--samples", "3"]].concat());
        assert_eq!(first["resumed"], Value::Null);
        let before = folder.image("scene.exr");
        let second = render(&folder, &[sets, &["--samples", "8", "--resume"]].concat());
        assert_same(&folder, "scene.exr", "whole.exr");
        let after = folder.image("scene.exr");
        for key in ["seconds_wall", "seconds_device", "seconds_build", "launches"] {
            assert!(number(&after, key) > number(&before, key), "{key}");
        }
        assert_eq!(second["samples"], 8);
        assert_eq!(second["resumed"]["samples"], 3);
        assert_eq!(second["resumed"]["launches"].as_f64().unwrap(), number(&before, "launches"));
        let wall = second["resumed"]["seconds"]["wall"].as_f64().unwrap();
        assert!((wall - number(&before, "seconds_wall")).abs() < 1e-9);
        assert!(second["seconds"]["wall"].as_f64().unwrap() >= number(&after, "seconds_wall"));
    }
}

const SCATTERING: [&str; 4] = [
    "--set",
    "method={ kind = \"multiple-scattering\", max_order = 2 }",
    "--set",
    "transfer={ points = [{ value = 0, opacity = 0 }, { value = 1, opacity = 1, color = [0.9, 0.6, 0.3] }] }",
];

#[test]
fn paths_and_auxiliary_images_go_on_too() {
    let folder = Folder::new();
    let run = |more: &[&str]| {
        let auxiliary = ["--set", "film.auxiliary=true", "--set", "background.color=1"];
        render(&folder, &[&SCATTERING[..], &auxiliary, more].concat())
    };
    let whole = run(&["--samples", "8", "-o", "whole.exr"]);
    run(&["--samples", "3"]);
    let resumed = run(&["--samples", "8", "--resume"]);
    assert_same(&folder, "scene.exr", "whole.exr");
    let (after, before) = (folder.image("scene.exr"), folder.image("whole.exr"));
    for channel in ["albedo.G", "normal.Z", "transmittance", "Z"] {
        assert!(words(after.channel(channel).unwrap()).iter().any(|&word| word != 0), "{channel}");
    }
    for key in ["paths", "null_collisions", "above_majorant", "unfinished"] {
        assert_eq!(number(&after, key), number(&before, key), "{key}");
    }
    assert!(number(&after, "paths") > 0.0);
    for key in ["count", "lookups", "collisions", "null_collisions", "unfinished"] {
        assert_eq!(resumed["paths"][key], whole["paths"][key], "{key}");
    }
    for key in ["escaped", "absorbed", "cut", "gained"] {
        // Each sample's sum is rounded to float32 when it is added.
        let bound = f64::from(f32::EPSILON);
        assert!(
            (number(&after, key) - number(&before, key)).abs() < bound * number(&after, "paths"),
            "{key}"
        );
        let [a, b] = [&resumed, &whole].map(|summary| summary["paths"][key].as_f64().unwrap());
        assert!((a - b).abs() < bound, "{key}");
    }
    // Nothing is lost: each path's weight escapes, is absorbed or cut. 1e-6: a rounding of float32 per event.
    assert!(whole["paths"]["imbalance"].as_f64().unwrap().abs() < 1e-6, "{whole}");
    assert!(whole["paths"]["cut"].as_f64().unwrap() > 1e-3, "{whole}");
}

#[test]
fn auxiliary_images_are_there_from_the_start_or_not_at_all() {
    let folder = Folder::new();
    for (then, now) in [("true", "false"), ("false", "true")] {
        let set = |value: &str| format!("film.auxiliary={value}");
        render(&folder, &[&SCATTERING[..], &["--samples", "2", "--set", &set(then)]].concat());
        let needle =
            format!("it was rendered with film.auxiliary = {then}, this render has film.auxiliary = {now}");
        refuses(&folder, &[&SCATTERING[..], &["--set", &set(now)]].concat(), &needle);
    }
}

#[test]
fn a_scattering_image_without_its_ledger_is_refused() {
    let folder = Folder::new();
    render(&folder, &[&SCATTERING[..], &["--samples", "2"]].concat());
    let mut picture = folder.image("scene.exr");
    picture.metadata.remove("svetlo.escaped");
    write_exr(&folder.path("scene.exr"), &picture).unwrap();
    refuses(&folder, &SCATTERING, "its header lacks svetlo.escaped");
}

#[test]
fn a_stop_by_time_within_a_sample_leaves_no_trace() {
    let folder = Folder::new();
    // One sample is many launches.
    let slow = [
        ["--set", "image.width=203"],
        ["--set", "image.height=150"],
        ["--set", "method.quadrature=step"],
        ["--set", "method.step=0.0005"],
    ]
    .concat();
    let timed = |more: &[&str]| render(&folder, &[&slow, more].concat());
    let first = timed(&["--time", "1ms"]);
    assert_eq!((&first["ended"], &first["samples"]), (&"time".into(), &1.into()));
    for _ in 0..2 {
        // The limit is this run's own: the runs before took longer.
        let next = timed(&["--time", "100ms", "--resume"]);
        assert_eq!(next["ended"], "time");
        assert!(next["launches"].as_u64() > next["resumed"]["launches"].as_u64());
        assert!(next["resumed"]["seconds"]["wall"].as_f64().unwrap() > 0.1);
    }
    let total = timed(&["--time", "1ms", "--resume"])["samples"].as_u64().unwrap() + 1;
    let total = total.to_string();
    timed(&["--samples", &total, "--resume"]);
    timed(&["--samples", &total, "-o", "whole.exr"]);
    assert_same(&folder, "scene.exr", "whole.exr");
}

fn endless(folder: &Folder) -> Child {
    let arguments = ["render", "scene.toml", "--samples", "1000000000", "--quiet"];
    let mut child = folder.svetlo(&arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    wait_until(|| folder.path("scene.exr").exists());
    assert!(child.try_wait().unwrap().is_none(), "the image is there while the render runs");
    child
}

/// Adds a few samples to the image that is there, and compares it with a render of as many.
fn continue_and_compare(folder: &Folder) {
    let total = (number(&folder.image("scene.exr"), "samples") as u64 + 5).to_string();
    let resumed = render(folder, &["--samples", &total, "--resume"]);
    assert!(resumed["resumed"]["samples"].as_u64().unwrap() > 0);
    render(folder, &["--samples", &total, "-o", "whole.exr"]);
    assert_same(folder, "scene.exr", "whole.exr");
}

#[test]
fn an_interrupt_leaves_an_image_to_continue() {
    let folder = Folder::new();
    let mut child = endless(&folder);
    interrupt(&child);
    assert_eq!(child.wait().unwrap().code(), Some(130));
    continue_and_compare(&folder);
}

#[test]
fn a_killed_render_continues_from_its_last_image() {
    let folder = Folder::new();
    let mut child = endless(&folder);
    child.kill().unwrap();
    assert_eq!(child.wait().unwrap().code(), None);
    continue_and_compare(&folder);
}

#[test]
fn the_error_rule_ends_a_resumed_render_where_it_ends_a_whole_one() {
    let folder = Folder::new();
    let whole = render(&folder, &["--error", "1%", "-o", "whole.exr"]);
    assert_eq!(whole["ended"], "error");
    let samples = whole["samples"].as_u64().unwrap();
    assert!(samples > 16, "{samples}: the checks are not at every sample");
    for first in [1, 3, 4, 9, samples / 2 + 1, samples - 1] {
        render(&folder, &["--samples", &first.to_string()]);
        let resumed = render(&folder, &["--error", "1%", "--resume"]);
        assert_eq!(resumed["ended"], "error");
        assert_same(&folder, "scene.exr", "whole.exr");
    }
    // And once more, where nothing is left to do.
    assert_eq!(render(&folder, &["--error", "1%", "--resume"])["ended"], "error");
}

#[test]
fn a_finished_render_is_left_as_it_is() {
    let folder = Folder::new();
    render(&folder, &["--samples", "4"]);
    let image = std::fs::read(folder.path("scene.exr")).unwrap();
    let preview = std::fs::read(folder.path("scene.png")).unwrap();
    for samples in ["4", "2"] {
        // The preview's settings may change in between.
        let arguments =
            ["render", "scene.toml", "--samples", samples, "--resume", "--set", "film.exposure=3"];
        let ran = folder.succeed(&arguments);
        assert_eq!(
            ran.out,
            "scene.exr is finished already and was left as it is; wrote its preview scene.png\n"
        );
        assert_eq!(std::fs::read(folder.path("scene.exr")).unwrap(), image);
        assert_ne!(std::fs::read(folder.path("scene.png")).unwrap(), preview);
    }
    let summary = render(&folder, &["--samples", "4", "--resume"]);
    assert_eq!((&summary["ended"], &summary["samples"]), (&"samples".into(), &4.into()));
    assert_eq!(std::fs::read(folder.path("scene.png")).unwrap(), preview);
    // Where nothing is random, one sample is all.
    let point = ["--set", "image.filter=point", "-o", "point.exr"];
    render(&folder, &point);
    assert_eq!(render(&folder, &[&point[..], &["--resume"]].concat())["ended"], "deterministic");
}

#[test]
fn without_an_image_the_render_starts_anew_and_says_so() {
    let folder = Folder::new();
    let ran = folder.succeed(&["render", "scene.toml", "--resume"]);
    assert!(ran.err.contains("note: there is no scene.exr to resume"), "{}", ran.err);
    assert_eq!(ran.out, "wrote scene.exr and its preview scene.png\n");
    assert!(!folder.succeed(&["render", "scene.toml"]).err.contains("resume"));
    let ran = folder.succeed(&["render", "scene.toml", "--resume", "--quiet", "-o", "other.exr"]);
    assert_eq!((ran.out.as_str(), ran.err.as_str()), ("", ""));
}

#[test]
fn another_device_or_version_is_noted() {
    let folder = Folder::new();
    render(&folder, &["--samples", "2"]);
    let mut picture = folder.image("scene.exr");
    picture.metadata.insert("svetlo.driver".into(), "another driver".into());
    picture.metadata.insert("svetlo.version".into(), "0.0.1".into());
    write_exr(&folder.path("scene.exr"), &picture).unwrap();
    let ran = folder.succeed(&["render", "scene.toml", "--samples", "3", "--resume"]);
    let noted = "note: scene.exr was begun elsewhere (version 0.0.1, now 0.1.0; driver another driver, now ";
    assert!(ran.err.contains(noted), "{}", ran.err);
    assert!(!folder.succeed(&["render", "scene.toml", "--samples", "4", "--resume"]).err.contains("begun"));
}

/// Runs `render --resume` with more arguments, which must refuse and leave the files alone.
#[track_caller]
fn refuses(folder: &Folder, more: &[&str], needle: &str) {
    let state = || ["scene.exr", "scene.png"].map(|name| std::fs::read(folder.path(name)).unwrap());
    let before = state();
    folder
        .run(&[&["render", "scene.toml", "--samples", "5", "--resume"], more].concat())
        .fails_with(2, needle);
    assert!(state() == before, "the files changed: {needle}");
}

#[test]
fn another_scene_seed_or_size_is_refused() {
    let folder = Folder::new();
    render(&folder, &["--samples", "2"]);
    refuses(&folder, &["--seed", "9"], "was rendered with seed 1, this render has seed 9");
    refuses(&folder, &["--set", "medium.sigma_max=6"], "is of another scene");
    refuses(&folder, &["--set", "image.width=23"], "24×16 pixels, this render has 23×16");
    // What leaves the pixels alone does not matter.
    render(&folder, &["--samples", "3", "--resume", "--set", "film.exposure=2", "--set", "stop.time=1h"]);
}

#[test]
fn an_image_that_is_not_as_it_was_written_is_refused() {
    let folder = Folder::new();
    render(&folder, &["--samples", "3"]);
    let good = folder.image("scene.exr");
    let flip = |name: &'static str| {
        move |picture: &mut Picture| {
            let channel = picture.channels.iter_mut().find(|channel| channel.name == name).unwrap();
            let mut bits = words(&channel.data);
            bits[200] ^= 1;
            channel.data = match channel.data {
                Samples::F32(_) => Samples::F32(bits.into_iter().map(f32::from_bits).collect()),
                Samples::U32(_) => Samples::U32(bits),
            };
        }
    };
    let drop = |name: &'static str| {
        move |picture: &mut Picture| picture.channels.retain(|channel| channel.name != name)
    };
    let header = |key: &'static str, value: Option<&'static str>| {
        move |picture: &mut Picture| {
            picture.metadata.remove(key);
            picture.metadata.extend(value.map(|value| (key.to_owned(), value.to_owned())));
        }
    };
    let crop = |picture: &mut Picture| {
        let rows = |data: &Samples| match data {
            Samples::F32(values) => Samples::F32(values[..24 * 8].to_vec()),
            Samples::U32(values) => Samples::U32(values[..24 * 8].to_vec()),
        };
        let channels: Vec<Channel> =
            picture.channels.iter().map(|c| Channel { name: c.name.clone(), data: rows(&c.data) }).collect();
        (picture.height, picture.channels) = (8, channels);
    };
    let changed = "some were changed or are missing";
    type Damage = Box<dyn Fn(&mut Picture)>;
    let damages: Vec<(Damage, &str)> = vec![
        (Box::new(flip("R")), changed),
        (Box::new(flip("variance.G")), changed),
        (Box::new(flip("samples")), changed),
        (Box::new(flip("state.mean_low.B")), changed),
        (Box::new(flip("state.lookups_low")), changed),
        (Box::new(drop("A")), changed),
        (Box::new(drop("state.m2_low.R")), changed),
        (Box::new(header("svetlo.state_hash", None)), changed),
        (Box::new(header("svetlo.state", None)), "holds no state"),
        (Box::new(header("svetlo.state", Some("999"))), "its state has the format 999, this svetlo reads"),
        (Box::new(header("svetlo.seed", None)), "its header lacks svetlo.seed"),
        (Box::new(header("svetlo.launches", Some("many"))), "`many`, not a number"),
        (Box::new(header("svetlo.seconds_wall", Some("-1"))), "-1, not a time"),
        (Box::new(header("svetlo.data_hash", Some("0"))), "held other data"),
        (Box::new(crop), "24×8 pixels"),
    ];
    for (damage, needle) in damages {
        let mut picture = good.clone();
        damage(&mut picture);
        write_exr(&folder.path("scene.exr"), &picture).unwrap();
        refuses(&folder, &[], needle);
    }
    // A copy that lost nothing is as good.
    write_exr(&folder.path("scene.exr"), &good).unwrap();
    let bytes = std::fs::read(folder.path("scene.exr")).unwrap();
    render(&folder, &["--samples", "5", "--resume"]);
    for length in [0, 3, 100, bytes.len() / 2, bytes.len() - 1] {
        folder.write("scene.exr", &bytes[..length]);
        refuses(&folder, &[], "cannot resume: scene.exr: ");
    }
    folder.write("scene.exr", "not an image");
    refuses(&folder, &[], "not an EXR file");
}

#[test]
fn other_data_in_the_files_of_the_scene_are_refused() {
    let folder = Folder::new();
    let mut voxels: Vec<u8> = (0..512).map(|i| (i % 251) as u8).collect();
    folder.write("v_8x8x8_uint8.raw", &voxels);
    let map = |value: f32| {
        let plane = vec![value; 8];
        let map = Picture::new(4, 2).with_channel("Y", plane);
        write_exr(&folder.path("map.exr"), &map).unwrap();
    };
    let table = |opacity: u8| {
        let texels = [[255, opacity, 0], [0, 255, opacity], [9, 9, 9], [opacity, 0, 9]].concat();
        write_png_rgb8(&folder.path("table.png"), 2, 2, &texels).unwrap();
    };
    map(0.5);
    table(7);
    let scene = std::fs::read_to_string(folder.path("scene.toml")).unwrap();
    let field = "field = { kind = \"sphere\" }\ndims = [8, 8, 8]\n";
    assert!(scene.contains(field));
    let files = scene.replace(field, "file = \"v_8x8x8_uint8.raw\"\n")
        + "[background]\nenvironment = \"map.exr\"\n[transfer]\nkind = \"2d\"\ngradient_max = 0.5\ntable = \"table.png\"\n";
    folder.write("scene.toml", files);
    render(&folder, &["--samples", "2"]);
    let refused = "the files that the scene reads held other data then";
    voxels[300] ^= 1;
    folder.write("v_8x8x8_uint8.raw", &voxels);
    refuses(&folder, &[], refused);
    voxels[300] ^= 1;
    folder.write("v_8x8x8_uint8.raw", &voxels);
    map(0.75);
    refuses(&folder, &[], refused);
    map(0.5);
    table(8);
    refuses(&folder, &[], refused);
    table(7);
    render(&folder, &["--samples", "4", "--resume"]);
    render(&folder, &["--samples", "4", "-o", "whole.exr"]);
    assert_same(&folder, "scene.exr", "whole.exr");
}
