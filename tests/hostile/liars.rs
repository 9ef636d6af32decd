//! Headers that promise what the file does not have: each is refused, and allocates no more than the file justifies.

use crate::allocated_for;
use crate::allocations::measured;
use crate::corpus::{gzip, nifti_header};
use std::path::Path;
use svetlo::picture::{Picture, read_picture, write_exr, write_png_rgb8};
use svetlo::volume::{Components, Endian, RawOptions, StoredType, read};
use tempfile::TempDir;

/// Writes a file, has it read, and holds the error and the allocations against what they should be.
#[track_caller]
fn refused<T>(name: &str, bytes: &[u8], needle: &str, read: impl FnOnce(&Path) -> Result<T, String>) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    let (result, allocated) = measured(|| read(&path).err());
    let error = result.unwrap_or_else(|| panic!("{name}: it was read"));
    assert!(error.contains(needle), "{name}: no {needle:?} in {error}");
    let allowed = allocated_for(bytes.len());
    // While a vector grows, it is there twice.
    let within = allocated.largest <= allowed && allocated.most <= 2 * allowed;
    assert!(within, "{name}: {allocated:?} for {} bytes", bytes.len());
}

fn volume(path: &Path) -> Result<(), String> {
    read(path, &RawOptions::default()).map(drop).map_err(|error| error.to_string())
}

fn picture(path: &Path) -> Result<(), String> {
    read_picture(path).map(drop).map_err(|error| error.to_string())
}

/// Sizes whose product is 10^18 voxels, which memory can address and no file has.
const HUGE: &str = "1000000 1000000 1000000";

fn nrrd(sizes: &str, encoding: &str, data: &[u8]) -> Vec<u8> {
    let header = format!(
        "NRRD0005\ntype: float\ndimension: 3\nsizes: {sizes}\nendian: little\nencoding: {encoding}\n\n"
    );
    [header.as_bytes(), data].concat()
}

/// Half a gibibyte of zeros in half a mebibyte.
fn bomb() -> Vec<u8> {
    use std::io::Write;
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    let zeros = vec![0; 1 << 20];
    (0..256).for_each(|_| encoder.write_all(&zeros).unwrap());
    encoder.finish().unwrap()
}

#[test]
fn volumes_that_promise_too_much() {
    let short = [7; 200];
    refused("a.nrrd", &nrrd(HUGE, "raw", &short), "found 200", volume);
    refused("a.nrrd", &nrrd(HUGE, "ascii", &short), "room for at most", volume);
    refused("a.nrrd", &nrrd(HUGE, "gzip", &gzip(&short)), "found 200", volume);
    let meta = |more: &str, data: &[u8]| {
        let header =
            format!("NDims = 3\nDimSize = {HUGE}\nElementType = MET_DOUBLE\n{more}ElementDataFile = LOCAL\n");
        [header.as_bytes(), data].concat()
    };
    refused("a.mha", &meta("", &short), "found 200", volume);
    refused("a.mha", &meta("BinaryData = False\n", &short), "room for at most", volume);
    refused("a.mha", &meta("CompressedData = True\n", &gzip(&short)), "", volume);
    let mut nifti = nifti_header(StoredType::F64, Endian::Little, b"n+1\0");
    for axis in 0..3 {
        nifti[42 + 2 * axis..44 + 2 * axis].copy_from_slice(&30_000_u16.to_le_bytes());
    }
    let nifti = [&nifti[..], &short].concat();
    refused("a.nii", &nifti, "found 200", volume);
    refused("a.nii.gz", &gzip(&nifti), "found 200", volume);
    refused("a_1000000x1000000x1000000_uint8.raw", &short, "found 200", volume);
    refused("a_1000000x1000000x1000000_uint8.raw.gz", &gzip(&short), "found 200", volume);
}

#[test]
fn light_volumes_that_promise_too_much() {
    let header = "NRRD0005\ntype: float\ndimension: 4\nsizes: 6 100000 100000 1000000\nendian: little\n\
                  encoding: raw\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\n\n12345678";
    let read = |path: &Path| Components::read(path).map(drop).map_err(|error| error.to_string());
    refused("a.nrrd", header.as_bytes(), "found 8", read);
}

/// A stream that yields a part of what the header says, however much that is, is not kept.
#[test]
fn compressed_streams_that_fall_short() {
    let bomb = bomb();
    let found = (256 << 20).to_string();
    refused("a.nrrd", &nrrd("1000 1000 70", "gzip", &bomb), &found, volume);
    refused("a_8192x8192x8192_uint8.raw.gz", &bomb, &found, volume);
    // What comes before the voxels is not kept either.
    let skipping = nrrd("8 8 8", &format!("gzip\nbyte skip: {}", 1_u64 << 40), &bomb);
    refused("a.nrrd", &skipping, "found 0", volume);
}

#[test]
fn pictures_that_promise_too_much() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.exr");
    // Noise, so that the file is long enough for a larger picture to be believed at first.
    let plane: Vec<f32> = (0..512 * 512).map(|i| (i as f32 * 12.9898).sin()).collect();
    write_exr(&path, &Picture::new(512, 512).with_channel("Y", plane)).unwrap();
    let whole = std::fs::read(&path).unwrap();
    let at = |name: &str| {
        let place = whole.windows(name.len()).position(|window| window == name.as_bytes()).unwrap();
        // Behind the name: the type `box2i`, the size 16, the low corner.
        place + name.len() + 1 + "box2i".len() + 1 + 4 + 8
    };
    for (width, height) in [(8192, 16_383), (512, 200_000), (1 << 20, 128), (i32::MAX, i32::MAX)] {
        let mut lying = whole.clone();
        for place in [at("dataWindow"), at("displayWindow")] {
            lying[place..place + 4].copy_from_slice(&(width - 1_i32).to_le_bytes());
            lying[place + 4..place + 8].copy_from_slice(&(height - 1_i32).to_le_bytes());
        }
        refused("a.exr", &lying, "", picture);
    }
    let path = folder.path().join("a.png");
    write_png_rgb8(&path, 16, 16, &[9; 768]).unwrap();
    let mut lying = std::fs::read(&path).unwrap();
    // IHDR: width and height behind the signature, a length and a name; its checksum behind 13 bytes.
    lying[16..20].copy_from_slice(&12_000_u32.to_be_bytes());
    lying[20..24].copy_from_slice(&12_000_u32.to_be_bytes());
    let checksum = crc32fast::hash(&lying[12..29]);
    lying[29..33].copy_from_slice(&checksum.to_be_bytes());
    refused("a.png", &lying, "fewer than its header claims", picture);
    // One colour is packed a thousandfold, and is all there. What this allocates is counted apart.
    measured(|| {
        write_png_rgb8(&path, 4000, 3000, &vec![9; 36_000_000]).unwrap();
        assert!(std::fs::metadata(&path).unwrap().len() < 1 << 20);
        picture(&path).unwrap();
    });
}

#[test]
fn meshes_that_promise_too_much() {
    use svetlo::scene::{Surface, SurfaceMaterial, SurfaceShape};
    let mesh = |path: &Path| {
        let shape =
            SurfaceShape::Mesh { path: path.into(), scale: 1.0, translate: glam::DVec3::ZERO, smooth: false };
        let mirror = SurfaceMaterial::Mirror { color: [1.0; 3] };
        svetlo::surfaces::load(&[Surface { shape, material: 0 }], &[mirror])
            .map(drop)
            .map_err(|e| e.to_string())
    };
    let ply = |format: &str, vertices: &str, data: &[u8]| {
        let header = format!(
            "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uint int vertex_indices\nend_header\n"
        );
        [header.as_bytes(), data].concat()
    };
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        refused("a.ply", &ply(format, "4000000000", &[b'1'; 200]), "its header promises 4000000000", mesh);
    }
    // A list of 2^32 - 1 corners.
    let list = [&[0; 36][..], &[0xff; 4], &[0; 12]].concat();
    refused("a.ply", &ply("binary_little_endian", "3", &list), "a.ply", mesh);
    refused("a.ply", &ply("ascii", "1", b"0 0 0\n4294967295 0 0 0\n"), "a.ply", mesh);
    refused("a.obj", b"v 0 0 0\nf 1 2147483647 4294967296\n", "line 2", mesh);
}

/// Scenes have no header, but may be long, deep, or one long line.
#[test]
fn scenes_out_of_proportion() {
    let texts = [
        format!("a = {}1{}", "[".repeat(100_000), "]".repeat(100_000)),
        format!("a = {}", "{ b = ".repeat(100_000)),
        format!("{}z = 1", "a.".repeat(100_000)),
        format!("[{}z]", "a.".repeat(100_000)),
        (0..20_000).map(|i| format!("a{i} = {i}\n")).collect(),
        format!("a = [{}]", "[1, 2, 3], ".repeat(50_000)),
        format!("[image]\nwidth = {}", "9".repeat(500_000)),
        format!("{} = 1", "k".repeat(500_000)),
        "[[light]]\n".repeat(50_000),
        "\"".repeat(500_000),
    ];
    for text in texts {
        let start = std::time::Instant::now();
        let (error, allocated) =
            measured(|| svetlo::config::parse("s.toml", &text, &[]).unwrap_err().to_string());
        let shown: String = text.chars().take(20).collect();
        assert!(start.elapsed() < crate::HANGS, "{shown}: {:?}", start.elapsed());
        assert!(allocated.largest <= allocated_for(text.len()), "{shown}: {allocated:?}");
        assert!(error.len() < 100_000, "{shown}: an error of {} bytes", error.len());
    }
    // By --set, the same depth.
    let set = format!("{}z=1", "a.".repeat(100_000));
    assert!(svetlo::config::parse("s.toml", "", &[set]).is_err());
    // Thousands of fields, each of which is looked for among the others.
    let fields: String = (0..60_000).map(|i| format!("a{i}: {i}\n")).collect();
    let start = std::time::Instant::now();
    refused("a.nrrd", format!("NRRD0005\n{fields}\n").as_bytes(), "has no `dimension`", volume);
    assert!(start.elapsed() < crate::HANGS, "{:?}", start.elapsed());
}
