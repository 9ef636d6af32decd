//! What reads bytes that others wrote: one function for each kind of file, which must return whatever the bytes are.
//!
//! `tests/hostile` feeds them damaged files and mutations, `tests/fuzz` what libFuzzer finds.

use glam::DVec3;
use std::path::{Path, PathBuf};
use svetlo::bench::suite::Suite;
use svetlo::irradiance::LightData;
use svetlo::picture::{Environment, read_picture};
use svetlo::render::{BRICK_SHIFT, Plan, Saved, SceneData, announced_memory, data_hash};
use svetlo::scene::{Scene, Surface, SurfaceMaterial, SurfaceShape};
use svetlo::volume::{Components, RawOptions};
use tempfile::TempDir;

/// Its name, and what reads the bytes.
type Target = (&'static str, fn(&[u8]));

/// All of them; of those that say so, the first byte chooses among `VOLUMES` or `MESHES`.
pub const TARGETS: [Target; 8] = [
    ("scene", scene),
    ("suite", suite),
    ("volume", volume),
    ("picture", picture),
    ("environment", environment),
    ("mesh", mesh),
    ("light", light),
    ("resume", resume),
];

/// Runs one by its name.
pub fn run(name: &str, data: &[u8]) {
    let found = TARGETS.iter().find(|(target, _)| *target == name);
    found.expect("the name of a target").1(data);
}

/// Names that lead to each reader of volumes.
pub const VOLUMES: [&str; 12] = [
    "raw.nrrd",
    "detached.nhdr",
    "a.nii",
    "a.nii.gz",
    "b.hdr",
    "d.hdr.gz",
    "local.mha",
    "beside.mhd",
    "x_3x4x5_int16.raw",
    "x_3x4x5_int16.raw.gz",
    "by_content",
    "c.img",
];

/// Names that lead to each reader of meshes.
pub const MESHES: [&str; 2] = ["a.obj", "a.ply"];

/// A scene with a light volume, to which films and light belong.
pub const LIT: &str = "[image]\nwidth = 9\nheight = 7\n[camera]\nposition = [20, 13, -9]\ntarget = [2, 2, 2]\nfov = 12\n\
    [volume]\nfield = { kind = \"cloud\" }\ndims = [5, 4, 3]\n[medium]\nsigma_max = 0.8\n\
    [[light]]\nkind = \"directional\"\ndirection = [1, -1, 1]\nirradiance = [3, 2, 1]\n\
    [method]\nkind = \"hybrid-diffusion\"\niterations = 1\n[stop]\nsamples = 1\n";

/// A scene, and overrides behind NUL bytes.
fn scene(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    let mut parts = text.split('\0');
    let file = parts.next().unwrap_or_default();
    let sets: Vec<String> = parts.map(str::to_owned).collect();
    if let Ok(loaded) = svetlo::config::parse("scene.toml", file, &sets)
        && let Ok(scene) = Scene::from_loaded(&loaded, Path::new("nowhere"))
    {
        let _ = announced_memory(&scene).total();
    }
}

fn suite(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    if let Ok(loaded) = svetlo::config::parse_as("suite.toml", "suite", &text, &[]) {
        let _ = Suite::from_loaded(&loaded, Path::new("nowhere/suite.toml"));
    }
}

fn volume(data: &[u8]) {
    let Some((&choice, data)) = data.split_first() else { return };
    in_file(VOLUMES[usize::from(choice) % VOLUMES.len()], data, |path| {
        let _ = svetlo::volume::read(path, &RawOptions::default());
    });
}

fn picture(data: &[u8]) {
    in_file("a.exr", data, |path| drop(read_picture(path)));
}

fn environment(data: &[u8]) {
    in_file("a.exr", data, |path| drop(Environment::read(path)));
}

fn mesh(data: &[u8]) {
    let Some((&choice, data)) = data.split_first() else { return };
    let choice = usize::from(choice);
    in_file(MESHES[choice % MESHES.len()], data, |path| {
        let smooth = choice / MESHES.len() % 2 == 1;
        let shape = SurfaceShape::Mesh { path: path.into(), scale: 1.0, translate: DVec3::ZERO, smooth };
        let glass = SurfaceMaterial::Dielectric { cauchy: [1.5, 0.0, 0.0], absorption: [0.0; 3] };
        let _ = svetlo::surfaces::load(&[Surface { shape, material: 0 }], &[glass]);
    });
}

/// The scene that films and light belong to, with its data.
pub fn lit() -> (Scene, SceneData) {
    let loaded = svetlo::config::parse("lit.toml", LIT, &[]).expect("a scene");
    let scene = Scene::from_loaded(&loaded, Path::new("")).expect("a scene");
    let data = SceneData::load(&scene).expect("a field");
    (scene, data)
}

fn light(data: &[u8]) {
    with_plan(|_, plan, hash| {
        in_file("light.nrrd", data, |path| {
            let _ = Components::read(path);
            let _ = LightData::read(path, plan, hash);
        });
    });
}

fn resume(data: &[u8]) {
    with_plan(|scene, plan, hash| {
        in_file("film.exr", data, |path| {
            if let Ok(Some(saved)) = Saved::open(path, scene) {
                let _ = saved.film(plan, hash);
            }
        });
    });
}

thread_local! {
    /// Where the files of this thread lie, with those that headers may name.
    static FOLDER: TempDir = {
        let folder = TempDir::new().expect("a folder for the files");
        for name in ["voxels.bin", "voxels.dat", "b.img", "c.hdr", "d.img.gz"] {
            std::fs::write(folder.path().join(name), [7; 480]).expect("room for 480 bytes");
        }
        folder
    };
    /// A plan takes longer than the files: it is made once, and stays.
    static PLAN: (&'static Scene, Plan<'static>, String) = {
        let (scene, data): &'static (Scene, SceneData) = Box::leak(Box::new(lit()));
        let plan = Plan::new(scene, data, BRICK_SHIFT).expect("a plan");
        let hash = data_hash(&plan, data).expect("a hash");
        (scene, plan, hash)
    };
}

fn with_plan(body: impl FnOnce(&Scene, &Plan<'_>, &str)) {
    PLAN.with(|(scene, plan, hash)| body(scene, plan, hash));
}

/// Writes the file and has it read.
fn in_file(name: &str, data: &[u8], read: impl FnOnce(&Path)) {
    let path: PathBuf = FOLDER.with(|folder| folder.path().join(name));
    let before = std::fs::read(&path).ok();
    std::fs::write(&path, data).expect("room for the file");
    read(&path);
    match before {
        Some(bytes) => std::fs::write(&path, bytes).expect("room for the file"),
        None => std::fs::remove_file(&path).expect("a file of this thread"),
    }
}
