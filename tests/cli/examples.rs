//! The example scenes are valid and show something, and the template explains every key.

use crate::support::{Folder, run};
use std::path::{Path, PathBuf};

fn scenes() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.filter(|path| path.extension().is_some_and(|extension| extension == "toml")).collect()
}

#[test]
fn every_example_is_valid_and_opens_with_a_comment() {
    let folder = Folder::new();
    assert!(scenes().len() >= 17, "{:?}", scenes());
    for scene in scenes() {
        let ran = folder.succeed(&[Path::new("check"), &scene]);
        assert!(ran.out.starts_with("scene      valid"), "{}", ran.out);
        assert!(std::fs::read_to_string(&scene).unwrap().starts_with("# "), "{}", scene.display());
    }
}

#[test]
fn every_example_renders_something() {
    let folder = Folder::new();
    let small =
        ["--set", "image.width=32", "--set", "image.height=32", "--samples", "1", "--quiet", "-o", "a.exr"];
    for scene in scenes() {
        let mut render = folder.svetlo(&[Path::new("render"), &scene]);
        render.args(small);
        let several = scene.ends_with("brain_hybrid.toml");
        if several {
            // One estimate of each cell's light, which takes the most of the time.
            let quick = ["method.iterations=1", "method.coarsening=4", "camera.turntable.frames=2"];
            render.args(quick.iter().flat_map(|set| ["--set", set]));
        }
        let ran = run(&mut render);
        assert_eq!(ran.code, Some(0), "{}: {}", scene.display(), ran.err);
        let image = folder.image(if several { "a.0002.exr" } else { "a.exr" });
        let red = image.channel("R").unwrap().to_f32().into_owned();
        let (least, most) = red.iter().fold((f32::MAX, f32::MIN), |(a, b), &v| (a.min(v), b.max(v)));
        assert!(most > least + 0.05, "{} is a blank picture", scene.display());
    }
}

#[test]
fn every_suite_is_valid_and_opens_with_a_comment() {
    let folder = Folder::new();
    let suites = std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/bench")).unwrap();
    let mut count = 0;
    for suite in suites.map(|entry| entry.unwrap().path()) {
        let ran = folder.succeed(&[Path::new("bench"), &suite, Path::new("--list")]);
        assert!(ran.out.contains(" cases are valid"), "{}", ran.out);
        assert!(std::fs::read_to_string(&suite).unwrap().starts_with("# "), "{}", suite.display());
        count += 1;
    }
    assert!(count >= 4);
}

/// The templates explain every key of the scene language: those in force and those after a `#`.
#[test]
fn the_templates_name_every_key() {
    let text = [include_str!("../../configs/own_data.toml"), include_str!("../../configs/own_surfaces.toml")]
        .concat();
    let schema = svetlo::config::schema();
    let mut keys = Vec::new();
    collect_keys(&schema, &mut keys);
    assert!(keys.len() > 50, "{keys:?}");
    // Parameters of fields and shapes belong to their own examples.
    let defs = schema["$defs"].as_object().unwrap();
    let mut special = Vec::new();
    for name in ["FieldConfig", "ShapeConfig"] {
        collect_keys(&defs[name], &mut special);
    }
    special.extend(["table", "shapes", "gradient_max"].map(String::from));
    for key in keys.iter().filter(|key| !special.contains(key)) {
        let named = text.split(|c: char| !(c.is_alphanumeric() || c == '_')).any(|word| word == key);
        assert!(named, "`{key}` is in no template");
    }
}

fn collect_keys(node: &serde_json::Value, keys: &mut Vec<String>) {
    match node {
        serde_json::Value::Object(map) => {
            if let Some(properties) = map.get("properties").and_then(|properties| properties.as_object()) {
                keys.extend(properties.keys().cloned());
            }
            map.values().for_each(|value| collect_keys(value, keys));
        }
        serde_json::Value::Array(list) => list.iter().for_each(|value| collect_keys(value, keys)),
        _ => {}
    }
}
