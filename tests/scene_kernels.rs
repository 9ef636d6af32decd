//! Every kernel is launched by a `tests/scenes/tiny_*.toml`: these run under Oclgrind.

mod common;

use common::device;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use svetlo::crew::Crew;
use svetlo::device::Faults;
use svetlo::render::{BRICK_SHIFT, Plan, Rendering, SceneData, Session};
use svetlo::scene::Scene;

/// Kernels that no scene can reach, and why.
const UNREACHED: [(&str, &str); 3] = [
    ("bitonic_exchange", "for more than 16384 photons: tests/device_sort.rs"),
    ("bitonic_merge", "for more than 16384 photons: tests/device_sort.rs"),
    ("radix_tiles", "for GPUs: tests/device_sort.rs"),
];

fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let found = |path: PathBuf| if path.is_dir() { files(&path, ending) } else { vec![path] };
    entries.flat_map(found).filter(|path| path.to_string_lossy().ends_with(ending)).collect()
}

/// The kernels of all sources.
fn written() -> BTreeSet<String> {
    let sources = files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("cl"), ".cl");
    let texts = sources.iter().map(|path| std::fs::read_to_string(path).unwrap());
    let name = |line: &str| Some(line.strip_prefix("__kernel void ")?.split('(').next()?.trim().to_owned());
    texts.flat_map(|text| text.lines().filter_map(name).collect::<Vec<_>>()).collect()
}

/// The kernels that a render of the scene launches; `crew`: by a crew, of one device, since Oclgrind has only one and
/// takes calls from one thread.
fn launched(path: &Path, crew: bool) -> BTreeSet<&'static str> {
    let scene = Scene::load(path, &[]).unwrap_or_else(|error| panic!("{error}"));
    let data = SceneData::load(&scene).unwrap();
    let plan = Plan::new(&scene, &data, BRICK_SHIFT).unwrap();
    let samples = scene.stop.samples.unwrap_or(1) as u32;
    let watch = Arc::new(Faults::default());
    let watched = || device().failing(Arc::clone(&watch)).unwrap();
    if crew {
        std::thread::scope(|scope| {
            let mut crew = Crew::start(scope, &plan, vec![watched()], None, None).unwrap();
            while crew.progress().samples < samples {
                crew.step(samples).unwrap();
            }
        });
    } else {
        Session::new(watched(), &plan).unwrap().render(samples).unwrap();
    }
    watch.kernels()
}

fn scene_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes").join(name)
}

/// A small one, which `scripts/test` runs under Oclgrind: `svetlo render` launches that kernel for several devices only.
#[test]
fn crews_add_samples() {
    assert!(launched(&scene_path("tiny_caustics.toml"), true).contains("film_fold"));
}

#[test]
fn tiny_scenes_launch_every_kernel() {
    let written = written();
    assert!(written.len() > 80, "{written:?}");
    let scenes = files(&scene_path(""), ".toml");
    let tiny = scenes.iter().filter(|path| path.file_name().unwrap().to_string_lossy().starts_with("tiny_"));
    let mut launched: BTreeSet<&str> = tiny.flat_map(|path| launched(path, false)).collect();
    launched.insert("film_fold");
    let expected = written.iter().map(String::as_str).filter(|name| !launched.contains(name));
    // Some devices sort as GPUs do.
    let missing: Vec<_> = expected.filter(|name| UNREACHED.iter().all(|(known, _)| known != name)).collect();
    assert!(missing.is_empty(), "no tests/scenes/tiny_*.toml launches {missing:?}");
    let gone = UNREACHED.iter().find(|(kernel, _)| !written.contains(*kernel));
    assert_eq!(gone, None, "there is no such kernel");
}
