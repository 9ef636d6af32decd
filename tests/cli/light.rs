//! Light volumes on the command line: several views, and files of light.

use crate::support::Folder;
use serde_json::Value;
use svetlo::picture::Picture;

const SCENE: &str = r#"
[image]
width = 16
height = 12
[camera]
position = [0.5, 0.6, -2]
target = [0.5, 0.5, 0.5]
[volume]
field = { kind = "sphere" }
dims = [8, 9, 7]
spacing = 0.125
[medium]
sigma_max = 5
albedo = 0.9
[[light]]
kind = "directional"
direction = [1, -2, 1]
irradiance = [3, 2, 1]
[background]
color = 0.1
[method]
kind = "hybrid-diffusion"
iterations = 3
[stop]
samples = 2
"#;

const PAPER: &str = "method={kind=\"convection-diffusion\"}";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("lit.toml", SCENE);
    folder
}

fn rgb(picture: &Picture) -> Vec<Vec<f32>> {
    ["R", "G", "B"].map(|name| picture.channel(name).expect("a channel").to_f32().into_owned()).to_vec()
}

#[test]
fn views_are_numbered_and_look_as_each_would_alone() {
    let folder = folder();
    let views = "camera.views=[{}, {position = [3, 0.5, 0.5]}]";
    for method in ["method.iterations=3", PAPER, "method={kind=\"multiple-scattering\"}"] {
        let ran =
            folder.succeed(&["render", "lit.toml", "-o", "v.exr", "--json", "--set", views, "--set", method]);
        let report: Value = serde_json::from_str(&ran.out).unwrap();
        assert_eq!(report["views"].as_array().unwrap().len(), 2, "{}", ran.out);
        assert_eq!(report["views"][1]["output"], "v.0002.exr");
        assert!(folder.path("v.0002.png").exists() && !folder.path("v.exr").exists());
        let sets = ["--set", "camera.position=[3, 0.5, 0.5]", "--set", method];
        folder.succeed(&[&["render", "lit.toml", "-o", "alone.exr"], &sets[..]].concat());
        assert_eq!(rgb(&folder.image("v.0002.exr")), rgb(&folder.image("alone.exr")), "{method}");
        // The light was computed for the first view alone.
        let light = |view: usize| !report["views"][view]["light"].is_null();
        assert_eq!([light(0), light(1)], [!method.contains("multiple"), false], "{}", ran.out);
    }
}

#[test]
fn finished_views_are_left_and_the_others_are_rendered() {
    let folder = folder();
    let render = |samples: &str| {
        let sets = ["--set", "camera.turntable.frames=3", "--samples", samples, "--resume"];
        folder.succeed(&[&["render", "lit.toml", "-o", "v.exr"], &sets[..]].concat())
    };
    render("2");
    let before = std::fs::read(folder.path("v.0001.exr")).unwrap();
    std::fs::remove_file(folder.path("v.0003.exr")).unwrap();
    let ran = render("2");
    assert!(ran.out.contains("v.0001.exr is finished already"), "{}", ran.out);
    assert!(ran.out.contains("wrote v.0003.exr"), "{}", ran.out);
    assert_eq!(std::fs::read(folder.path("v.0001.exr")).unwrap(), before);
}

#[test]
fn light_is_written_read_and_refused_for_other_scenes() {
    let folder = folder();
    for phase in ["phase.kind=isotropic", "phase={kind=\"henyey-greenstein\",g=0.6}"] {
        let scene = ["--set", phase];
        let render = |rest: &[&str]| folder.succeed(&[&["render", "lit.toml"], &scene[..], rest].concat());
        render(&["-o", "a.exr", "--save-light", "light.nrrd"]);
        render(&["-o", "b.exr", "--load-light", "light.nrrd"]);
        assert_eq!(rgb(&folder.image("a.exr")), rgb(&folder.image("b.exr")), "{phase}");
        let elsewhere = ["--set", "camera.position=[3, 0.5, 0.5]", "--set", "image.width=20"];
        render(&[&["-o", "c.exr", "--load-light", "light.nrrd"], &elsewhere[..]].concat());
        let other = ["--set", "medium.sigma_max=6", "--load-light", "light.nrrd"];
        let ran = folder.run(&[&["render", "lit.toml", "-o", "d.exr"], &scene[..], &other[..]].concat());
        ran.fails_with(2, "was computed for another scene");
        assert!(!folder.path("d.exr").exists());
    }
}

#[test]
fn damaged_light_is_refused() {
    let folder = folder();
    folder.succeed(&["render", "lit.toml", "-o", "a.exr", "--save-light", "light.nrrd"]);
    let good = std::fs::read(folder.path("light.nrrd")).unwrap();
    let header = good.windows(2).position(|pair| pair == b"\n\n").unwrap() + 2;
    let edit = |old: &str, new: &str| {
        let text = String::from_utf8(good[..header].to_vec()).unwrap();
        assert!(text.contains(old), "{text}");
        [text.replace(old, new).as_bytes(), &good[header..]].concat()
    };
    let mut infinite = good.clone();
    infinite[header..header + 4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    let mut dark = good.clone();
    dark[header..header + 4].copy_from_slice(&(-1.0_f32).to_le_bytes());
    let mut other = good.clone();
    other[header..header + 4].copy_from_slice(&1.0_f32.to_le_bytes());
    let cases = [
        (good[..good.len() - 1].to_vec(), "expected 12096 bytes"),
        ([&good[..], &[0]].concat(), "found 12097"),
        (infinite, "not finite"),
        (dark, "which is below 0"),
        (other, "svetlo.content_hash"),
        (edit("svetlo.components:=fluence direct", "svetlo.components:=direct fluence"), "`direct fluence`"),
        (edit("space directions: none (0.125,0,0)", "space directions: none (0.25,0,0)"), "elsewhere"),
        (edit("space origin: (", "space origin: (1"), "elsewhere"),
        (edit("sizes: 6 8 9 7", "sizes: 6 9 8 7"), "9×8×7"),
        (edit("sizes: 6 8 9 7", "sizes: 3 16 9 7"), "has 3 numbers"),
        (edit("dimension: 4\nsizes: 6 8 9 7", "dimension: 3\nsizes: 48 9 7"), "four sizes"),
        (edit("type: float", "type: double"), "must be `float`"),
        (edit("svetlo:=light volume 1", "svetlo:=light volume 2"), "light volume 1"),
        (edit("svetlo.data_hash:=", "svetlo.data_hash:=0"), "from other data"),
        (b"nothing".to_vec(), "does not begin with NRRD"),
    ];
    for (bytes, problem) in cases {
        folder.write("bad.nrrd", bytes);
        let ran = folder.run(&["render", "lit.toml", "-o", "b.exr", "--load-light", "bad.nrrd"]);
        ran.fails_with(2, problem);
        assert!(ran.err.contains("bad.nrrd"), "{}", ran.err);
    }
    folder
        .run(&["render", "lit.toml", "--load-light", "none.nrrd"])
        .fails_with(2, "none.nrrd: there is no such file");
}

#[test]
fn a_single_cell_is_lit_as_others_and_kept() {
    let folder = folder();
    let render = |rest: &[&str]| {
        folder.succeed(&[&["render", "lit.toml", "--set", "volume.dims=[1,1,1]"], rest].concat())
    };
    render(&["-o", "a.exr", "--save-light", "light.nrrd"]);
    render(&["-o", "b.exr", "--load-light", "light.nrrd"]);
    assert_eq!(rgb(&folder.image("a.exr")), rgb(&folder.image("b.exr")));
    render(&["-o", "dark.exr", "--set", "light=[]", "--set", "background.color=0"]);
    assert_ne!(rgb(&folder.image("a.exr")), rgb(&folder.image("dark.exr")));
}

#[test]
fn a_render_goes_on_with_the_light_that_it_began_with() {
    let folder = folder();
    fn render<'a>(rest: &[&'a str]) -> Vec<&'a str> {
        [&["render", "lit.toml", "-o", "a.exr"], rest].concat()
    }
    folder.succeed(&render(&["--samples", "1", "--save-light", "own.nrrd"]));
    // Light of the same scene that another program has altered, and signed.
    let own = std::fs::read(folder.path("own.nrrd")).unwrap();
    folder.write("other.nrrd", own.clone());
    folder.succeed(&render(&["--samples", "2", "--resume", "--load-light", "other.nrrd"]));
    let ran = folder.run(&render(&["--samples", "3", "--resume"]));
    ran.fails_with(2, "begun with the light volume of a file");
    let header = own.windows(2).position(|pair| pair == b"\n\n").unwrap() + 2;
    let mut altered = own.clone();
    altered[header..header + 4].copy_from_slice(&1.0_f32.to_le_bytes());
    folder.write("altered.nrrd", &altered[..]);
    let refused = folder.run(&render(&["--samples", "3", "--resume", "--load-light", "altered.nrrd"]));
    let found = refused.err.split("of its numbers it is ").nth(1).expect("a hash")[..32].to_owned();
    let text = String::from_utf8(altered[..header].to_vec()).unwrap();
    let kept = text.split("svetlo.content_hash:=").nth(1).unwrap()[..32].to_owned();
    folder.write("altered.nrrd", [text.replace(&kept, &found).as_bytes(), &altered[header..]].concat());
    let ran = folder.run(&render(&["--samples", "3", "--resume", "--load-light", "altered.nrrd"]));
    ran.fails_with(2, "begun with another light volume");
}

#[test]
fn finished_renders_still_save_their_light() {
    let folder = folder();
    folder.succeed(&["render", "lit.toml", "-o", "a.exr"]);
    let ran =
        folder.succeed(&["render", "lit.toml", "-o", "a.exr", "--resume", "--save-light", "light.nrrd"]);
    assert!(ran.out.contains("is finished already"), "{}", ran.out);
    folder.succeed(&["render", "lit.toml", "-o", "b.exr", "--load-light", "light.nrrd"]);
    assert_eq!(rgb(&folder.image("a.exr")), rgb(&folder.image("b.exr")));
}

#[test]
fn programs_and_people_are_told_what_is_wrong_with_the_light() {
    let folder = folder();
    // A rectangle in the volume; cells of 1.25 mean free paths in a vacuum.
    let light = "light=[{kind=\"rectangle\",centre=[0.5,0.5,0.44],edge_u=[1,0,0],edge_v=[0,1,0],radiance=1}]";
    let hard = [
        "--set",
        light,
        "--set",
        "medium.sigma_max=10",
        "--set",
        "method.iterations=32",
        "--set",
        "volume.window={lo=0,hi=0.2}",
    ];
    let render =
        |more: &[&str]| folder.succeed(&[&["render", "lit.toml", "-o", "a.exr"], &hard[..], more].concat());
    let [noisy, thick] = ["the direct light of the cells is off by", "1.25 mean free paths thick"];
    let ran = render(&["--json"]);
    let report: Value = serde_json::from_str(&ran.out).unwrap();
    let notes = report["notes"].to_string();
    for text in [noisy, thick] {
        assert!(notes.contains(text) && ran.err.contains(text), "{notes} {}", ran.err);
    }
    let facts = &report["light"]["channels"][0];
    assert!(
        facts["floor_cells"].as_u64() > Some(0) && facts["largest_flux"].as_f64() <= Some(1.0),
        "{facts}"
    );
    assert_eq!(render(&["--json", "--quiet"]).err, "");
    let ran = render(&[]);
    assert!(ran.err.contains("of the cells are thinner than `method.steady.floor` = 0.01"), "{}", ran.err);
    let ran = folder.succeed(&[&["check", "lit.toml"], &hard[..]].concat());
    assert!(ran.out.contains(thick), "{}", ran.out);
}

#[test]
fn light_files_go_with_methods_that_have_light() {
    let folder = folder();
    for option in ["--save-light", "--load-light"] {
        let ran = folder.run(&["render", "scene.toml", option, "light.nrrd"]);
        ran.fails_with(2, "hybrid-diffusion or convection-diffusion");
    }
    folder.run(&["render", "lit.toml", "--save-light", "light.exr"]).fails_with(2, ".nrrd");
    let none = folder.run(&["render", "lit.toml", "--save-light", "no/light.nrrd"]);
    none.fails_with(2, "no/light.nrrd");
}

#[test]
fn what_the_model_cannot_do_is_refused() {
    let folder = folder();
    let paper = "{kind=\"convection-diffusion\"";
    let cases = [
        (format!("method={paper},courant=0.9}}"), "at most 0.61"),
        (format!("method={paper},spreading=0.2}}"), "at most 0.1666"),
        (format!("method={paper},steady={{}}}}"), "needs `method.model = \"steady\"`"),
        (format!("method={paper},model=\"steady\",iterations=3}}"), "needs `method.model = \"paper\"`"),
        ("method.direct_coarsening=2".into(), "must not exceed `method.coarsening`"),
        ("method.steady.floor=1e-7".into(), "`method.steady.floor`"),
        ("method.steady.limiter_tolerance=1e-6".into(), "`method.steady.limiter_tolerance`"),
        (
            "camera={position=[0,0,-2],target=[0,0,0],turntable={frames=2},views=[{}]}".into(),
            "give one of the two",
        ),
        ("camera.views=[{target=[0.5,0.6,-2]}]".into(), "`camera.views.0.target` must differ"),
    ];
    for (set, problem) in cases {
        folder.run(&["render", "lit.toml", "--set", &set]).fails_with(2, problem);
    }
    let rectangle = format!(
        "{SCENE}[[light]]\nkind = \"rectangle\"\ncentre = [0, 2, 0]\nedge_u = [1, 0, 0]\n\
                             edge_v = [0, 0, 1]\nradiance = 1\n"
    );
    folder.write("rectangle.toml", rectangle);
    let ran = folder.run(&["render", "rectangle.toml", "--set", PAPER]);
    ran.fails_with(2, "`light.1` is a rectangle");
    let ran = folder.succeed(&["render", "lit.toml", "--set", PAPER]);
    assert!(ran.err.contains("the background is seen, but lights nothing"), "{}", ran.err);
}
