//! The cloud in light, once and many times scattered, against pictures of two other renderers.

mod common;

use common::Case;
use common::scattering::{Measured, all_finite, blocks, chi_square, family, of_film};
use serde_json::Value;
use svetlo::film::FilmPixel;
use svetlo::volume::{Volume, field};

const SIDE: usize = 256;

/// The scene of the bench in light, without its volume.
fn scene(method: &str) -> String {
    let text = include_str!("../benches/scenes/cloud.toml");
    let volume = |line: &&str| line.starts_with("field =") || line.starts_with("dims =");
    let text = text.lines().filter(|line| !volume(line)).collect::<Vec<_>>().join("\n");
    let text = text.replace("kind = \"emission-absorption\"", &format!("kind = \"{method}\""));
    let text = text.replace("filter = \"point\"", "filter = \"box\"");
    let text = text.replace("color = 0.0 }", "color = 0.9 }").replace("color=0.0 }", "color = 0.9 }");
    format!("{text}\n[[light]]\nkind = \"directional\"\ndirection = [-1, -1, -1]\nirradiance = 5\n")
}

fn cloud() -> Volume {
    let mut volume = field::sample(&field::Cloud, [128; 3]).unwrap();
    volume.spacing /= 128.0;
    volume
}

/// A mean and its standard error as the file has them.
fn number(entry: &Value) -> Measured {
    Measured { value: entry[0].as_f64().unwrap(), error: entry[1].as_f64().unwrap() }
}

/// The picture's mean and the means of 16 blocks are the others', within 4σ each and in their sum of squares.
fn compare(method: &str, film: &[FilmPixel]) {
    let reference: Value = serde_json::from_str(include_str!("data/cloud_scattering.json")).unwrap();
    let reference = &reference[method];
    all_finite(film);
    assert!(family(17) < 4.0);
    let mut squares = 0.0;
    let blocks: Vec<Vec<usize>> = blocks(SIDE, 4);
    let parts = blocks.iter().map(|block| block.iter().map(|&i| &film[i]).collect::<Vec<_>>());
    for (index, (part, exact)) in parts.zip(reference["blocks"].as_array().unwrap()).enumerate() {
        let (found, exact) = (of_film(part, 1), number(exact));
        // Beside the cloud a path in 10⁵ scatters; pixels without any have no variance, so the errors there say little.
        let rare = if exact.error < 1e-5 { 1e-5 } else { 0.0 };
        let z = found.deviation(exact, rare);
        println!("{method}, block {index}: {found:?} against {exact:?}: {z:.2} σ");
        assert!(z < 4.0, "{method}, block {index}: {found:?} against {exact:?}: {z:.2} σ");
        squares += z * z;
    }
    let (found, exact) = (of_film(film, 1), number(&reference["mean"]));
    let z = found.deviation(exact, 0.0);
    println!(
        "{method}: {found:?} against {exact:?}: {z:.2} σ; χ² {squares:.1} of {:.1}",
        chi_square(16.0, 4.0)
    );
    assert!(z < 4.0, "{method}: {found:?} against {exact:?}: {z:.2} σ");
    assert!(squares < chi_square(16.0, 4.0), "{method}: χ² {squares}");
    // Light of one channel is that of all: the cloud is white.
    assert!(
        film.iter().all(|pixel| pixel.mean()[0] == pixel.mean()[1] && pixel.mean()[1] == pixel.mean()[2])
    );
}

#[test]
fn single_and_multiple_scattering_look_as_the_peers_see_them() {
    for method in ["single-scattering", "multiple-scattering"] {
        compare(method, &Case::new(&scene(method), cloud()).film_of(64));
    }
}

/// As exact as the references: `cargo test --release --test render_scattering_cloud -- --ignored`.
#[test]
#[ignore = "minutes"]
fn many_samples_still_look_as_the_peers_see_them() {
    for method in ["single-scattering", "multiple-scattering"] {
        compare(method, &Case::new(&scene(method), cloud()).film_of(4096));
    }
}
