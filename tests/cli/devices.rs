//! Several devices from the command line: who may be named, that the picture is that of one, and that one may be lost.
//!
//! PoCL offers as many devices as `POCL_DEVICES` lists. Other runtimes have one here, and the tests that need two are
//! for PoCL.

use crate::support::{Folder, Ran, more_samples, run};
use svetlo::picture::Picture;

/// Runs with `devices` of PoCL; `None` where the devices are not PoCL's.
fn with_devices(folder: &Folder, arguments: &[&str], fault: &str) -> Option<Ran> {
    let mut list = folder.svetlo(&["devices", "--json"]);
    let listed = run(list.env("POCL_DEVICES", "pthread pthread"));
    let listed: serde_json::Value = serde_json::from_str(&listed.out).expect("JSON");
    let devices = listed["devices"].as_array().expect("a list");
    let two =
        devices.iter().filter(|device| device["platform"] == "Portable Computing Language").count() == 2;
    let mut command = folder.svetlo(arguments);
    two.then(|| run(command.env("POCL_DEVICES", "pthread pthread").env("SVETLO_FAULT", fault)))
}

fn assert_same(found: &Picture, expected: &Picture) {
    assert_eq!(found.channels.len(), expected.channels.len());
    for (a, b) in found.channels.iter().zip(&expected.channels) {
        assert!(a == b, "channel {} differs", a.name);
    }
}

const ARGUMENTS: [&str; 8] =
    ["render", "scene.toml", "-o", "two.exr", "--device", "all:portable", "--samples", "9"];

#[test]
fn two_devices_make_the_picture_of_one() {
    let folder = Folder::new();
    let Some(ran) = with_devices(&folder, &ARGUMENTS, "") else { return };
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert_eq!(ran.err.matches(" % of the samples in ").count(), 2, "{}", ran.err);
    folder.succeed(&["render", "scene.toml", "-o", "one.exr", "--samples", "9", "--device", "portable"]);
    assert_same(&folder.image("two.exr"), &folder.image("one.exr"));
    // And goes on from there.
    let more = ["--samples", "12", "--resume", "--json"];
    let ran = with_devices(&folder, &[&ARGUMENTS[..6], &more].concat(), "").expect("as before");
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let summary: serde_json::Value = serde_json::from_str(&ran.out).expect("JSON");
    assert_eq!(summary["devices"].as_array().map(Vec::len), Some(2), "{summary}");
    folder.succeed(&[
        "render",
        "scene.toml",
        "-o",
        "one.exr",
        "--samples",
        "12",
        "--device",
        "portable",
        "--resume",
    ]);
    assert_same(&folder.image("two.exr"), &folder.image("one.exr"));
}

#[test]
fn a_device_that_is_lost_is_left_out_with_a_note() {
    let folder = Folder::new();
    // Kernels that are compiled, and so many samples that the first device does not end before the other has begun.
    if with_devices(&folder, &ARGUMENTS, "").is_none() {
        return;
    }
    let longer = [&ARGUMENTS[..7], &["300"]].concat();
    let Some(ran) = with_devices(&folder, &longer, "write=3@0:1") else { return };
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let note = "(0:1) is left out from now on: ";
    assert!(ran.err.contains(note) && ran.err.contains("clEnqueueWriteBuffer"), "{}", ran.err);
    assert!(ran.err.contains("; it failed on the way"), "{}", ran.err);
    folder.succeed(&["render", "scene.toml", "-o", "one.exr", "--samples", "300", "--device", "portable"]);
    assert_same(&folder.image("two.exr"), &folder.image("one.exr"));
    // One that cannot even be opened.
    let ran = with_devices(&folder, &ARGUMENTS, "open=1@0:0").expect("as before");
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert!(ran.err.contains("note: left out: "), "{}", ran.err);
    // And both.
    let ran = with_devices(&folder, &ARGUMENTS, "build=1").expect("as before");
    ran.fails_with(1, "no device is left that works: ");
}

#[test]
fn devices_are_named_once() {
    let folder = Folder::new();
    let device = ["--device", "0:0"];
    let ran = folder.run(&[&["render", "scene.toml"][..], &device, &device].concat());
    ran.fails_with(2, "which another --device names already");
    let ran = folder.run(&["render", "scene.toml", "--device", "0:0", "--device", "all:nothing"]);
    ran.fails_with(2, "no OpenCL device matches 'nothing'; there are:");
}

#[test]
fn what_was_added_outlives_the_last_device() {
    let folder = Folder::new();
    // Nobody comes to the end of it.
    let arguments = [&ARGUMENTS[..7], &["10000000", "--snapshot", "1h"]].concat();
    let Some(ran) = with_devices(&folder, &arguments, "lost=90@0:0,lost=60@0:1") else { return };
    ran.fails_with(1, "no device is left that works: 0:0: ");
    assert!(ran.err.contains("; the image so far is in two.exr"), "{}", ran.err);
    let samples = more_samples(&folder, "two.exr");
    let further = ["render", "scene.toml", "--device", "portable", "--samples", &samples, "-o"];
    folder.succeed(&[&further[..], &["two.exr", "--resume"]].concat());
    folder.succeed(&[&further[..], &["one.exr"]].concat());
    assert_same(&folder.image("two.exr"), &folder.image("one.exr"));
}

#[test]
fn finished_renders_of_two_devices_still_save_their_light() {
    let folder = Folder::new();
    let render = |rest: &[&'static str]| {
        let method = "method={ kind = \"hybrid-diffusion\", iterations = 30 }";
        let light = "light=[{ kind = \"directional\", direction = [1, -2, 1], irradiance = [3, 2, 1] }]";
        let sets = ["--set", method, "--set", light, "--set", "medium.albedo=0.9", "--samples", "2"];
        [&["render", "scene.toml"], rest, &sets].concat()
    };
    let Some(ran) = with_devices(&folder, &render(&["-o", "two.exr", "--device", "all:portable"]), "") else {
        return;
    };
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let again = ["-o", "two.exr", "--device", "all:portable", "--resume", "--save-light", "two.nrrd"];
    let ran = with_devices(&folder, &render(&again), "").expect("as before");
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    folder.succeed(&render(&["-o", "one.exr", "--device", "portable", "--save-light", "one.nrrd"]));
    assert!(
        std::fs::read(folder.path("two.nrrd")).unwrap() == std::fs::read(folder.path("one.nrrd")).unwrap()
    );
}

/// Rows differ in samples where several devices stop by time: each pixel of the sum has the mean of its own.
#[test]
fn parts_that_two_devices_stopped_by_time_are_merged() {
    let folder = Folder::new();
    let render = |part, output| {
        let arguments = ["--device", "all:portable", "--time", "700ms", "--part", part, "-o", output];
        with_devices(&folder, &[&["render", "scene.toml"], &arguments[..]].concat(), "")
    };
    let Some(ran) = render("1/2", "a.exr") else { return };
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    render("2/2", "b.exr").expect("as before");
    folder.succeed(&["merge", "a.exr", "b.exr", "-o", "c.exr"]);
    let [a, b, c] = ["a.exr", "b.exr", "c.exr"].map(|name| folder.image(name));
    let [[of_a, count_a], [of_b, count_b], [of_c, count_c]] =
        [&a, &b, &c].map(|image| ["G", "samples"].map(|name| image.channel(name).expect("a plane").to_f32()));
    for i in 0..of_c.len() {
        assert_eq!(count_a[i] + count_b[i], count_c[i]);
        let mean = (of_a[i] * count_a[i] + of_b[i] * count_b[i]) / count_c[i];
        // Both are rounded to float32, and so is this.
        assert!((of_c[i] - mean).abs() <= 8.0 * f32::EPSILON * mean.abs(), "{}, not {mean}", of_c[i]);
    }
    let counts: std::collections::BTreeSet<u32> = count_a.iter().map(|&count| count as u32).collect();
    println!("samples of the first part: {counts:?}; of both: {}", c.metadata["svetlo.part"]);
}
