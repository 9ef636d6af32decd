//! Sides of surfaces: what is lit on one side is black on the other, however thin, curved or bent it is, and however wide
//! photons are gathered.

mod common;

use common::{close, device};
use std::fmt::Write;
use std::path::Path;
use svetlo::film::FilmPixel;
use svetlo::render::{BRICK_SHIFT, Plan, SceneData, Session};
use svetlo::scene::Scene;

const ACROSS: usize = 16;

/// A look from one place to another, through parallel rays of `height`; photons from a lamp through a rectangle, and those
/// that diffuse surfaces reflect once.
struct Lit<'a> {
    surface: &'a str,
    lamp: [f64; 3],
    target: &'a str,
    radius: f64,
}

impl Lit<'_> {
    fn seen(&self, from: [f64; 3], to: [f64; 3], height: f64) -> Vec<FilmPixel> {
        let Self { surface, lamp, target, radius } = self;
        let text = format!(
            "[image]\nwidth = {ACROSS}\nheight = {ACROSS}\nfilter = \"point\"\n\
             [camera]\nkind = \"orthographic\"\nposition = {from:?}\ntarget = {to:?}\nup = [0, 1, 0]\nheight = {height}\n\
             [[material]]\nname = \"white\"\nkind = \"diffuse\"\ncolor = 1\n\
             [[surface]]\nmaterial = \"white\"\n{surface}\n\
             [[light]]\nkind = \"point\"\nposition = {lamp:?}\nintensity = 1\n\
             [method]\nkind = \"caustics\"\nphotons = 20000\nradius = {radius}\nbounce_radius = {radius}\nbounces = 1\n\
             direct = \"photons\"\nemission = {{ target = {{ {target} }} }}\n"
        );
        let loaded = svetlo::config::parse("test.toml", &text, &[]).unwrap_or_else(|e| panic!("{e}\n{text}"));
        let scene = Scene::from_loaded(&loaded, Path::new("/")).unwrap_or_else(|e| panic!("{e}"));
        let data = SceneData::load(&scene).unwrap();
        let mut session = Session::new(device(), &Plan::new(&scene, &data, BRICK_SHIFT).unwrap()).unwrap();
        session.render(1).unwrap();
        session.film().unwrap()
    }
}

/// The pixels that are not black.
fn lit(film: &[FilmPixel]) -> usize {
    film.iter().filter(|pixel| pixel.mean()[..3] != [0.0; 3]).count()
}

/// A mesh as the text of a surface, from its corners and the corners of its triangles; the file stays as long as its folder is held.
fn mesh(corners: &[[f64; 3]], triangles: &[[usize; 3]]) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh.obj");
    let mut text = String::new();
    for [x, y, z] in corners {
        writeln!(text, "v {x} {y} {z}").unwrap();
    }
    for [a, b, c] in triangles {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    std::fs::write(&path, text).unwrap();
    (folder, format!("kind = \"mesh\"\npath = {path:?}\n"))
}

/// A sphere of radius 1, by meridians and parallels.
fn globe() -> (tempfile::TempDir, String) {
    const AROUND: usize = 48;
    const DOWN: usize = 24;
    let step = std::f64::consts::TAU / AROUND as f64;
    let mut corners = Vec::new();
    for row in 0..=DOWN {
        let (sin, cos) = (step * row as f64).sin_cos();
        corners
            .extend((0..AROUND).map(|k| (step * k as f64).sin_cos()).map(|(y, x)| [sin * x, sin * y, cos]));
    }
    let mut triangles = Vec::new();
    for row in 0..DOWN {
        for k in 0..AROUND {
            let [a, b] = [k, (k + 1) % AROUND].map(|k| row * AROUND + k);
            triangles.extend([[a, a + AROUND, b + AROUND], [a, b + AROUND, b]]);
        }
    }
    mesh(&corners, &triangles)
}

/// A cuboid around the origin, of triangles that face outward, or of which every other one faces inward.
fn cuboid(half: [f64; 3], mixed: bool) -> (tempfile::TempDir, String) {
    let corner = |i: usize| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { -half[axis] } else { half[axis] });
    let squares = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<[usize; 3]> = squares
        .into_iter()
        .flat_map(|[a, b, c, d]| [[a, b, c], if mixed { [d, c, a] } else { [a, c, d] }])
        .collect();
    mesh(&[0, 1, 2, 3, 4, 5, 6, 7].map(corner), &triangles)
}

const UP: &str = "centre = [0, 0, 0.3], edge_u = [1, 0, 0], edge_v = [0, 1, 0]";

#[test]
fn shells_that_are_lit_inside_are_black_outside() {
    let (_folder, globe) = globe();
    let ball = "kind = \"sphere\"\ncentre = [0, 0, 0]\nradius = 1\n";
    // The last one is more than the shell is wide.
    for (surface, radius) in [(&*globe, 0.4), (ball, 0.09), (ball, 3.0)] {
        let scene = Lit { surface, lamp: [0.1, 0.05, -0.3], target: UP, radius };
        let inside = lit(&scene.seen([0.0, 0.0, 0.5], [0.0, 0.0, 2.0], 0.8));
        let outside = lit(&scene.seen([0.0, 0.0, 5.0], [0.0, 0.0, 0.0], 2.2));
        assert_eq!((inside, outside), (ACROSS * ACROSS, 0), "{surface}{radius}");
    }
}

#[test]
fn thin_plates_are_black_below() {
    // A hundredth thick; the radius is thirty times that.
    for mixed in [false, true] {
        let (_folder, surface) = cuboid([1.0, 1.0, 0.005], mixed);
        let target = "centre = [0, 0, 0.5], edge_u = [0.9, 0, 0], edge_v = [0, 0.9, 0]";
        let scene = Lit { surface: &surface, lamp: [0.0, 0.0, 1.0], target, radius: 0.3 };
        assert_eq!(lit(&scene.seen([0.0, 0.0, -3.0], [0.0, 0.0, 0.0], 2.4)), 0, "mixed: {mixed}");
        let above = scene.seen([0.0, 0.0, 0.4], [0.0, 0.0, 0.0], 0.4);
        // However its triangles turn: I cos / (pi r^2), to the radius' bias of 3/40 0.09 12 and the noise of 900 photons.
        for pixel in above {
            close("above", std::f64::consts::PI * pixel.mean()[0], 1.0, 0.15);
        }
    }
}

#[test]
fn light_does_not_go_round_edges() {
    // The lamp shines from the left on the top of a cube; its right is in the shade.
    let (_folder, surface) = cuboid([1.0; 3], false);
    let target = "centre = [0, 0, 1.3], edge_u = [2, 0, 0], edge_v = [0, 2, 0]";
    let lamp = [-0.9, 0.0, 1.8];
    let scene = Lit { surface: &surface, lamp, target, radius: 0.5 };
    assert_eq!(lit(&scene.seen([4.0, 0.0, 0.0], [0.0, 0.0, 0.0], 2.2)), 0);
    assert!(lit(&scene.seen([0.0, 0.0, 4.0], [0.0, 0.0, 0.0], 2.2)) > 100);
}
