//! Surfaces and materials: their values, and what users read when they are wrong.

use std::path::Path;

use glam::DVec3;

use super::context::Context;
use super::surface::{materials, surfaces};
use super::{Metaball, Surface, SurfaceMaterial, SurfaceShape};
use crate::config;

/// The rest of a scene, after the tables that matter here.
const REST: &str = r#"[camera]
position = [0, 0, -2]
target = [0, 0, 0]
[volume]
field = { kind = "cloud" }
dims = [8, 8, 8]
[method]
kind = "mip"
"#;

type Read = (Vec<SurfaceMaterial>, Vec<Surface>);

/// Materials and surfaces by themselves, whatever the method; files are looked for in `folder`.
fn read_in(text: &str, folder: &Path) -> Result<Read, String> {
    let loaded = config::parse("scene.toml", &format!("{text}{REST}"), &[]).map_err(|e| e.to_string())?;
    let mut cx = Context::new(&loaded.document, folder);
    let read = (
        materials(&loaded.config.material, &mut cx),
        surfaces(&loaded.config.surface, &loaded.config.material, &mut cx),
    );
    let problems = cx.into_problems();
    if problems.is_empty() { Ok(read) } else { Err(loaded.document.error(&problems).to_string()) }
}

fn read(text: &str) -> Result<Read, String> {
    read_in(text, Path::new("data"))
}

/// Asserts that a text fails with this at first, without the lines that show the place.
#[track_caller]
fn fails(text: &str, expected: &[&str]) {
    let text = read(text).expect_err("it is wrong");
    let lines: Vec<_> = text.lines().filter(|line| !line.trim().is_empty()).collect();
    for piece in expected {
        assert!(lines.iter().any(|line| line.contains(piece)), "expected {piece}\ngot\n{text}");
    }
    assert!(text.ends_with("1 problem in scene.toml"), "{text}");
}

const GLASS: &str = "[[material]]\nname = \"glass\"\nkind = \"dielectric\"\nior = 1.5\n";

fn with_glass(surface: &str) -> String {
    format!("{GLASS}[[surface]]\nmaterial = \"glass\"\n{surface}\n")
}

#[test]
fn every_material() {
    let text = "[[material]]\nname = \"chalk\"\nkind = \"diffuse\"\ncolor = [0.8, 0.7, 0.6]\n\
                [[material]]\nname = \"silver\"\nkind = \"mirror\"\n\
                [[material]]\nname = \"BK7\"\nkind = \"dielectric\"\ndispersion = { a = 1.5046, b = 0.0042 }\n\
                absorption = [0.1, 0, 0.2]\n";
    let (materials, _) = read(text).unwrap();
    let glass = SurfaceMaterial::Dielectric { cauchy: [1.5046, 0.0042, 0.0], absorption: [0.1, 0.0, 0.2] };
    assert_eq!(
        materials,
        [
            SurfaceMaterial::Diffuse { color: [0.8, 0.7, 0.6] },
            SurfaceMaterial::Mirror { color: [1.0; 3] },
            glass
        ]
    );
    assert!(materials.iter().map(SurfaceMaterial::is_specular).eq([false, true, true]));
    // n_d of BK7 by this fit: 1.5046 + 0.0042 / 0.5876².
    assert!((glass.index(0.5876) - 1.516764).abs() < 1e-6);
    assert_eq!(read(GLASS).unwrap().0[0].index(0.4), 1.5);
}

#[test]
fn every_shape() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("Ring.PLY"), "").unwrap();
    let text = |surface: &str| with_glass(surface);
    let shape = |surface: &str| read_in(&text(surface), folder.path()).unwrap().1.remove(0).shape;
    let v = DVec3::new;
    assert_eq!(
        shape("kind = \"plane\"\npoint = [1, 2, 3]\nnormal = [0, 0, -4]"),
        SurfaceShape::Plane { point: v(1.0, 2.0, 3.0), normal: DVec3::NEG_Z }
    );
    assert_eq!(
        shape("kind = \"sphere\"\ncentre = [1, 2, 3]\nradius = 0.5"),
        SurfaceShape::Sphere { centre: v(1.0, 2.0, 3.0), radius: 0.5 }
    );
    assert_eq!(
        shape("kind = \"rectangle\"\ncentre = [1, 2, 3]\nedge_u = [2, 0, 0]\nedge_v = [1, 1, 0]"),
        SurfaceShape::Rectangle {
            centre: v(1.0, 2.0, 3.0),
            edge_u: v(2.0, 0.0, 0.0),
            edge_v: v(1.0, 1.0, 0.0)
        }
    );
    assert_eq!(
        shape("kind = \"disk\"\ncentre = [1, 2, 3]\nnormal = [9, 0, 0]\nradius = 2"),
        SurfaceShape::Disk { centre: v(1.0, 2.0, 3.0), normal: DVec3::X, radius: 2.0 }
    );
    assert_eq!(
        shape("kind = \"box\"\nlow = [0, 0, 0]\nhigh = [1, 2, 3]"),
        SurfaceShape::Box { low: DVec3::ZERO, high: v(1.0, 2.0, 3.0) }
    );
    let ball = |x: f64, weight| Metaball { centre: v(x, 0.0, 0.0), radius: 1.0, weight };
    assert_eq!(
        shape(
            "kind = \"metaballs\"\nthreshold = 0.2\n\
             balls = [{ centre = [0, 0, 0], radius = 1 }, { centre = [1, 0, 0], radius = 1, weight = -0.5 }]"
        ),
        SurfaceShape::Metaballs { balls: vec![ball(0.0, 1.0), ball(1.0, -0.5)], threshold: 0.2 }
    );
    assert_eq!(
        shape("kind = \"mesh\"\npath = \"Ring.PLY\""),
        SurfaceShape::Mesh {
            path: folder.path().join("Ring.PLY"),
            scale: 1.0,
            translate: DVec3::ZERO,
            smooth: false
        }
    );
}

#[test]
fn surfaces_find_their_materials_by_name() {
    let text = format!(
        "[[material]]\nname = \"chalk\"\nkind = \"diffuse\"\ncolor = 1\n{}",
        with_glass("kind = \"sphere\"\ncentre = [0, 0, 0]\nradius = 1")
    );
    assert_eq!(read(&text).unwrap().1[0].material, 1);
}

#[test]
fn a_material_that_is_not_there() {
    let sphere = "kind = \"sphere\"\ncentre = [0, 0, 0]\nradius = 1\n";
    let text = read(&format!("{GLASS}[[surface]]\nmaterial = \"glas\"\n{sphere}")).unwrap_err();
    let expected = "error: there is no material \"glas\"
  ┌─ scene.toml:6:12
  │
6 │ material = \"glas\"
  │            ^^^^^^ did you mean \"glass\"?
  │
  = materials: \"glass\"

1 problem in scene.toml";
    assert_eq!(text, expected);
    let other = format!("{GLASS}[[surface]]\nmaterial = \"marble\"\n{sphere}");
    fails(&other, &["there is no material \"marble\"", "no `[[material]]` has this name"]);
    let alone = format!("[[surface]]\nmaterial = \"glass\"\n{sphere}");
    fails(&alone, &["there is no material \"glass\"", "the scene has no materials: add a `[[material]]`"]);
}

#[test]
fn names_of_materials() {
    fails(&format!("{GLASS}{GLASS}"), &["there are two materials \"glass\"", "`material.0` has this name"]);
    fails(&GLASS.replace("glass", ""), &["`material.0.name` must not be empty"]);
}

#[test]
fn indices_of_refraction() {
    let glass = |keys: &str| GLASS.replace("ior = 1.5", keys);
    fails(&glass(""), &["a dielectric needs `ior` or `dispersion`"]);
    fails(&glass("ior = 0"), &["`material.0.ior` is out of range", "must be more than 0 and at most 100"]);
    fails(&glass("ior = 101"), &["`material.0.ior` is out of range"]);
    fails(&glass("ior = nan"), &["`material.0.ior` must be a finite number", "this is not a number"]);
    let both = glass("ior = 1.5\ndispersion = { a = 1.5, b = 0 }");
    fails(&both, &["`material.0.dispersion` does not go with `material.0.ior`"]);
    let wrong = "`material.0.dispersion` gives a refractive index out of range";
    for dispersion in ["a = 1.5, b = -1", "a = 0, b = 0", "a = 1.5, b = 0, c = 1e9", "a = -1.5, b = 0.004"] {
        fails(&glass(&format!("dispersion = {{ {dispersion} }}")), &[wrong]);
    }
    // Good at both ends, negative in between.
    fails(&glass("dispersion = { a = 7, b = -4, c = 0.5 }"), &[wrong]);
    fails(&glass("dispersion = { a = 1.5 }"), &["missing key `b` in `material.0.dispersion`"]);
    fails(&glass("ior = 1.5\nabsorption = -1"), &["`material.0.absorption"]);
}

#[test]
fn colours_conserve_energy() {
    let text = "[[material]]\nname = \"m\"\nkind = \"diffuse\"\ncolor = [0.5, 1.01, 0]\n";
    fails(text, &["`material.0.color.1` is out of range", "must be at least 0 and at most 1"]);
    fails(&text.replace("diffuse", "mirror"), &["`material.0.color.1` is out of range"]);
    fails("[[material]]\nname = \"m\"\nkind = \"diffuse\"\n", &["missing key `color` in `material.0`"]);
}

#[test]
fn shapes_without_extent() {
    let wrong = |surface: &str, expected: &[&str]| fails(&with_glass(surface), expected);
    wrong(
        "kind = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 0]",
        &["`surface.0.normal` must not be zero"],
    );
    wrong(
        "kind = \"plane\"\npoint = [0, inf, 0]\nnormal = [0, 1, 0]",
        &["`surface.0.point.1` must be a finite number", "this is infinite"],
    );
    wrong("kind = \"sphere\"\ncentre = [0, 0, 0]\nradius = 0", &["`surface.0.radius` is out of range"]);
    wrong(
        "kind = \"disk\"\ncentre = [0, 0, 0]\nnormal = [0, 1, 0]\nradius = -1",
        &["`surface.0.radius` is out of range", "must be more than 0"],
    );
    wrong(
        "kind = \"rectangle\"\ncentre = [0, 0, 0]\nedge_u = [0, 0, 0]\nedge_v = [0, 1, 0]",
        &["`surface.0.edge_u` must not be zero"],
    );
    wrong(
        "kind = \"rectangle\"\ncentre = [0, 0, 0]\nedge_u = [0, 2, 0]\nedge_v = [0, 1, 0]",
        &["`surface.0.edge_v` must not be parallel to `surface.0.edge_u`"],
    );
    wrong(
        "kind = \"box\"\nlow = [0, 0, 0]\nhigh = [1, 0, 1]",
        &["`surface.0.high` must be more than `surface.0.low` on every axis", "the low corner is [0, 0, 0]"],
    );
}

#[test]
fn metaballs_that_are_none() {
    let wrong = |keys: &str, expected: &[&str]| {
        fails(&with_glass(&format!("kind = \"metaballs\"\n{keys}")), expected)
    };
    let ball = "balls = [{ centre = [0, 0, 0], radius = 1, weight = 0.5 }, { centre = [1, 0, 0], radius = 1, weight = -2 }]";
    wrong(
        "balls = []\nthreshold = 0.5",
        &["`surface.0.balls` must be a list of tables", "this is an empty list"],
    );
    wrong(&format!("{ball}\nthreshold = 0"), &["`surface.0.threshold` is out of range"]);
    wrong(
        &format!("{ball}\nthreshold = 0.5"),
        &["`surface.0.threshold` is more than the field anywhere", "the positive weights add up to 0.5"],
    );
    wrong(
        "balls = [{ centre = [0, 0, 0], radius = 1, weight = 3e9 }, { centre = [1, 0, 0], radius = 1, weight = -1e9 }]\nthreshold = 3.9",
        &[
            "`surface.0.threshold` is too small beside the weights",
            "a billionth of their sum is the least: 4",
        ],
    );
    wrong(
        "balls = [{ centre = [0, 0, 0], radius = 0 }]\nthreshold = 0.5",
        &["`surface.0.balls.0.radius` is out of range"],
    );
}

#[test]
fn meshes_that_are_none() {
    let mesh = |path: &str| with_glass(&format!("kind = \"mesh\"\npath = \"{path}\""));
    fails(&mesh("no.obj"), &["there is no file \"no.obj\"", "looked for data/no.obj"]);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("ring.stl"), "").unwrap();
    let text = read_in(&mesh("ring.stl"), folder.path()).unwrap_err();
    assert!(text.contains("\"ring.stl\" is not a mesh that can be read"), "{text}");
    assert!(text.contains("meshes end in .obj or .ply"), "{text}");
    let scaled = mesh("a.obj").replace("path", "scale = 0\npath");
    fails(&scaled, &["`surface.0.scale` is out of range"]);
}
