//! Volume files that are wrong, and voxels that are not numbers.

use crate::support::Folder;
use flate2::{Compression, write::GzEncoder};
use std::io::Write;

/// A folder whose scene reads `file`.
fn folder_with(file: &str, content: &[u8], more: &str) -> Folder {
    let folder = Folder::new();
    folder.write(file, content);
    let volume = format!("[volume]\nfile = \"{file}\"\n{more}\n");
    let scene = format!(
        "{volume}[camera]\nposition = [4, 4, -20]\ntarget = [4, 4, 4]\n[image]\nwidth = 8\nheight = 8\n\
         [medium]\nsigma_max = 1\n[method]\nkind = \"emission-absorption\"\n[stop]\nsamples = 2\n"
    );
    folder.write("scene.toml", scene);
    folder
}

fn refused(file: &str, content: &[u8], more: &str, needle: &str) {
    let folder = folder_with(file, content, more);
    let before = folder.names();
    folder.run(&["render", "scene.toml"]).fails_with(2, needle);
    folder.run(&["check", "scene.toml"]).fails_with(2, needle);
    assert_eq!(folder.names(), before);
}

fn gzip(content: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(content).unwrap();
    encoder.finish().unwrap()
}

fn nrrd(sizes: &str, content: &[u8]) -> Vec<u8> {
    [format!("NRRD0004\ntype: uint8\ndimension: 3\nsizes: {sizes}\nencoding: raw\n\n").as_bytes(), content]
        .concat()
}

const RAW: &str = "dims = [8, 8, 8]\ntype = \"uint8\"";

#[test]
fn truncated_files_say_how_much_is_missing() {
    let missing = "expected 512 bytes of voxels (8x8x8 uint8), found ";
    refused("v.raw", &[0; 200], RAW, &format!("v.raw: {missing}200"));
    refused("v.raw", &[], RAW, &format!("v.raw: {missing}0"));
    refused("v.raw.gz", &gzip(&[7; 300]), RAW, &format!("v.raw.gz: {missing}300"));
    let whole = gzip(&(0..512_u32).map(|i| (i * i) as u8).collect::<Vec<_>>());
    refused("v.raw.gz", &whole[..whole.len() / 2], RAW, &format!("v.raw.gz: {missing}"));
    refused("v.nrrd", &nrrd("8 8 8", &[0; 100]), "", &format!("v.nrrd: {missing}100"));
    let header = "NDims = 3\nDimSize = 8 8 8\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n";
    refused("v.mha", &[header.as_bytes(), &[0; 10]].concat(), "", &format!("v.mha: {missing}10"));
    refused("v.nii", &[0; 100], "", "expected a header of 348 bytes, found 100");
    refused("v.nii.gz", &gzip(&[0; 100]), "", "v.nii.gz: ");
    refused("v.nrrd", b"NRRD0004\ntype: uint8\ndimen", "", "line 3 of its header");
}

#[test]
fn more_bytes_than_voxels_are_suspicious_without_a_header() {
    refused("v.raw", &[0; 600], RAW, "found 600 bytes; correct `dims`, `type` or `offset`");
}

#[test]
fn sizes_that_cannot_be() {
    refused("v.nrrd", &nrrd("8 0 8", &[0; 64]), "", "each extent must be at least 1");
    let huge = "4294967296 4294967296 4294967296";
    refused("v.nrrd", &nrrd(huge, &[0; 64]), "", "more than memory can address");
    refused("v.nrrd", &nrrd("65536 65536 65536", &[0; 64]), "", "found 64");
    refused("v.raw", &[0; 512], "dims = [8, 8, 0]\ntype = \"uint8\"", "at least 1");
}

#[test]
fn what_a_raw_file_leaves_open_is_asked_for() {
    refused("v.raw", &[0; 512], "", "give `dims = [W, H, D]` and `type`");
    refused("v.raw", &[0; 512], "dims = [8, 8, 8]", "give `type`");
    refused("v.nrrd", &nrrd("8 8 8", &[0; 512]), "dims = [8, 8, 8]", "`volume.dims` is for raw files only");
    refused("v.dat", &[0; 512], "", "not a volume format");
}

#[test]
fn volumes_that_are_no_files() {
    let folder = Folder::new();
    let sets = |file: &str| {
        ["render".into(), "scene.toml".into(), "--set".into(), format!("volume={{file=\"{file}\"}}")]
    };
    folder.run(&sets("none.nrrd")).fails_with(2, "there is no file \"none.nrrd\"");
    folder.run(&sets(".")).fails_with(2, "is a directory");
}

fn float32(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

const FLOATS: &str = "dims = [8, 8, 8]\ntype = \"float32\"";

#[test]
fn voxels_that_are_not_finite_are_counted_and_the_image_is() {
    let mut values: Vec<f32> = (0..512).map(|i| i as f32).collect();
    values[100..104].copy_from_slice(&[f32::NAN, f32::NAN, f32::INFINITY, f32::NEG_INFINITY]);
    let folder = folder_with("v.raw", &float32(&values), FLOATS);
    let ran = folder.succeed(&["render", "scene.toml"]);
    assert!(ran.err.contains("2 NaN and 2 infinite voxels"), "{}", ran.err);
    assert!(ran.err.contains("window 0 to 511"), "{}", ran.err);
    let image = folder.image("scene.exr");
    assert!(image.channel("R").unwrap().to_f32().iter().all(|value| value.is_finite()));
}

#[test]
fn a_volume_of_nan_alone_needs_a_window() {
    refused("v.raw", &float32(&[f32::NAN; 512]), FLOATS, "no finite voxel");
    let windowed = format!("{FLOATS}\nwindow = {{ lo = 0, hi = 1 }}");
    let folder = folder_with("v.raw", &float32(&[f32::NAN; 512]), &windowed);
    folder.succeed(&["render", "scene.toml"]);
}
