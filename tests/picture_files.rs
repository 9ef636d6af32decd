//! Pictures on disk through the public API: what one command writes, another reads and compares.

use std::path::Path;

use svetlo::{
    metrics::{compare, write_difference},
    picture::{Curve, Environment, Picture, Tonemap, check_writable, read_picture, write_exr, write_png},
};

/// A colour gradient with values from 0 to 1, away from the cut of the display range.
fn gradient(width: usize, height: usize) -> Picture {
    let values = |k: usize| (0..width * height).map(|i| (i * k % 251) as f32 / 250.0).collect();
    Picture::new(width, height)
        .with_channel("R", values(1))
        .with_channel("G", values(7))
        .with_channel("B", values(13))
}

#[test]
fn exr_and_png_of_one_picture_agree_to_the_quantisation() {
    let folder = tempfile::tempdir().unwrap();
    // The names are swapped on purpose: the content decides the format.
    let (exr, png) = (folder.path().join("a.png"), folder.path().join("a.exr"));
    let picture = gradient(64, 48);
    write_exr(&exr, &picture).unwrap();
    write_png(&png, &picture, &Tonemap::default()).unwrap();
    let result = compare(&read_picture(&png).unwrap(), &read_picture(&exr).unwrap()).unwrap();
    // Rounding to 255 steps is uniform in ±½ step: RMSE 1/(255·√12) in codes, hence 58.9 dB.
    let expected = 10.0 * (255.0_f64.powi(2) * 12.0).log10();
    assert!((result.psnr.display_db.unwrap() - expected).abs() < 0.5, "{:?}", result.psnr);
}

#[test]
fn a_failed_write_leaves_the_folder_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.exr");
    write_exr(&path, &gradient(8, 8)).unwrap();
    let before = std::fs::read(&path).unwrap();
    let mut broken = gradient(8, 8);
    broken.width = 9;
    assert_eq!(write_exr(&path, &broken).unwrap_err().exit_code(), 1);
    assert_eq!(std::fs::read(&path).unwrap(), before);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    assert_eq!(check_writable(&path.join("below.exr")).unwrap_err().exit_code(), 2);
}

#[test]
fn files_that_are_no_pictures_are_wrong_input() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    for content in ["", "abc", "[film]\nwidth = 3\n"] {
        std::fs::write(&path, content).unwrap();
        let error = read_picture(&path).unwrap_err();
        assert_eq!(error.exit_code(), 2);
        assert!(error.to_string().starts_with(&path.display().to_string()), "{error}");
    }
    assert_eq!(read_picture(&folder.path().join("none")).unwrap_err().exit_code(), 2);
    assert_eq!(read_picture(folder.path()).unwrap_err().exit_code(), 2);
}

#[test]
fn a_false_colour_difference_is_a_png_of_the_same_size() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.png");
    let scale = write_difference(&path, &gradient(20, 10), &gradient(20, 10)).unwrap();
    assert_eq!(scale, Some(0.0));
    let white = read_picture(&path).unwrap();
    assert!(white.colour().unwrap().iter().all(|plane| plane.data.iter().all(|&value| value == 1.0)));
}

#[test]
fn the_shipped_environment_map_is_whole() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/data/studio_512x256.exr");
    let map = Environment::read(&path).unwrap();
    assert_eq!((map.width, map.height, map.notes.as_slice()), (512, 256, &[][..]));
    let picture = read_picture(&path).unwrap();
    assert!(picture.metadata["comments"].contains("Greg Zaal, HDRI Haven, CC0"));
    let folder = tempfile::tempdir().unwrap();
    let preview = Tonemap { curve: Curve::Filmic, ..Tonemap::default() };
    write_png(&folder.path().join("studio.png"), &picture, &preview).unwrap();
}
