//! Scenes of surfaces: what is wrong with caustics, their photons and how they are gathered.

use super::{plain, read};

/// A valid scene of surfaces that the tests break.
const SURFACES: &str = r#"[camera]
position = [0, -4, 2]
target = [0, 0, 0]
[[material]]
name = "white"
kind = "diffuse"
color = 1
[[surface]]
kind = "plane"
point = [0, 0, 0]
normal = [0, 0, 1]
material = "white"
[[light]]
kind = "point"
position = [0, 0, 1]
intensity = 1
[method]
kind = "caustics"
"#;

/// Asserts that the scene with a piece replaced and lines of `[method]` added fails with exactly this text.
#[track_caller]
fn fails(edit: (&str, &str), method: &str, expected: &str) {
    assert!(SURFACES.contains(edit.0));
    let text = SURFACES.replacen(edit.0, edit.1, 1) + method;
    let error = plain(&read(&text, &[]).expect_err("the scene is wrong"));
    assert!(error == expected.trim(), "expected\n{expected}\ngot\n{error}\n");
}

#[test]
fn the_scene_of_surfaces_is_valid() {
    let scene = read(SURFACES, &[]).expect("valid");
    assert!(scene.volume.is_none());
}

#[test]
fn intensity_without_weights_as_published() {
    fails(
        ("", ""),
        "gather.intensity = 2\n",
        r#"
error: `method.gather.intensity` needs `method.gather.weights = "paper"`
   ┌─ scene.toml:19:8
   │
19 │ gather.intensity = 2
   │        ^^^^^^^^^ normalised weights have no scale of their own

1 problem in scene.toml
"#,
    );
}

#[test]
fn weights_as_published_without_what_they_need() {
    fails(
        ("", ""),
        "gather.weights = \"paper\"\n",
        r#"
error: weights "paper" need `method.gather.intensity`
   ┌─ scene.toml:19:18
   │
19 │ gather.weights = "paper"
   │                  ^^^^^^^ what does a photon add at its place?

error: weights "paper" need `method.emission.flux = "equal"`
   ┌─ scene.toml:19:18
   │
19 │ gather.weights = "paper"
   │                  ^^^^^^^ as published, all photons are alike

2 problems in scene.toml
"#,
    );
}

#[test]
fn a_target_with_parallel_edges() {
    fails(
        ("", ""),
        "emission.target = { centre = [0, 0, 0], edge_u = [1, 0, 0], edge_v = [2, 0, 0] }\n",
        r#"
error: `method.emission.target.edge_v` must be perpendicular to `edge_u`
   ┌─ scene.toml:19:70
   │
19 │ emission.target = { centre = [0, 0, 0], edge_u = [1, 0, 0], edge_v = [2, 0, 0] }
   │                                                                      ^^^^^^^^^ they span no rectangle

1 problem in scene.toml
"#,
    );
}

#[test]
fn a_target_that_is_no_rectangle() {
    for (edge, right) in [("[1e-3, 1, 0]", false), ("[1e-9, 1, 0]", true), ("[0, 0, 0]", false)] {
        let target =
            format!("emission.target = {{ centre = [0, 0, 0], edge_u = [1, 0, 0], edge_v = {edge} }}\n");
        let read = read(&format!("{SURFACES}{target}"), &[]);
        assert_eq!(read.is_ok(), right, "{edge}: {read:?}");
        assert!(right || read.unwrap_err().contains("method.emission.target.edge_v"), "{edge}");
    }
}

#[test]
fn a_material_that_is_not_there() {
    fails(
        ("material = \"white\"", "material = \"whit\""),
        "",
        r#"
error: there is no material "whit"
   ┌─ scene.toml:12:12
   │
12 │ material = "whit"
   │            ^^^^^^ did you mean "white"?
   │
   = materials: "white"

1 problem in scene.toml
"#,
    );
}

#[test]
fn surfaces_by_a_method_for_volumes() {
    fails(
        ("\"caustics\"", "\"mip\""),
        "",
        r#"
error: missing key `volume`
  ┌─ scene.toml:1:1
  │
1 │ [camera]
  │ ^ this method renders a volume
  │
  = a [volume] table, or `method.kind = "caustics"` for surfaces alone

error: `[[surface]]` needs `method.kind = "caustics"`
  ┌─ scene.toml:8:1
  │
8 │ [[surface]]
  │ ^^^^^^^^^^^ only caustics renders surfaces

2 problems in scene.toml
"#,
    );
}

#[test]
fn caustics_without_surfaces() {
    fails(
        ("[[surface]]\nkind = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nmaterial = \"white\"\n", ""),
        "",
        r#"
error: caustics needs at least one `[[surface]]`
   ┌─ scene.toml:13:8
   │
13 │ kind = "caustics"
   │        ^^^^^^^^^^ there is nothing to render

1 problem in scene.toml
"#,
    );
}

#[test]
fn what_belongs_to_a_volume_without_one() {
    fails(
        ("", ""),
        "[medium]\nsigma_max = 1\n[transfer]\ncolormap = \"hot\"\n[phase]\n",
        r#"
error: `medium` needs a `[volume]`
   ┌─ scene.toml:19:2
   │
19 │ [medium]
   │  ^^^^^^ there is no volume that it would be of

error: `transfer` needs a `[volume]`
   ┌─ scene.toml:21:2
   │
21 │ [transfer]
   │  ^^^^^^^^ there is no volume that it would be of

error: `phase` needs a `[volume]`
   ┌─ scene.toml:23:2
   │
23 │ [phase]
   │  ^^^^^ there is no volume that it would be of

3 problems in scene.toml
"#,
    );
}

#[test]
fn cells_on_planes_where_a_receiver_is_curved() {
    let sphere =
        "[[surface]]\nkind = \"sphere\"\ncentre = [0, 0, 0]\nradius = 1\nmaterial = \"white\"\n[[light]]";
    fails(
        ("[[light]]", sphere),
        "gather.acceleration = \"planar\"\n",
        r#"
error: `method.gather.acceleration = "planar"` needs receivers that are planes, rectangles or disks
   ┌─ scene.toml:24:23
   │
24 │ gather.acceleration = "planar"
   │                       ^^^^^^^^ `surface.1` is diffuse and has no plane of its own

1 problem in scene.toml
"#,
    );
}

#[test]
fn numbers_out_of_range() {
    for (line, range) in [
        ("photons = 3000000000", "must be at least 0 and at most 2147483647"),
        ("depth = 0", "must be at least 1 and at most 1000"),
        ("radius = 0", "must be more than 0"),
        ("alpha = 1.5", "must be more than 0 and at most 1"),
        (
            "gather.acceleration = \"octree\"",
            "allowed: \"voxels\", \"planar\", \"lexicographic\" or \"brute-force\"",
        ),
    ] {
        let error = read(&format!("{SURFACES}{line}\n"), &[]).unwrap_err();
        assert!(error.contains("scene.toml:19:") && error.contains(range), "{line}: {error}");
    }
}
