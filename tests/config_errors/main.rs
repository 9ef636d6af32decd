//! What a user reads when a scene is wrong: exact texts, kind by kind; and that nothing panics.

mod examples;
mod keys;
mod robust;
mod set;
mod surfaces;
mod together;
mod values;

use std::path::Path;

use svetlo::config;
use svetlo::scene::Scene;

/// A valid scene that the tests break.
const SCENE: &str = r#"[camera]
position = [0.5, 0.5, -2.0]
target = [0.5, 0.5, 0.5]
[volume]
field = { kind = "cloud" }
dims = [8, 8, 8]
[medium]
sigma_max = 40.0
[method]
kind = "emission-absorption"
"#;

/// Reads and validates a text, with its files looked for in the folder `data`, which does not exist.
fn read(text: &str, sets: &[&str]) -> Result<Scene, String> {
    let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
    config::parse("scene.toml", text, &sets)
        .and_then(|loaded| Scene::from_loaded(&loaded, Path::new("data")))
        .map_err(|error| plain(&error.to_string()))
}

/// [`SCENE`] with some pieces replaced, each of which must be there.
fn edited(edits: &[(&str, &str)]) -> String {
    edits.iter().fold(SCENE.to_owned(), |text, (old, new)| {
        assert!(text.contains(old), "{old:?} is not in\n{text}");
        text.replacen(old, new, 1)
    })
}

/// Asserts that the edited scene with these overrides fails with exactly this text.
#[track_caller]
fn fails(edits: &[(&str, &str)], sets: &[&str], expected: &str) {
    let text = read(&edited(edits), sets).expect_err("the scene is wrong");
    assert!(text == expected.trim(), "expected\n{expected}\ngot\n{text}\n");
}

/// The text without colours: the tests may run on a terminal.
fn plain(text: &str) -> String {
    let mut parts = text.split('\x1b');
    let first = parts.next().unwrap_or_default().to_owned();
    let plain = parts.fold(first, |text, part| text + part.split_once('m').map_or("", |(_, rest)| rest));
    plain.lines().map(str::trim_end).collect::<Vec<_>>().join("\n")
}

#[test]
fn the_scene_that_the_tests_break_is_valid() {
    read(SCENE, &[]).expect("valid");
}
