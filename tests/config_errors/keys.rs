//! Unknown, missing and misplaced keys; what is not TOML at all.

use super::fails;

#[test]
fn unknown_key_with_a_suggestion() {
    fails(
        &[("sigma_max", "sigma_mx")],
        &[],
        r#"
error: unknown key `sigma_mx` in `medium`
  ┌─ scene.toml:8:1
  │
8 │ sigma_mx = 40.0
  │ ^^^^^^^^ did you mean `sigma_max`?
  │
  = keys here: `mode`, `sigma_max`, `albedo`, `extinction_color`

1 problem in scene.toml
"#,
    );
}

#[test]
fn unknown_key_without_a_suggestion() {
    fails(
        &[("sigma_max = 40.0", "sigma_max = 40.0\nthickness = 1")],
        &[],
        r#"
error: unknown key `thickness` in `medium`
  ┌─ scene.toml:9:1
  │
9 │ thickness = 1
  │ ^^^^^^^^^ no such key
  │
  = keys here: `mode`, `sigma_max`, `albedo`, `extinction_color`

1 problem in scene.toml
"#,
    );
}

#[test]
fn unknown_table() {
    fails(
        &[("[medium]", "[lamp]\nx = 1\n[medium]")],
        &[],
        r#"
error: unknown key `lamp`
  ┌─ scene.toml:7:2
  │
7 │ [lamp]
  │  ^^^^ no such key
  │
  = keys here: `seed`, `image`, `camera`, `volume`, `medium`, `phase`, `transfer`, `background`, `light`, `material`, `surface`, `method`, `film`, `stop`

1 problem in scene.toml
"#,
    );
}

#[test]
fn missing_key() {
    fails(
        &[("target = [0.5, 0.5, 0.5]\n", "")],
        &[],
        r#"
error: missing key `target` in `camera`
  ┌─ scene.toml:1:1
  │
1 │ [camera]
  │ ^^^^^^^^ needs `target`
  │
  = `target`: The point in the middle of the image, [x, y, z] in scene units; not `position`.

1 problem in scene.toml
"#,
    );
}

#[test]
fn missing_table() {
    fails(
        &[("[camera]\nposition = [0.5, 0.5, -2.0]\ntarget = [0.5, 0.5, 0.5]\n", "")],
        &[],
        r#"
error: missing key `camera`
  ┌─ scene.toml:1:1
  │
1 │ [volume]
  │ ^ needs `camera`
  │
  = `camera`: The camera. Image right is forward × up (right-handed).

1 problem in scene.toml
"#,
    );
}

#[test]
fn missing_kind() {
    fails(
        &[(r#"kind = "emission-absorption""#, "radiance = 1")],
        &[],
        r#"
error: missing key `kind` in `method`
  ┌─ scene.toml:9:1
  │
9 │ [method]
  │ ^^^^^^^^ needs `kind`: "emission-absorption", "mip", "isosurface", "single-scattering", "multiple-scattering", "convection-diffusion", "hybrid-diffusion" or "caustics"

1 problem in scene.toml
"#,
    );
}

#[test]
fn key_of_another_kind() {
    fails(
        &[("[volume]", "kind = \"orthographic\"\nheight = 1\nfov = 30\n[volume]")],
        &[],
        r#"
error: `camera.fov` does not go with kind = "orthographic"
  ┌─ scene.toml:6:1
  │
6 │ fov = 30
  │ ^^^ only with kind = "perspective"
  │
  = keys here: `kind`, `position`, `target`, `up`, `height`, `turntable`, `views`

1 problem in scene.toml
"#,
    );
}

#[test]
fn an_order_for_single_scattering() {
    fails(
        &[(r#""emission-absorption""#, "\"single-scattering\"\nmax_order = 8")],
        &[],
        r#"
error: `method.max_order` does not go with kind = "single-scattering"
   ┌─ scene.toml:11:1
   │
11 │ max_order = 8
   │ ^^^^^^^^^ only with kind = "multiple-scattering"
   │
   = keys here: `kind`, `transmittance`, `majorant_scale`, `paths`

1 problem in scene.toml
"#,
    );
}

#[test]
fn a_phase_function_without_its_name() {
    fails(
        &[("[method]", "[phase]\ng = 0.9\n[method]")],
        &[],
        r#"
error: `phase.g` does not go with kind = "isotropic"
   ┌─ scene.toml:10:1
   │
10 │ g = 0.9
   │ ^ only with kind = "henyey-greenstein" or "two-lobe"
   │
   = keys here: `kind`

1 problem in scene.toml
"#,
    );
}

#[test]
fn window_of_two_minds() {
    fails(
        &[("[medium]", "window = { lo = 0, width = 5 }\n[medium]")],
        &[],
        r#"
error: missing key `hi` in `volume.window`
  ┌─ scene.toml:7:10
  │
7 │ window = { lo = 0, width = 5 }
  │          ^^^^^^^^^^^^^^^^^^^^^ needs `hi`
  │
  = `hi`: The data value that maps to 1; more than `lo`.

error: unknown key `width` in `volume.window`
  ┌─ scene.toml:7:20
  │
7 │ window = { lo = 0, width = 5 }
  │                    ^^^^^ no such key
  │
  = keys here: `lo`, `hi`

2 problems in scene.toml
"#,
    );
}

#[test]
fn several_syntax_errors() {
    fails(
        &[("sigma_max = 40.0", "sigma_max = \nmode ! 3"), ("dims = [8, 8, 8]", "dims = [8, 8")],
        &[],
        r#"
error: not valid TOML: missing comma between array elements, expected `,`
  ┌─ scene.toml:7:1
  │
7 │ [medium]
  │ ^

error: not valid TOML: unclosed array, expected `]`
   ┌─ scene.toml:11:29
   │
11 │ kind = "emission-absorption"
   │                             ^

2 problems in scene.toml
"#,
    );
}

#[test]
fn duplicate_key() {
    fails(
        &[("sigma_max = 40.0", "sigma_max = 40.0\nsigma_max = 4")],
        &[],
        r#"
error: not valid TOML: duplicate key
  ┌─ scene.toml:9:1
  │
9 │ sigma_max = 4
  │ ^^^^^^^^^

1 problem in scene.toml
"#,
    );
}

#[test]
fn several_problems_at_once_sorted() {
    fails(
        &[("sigma_max", "sigma_mx"), ("target = [0.5, 0.5, 0.5]", "up = 3"), ("emission-absorption", "mip")],
        &["image.width=wide"],
        r#"
error: missing key `target` in `camera`
  ┌─ scene.toml:1:1
  │
1 │ [camera]
  │ ^^^^^^^^ needs `target`
  │
  = `target`: The point in the middle of the image, [x, y, z] in scene units; not `position`.

error: `camera.up` must be a list of 3 numbers
  ┌─ scene.toml:3:6
  │
3 │ up = 3
  │      ^ this is the whole number 3

error: unknown key `sigma_mx` in `medium`
  ┌─ scene.toml:8:1
  │
8 │ sigma_mx = 40.0
  │ ^^^^^^^^ did you mean `sigma_max`?
  │
  = keys here: `mode`, `sigma_max`, `albedo`, `extinction_color`

error: `image.width` must be a whole number
  ┌─ --set:1:13
  │
1 │ image.width=wide
  │             ^^^^ this is the text "wide"

4 problems in scene.toml
"#,
    );
}
