//! Caustics from the command line: what cannot be is refused, what is odd is rendered, and runs go on where they stopped.

use crate::support::Folder;
use svetlo::picture::Picture;

/// A glass sphere over a plane.
const SCENE: &str = r#"
[image]
width = 24
height = 16
[camera]
position = [0, -4, 2]
target = [0, 0, 0.4]
up = [0, 0, 1]
[[material]]
name = "white"
kind = "diffuse"
color = 1
[[material]]
name = "glass"
kind = "dielectric"
ior = 1.5
[[material]]
name = "silver"
kind = "mirror"
[[surface]]
kind = "plane"
point = [0, 0, 0]
normal = [0, 0, 1]
material = "white"
[[surface]]
kind = "sphere"
centre = [0, 0, 0.6]
radius = 0.5
material = "glass"
[[light]]
kind = "point"
position = [1, -1, 3]
intensity = 5
[method]
kind = "caustics"
photons = 4096
radius = 0.1
[stop]
samples = 2
"#;

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("scene.toml", SCENE);
    folder
}

/// The scene with overrides, rendered without a word.
fn picture(folder: &Folder, sets: &[&str]) -> Picture {
    let sets = sets.iter().flat_map(|set| ["--set", set]);
    let arguments: Vec<&str> =
        ["render", "scene.toml", "-o", "a.exr", "--quiet"].into_iter().chain(sets).collect();
    folder.succeed(&arguments);
    folder.image("a.exr")
}

/// The mean of a channel, all of whose values are finite and none negative.
fn mean(picture: &Picture, channel: &str) -> f64 {
    let values = picture.channel(channel).unwrap().to_f32().into_owned();
    assert!(values.iter().all(|value| value.is_finite() && *value >= 0.0), "{values:?}");
    values.iter().map(|&value| f64::from(value)).sum::<f64>() / values.len() as f64
}

#[test]
fn too_many_photons_are_refused_with_both_numbers() {
    let folder = folder();
    let before = folder.names();
    let ran = folder.run(&["render", "scene.toml", "--quiet", "--set", "method.photons=500000000"]);
    ran.fails_with(1, "the photons would take 14.9 GiB, but the device's ");
    assert!(ran.err.contains("fewer photons"), "{}", ran.err);
    assert_eq!(folder.names(), before);
    let ran = folder.succeed(&["check", "scene.toml", "--set", "method.photons=500000000"]);
    assert!(ran.out.contains("14.9 GiB") && ran.out.contains("would take"), "{}", ran.out);
    // No device could number so many.
    for command in [&["render", "--quiet"][..], &["check"]] {
        let ran = folder.run(&[command, &["scene.toml", "--set", "method.photons=2000000000"]].concat());
        ran.fails_with(2, "`method.photons` = 2000000000 is too large");
    }
    assert_eq!(folder.names(), before);
}

#[test]
fn light_between_diffuse_surfaces_has_a_radius_of_its_own() {
    let folder = folder();
    let check = |sets: &[&str]| {
        let sets = sets.iter().flat_map(|set| ["--set", set]);
        folder.succeed(&["check", "scene.toml"].into_iter().chain(sets).collect::<Vec<_>>()).out
    };
    let says = |sets: &[&str], radius: &str| {
        let text = check(sets);
        let note = format!("photons that diffuse surfaces reflect are gathered within {radius} scene units");
        assert!(text.contains(&note) && text.contains("BOUNCED"), "{sets:?}: {text}");
    };
    // The sphere is 1 wide; the camera is 4.3 from its target.
    says(&[], "0.200000");
    says(&["method.radius=0.01"], "0.160000");
    says(&["method.radius=0.001"], "0.080000");
    says(&["method.radius=0.5"], "0.500000");
    says(&["camera.target=[0, -3.5, 1.75]"], "0.111803");
    says(&["method.bounce_radius=0.03"], "0.030000");
    let without = check(&["method.bounces=0", "method.bounce_radius=0.03"]);
    assert!(!without.contains("BOUNCED") && !without.contains("reflect are gathered"), "{without}");
    let refused = folder.run(&["check", "scene.toml", "--set", "method.bounce_radius=0"]);
    refused.fails_with(2, "must be more than 0");
}

#[test]
fn odd_scenes_are_rendered() {
    let folder = folder();
    let usual = mean(&picture(&folder, &[]), "R");
    let dark = |sets: &[&str]| assert_eq!(mean(&picture(&folder, sets), "R"), 0.0, "{sets:?}");
    let lit = |sets: &[&str]| {
        let found = mean(&picture(&folder, sets), "R");
        assert!(found > 0.0, "{sets:?}");
        found
    };
    assert!(lit(&["method.photons=0"]) < usual);
    lit(&["method.photons=1", "method.bounces=0"]);
    assert!(lit(&["method.depth=1"]) < usual);
    // Spread over far more than is seen, and within less than float32 has of a unit.
    lit(&["method.radius=1000"]);
    lit(&["method.radius=1e-12"]);
    lit(&["method.bounce_radius=1000"]);
    lit(&["method.bounce_radius=1e-12"]);
    dark(&["light=[]"]);
    dark(&["surface.0.material=silver", "surface.1.material=silver"]);
    lit(&["surface.1.material=white"]);
    lit(&["surface.0.material=glass", "surface.1.material=white"]);
    // The camera in glass, and along the plane.
    lit(&["camera.position=[0,0,0.6]", "camera.target=[1,0.1,0.5]"]);
    lit(&["camera.position=[-3,0,0]", "camera.target=[0,0,0]"]);
    // A lamp in glass sends all that it has through it.
    lit(&["light.0.position=[0,0,0.6]", "method.direct=none", "method.bounces=0"]);
    lit(&["light.0.position=[0.1,0.1,0.6]", "method.direct=none"]);
    lit(&["light.0.position=[0,0,1e5]", "light.0.intensity=1e10"]);
}

#[test]
fn a_surface_of_water_without_bounds_lets_light_pass() {
    let folder = folder();
    let water = "surface.1={kind=\"plane\",point=[0,0,1],normal=[0,0,1],material=\"glass\"}";
    let through = mean(&picture(&folder, &[water, "method.bounces=0", "method.radius=0.3"]), "R");
    assert!(through > 0.0);
}

#[test]
fn a_lamp_on_a_ceiling_lights_the_room() {
    let folder = folder();
    let lamps = [
        "light=[{kind=\"point\",position=[1,-1,3.1],intensity=5}]",
        "light=[{kind=\"rectangle\",centre=[0.1,0.2,3.1],edge_u=[0,1.1,0],edge_v=[1,0,0],radiance=3}]",
    ];
    for lamp in lamps {
        // No caustics: a sphere of silver that is not there.
        let seen = |height: &str| {
            let ceiling = format!(
                "surface=[{{kind=\"plane\",point=[0,0,0],normal=[0,0,1],material=\"white\"}},\
                 {{kind=\"rectangle\",centre=[0.1,0.13,{height}],edge_u=[9,0,0],edge_v=[0,9.1,0],material=\"white\"}}]"
            );
            mean(
                &picture(
                    &folder,
                    &[lamp, &ceiling, "method.bounces=0", "image.filter=point", "camera.target=[0,-0.5,0]"],
                ),
                "R",
            )
        };
        // The camera looks at the floor alone; a ceiling that is higher shades nothing either.
        let (flush, free) = (seen("3.1"), seen("3.3"));
        assert!(free > 0.0 && (flush - free).abs() <= 1e-6 * free, "{lamp}: {flush} {free}");
    }
}

#[test]
fn light_by_photons_says_where_it_comes() {
    let folder = folder();
    let ran = folder.succeed(&["render", "scene.toml", "--set", "method.direct=photons"]);
    assert!(ran.err.contains("note: direct light by photons"), "{}", ran.err);
    let target = "method.emission.target={centre=[0,0,0],edge_u=[9,0,0],edge_v=[0,9,0]}";
    let ran = folder.succeed(&["render", "scene.toml", "--set", "method.direct=photons", "--set", target]);
    assert!(!ran.err.contains("direct light by photons"), "{}", ran.err);
}

#[test]
fn units_do_not_show() {
    // Powers of two: the same bits.
    let scaled = |unit: f64| {
        let v = |v: [f64; 3]| format!("{:?}", v.map(|x| x * unit));
        let number = |x: f64| format!("{x:e}");
        let text = SCENE
            .replace("[0, -4, 2]", &v([0.0, -4.0, 2.0]))
            .replace("[0, 0, 0.4]", &v([0.0, 0.0, 0.375]))
            .replace("[0, 0, 0.6]", &v([0.0, 0.0, 0.625]))
            .replace("radius = 0.5", &format!("radius = {}", number(0.5 * unit)))
            .replace("[1, -1, 3]", &v([1.0, -1.0, 3.0]))
            .replace("intensity = 5", &format!("intensity = {}", number(5.0 * unit * unit)))
            .replace("radius = 0.1", &format!("radius = {}", number(0.125 * unit)));
        let folder = folder();
        folder.write("scene.toml", text);
        folder.succeed(&["render", "scene.toml", "-o", "a.exr", "--quiet"]);
        folder.image("a.exr")
    };
    let red = |picture: &Picture| picture.channel("R").unwrap().to_f32().into_owned();
    let usual = scaled(1.0);
    for unit in [f64::powi(2.0, 20), f64::powi(2.0, -20)] {
        assert_eq!(red(&scaled(unit)), red(&usual), "{unit}");
    }
    for unit in [1e6, 1e-6] {
        let (found, expected) = (mean(&scaled(unit), "R"), mean(&usual, "R"));
        // Rounding may send one photon of 8192 elsewhere, or a few.
        assert!((found - expected).abs() < 1e-3 * expected, "{unit}: {found} {expected}");
    }
}

#[test]
fn meshes_that_are_not_there_or_damaged() {
    let folder = folder();
    let with = |path: &str| {
        let mesh = format!("surface.1={{kind=\"mesh\",path=\"{path}\",material=\"glass\"}}");
        folder.run(&["render", "scene.toml", "--quiet", "--set", &mesh])
    };
    with("none.ply").fails_with(2, "there is no file \"none.ply\"");
    folder.write("empty.obj", "");
    with("empty.obj").fails_with(2, "empty.obj");
    folder.write("far.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    with("far.obj").fails_with(2, "far.obj");
    folder.write("cut.ply", "ply\nformat binary_little_endian 1.0\nelement vertex 9\nproperty float x\n");
    with("cut.ply").fails_with(2, "cut.ply");
    folder.write("mesh.stl", "solid");
    with("mesh.stl").fails_with(2, "meshes end in .obj or .ply");
}

#[test]
fn sizes_beyond_float32_are_refused_before_anything_is_rendered() {
    let folder = folder();
    for (sets, needle) in [
        (
            &["method.radius=1e-30"][..],
            "`method.radius` = 1e-30 is out of range: it must be from 1e-13 to 1e13",
        ),
        (&["method.radius=1e300"], "`method.radius` = 1e300 is out of range"),
        (
            &["surface.1.radius=1e-30"],
            "`method.radius` = 1e-1 is out of range: it must be from 2e-43 to 2e-17",
        ),
        (&["surface.1.radius=1e30", "method.radius=1e29"], "the view is too small for the scene"),
    ] {
        let sets = sets.iter().flat_map(|set| ["--set", set]);
        let arguments: Vec<&str> = ["check", "scene.toml"].into_iter().chain(sets).collect();
        folder.run(&arguments).fails_with(2, needle);
    }
}

#[test]
fn a_render_that_was_stopped_goes_on() {
    let folder = folder();
    folder.succeed(&["render", "scene.toml", "-o", "whole.exr", "--quiet", "--samples", "5"]);
    folder.succeed(&["render", "scene.toml", "-o", "a.exr", "--quiet", "--samples", "2"]);
    folder.succeed(&["render", "scene.toml", "-o", "a.exr", "--quiet", "--samples", "5", "--resume"]);
    let (whole, resumed) = (folder.image("whole.exr"), folder.image("a.exr"));
    for channel in ["R", "G", "B", "A", "Z", "variance.R"] {
        let of = |picture: &Picture| picture.channel(channel).unwrap().to_f32().into_owned();
        assert_eq!(of(&whole), of(&resumed), "{channel}");
    }
    assert_eq!(whole.metadata["svetlo.state_hash"], resumed.metadata["svetlo.state_hash"]);
    folder.succeed(&["compare", "a.exr", "whole.exr", "--max-rmse", "0"]);
}

#[test]
fn a_turntable_has_photons_for_each_picture() {
    let folder = folder();
    let turntable = "camera.turntable={frames=2,angle=180,axis=[0,0,1]}";
    let ran = folder.succeed(&["render", "scene.toml", "-o", "a.exr", "--set", turntable]);
    assert!(ran.out.contains("a.0001.exr") && ran.out.contains("a.0002.exr"), "{}", ran.out);
    assert_eq!(ran.err.matches("photons: 8192 in 2 passes").count(), 2, "{}", ran.err);
    assert!(mean(&folder.image("a.0002.exr"), "R") > 0.0);
}

#[test]
fn what_is_for_volumes_is_refused() {
    let folder = folder();
    let light = ["render", "scene.toml", "--save-light", "light.nrrd"];
    folder.run(&light).fails_with(2, "this scene's is caustics");
    folder.run(&["ladder", "scene.toml"]).fails_with(2, "this scene's method is caustics");
}

#[test]
fn a_bench_measures_caustics() {
    let folder = folder();
    folder.write(
        "suite.toml",
        "# A suite.\ntitle = \"Caustics\"\nrepeats = 2\ncheckpoints = { samples = [1, 4] }\n[[case]]\nname = \"sphere\"\n\
         scene = \"scene.toml\"\nreference = { error = \"20%\", time = \"1s\" }\n",
    );
    let ran = folder.succeed(&["bench", "suite.toml", "--no-selftest"]);
    assert!(ran.out.contains("sphere"), "{}", ran.out);
    let results = std::fs::read_to_string(folder.path("suite.bench/results.json")).unwrap();
    assert!(results.contains("4096 photons a pass"), "{results}");
}
