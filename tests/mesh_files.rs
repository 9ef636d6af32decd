//! Mesh files read back; damaged ones are refused with a message that names the file, never with a panic.

use glam::DVec3;
use std::fs;
use std::path::Path;
use svetlo::scene::{Surface, SurfaceMaterial, SurfaceShape};
use svetlo::surfaces::{Mesh, Meshes, load};
use tempfile::TempDir;

const GLASS: SurfaceMaterial = SurfaceMaterial::Dielectric { cauchy: [1.5, 0.0, 0.0], absorption: [0.0; 3] };

/// A cube 0..1 of six squares that face outward.
const CUBE: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
];
const SQUARES: [[u8; 4]; 6] =
    [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

fn read_as(name: &str, bytes: &[u8], shape: impl Fn(&Path) -> SurfaceShape) -> Result<Meshes, String> {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    let surface = Surface { shape: shape(&path), material: 0 };
    let read = load(&[surface], &[GLASS]);
    let folder = format!("{}/", folder.path().display());
    match read {
        Ok(mut meshes) => {
            meshes.notes.iter_mut().for_each(|note| *note = note.replace(&folder, ""));
            Ok(meshes)
        }
        Err(error) => {
            assert_eq!(error.exit_code(), 2, "{error}");
            Err(error.to_string().replace(&folder, ""))
        }
    }
}

fn plain(path: &Path) -> SurfaceShape {
    SurfaceShape::Mesh { path: path.into(), scale: 1.0, translate: DVec3::ZERO, smooth: false }
}

fn smooth(path: &Path) -> SurfaceShape {
    SurfaceShape::Mesh { path: path.into(), scale: 1.0, translate: DVec3::ZERO, smooth: true }
}

fn read(name: &str, bytes: &[u8]) -> Result<Meshes, String> {
    read_as(name, bytes, plain)
}

fn obj(points: &[[f64; 3]], faces: &[[u8; 4]]) -> String {
    let vertices = points.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let faces = faces.iter().map(|[a, b, c, d]| format!("f {} {} {} {}\n", a + 1, b + 1, c + 1, d + 1));
    vertices.chain(faces).collect()
}

fn ply_header(format: &str, vertices: usize, faces: usize) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment a cube\nelement vertex {vertices}\nproperty float x\nproperty float y\n\
         property float z\nproperty uchar red\nelement face {faces}\nproperty list uchar int vertex_indices\n\
         element edge 0\nproperty int from\nend_header\n"
    )
}

fn ply_text() -> Vec<u8> {
    let vertices = CUBE.iter().map(|[x, y, z]| format!("{x} {y} {z} 7\n"));
    let faces = SQUARES.iter().map(|[a, b, c, d]| format!("4 {a} {b} {c} {d}\n"));
    (ply_header("ascii", 8, 6) + &vertices.chain(faces).collect::<String>()).into()
}

fn ply_binary(big: bool) -> Vec<u8> {
    let format = if big { "binary_big_endian" } else { "binary_little_endian" };
    let mut bytes: Vec<u8> = ply_header(format, 8, 6).into();
    for point in CUBE {
        for x in point {
            bytes.extend(if big { (x as f32).to_be_bytes() } else { (x as f32).to_le_bytes() });
        }
        bytes.push(7);
    }
    for square in SQUARES {
        bytes.push(4);
        for k in square.map(i32::from) {
            bytes.extend(if big { k.to_be_bytes() } else { k.to_le_bytes() });
        }
    }
    bytes
}

fn corpus() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("cube.obj", obj(&CUBE, &SQUARES).into()),
        ("cube.ply", ply_text()),
        ("little.ply", ply_binary(false)),
        ("BIG.PLY", ply_binary(true)),
    ]
}

fn areas(mesh: &Mesh) -> (f64, f64) {
    let area = |[a, b, c]: [DVec3; 3]| 0.5 * (b - a).cross(c - a).length();
    let volume = |[a, b, c]: [DVec3; 3]| a.dot(b.cross(c)) / 6.0;
    let faces = || mesh.faces().map(|(corners, _)| corners);
    (faces().map(area).sum(), faces().map(volume).sum())
}

#[test]
fn every_format_reads_back() {
    for (name, bytes) in corpus() {
        let meshes = read(name, &bytes).unwrap_or_else(|e| panic!("{e}"));
        let mesh = meshes.of(0).unwrap();
        assert_eq!((mesh.points.len(), mesh.triangles.len()), (8, 12), "{name}");
        let (area, volume) = areas(mesh);
        assert!((area - 6.0).abs() < 1e-14 && (volume - 1.0).abs() < 1e-14, "{name}");
        assert_eq!((&mesh.normals, &meshes.notes), (&None, &vec![]), "{name}");
        let bounds = mesh.bounds().unwrap();
        assert_eq!((bounds.low, bounds.high), (DVec3::ZERO, DVec3::ONE));
    }
}

#[test]
fn scale_before_translation() {
    let shape = |path: &Path| SurfaceShape::Mesh {
        path: path.into(),
        scale: 3.0,
        translate: DVec3::new(1.0, 2.0, -5.0),
        smooth: false,
    };
    let meshes = read_as("cube.obj", &corpus()[0].1, shape).unwrap();
    let bounds = meshes.of(0).unwrap().bounds().unwrap();
    assert_eq!((bounds.low, bounds.high), (DVec3::new(1.0, 2.0, -5.0), DVec3::new(4.0, 5.0, -2.0)));
}

#[test]
fn lines_may_go_on() {
    let text =
        "v 0 0 \\\n  0\r\nv 2 \\\r\n 0 0\nv 0 1 0\n# no end\\\nv 0 0 1\nf 1 \\\n 2 \\\n\\\n 3\nf 1 3 4\\";
    let mesh = read("a.obj", text.as_bytes()).unwrap().of(0).unwrap().clone();
    let corners: Vec<_> = mesh.faces().map(|(corners, _)| corners).collect();
    assert_eq!(corners, [[DVec3::ZERO, 2.0 * DVec3::X, DVec3::Y], [DVec3::ZERO, DVec3::Y, DVec3::Z]]);
    // Lines are counted as they stand.
    let wrong = "v 0 0 \\\n 0\nv 2 0 0\nv 0 1 0\nf 1 2 \\\n 3\nf 1 2 9\n";
    let error = read("a.obj", wrong.as_bytes()).unwrap_err();
    assert!(error.contains("line 7: `9` names `v` 9, but the file has 3 vertices"), "{error}");
}

#[test]
fn faces_that_are_none_are_noted() {
    let text = "v 0 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\nf 1 2\nf 3\nl 1 2\n";
    let notes = read("a.obj", text.as_bytes()).unwrap().notes;
    assert_eq!(notes[0], "a.obj: 2 faces of fewer than three vertices left out");
    let header = ply_header("ascii", 3, 2).replace("property uchar red\n", "");
    let rows = "0 0 0\n2 0 0\n0 1 0\n3 0 1 2\n2 0 1\n";
    let notes = read("a.ply", (header + rows).as_bytes()).unwrap().notes;
    assert_eq!(notes[0], "a.ply: 1 face of fewer than three vertices left out");
}

#[test]
fn what_files_may_say_besides() {
    let text = "# caf\u{e9}\r\nmtllib none.mtl\r\no one\r\nv 0 0 0 1\r\nv 2 0 0 2\r\nv 0 1 0\r\nvt 0 0\r\n\
                vn 0 0 2\r\nusemtl red\r\ns off\r\nf -3/1/1 -2/1/1 -1/1/1\r\ng two\r\nv 0 0 1\r\nusemtl blue\r\n\
                f 1//1 2//1 4//1\r\nl 1 2\r\n";
    // In another encoding.
    let bytes: Vec<u8> = text.chars().map(|c| c as u8).collect();
    let mesh = read_as("a.obj", &bytes, smooth).unwrap().of(0).unwrap().clone();
    assert_eq!(mesh.triangles.len(), 2);
    assert_eq!(mesh.normals, Some(vec![[DVec3::Z; 3]; 2]));
    let second = mesh.faces().nth(1).unwrap().0;
    assert_eq!(second, [DVec3::ZERO, DVec3::X, DVec3::Z]);
    // A byte order mark.
    let marked = format!("\u{feff}{}", obj(&CUBE, &SQUARES));
    assert_eq!(read("a.obj", marked.as_bytes()).unwrap().of(0).unwrap().triangles.len(), 12);
}

/// At the corner of a cube the three faces count alike, however they are cut into triangles.
#[test]
fn normals_of_smooth_meshes() {
    for (name, bytes) in corpus() {
        let mesh = read_as(name, &bytes, smooth).unwrap().of(0).unwrap().clone();
        for (corners, normals) in mesh.faces() {
            for (corner, normal) in corners.into_iter().zip(normals.unwrap()) {
                let face = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
                let outward = (corner - 0.5).normalize();
                assert!((normal.length() - 1.0).abs() < 1e-12 && normal.dot(face) > 0.3, "{name} {normal}");
                // A square has one or two of its triangles there: weights of 1 to 2.
                assert!(normal.dot(outward) > 0.94, "{name} {normal}");
            }
        }
    }
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n\
               property float nx\nproperty float ny\nproperty float nz\nelement face 1\n\
               property list uchar uint vertex_index\nend_header\n0 0 0 3 0 0\n1 0 0 0 -2 0\n0 1 0 0 0 0\n3 0 1 2\n";
    let mesh = read_as("a.ply", ply.as_bytes(), smooth).unwrap().of(0).unwrap().clone();
    assert_eq!(mesh.normals, Some(vec![[DVec3::X, DVec3::NEG_Y, DVec3::Z]]));
}

/// Glass must be closed, and face outward.
#[test]
fn doubts_about_solids() {
    let notes = |faces: &[[u8; 4]]| read("cube.obj", obj(&CUBE, faces).as_bytes()).unwrap().notes;
    assert_eq!(
        notes(&SQUARES[..5]),
        [
            "cube.obj: the mesh is not closed (4 edges of one triangle only): light finds its way in without refraction"
        ]
    );
    let turned = SQUARES.map(|[a, b, c, d]| [d, c, b, a]);
    assert_eq!(
        notes(&turned),
        ["cube.obj: its triangles face inward: what is around it counts as the inside"]
    );
    let mut one_turned = SQUARES;
    one_turned[2].reverse();
    assert_eq!(notes(&one_turned), ["cube.obj: the triangles at 4 edges do not agree which side is outside"]);
    // The same corners with indices of their own for every face are closed all the same.
    let split: Vec<[f64; 3]> = SQUARES.iter().flatten().map(|&k| CUBE[usize::from(k)]).collect();
    let faces: Vec<[u8; 4]> = (0..6).map(|k| [4 * k, 4 * k + 1, 4 * k + 2, 4 * k + 3]).collect();
    let meshes = read("cube.obj", obj(&split, &faces).as_bytes()).unwrap();
    assert_eq!((meshes.of(0).unwrap().points.len(), meshes.notes), (24, vec![]));
}

#[test]
fn triangles_without_area_are_left_out() {
    let text = obj(&CUBE, &SQUARES) + "v 2 0 0\nf 1 2 9\nf 1 1 2\nf 3 4 4\n";
    let meshes = read("cube.obj", text.as_bytes()).unwrap();
    assert_eq!(meshes.of(0).unwrap().triangles.len(), 12);
    assert_eq!(meshes.notes, ["cube.obj: 3 triangles without area left out"]);
    // Small is not flat.
    let small = CUBE.map(|point| point.map(|x| 1e-30 * x));
    assert_eq!(read("cube.obj", obj(&small, &SQUARES).as_bytes()).unwrap().notes, Vec::<String>::new());
}

#[track_caller]
fn fails(name: &str, bytes: impl AsRef<[u8]>, expected: &str) {
    let text = read(name, bytes.as_ref()).expect_err("it is damaged");
    assert!(
        text.starts_with(&format!("{name}: ")) && text.contains(expected),
        "expected {expected}\ngot {text}"
    );
    assert!(!text.contains('\n') && text.len() < 400, "{text}");
}

#[test]
fn damaged_obj_files() {
    let cube = obj(&CUBE, &SQUARES);
    let with = |line: &str| cube.clone() + line;
    fails("a.obj", "", "it has no faces; a mesh needs at least one triangle");
    fails("a.obj", "v 0 0 0\nl 1 1\n", "it has no faces");
    fails("a.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "none of its triangles has an area");
    fails("a.obj", with("f 1 2 9\n"), "line 15: `9` names `v` 9, but the file has 8 vertices");
    fails("a.obj", with("f 0 1 2\n"), "line 15: `0` names `v` 0");
    fails("a.obj", with("f -9 1 2\n"), "line 15: `-9` names `v` -9");
    fails("a.obj", with("f 1//1 2//1 3//1\n"), "names `vn` 1, but the file has 0 normals");
    fails(
        "a.obj",
        with("vn 0 0 1\nf 1//-2 2//1 3//1\n"),
        "line 16: `1//-2` names `vn` -2, but the file has 1 normals",
    );
    fails("a.obj", with("f 1/9223372036854775807 2/1 3/1\n"), "names `vt` 9223372036854775807");
    fails("a.obj", with("f 1/-9223372036854775808 2/1 3/1\n"), "names `vt` -9223372036854775808");
    let late = "v 1 0 0\nv 0 1 0\nv 0 0 1\nf 1//1 2//1 3//1\no part\nvn 0 0 1\nf 1//1 2//1 3//1\n";
    fails("a.obj", late, "`vn` lines must stand before the faces that name them");
    fails("a.obj", with("f 1 2 x\n"), "line 15: a face needs the numbers of its vertices");
    fails("a.obj", with("f 1/2/3/4 2 3\n"), "line 15: ");
    fails("a.obj", with("v 1 2\n"), "line 15: a vertex needs three numbers");
    fails("a.obj", with("v 1 2 2m\n"), "line 15: a vertex needs three numbers");
    fails("a.obj", cube.replace("v 1 1 1", "v 1 nan 1"), "vertex 7 is not finite");
    fails("a.obj", cube.replace("v 1 1 1", "v 1 -inf 1"), "is not finite");
    fails("a.obj", cube.replace("v 1 1 1", "v 1 1e999 1"), "is not finite");
    let normals = with("vn nan 0 1\n").replace("f 4 3 2 1", "f 4//1 3//1 2//1 1//1");
    let only =
        normals.lines().filter(|line| !line.starts_with("f ") || line.contains("//")).collect::<Vec<_>>();
    let text = read_as("a.obj", only.join("\n").as_bytes(), smooth).unwrap_err();
    assert!(text.contains("a normal is not finite"), "{text}");
}

#[test]
fn damaged_ply_files() {
    let text = String::from_utf8(ply_text()).unwrap();
    fails("a.ply", "", "it is not a valid PLY file: ");
    fails("a.ply", "solid cube\n", "it is not a valid PLY file: ");
    fails("a.ply", text.replace("end_header\n", ""), "it is not a valid PLY file: ");
    fails("a.ply", text.replace("property float y\n", "property float w\n"), "its vertices have no `y`");
    fails(
        "a.ply",
        text.replace("property float y", "property list uchar float y"),
        "it is not a valid PLY file: ",
    );
    fails("a.ply", text.replace("vertex_indices", "corners"), "its faces have no list `vertex_indices`");
    fails("a.ply", text.replace("uchar int vertex", "uchar float vertex"), "it is not a valid PLY file: ");
    fails(
        "a.ply",
        text.replace("element vertex", "element point"),
        "face 1 names vertex 3, but the vertices are 0 to -1",
    );
    fails(
        "a.ply",
        text.replace("4 0 1 5 4", "4 0 1 8 4"),
        "face 3 names vertex 8, but the vertices are 0 to 7",
    );
    fails("a.ply", text.replace("4 0 1 5 4", "4 0 1 -1 4"), "face 3 names vertex -1");
    fails("a.ply", text.replace("4 0 1 5 4", "5 0 1 5 4"), "it is not a valid PLY file: ");
    fails("a.ply", text.replace("1 1 1 7", "1 nan 1 7"), "it is not a valid PLY file: ");
    fails("a.ply", text.replace("1 1 1 7", "1 1e999 1 7"), "vertex 7 is not finite");
    fails("a.ply", text.replace("element face 6", "element face 0"), "it has no faces");
    fails(
        "a.ply",
        text.replace("face 6", "face 1000000000"),
        "its header promises 1000000000 of `face`, at least ",
    );
    fails("a.ply", text.replace("face 6", "face 99999999999999999999"), "it is not a valid PLY file: ");
    fails("a.ply", text.replace("vertex 8", "vertex 18446744073709551615"), "its header promises");
    fails("a.ply", text.replace("edge 0\nproperty int from", "edge 4000000000"), "`edge` has no properties");
    let promise = |element: &str| {
        let bytes =
            String::from_utf8_lossy(&ply_binary(false)[..ply_header("binary_little_endian", 8, 6).len()])
                .into_owned();
        [
            bytes
                .replace(element, &format!("{} 1000000000", element.rsplit_once(' ').unwrap().0))
                .into_bytes(),
            ply_binary(false),
        ]
        .concat()
    };
    fails(
        "a.ply",
        promise("element vertex 8"),
        "its header promises 1000000000 of `vertex`, at least 13000000000 bytes",
    );
    fails("a.ply", promise("element face 6"), "its header promises 1000000000 of `face`");
    let mut nan = ply_binary(false);
    let start = ply_header("binary_little_endian", 8, 6).len();
    nan[start..start + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    fails("a.ply", nan, "vertex 1 is not finite");
    let mut long = ply_binary(false);
    long[start + 8 * 13] = 255;
    fails("a.ply", long, "it is not a valid PLY file: ");
}

#[test]
fn a_file_that_is_gone() {
    let surface = Surface { shape: plain(Path::new("/nowhere/ring.obj")), material: 0 };
    let text = load(&[surface], &[GLASS]).unwrap_err().to_string();
    assert!(text.starts_with("/nowhere/ring.obj: it cannot be read: "), "{text}");
}

/// Whatever is cut off or changed: a mesh, or a message.
#[test]
fn nothing_panics() {
    let folder = TempDir::new().unwrap();
    for (name, bytes) in corpus() {
        let surface = Surface { shape: plain(&folder.path().join(name)), material: 0 };
        let check = |bytes: &[u8]| {
            fs::write(folder.path().join(name), bytes).unwrap();
            match load(std::slice::from_ref(&surface), &[GLASS]) {
                Ok(meshes) => assert!(!meshes.of(0).unwrap().triangles.is_empty()),
                Err(error) => assert!(error.to_string().contains(&format!("{name}: ")), "{error}"),
            }
        };
        for end in (0..bytes.len()).step_by(2) {
            check(&bytes[..end]);
        }
        for at in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[at] = [b'0', b'9', b'-', b'\n', b' ', 0xff][at % 6];
            check(&changed);
        }
    }
}
