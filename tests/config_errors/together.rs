//! What is valid key by key but wrong together.

use super::fails;

#[test]
fn position_is_target() {
    fails(
        &[("-2.0", "0.5")],
        &[],
        r#"
error: `camera.target` must differ from `camera.position`
  ┌─ scene.toml:3:10
  │
3 │ target = [0.5, 0.5, 0.5]
  │          ^^^^^^^^^^^^^^^ no view direction

1 problem in scene.toml
"#,
    );
}

#[test]
fn up_along_the_view() {
    fails(
        &[("[volume]", "up = [0, 0, 3]\n[volume]")],
        &[],
        r#"
error: `camera.up` must not be parallel to the view
  ┌─ scene.toml:4:6
  │
4 │ up = [0, 0, 3]
  │      ^^^^^^^^^ the view goes along this direction

1 problem in scene.toml
"#,
    );
}

#[test]
fn image_too_large() {
    fails(
        &[("[medium]", "[image]\nwidth = 65536\nheight = 4097\n[medium]")],
        &[],
        r#"
error: the image is too large: 65536 × 4097 pixels
  ┌─ scene.toml:8:9
  │
8 │ width = 65536
  │         ^^^^^ width × height must be at most 268435456

1 problem in scene.toml
"#,
    );
}

#[test]
fn window_upside_down() {
    fails(
        &[("[medium]", "window = { lo = 5, hi = 5 }\n[medium]")],
        &[],
        r#"
error: `hi` must be more than `lo` in `volume.window`
  ┌─ scene.toml:7:25
  │
7 │ window = { lo = 5, hi = 5 }
  │                         ^ the window starts at 5

1 problem in scene.toml
"#,
    );
}

#[test]
fn file_and_field() {
    fails(
        &[("dims", "file = \"a.nrrd\"\ndims")],
        &[],
        r#"
error: `volume.field` does not go with `volume.file`
  ┌─ scene.toml:5:1
  │
5 │ field = { kind = "cloud" }
  │ ^^^^^ give one of the two

1 problem in scene.toml
"#,
    );
}

#[test]
fn neither_file_nor_field() {
    fails(
        &[("field = { kind = \"cloud\" }\n", "")],
        &[],
        r#"
error: the volume needs `file` or `field`
  ┌─ scene.toml:4:1
  │
4 │ [volume]
  │ ^^^^^^^^ neither is given

1 problem in scene.toml
"#,
    );
}

#[test]
fn field_without_dims() {
    fails(
        &[("dims = [8, 8, 8]\n", "")],
        &[],
        r#"
error: a procedural field needs `volume.dims`
  ┌─ scene.toml:5:9
  │
5 │ field = { kind = "cloud" }
  │         ^^^^^^^^^^^^^^^^^^ sampled at how many voxels?

1 problem in scene.toml
"#,
    );
}

#[test]
fn missing_file() {
    fails(
        &[(r#"field = { kind = "cloud" }"#, r#"file = "no.nrrd""#)],
        &[],
        r#"
error: there is no file "no.nrrd"
  ┌─ scene.toml:5:8
  │
5 │ file = "no.nrrd"
  │        ^^^^^^^^^ looked for data/no.nrrd

error: `volume.dims` is for raw files only
  ┌─ scene.toml:6:1
  │
6 │ dims = [8, 8, 8]
  │ ^^^^ the header of this file says it

2 problems in scene.toml
"#,
    );
}

#[test]
fn missing_sigma_max() {
    fails(
        &[("sigma_max = 40.0\n", "")],
        &[],
        r#"
error: emission-absorption needs `medium.sigma_max`
  ┌─ scene.toml:7:1
  │
7 │ [medium]
  │ ^^^^^^^^ how much does opacity 1 absorb?
  │
  = give `sigma_max`, the extinction at opacity 1 per scene unit, or `mode = "opacity"` in [medium]

1 problem in scene.toml
"#,
    );
}

#[test]
fn missing_medium() {
    fails(
        &[("[medium]\nsigma_max = 40.0\n", "")],
        &[],
        r#"
error: emission-absorption needs `medium.sigma_max`
  ┌─ scene.toml:8:8
  │
8 │ kind = "emission-absorption"
  │        ^^^^^^^^^^^^^^^^^^^^^ how much does opacity 1 absorb?
  │
  = give `sigma_max`, the extinction at opacity 1 per scene unit, or `mode = "opacity"` in [medium]

1 problem in scene.toml
"#,
    );
}

#[test]
fn scattering_without_sigma_max() {
    fails(
        &[("sigma_max = 40.0\n", ""), ("emission-absorption", "multiple-scattering")],
        &[],
        r#"
error: multiple-scattering needs `medium.sigma_max`
  ┌─ scene.toml:7:1
  │
7 │ [medium]
  │ ^^^^^^^^ how dense is opacity 1?
  │
  = give `sigma_max`, the extinction at opacity 1 per scene unit, or `mode = "opacity"` in [medium]

1 problem in scene.toml
"#,
    );
}

#[test]
fn black_extinction() {
    fails(
        &[("sigma_max = 40.0", "sigma_max = 40.0\nextinction_color = 0")],
        &[],
        r#"
error: `medium.extinction_color` must not be black
  ┌─ scene.toml:9:20
  │
9 │ extinction_color = 0
  │                    ^ no channel would see the medium

1 problem in scene.toml
"#,
    );
}

#[test]
fn points_out_of_order() {
    fails(
        &[(
            "[method]",
            "[transfer]\npoints = [\n  { value = 0.5, opacity = 0 },\n  { value = 0.5, opacity = 1 },\n]\n[method]",
        )],
        &[],
        r#"
error: the points of a transfer function must be sorted by value, without equal values
   ┌─ scene.toml:12:13
   │
12 │   { value = 0.5, opacity = 1 },
   │             ^^^ must be more than 0.5, the value before it

1 problem in scene.toml
"#,
    );
}

#[test]
fn data_units_in_the_window() {
    fails(
        &[("[method]", "[transfer]\npoints = [{ value = 300, opacity = 0 }]\n[method]")],
        &[],
        r#"
error: `transfer.points.0.value` is outside the window
   ┌─ scene.toml:10:21
   │
10 │ points = [{ value = 300, opacity = 0 }]
   │                     ^^^ must be at least 0 and at most 1
   │
   = for values in data units, set `transfer.domain` to "data"

1 problem in scene.toml
"#,
    );
}

#[test]
fn step_without_steps() {
    fails(
        &[(r#""emission-absorption""#, "\"emission-absorption\"\nstep = 0.5\njitter = false")],
        &[],
        r#"
error: `method.step` needs `method.quadrature = "step"`
   ┌─ scene.toml:11:1
   │
11 │ step = 0.5
   │ ^^^^ the quadrature per cell has no steps

error: `method.jitter` needs `method.quadrature = "step"`
   ┌─ scene.toml:12:1
   │
12 │ jitter = false
   │ ^^^^^^ the quadrature per cell has no steps

2 problems in scene.toml
"#,
    );
}

#[test]
fn quantum_numbers() {
    fails(
        &[(r#""cloud""#, r#""hydrogen", n = 3, l = 3"#)],
        &[],
        r#"
error: `l` must be less than `n`
  ┌─ scene.toml:5:41
  │
5 │ field = { kind = "hydrogen", n = 3, l = 3 }
  │                                         ^ n is 3

1 problem in scene.toml
"#,
    );
}

#[test]
fn table_and_shapes() {
    fails(
        &[("[method]", "[transfer]\nkind = \"2d\"\n[method]")],
        &[],
        r#"
error: a two-dimensional transfer function needs `table` or `shapes`
   ┌─ scene.toml:10:8
   │
10 │ kind = "2d"
   │        ^^^^ neither is given

1 problem in scene.toml
"#,
    );
}

#[test]
fn mip_color_and_colormap() {
    fails(
        &[(r#""emission-absorption""#, "\"mip\"\ncolor = 1\ncolormap = \"hot\"")],
        &[],
        r#"
error: `method.color` does not go with `method.colormap`
   ┌─ scene.toml:11:1
   │
11 │ color = 1
   │ ^^^^^ give one of the two

1 problem in scene.toml
"#,
    );
}

#[test]
fn environment_keys_without_environment() {
    fails(
        &[("[method]", "[background]\nrotation = 3\n[method]")],
        &[],
        r#"
error: `background.rotation` needs `background.environment`
   ┌─ scene.toml:10:1
   │
10 │ rotation = 3
   │ ^^^^^^^^ there is no environment map to apply it to

1 problem in scene.toml
"#,
    );
}

#[test]
fn sampling_without_environment() {
    fails(
        &[("[method]", "[background]\ncolor = 1\nsampling = \"escape\"\n[method]")],
        &[],
        r#"
error: `background.sampling` needs `background.environment`
   ┌─ scene.toml:11:1
   │
11 │ sampling = "escape"
   │ ^^^^^^^^ there is no environment map to apply it to

1 problem in scene.toml
"#,
    );
}

#[test]
fn auxiliary_channels_of_a_method_without_any() {
    fails(
        &[],
        &["film.auxiliary=true"],
        r#"
error: `film.auxiliary` needs a scattering method
  ┌─ --set:1:16
  │
1 │ film.auxiliary=true
  │                ^^^^ this method makes no such channels

1 problem in scene.toml
"#,
    );
}

/// A rectangle light with these edges, before `[method]`.
fn rectangle(edge_u: &str, edge_v: &str) -> String {
    format!(
        "[[light]]\nkind = \"rectangle\"\ncentre = [0, 2, 0]\nedge_u = {edge_u}\nedge_v = {edge_v}\nradiance = 1\n[method]"
    )
}

#[test]
fn rectangle_without_area() {
    fails(
        &[("[method]", &rectangle("[1, 0, 3]", "[-0.5, 0, -1.5]"))],
        &[],
        r#"
error: `light.0.edge_v` must not be parallel to `light.0.edge_u`
   ┌─ scene.toml:13:10
   │
13 │ edge_v = [-0.5, 0, -1.5]
   │          ^^^^^^^^^^^^^^^ they span no rectangle

1 problem in scene.toml
"#,
    );
}

#[test]
fn rectangle_without_an_edge() {
    fails(
        &[("[method]", &rectangle("[0, 0, 0]", "[1, 0, 0]"))],
        &[],
        r#"
error: `light.0.edge_u` must not be zero
   ┌─ scene.toml:12:10
   │
12 │ edge_u = [0, 0, 0]
   │          ^^^^^^^^^ no direction

1 problem in scene.toml
"#,
    );
}

#[test]
fn rectangle_for_an_isosurface() {
    fails(
        &[
            ("[method]", &rectangle("[1, 0, 0]", "[0, 0, 1]")),
            (r#""emission-absorption""#, "\"isosurface\"\nvalue = 0.5"),
        ],
        &[],
        r#"
error: isosurface takes point and directional lights
   ┌─ scene.toml:10:8
   │
10 │ kind = "rectangle"
   │        ^^^^^^^^^^^ a rectangle is for scattering methods

1 problem in scene.toml
"#,
    );
}

#[test]
fn light_without_direction() {
    fails(
        &[("[method]", "[[light]]\nkind = \"directional\"\ndirection = [0, 0, 0]\nirradiance = 1\n[method]")],
        &[],
        r#"
error: `light.0.direction` must not be zero
   ┌─ scene.toml:11:13
   │
11 │ direction = [0, 0, 0]
   │             ^^^^^^^^^ no direction

1 problem in scene.toml
"#,
    );
}

#[test]
fn semantic_problems_at_once() {
    fails(
        &[("-2.0", "0.5"), ("[medium]", "window = { lo = 5, hi = 4 }\n[medium]")],
        &["image.width=65536", "image.height=65536"],
        r#"
error: `camera.target` must differ from `camera.position`
  ┌─ scene.toml:3:10
  │
3 │ target = [0.5, 0.5, 0.5]
  │          ^^^^^^^^^^^^^^^ no view direction

error: `hi` must be more than `lo` in `volume.window`
  ┌─ scene.toml:7:25
  │
7 │ window = { lo = 5, hi = 4 }
  │                         ^ the window starts at 5

error: the image is too large: 65536 × 65536 pixels
  ┌─ --set:1:13
  │
1 │ image.width=65536
  │             ^^^^^ width × height must be at most 268435456

3 problems in scene.toml
"#,
    );
}

#[test]
fn surfaces_without_caustics() {
    fails(
        &[(
            "[method]",
            "[[material]]\nname = \"chalk\"\nkind = \"diffuse\"\ncolor = 0.8\n\
             [[surface]]\nkind = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\nmaterial = \"chalk\"\n[method]",
        )],
        &[],
        r#"
error: `[[surface]]` needs `method.kind = "caustics"`
   ┌─ scene.toml:13:1
   │
13 │ [[surface]]
   │ ^^^^^^^^^^^ only caustics renders surfaces

1 problem in scene.toml
"#,
    );
}
