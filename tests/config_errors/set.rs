//! Overrides from the command line.

use super::fails;

#[test]
fn without_equals() {
    fails(
        &[],
        &["image.width"],
        r#"
error: an override needs a value
  ┌─ --set:1:1
  │
1 │ image.width
  │ ^^^^^^^^^^^ no `=` in here
  │
  = write it as --set key.path=value, for example --set image.width=256

1 problem in scene.toml
"#,
    );
}

#[test]
fn with_an_empty_part() {
    fails(
        &[],
        &["image..width=3"],
        r#"
error: the path of this override has an empty part
  ┌─ --set:1:7
  │
1 │ image..width=3
  │       ^ a key is missing here

1 problem in scene.toml
"#,
    );
}

#[test]
fn unknown_key() {
    fails(
        &[],
        &["medium.sigma_mx=3"],
        r#"
error: unknown key `sigma_mx` in `medium`
  ┌─ --set:1:8
  │
1 │ medium.sigma_mx=3
  │        ^^^^^^^^ did you mean `sigma_max`?
  │
  = keys here: `mode`, `sigma_max`, `albedo`, `extinction_color`

1 problem in scene.toml
"#,
    );
}

#[test]
fn wrong_type() {
    fails(
        &[],
        &["image.width = wide"],
        r#"
error: `image.width` must be a whole number
  ┌─ --set:1:15
  │
1 │ image.width = wide
  │               ^^^^ this is the text "wide"

1 problem in scene.toml
"#,
    );
}

#[test]
fn through_a_number() {
    fails(
        &[],
        &["medium.sigma_max.x=3"],
        r#"
error: `medium.sigma_max` has no keys inside
  ┌─ --set:1:18
  │
1 │ medium.sigma_max.x=3
  │                  ^ `medium.sigma_max` is the decimal number 40.0

1 problem in scene.toml
"#,
    );
}

#[test]
fn index_out_of_range() {
    fails(
        &[("[method]", "[transfer]\npoints = [{ value = 0, opacity = 1 }]\n[method]")],
        &["transfer.points.1.opacity=0.5"],
        r#"
error: `transfer.points` has no entry 1
  ┌─ --set:1:17
  │
1 │ transfer.points.1.opacity=0.5
  │                 ^ the only entry is 0

1 problem in scene.toml
"#,
    );
}

#[test]
fn index_that_is_none() {
    fails(
        &[("[method]", "[transfer]\npoints = [{ value = 0, opacity = 1 }]\n[method]")],
        &["transfer.points.first.opacity=0.5"],
        r#"
error: `transfer.points` is a list, and "first" is not the number of an entry
  ┌─ --set:1:17
  │
1 │ transfer.points.first.opacity=0.5
  │                 ^^^^^ the only entry is 0

1 problem in scene.toml
"#,
    );
}

#[test]
fn into_a_missing_list() {
    fails(
        &[],
        &["light.0.intensity=5"],
        r#"
error: `light` has no entry 0
  ┌─ --set:1:7
  │
1 │ light.0.intensity=5
  │       ^ there is no such list to change

1 problem in scene.toml
"#,
    );
}

#[test]
fn too_deep() {
    fails(
        &[],
        &["a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a=5"],
        r#"
error: the path of this override is too deep
  ┌─ --set:1:1
  │
1 │ a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a=5
  │ ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ at most 16 keys

1 problem in scene.toml
"#,
    );
}
