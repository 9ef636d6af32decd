//! Where images go: names, links, existing files, and what must not be overwritten.

use crate::support::{Folder, run};
use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;

#[test]
fn the_default_name_keeps_all_but_the_last_ending() {
    let folder = Folder::new();
    let scene = std::fs::read(folder.path("scene.toml")).unwrap();
    folder.write("head.ct.toml", &scene);
    folder.write("bare", &scene);
    folder.write(".toml", &scene);
    for (name, image) in [("head.ct.toml", "head.ct.exr"), ("bare", "bare.exr"), (".toml", ".toml.exr")] {
        folder.succeed(&["render", name, "--quiet"]);
        folder.image(image);
        std::fs::remove_file(folder.path(image)).unwrap();
    }
}

#[test]
fn an_existing_image_is_replaced_and_a_link_stays_a_link() {
    let folder = Folder::new();
    folder.write("real.exr", "old");
    std::os::unix::fs::symlink("real.exr", folder.path("link.exr")).unwrap();
    folder.succeed(&["render", "scene.toml", "-o", "link.exr", "--quiet"]);
    assert!(folder.path("link.exr").is_symlink());
    assert!(!folder.path("real.exr").is_symlink());
    assert_eq!(folder.image("real.exr").width, 24);
    assert_eq!(folder.names(), ["link.exr", "link.png", "real.exr", "scene.toml"]);
}

#[test]
fn impossible_outputs_are_found_before_the_render() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("dir.exr")).unwrap();
    std::fs::create_dir(folder.path("x.png")).unwrap();
    for (output, needle) in [
        ("out.png", "must end in .exr"),
        ("out", "must end in .exr"),
        (".", "must end in .exr"),
        ("", "a value is required for '--output"),
        ("missing/out.exr", "create the folder missing first"),
        ("scene.toml/out.exr", "scene.toml must be a folder"),
        ("dir.exr", "the path of a file"),
        // The preview would go there.
        ("x.exr", "x.png"),
    ] {
        folder.run(&["render", "scene.toml", "-o", output]).fails_with(2, needle);
    }
    assert_eq!(folder.names(), ["dir.exr", "scene.toml", "x.png"]);
}

#[test]
fn no_input_of_the_scene_is_overwritten() {
    let folder = Folder::new();
    folder.succeed(&["render", "scene.toml", "-o", "table.exr", "--quiet"]);
    let before = std::fs::read(folder.path("table.png")).unwrap();
    let sets = ["--set", "transfer.kind=2d", "--set", "transfer.table=table.png"];
    let ran = folder.run(&[&["render", "scene.toml", "-o", "table.exr"], &sets[..]].concat());
    ran.fails_with(2, "the scene reads this file");
    std::os::unix::fs::symlink("table.exr", folder.path("link.exr")).unwrap();
    let sets = ["--set", "background.environment=table.exr"];
    let ran = folder.run(&[&["render", "scene.toml", "-o", "link.exr"], &sets[..]].concat());
    ran.fails_with(2, "the scene reads this file");
    assert_eq!(std::fs::read(folder.path("table.png")).unwrap(), before);
}

#[test]
fn paths_may_hold_blanks_and_any_letters_and_need_not_be_unicode() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("ü b")).unwrap();
    folder.write("ü b/s ö.toml", std::fs::read(folder.path("scene.toml")).unwrap());
    let ran = folder.succeed(&["render", "ü b/s ö.toml", "-o", "ü b/光 x.exr", "--json", "--quiet"]);
    assert!(ran.out.contains("ü b/光 x.exr"), "{}", ran.out);
    folder.image("ü b/光 x.exr");

    let name = OsStr::from_bytes(b"a\xff.exr");
    let arguments = [OsStr::new("render"), OsStr::new("scene.toml"), OsStr::new("-o"), name];
    let ran = run(folder.svetlo(&arguments).args(["--json", "--quiet"]));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert!(serde_json::from_str::<serde_json::Value>(&ran.out).is_ok(), "{}", ran.out);
    assert!(folder.path(name).exists());
}
