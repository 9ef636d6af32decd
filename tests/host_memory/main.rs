//! What a render allocates on the host: the volume once, the film, and little besides.

#[path = "../hostile/allocations.rs"]
mod allocations;

use allocations::measured;
use std::path::Path;
use std::time::Duration;
use svetlo::device::{Catalog, Device};
use svetlo::film::FilmPixel;
use svetlo::picture::{Picture, write_exr};
use svetlo::render::{Auxiliary, BRICK_SHIFT, Plan, SceneData, Session, Snapshot, data_hash};
use svetlo::scene::Scene;

const SIDE: usize = 192;
const IMAGE: usize = 256;

/// Methods, with auxiliary images where they make any.
const METHODS: [&str; 7] = [
    "[method]\nkind = \"mip\"",
    "[method]\nkind = \"isosurface\"\nvalue = 0.5",
    "[method]\nkind = \"emission-absorption\"",
    "[method]\nkind = \"single-scattering\"\n[film]\nauxiliary = true",
    "[method]\nkind = \"multiple-scattering\"\n[film]\nauxiliary = true",
    "[method]\nkind = \"hybrid-diffusion\"\niterations = 1\ncoarsening = 8\ndirect_coarsening = 8",
    "[method]\nkind = \"convection-diffusion\"\niterations = 2\ncoarsening = 8",
];

fn scene_text(method: &str, kind: &str) -> String {
    format!(
        "[image]\nwidth = {IMAGE}\nheight = {IMAGE}\n[camera]\nposition = [600, 350, -700]\ntarget = [96, 96, 96]\n\
         [volume]\nfile = \"data.raw\"\ndims = [{SIDE}, {SIDE}, {SIDE}]\ntype = \"{kind}\"\n\
         window = {{ lo = 0, hi = 255 }}\n[medium]\nsigma_max = 0.01\n\
         [[light]]\nkind = \"directional\"\ndirection = [1, -1, 1]\nirradiance = 1\n{method}\n[stop]\nsamples = 1\n"
    )
}

/// Renders as `svetlo render` does, and gives the picture that it wrote.
fn render(folder: &Path, text: &str) -> Picture {
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
    snapshot.picture
}

/// Bytes of what makes a picture: the film, the auxiliary images, and the planes that are written of them.
fn picture_bytes(picture: &Picture, has_auxiliary: bool) -> usize {
    let planes: usize = picture.channels.iter().map(|channel| 4 * channel.data.len()).sum();
    let auxiliary = if has_auxiliary { size_of::<Auxiliary>() } else { 0 };
    planes + picture.width * picture.height * (size_of::<FilmPixel>() + auxiliary)
}

/// Tables of the scene, ranges of bricks, blocks of the image that are packed, and a slab of the volume at a time.
const BESIDES: usize = 6 << 20;

#[test]
fn a_render_holds_the_volume_once() {
    let folder = tempfile::tempdir().unwrap();
    let count = SIDE * SIDE * SIDE;
    let byte = |i: usize| (i.wrapping_mul(2_654_435_761) >> 24) as u8;
    // Floats are changed on their way to the device, integers are not.
    for (kind, bytes, methods) in [("uint16", 2, &METHODS[..1]), ("float32", 4, &METHODS)] {
        let data: Vec<u8> = match bytes {
            2 => (0..count).flat_map(|i| u16::from(byte(i)).to_le_bytes()).collect(),
            _ => (0..count).flat_map(|i| f32::from(byte(i)).to_le_bytes()).collect(),
        };
        std::fs::write(folder.path().join("data.raw"), data).unwrap();
        for method in methods {
            let text = scene_text(method, kind);
            let (picture, allocated) = measured(|| render(folder.path(), &text));
            let allowed = count * bytes + picture_bytes(&picture, method.contains("auxiliary")) + BESIDES;
            assert!(allocated.most <= allowed, "{kind}, {method}: {allocated:?}, allowed {allowed}");
            // More than it may hold besides: a second volume would show.
            assert!(count * bytes > 2 * BESIDES);
        }
    }
}
