//! Progressive images and Ctrl-C: whatever moment a reader or the user picks, the image on disk is whole.

use crate::support::{Folder, interrupt, wait_until};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;
use svetlo::picture::{read_exr, read_png};

const ENDLESS: [&str; 5] = ["render", "scene.toml", "--samples", "1000000000", "--json"];

fn samples(path: &Path) -> u64 {
    read_exr(path).expect("the image is whole").metadata["svetlo.samples"].parse().unwrap()
}

#[test]
fn the_image_appears_early_is_always_whole_and_an_interrupt_keeps_it() {
    let folder = Folder::new();
    let (image, preview) = (folder.path("scene.exr"), folder.path("scene.png"));
    let mut child = folder.svetlo(&ENDLESS).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait_until(|| image.exists() && preview.exists());
    assert!(child.try_wait().unwrap().is_none(), "the image is there while the render runs");
    let first = samples(&image);
    interrupt(&child);
    // Read as often as possible while the last image replaces the first.
    let mut reads = 0;
    let took = wait_until(|| {
        samples(&image);
        read_png(&preview).expect("the preview is whole");
        reads += 1;
        child.try_wait().unwrap().is_some()
    });
    assert!(took < Duration::from_secs(5), "an interrupt is answered at once, not after {took:?}");
    assert!(reads > 1);
    let output = child.wait_with_output().unwrap();
    let err = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{err}");
    assert!(err.contains("interrupted after ") && err.contains("scene.exr"), "{err}");
    assert!(!err.contains("error"), "{err}");
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one JSON document");
    assert_eq!(summary["ended"], "interrupted");
    assert_eq!(summary["samples"], samples(&image));
    assert!(samples(&image) > first, "{first}");
    assert_eq!(folder.names(), ["scene.exr", "scene.png", "scene.toml"]);
}

#[test]
fn a_second_interrupt_does_not_wait_for_the_image() {
    let folder = Folder::new();
    // Without caches the program is built first, which takes a while and cannot be interrupted by one request.
    let mut child = folder
        .svetlo(&ENDLESS)
        .env("SVETLO_CACHE_DIR", "")
        .env("POCL_CACHE_DIR", folder.path("pocl"))
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(lines.next().unwrap().unwrap().starts_with("note: "), "the handler is set when notes appear");
    interrupt(&child);
    std::thread::sleep(Duration::from_millis(20));
    if child.try_wait().unwrap().is_none() {
        interrupt(&child);
    }
    wait_until(|| child.try_wait().unwrap().is_some());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(!folder.path("scene.exr").exists(), "it waited for the image");
}
