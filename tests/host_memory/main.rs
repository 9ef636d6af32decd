//! What a render allocates on the host: the volume once, the film, and little besides.

#[path = "../hostile/allocations.rs"]
mod allocations;

use allocations::measured;
use std::path::Path;
use std::time::Duration;
use svetlo::device::{Catalog, Device};
use svetlo::film::FilmPixel;
use svetlo::picture::write_exr;
use svetlo::render::{BRICK_SHIFT, Plan, SceneData, Session, Snapshot, data_hash};
use svetlo::scene::Scene;

const SIDE: usize = 192;
const IMAGE: usize = 256;

fn main_scene(method: &str, kind: &str) -> String {
    format!(
        "[image]\nwidth = {IMAGE}\nheight = {IMAGE}\n[camera]\nposition = [600, 350, -700]\ntarget = [96, 96, 96]\n\
         [volume]\nfile = \"data.raw\"\ndims = [{SIDE}, {SIDE}, {SIDE}]\ntype = \"{kind}\"\n\
         window = {{ lo = 0, hi = 255 }}\n[medium]\nsigma_max = 0.01\n\
         [[light]]\nkind = \"directional\"\ndirection = [1, -1, 1]\nirradiance = 1\n{method}\n[stop]\nsamples = 1\n"
    )
}

fn render(folder: &Path, text: &str) {
    let loaded = svetlo::config::parse("scene.toml", text, &[]).unwrap_or_else(|error| panic!("{error}"));
    let scene = Scene::from_loaded(&loaded, folder).unwrap_or_else(|error| panic!("{error}"));
    let data = SceneData::load(&scene).unwrap();
    let plan = Plan::new(&scene, &data, BRICK_SHIFT).unwrap();
    let hash = data_hash(&plan, &data).unwrap();
    let selector = std::env::var("SVETLO_DEVICE").ok();
    let device = Device::open(Catalog::enumerate().select(selector.as_deref()).unwrap()).unwrap();
    let mut session = Session::new(device, &plan).unwrap();
    session.render(1).unwrap();
    let snapshot = Snapshot::take(&session, &plan, &hash, Duration::ZERO).unwrap();
    write_exr(&folder.join("out.exr"), &snapshot.picture).unwrap();
}

#[test]
fn a_render_holds_the_volume_once() {
    let folder = tempfile::tempdir().unwrap();
    let count = SIDE * SIDE * SIDE;
    let film = IMAGE * IMAGE * size_of::<FilmPixel>();
    for (kind, bytes) in [("uint8", 1), ("float32", 4)] {
        let byte = |i: usize| (i.wrapping_mul(2_654_435_761) >> 24) as u8;
        let data: Vec<u8> = if bytes == 1 {
            (0..count).map(byte).collect()
        } else {
            (0..count).flat_map(|i| f32::from(byte(i)).to_ne_bytes()).collect()
        };
        std::fs::write(folder.path().join("data.raw"), data).unwrap();
        for method in [
            "[method]\nkind = \"mip\"",
            "[method]\nkind = \"isosurface\"\nvalue = 0.5",
            "[method]\nkind = \"emission-absorption\"",
            "[method]\nkind = \"single-scattering\"\n[film]\nauxiliary = true",
            "[method]\nkind = \"multiple-scattering\"\n[film]\nauxiliary = true",
            "[method]\nkind = \"hybrid-diffusion\"\niterations = 1\ncoarsening = 8\ndirect_coarsening = 8",
            "[method]\nkind = \"convection-diffusion\"\niterations = 2\ncoarsening = 8",
        ] {
            let text = main_scene(method, kind);
            let ((), allocated) = measured(|| render(folder.path(), &text));
            let volume = count * bytes;
            let beyond = (allocated.most as f64 - volume as f64 - film as f64) / f64::from(1 << 20);
            println!(
                "{kind} {method:?}: volume {volume}, film {film}, {allocated:?}, beyond {beyond:.1} MiB"
            );
        }
    }
}
