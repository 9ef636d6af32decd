//! Values of the wrong type, out of range, or no known word.

use super::fails;

#[test]
fn a_word_of_the_wrong_type() {
    fails(
        &[("dims = [8, 8, 8]", r#"dims = "8x8x8""#)],
        &[],
        r#"
error: `volume.dims` must be a list of 3 whole numbers
  ┌─ scene.toml:6:8
  │
6 │ dims = "8x8x8"
  │        ^^^^^^^ this is the text "8x8x8"

1 problem in scene.toml
"#,
    );
}

#[test]
fn a_decimal_number_for_a_whole_one() {
    fails(
        &[("[medium]", "[image]\nwidth = 640.0\n[medium]")],
        &[],
        r#"
error: `image.width` must be a whole number
  ┌─ scene.toml:8:9
  │
8 │ width = 640.0
  │         ^^^^^ this is the decimal number 640.0
  │
  = write it without a decimal point: 640

1 problem in scene.toml
"#,
    );
}

#[test]
fn text_for_a_number() {
    fails(
        &[("sigma_max = 40.0", r#"sigma_max = "40""#)],
        &[],
        r#"
error: `medium.sigma_max` must be a number
  ┌─ scene.toml:8:13
  │
8 │ sigma_max = "40"
  │             ^^^^ this is the text "40"

1 problem in scene.toml
"#,
    );
}

#[test]
fn wrong_number_of_coordinates() {
    fails(
        &[("[0.5, 0.5, 0.5]", "[0.5, 0.5]")],
        &[],
        r#"
error: `camera.target` must be a list of 3 numbers
  ┌─ scene.toml:3:10
  │
3 │ target = [0.5, 0.5]
  │          ^^^^^^^^^^ this is a list of 2 entries

1 problem in scene.toml
"#,
    );
}

#[test]
fn a_wrong_coordinate() {
    fails(
        &[("[0.5, 0.5, 0.5]", r#"[0.5, "a", 0.5]"#)],
        &[],
        r#"
error: `camera.target.1` must be a number
  ┌─ scene.toml:3:16
  │
3 │ target = [0.5, "a", 0.5]
  │                ^^^ this is the text "a"

1 problem in scene.toml
"#,
    );
}

#[test]
fn out_of_range() {
    fails(
        &[("[volume]", "fov = 200\n[volume]")],
        &[],
        r#"
error: `camera.fov` is out of range
  ┌─ scene.toml:4:7
  │
4 │ fov = 200
  │       ^^^ must be more than 0 and less than 180

1 problem in scene.toml
"#,
    );
}

#[test]
fn not_finite() {
    fails(
        &[("40.0", "inf")],
        &[],
        r#"
error: `medium.sigma_max` must be a finite number
  ┌─ scene.toml:8:13
  │
8 │ sigma_max = inf
  │             ^^^ this is infinite

1 problem in scene.toml
"#,
    );
}

#[test]
fn number_too_large() {
    fails(
        &[("[camera]", "seed = 99999999999999999999\n[camera]")],
        &[],
        r#"
error: this whole number is too large
  ┌─ scene.toml:1:8
  │
1 │ seed = 99999999999999999999
  │        ^^^^^^^^^^^^^^^^^^^^ does not fit into 64 bits

1 problem in scene.toml
"#,
    );
}

#[test]
fn unknown_word_with_a_suggestion() {
    fails(
        &[("emission-absorption", "emision-absorption")],
        &[],
        r#"
error: `method.kind` cannot be "emision-absorption"
   ┌─ scene.toml:10:8
   │
10 │ kind = "emision-absorption"
   │        ^^^^^^^^^^^^^^^^^^^^ did you mean "emission-absorption"?
   │
   = allowed: "emission-absorption", "mip", "isosurface", "single-scattering", "multiple-scattering", "convection-diffusion", "hybrid-diffusion" or "caustics"

1 problem in scene.toml
"#,
    );
}

#[test]
fn unknown_word_without_a_suggestion() {
    fails(
        &[("emission-absorption", "photons")],
        &[],
        r#"
error: `method.kind` cannot be "photons"
   ┌─ scene.toml:10:8
   │
10 │ kind = "photons"
   │        ^^^^^^^^^ unknown word
   │
   = allowed: "emission-absorption", "mip", "isosurface", "single-scattering", "multiple-scattering", "convection-diffusion", "hybrid-diffusion" or "caustics"

1 problem in scene.toml
"#,
    );
}

#[test]
fn colour() {
    fails(
        &[("[method]", "[background]\ncolor = \"#12345\"\n[method]")],
        &[],
        r##"
error: `background.color` must be a colour like "#ff8000"
   ┌─ scene.toml:10:9
   │
10 │ color = "#12345"
   │         ^^^^^^^^ a colour is written "#rrggbb" with six hexadecimal digits

1 problem in scene.toml
"##,
    );
}

#[test]
fn colour_of_the_wrong_type() {
    fails(
        &[("[method]", "[background]\ncolor = true\n[method]")],
        &[],
        r##"
error: `background.color` must be a number, a list of 3 numbers or a colour like "#ff8000"
   ┌─ scene.toml:10:9
   │
10 │ color = true
   │         ^^^^ this is true

1 problem in scene.toml
"##,
    );
}

#[test]
fn colour_out_of_range() {
    fails(
        &[("[method]", "[transfer]\npoints = [{ value = 0, opacity = 1.5, color = [1, 2, 0] }]\n[method]")],
        &[],
        r#"
error: `transfer.points.0.opacity` is out of range
   ┌─ scene.toml:10:34
   │
10 │ points = [{ value = 0, opacity = 1.5, color = [1, 2, 0] }]
   │                                  ^^^ must be at least 0 and at most 1

error: `transfer.points.0.color.1` is out of range
   ┌─ scene.toml:10:51
   │
10 │ points = [{ value = 0, opacity = 1.5, color = [1, 2, 0] }]
   │                                                   ^ must be at least 0 and at most 1

2 problems in scene.toml
"#,
    );
}

#[test]
fn scattering_out_of_range() {
    fails(
        &[
            ("sigma_max = 40.0", "sigma_max = 40.0\nalbedo = 1.1\nextinction_color = [1, 1, -1]"),
            (
                r#""emission-absorption""#,
                "\"multiple-scattering\"\nmax_order = 0\nmajorant_scale = 0.5\npaths = 65",
            ),
        ],
        &["phase={kind = \"henyey-greenstein\", g = 1}"],
        r#"
error: `medium.albedo` is out of range
  ┌─ scene.toml:9:10
  │
9 │ albedo = 1.1
  │          ^^^ must be at least 0 and at most 1

error: `medium.extinction_color.2` is out of range
   ┌─ scene.toml:10:27
   │
10 │ extinction_color = [1, 1, -1]
   │                           ^^ must be at least 0

error: `method.max_order` is out of range
   ┌─ scene.toml:13:13
   │
13 │ max_order = 0
   │             ^ must be at least 1 and at most 1000000

error: `method.majorant_scale` is out of range
   ┌─ scene.toml:14:18
   │
14 │ majorant_scale = 0.5
   │                  ^^^ must be at least 1 and at most 64

error: `method.paths` is out of range
   ┌─ scene.toml:15:9
   │
15 │ paths = 65
   │         ^^ must be at least 1 and at most 64

error: `phase.g` is out of range
  ┌─ --set:1:40
  │
1 │ phase={kind = "henyey-greenstein", g = 1}
  │                                        ^ must be at least -0.999 and at most 0.999

6 problems in scene.toml
"#,
    );
}

#[test]
fn lobes_that_are_not_two() {
    fails(
        &[("[method]", "[phase]\nkind = \"two-lobe\"\ng = [0.9, 0.5, 0.1]\nweight = 0.5\n[method]")],
        &[],
        r#"
error: `phase.g` must be a list of 2 numbers
   ┌─ scene.toml:11:5
   │
11 │ g = [0.9, 0.5, 0.1]
   │     ^^^^^^^^^^^^^^^ this is a list of 3 entries

1 problem in scene.toml
"#,
    );
}

#[test]
fn lobes_out_of_range() {
    fails(
        &[("[method]", "[phase]\nkind = \"two-lobe\"\ng = [0.9, -1]\nweight = 2\n[method]")],
        &[],
        r#"
error: `phase.g.1` is out of range
   ┌─ scene.toml:11:11
   │
11 │ g = [0.9, -1]
   │           ^^ must be at least -0.999 and at most 0.999

error: `phase.weight` is out of range
   ┌─ scene.toml:12:10
   │
12 │ weight = 2
   │          ^ must be at least 0 and at most 1

2 problems in scene.toml
"#,
    );
}

#[test]
fn an_unknown_transmittance() {
    fails(
        &[(r#""emission-absorption""#, "\"single-scattering\"\ntransmittance = \"residual\"")],
        &[],
        r#"
error: `method.transmittance` cannot be "residual"
   ┌─ scene.toml:11:17
   │
11 │ transmittance = "residual"
   │                 ^^^^^^^^^^ unknown word
   │
   = allowed: "auto", "analog", "ratio", "residual-ratio" or "ray-marching"

1 problem in scene.toml
"#,
    );
}

#[test]
fn time() {
    fails(
        &[("[method]", "[stop]\ntime = \"30\"\nerror = \"0%\"\n[method]")],
        &[],
        r#"
error: `stop.time` must be a time like "30s"
   ┌─ scene.toml:10:8
   │
10 │ time = "30"
   │        ^^^^ a time is written with its unit: "500ms", "30s", "2m" or "1h"

error: `stop.error` must be a percentage like "1%"
   ┌─ scene.toml:11:9
   │
11 │ error = "0%"
   │         ^^^^ a percentage must be more than 0

2 problems in scene.toml
"#,
    );
}

#[test]
fn empty_list() {
    fails(
        &[("[method]", "[transfer]\npoints = []\n[method]")],
        &[],
        r#"
error: `transfer.points` has too few entries
   ┌─ scene.toml:10:10
   │
10 │ points = []
   │          ^^ this is an empty list

1 problem in scene.toml
"#,
    );
}

#[test]
fn a_table_where_a_list_belongs() {
    fails(
        &[("[method]", "[light]\nkind = \"point\"\n[method]")],
        &[],
        r#"
error: `light` must be a list of tables
  ┌─ scene.toml:9:1
  │
9 │ [light]
  │ ^^^^^^^ this is a table

1 problem in scene.toml
"#,
    );
}
