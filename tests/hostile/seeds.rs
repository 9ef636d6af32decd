//! Whole files of every kind: what mutations and libFuzzer begin with.

use crate::corpus::{cases_with_header, raw_cases};
use crate::targets::{LIT, MESHES, VOLUMES, lit};
use glam::DVec3;
use std::path::Path;
use svetlo::picture::{Picture, Samples, write_exr, write_png_rgb8};
use svetlo::render::{BRICK_SHIFT, Plan, data_hash};
use svetlo::volume::{Components, Endian, StoredType};
use tempfile::TempDir;

/// Whole inputs of a target.
pub fn of(target: &str) -> Vec<Vec<u8>> {
    match target {
        "scene" => [texts("configs"), texts("tests/scenes"), vec![LIT.into()]].concat(),
        "suite" => texts("configs/bench"),
        "volume" => volumes(),
        "picture" => [pictures(), vec![png()]].concat(),
        "environment" => pictures(),
        "mesh" => meshes(),
        "light" => vec![light()],
        "resume" => films(),
        other => panic!("no target {other}"),
    }
}

/// The TOML files of a folder.
fn texts(folder: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.retain(|path| path.extension().is_some_and(|end| end == "toml"));
    paths.iter().map(|path| std::fs::read(path).unwrap()).collect()
}

fn volumes() -> Vec<Vec<u8>> {
    let raw = raw_cases(StoredType::I16, Endian::Little);
    let all = cases_with_header().into_iter().chain(raw);
    let known = |name: &str| {
        let end = |name: &str| name.split_once('.').map(|(_, end)| end.to_owned());
        VOLUMES.iter().position(|volume| end(volume) == end(name))
    };
    let mut seeds: Vec<Vec<u8>> = all
        .filter(|case| matches!(case.kind, StoredType::I16 | StoredType::F64))
        .filter_map(|case| Some([vec![known(&case.name)? as u8], case.bytes].concat()))
        .collect();
    seeds.sort();
    seeds.dedup();
    seeds
}

/// The bytes that a writer leaves in a file.
fn written(name: &str, write: impl FnOnce(&Path)) -> Vec<u8> {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    write(&path);
    std::fs::read(path).unwrap()
}

fn pictures() -> Vec<Vec<u8>> {
    let plane = |n: usize| (0..n).map(|i| (i as f32).sin()).collect::<Vec<_>>();
    let grey = Picture::new(5, 3).with_channel("Y", plane(15));
    let mut colour = Picture::new(20, 40);
    for name in ["R", "G", "B", "A", "depth.Z"] {
        colour = colour.with_channel(name, plane(800));
    }
    colour.metadata.insert("svetlo.seed".into(), "7".into());
    [grey, colour].iter().map(|picture| written("a.exr", |path| write_exr(path, picture).unwrap())).collect()
}

fn png() -> Vec<u8> {
    let codes: Vec<u8> = (0..9 * 7 * 3).map(|i| (i * 5 % 256) as u8).collect();
    written("a.png", |path| write_png_rgb8(path, 9, 7, &codes).unwrap())
}

fn meshes() -> Vec<Vec<u8>> {
    let header = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\ncomment two triangles\nelement vertex 4\nproperty float x\nproperty float y\n\
             property float z\nelement face 2\nproperty list uchar int vertex_indices\nelement edge 1\n\
             property list uchar short from\nend_header\n"
        )
    };
    let points = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let text = header("ascii") + "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n1 5\n";
    let mut binary = header("binary_little_endian").into_bytes();
    binary.extend(points.iter().flatten().flat_map(|x| x.to_le_bytes()));
    for face in [[0i32, 1, 2], [0, 1, 3]] {
        binary.push(3);
        binary.extend(face.iter().flat_map(|corner| corner.to_le_bytes()));
    }
    binary.extend([1, 5, 0]);
    let obj = "# mesh\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\nvt 0 1\no part\nf 1/1/1 2/1/1 3/1/1\nf -4 -3 -1\n\
               l 1 2\nusemtl none\nf 1//1 2//1 3//1 4//1\n";
    let ply = MESHES.iter().position(|name| name.ends_with("ply")).unwrap() as u8;
    let seed = |choice: u8, bytes: &[u8]| [&[choice], bytes].concat();
    let binary = [ply, ply + 2].map(|choice| seed(choice, &binary));
    [
        vec![seed(1 - ply, obj.as_bytes()), seed(3 - ply, obj.as_bytes()), seed(ply, text.as_bytes())],
        binary.into(),
    ]
    .concat()
}

/// A light volume that only its hash refuses.
fn light() -> Vec<u8> {
    let (scene, data) = lit();
    let plan = Plan::new(&scene, &data, BRICK_SHIFT).unwrap();
    let hash = data_hash(&plan, &data).unwrap();
    let keys = [
        ("svetlo", "light volume 1"),
        ("svetlo.components", "fluence direct"),
        ("svetlo.light_hash", &scene.light_hash),
        ("svetlo.data_hash", &hash),
        ("svetlo.content_hash", "none"),
    ];
    let size = plan.local.size() * plan.local.unit;
    let dims = [5, 4, 3];
    let spacing = size / DVec3::from_array(dims.map(|n| n as f64));
    let light = Components {
        count: 6,
        dims,
        spacing,
        origin: plan.local.origin + 0.5 * spacing,
        keys: keys.map(|(key, value)| (key.to_owned(), value.to_owned())).to_vec(),
        values: (0..360).map(|i| i as f32).collect(),
    };
    written("light.nrrd", |path| light.write(path).unwrap())
}

/// A film of the scene as far as its state goes, and one that is none.
fn films() -> Vec<Vec<u8>> {
    let (scene, _) = lit();
    let mut film = Picture::new(9, 7);
    for name in ["R", "G", "B", "A"] {
        film = film.with_channel(name, vec![0.5; 63]);
    }
    film.channels.push(svetlo::picture::Channel { name: "count".into(), data: Samples::U32(vec![1; 63]) });
    let seed = scene.seed.to_string();
    let texts = [("state", "1"), ("seed", &seed), ("scene_hash", &scene.hash), ("data_hash", "none")];
    for (key, value) in texts {
        film.metadata.insert(format!("svetlo.{key}"), value.to_owned());
    }
    let film = written("film.exr", |path| write_exr(path, &film).unwrap());
    [vec![film], pictures()].concat()
}
