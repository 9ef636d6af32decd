//! Volume files of every supported kind read back; damaged ones are refused with a message, never with a panic.

mod corpus;
mod damaged;
mod fuzz;

use corpus::*;
use glam::DVec3;
use std::fs;
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;
use svetlo::volume::{Endian, RawOptions, StoredType, Volume, read};
use tempfile::TempDir;

fn assert_reads(volume: &Volume, kind: StoredType, name: &str) {
    assert_eq!(volume.dims, DIMS, "{name}");
    for i in 0..COUNT {
        let (x, y, z) = (i % 3, i / 3 % 4, i / 12);
        assert_eq!(volume.value(x, y, z), value(kind, i), "{name} {kind:?} {i}");
    }
    let last = value(kind, COUNT - 1);
    assert_eq!(volume.data_range(), Some((value(kind, 0), last)));
    let expected = if kind == StoredType::F64 { "float32" } else { kind.name() };
    assert_eq!(volume.voxel_type().name(), expected);
    assert_eq!(volume.memory_bytes() as usize, COUNT * volume.voxel_type().bytes());
}

#[test]
fn every_type_byte_order_and_encoding_reads_back() {
    let folder = TempDir::new().unwrap();
    for case in cases_with_header() {
        let path = case.write(folder.path());
        let volume = read_plainly(&path).unwrap_or_else(|e| panic!("{e}"));
        assert_reads(&volume, case.kind, &case.name);
        assert_eq!(volume.spacing, DVec3::new(1.0, 2.0, 0.5), "{}", case.name);
        let notes =
            if case.kind == StoredType::F64 { vec!["float64 voxels are stored as float32"] } else { vec![] };
        assert_eq!(volume.notes, notes, "{}", case.name);
    }
}

#[test]
fn headerless_files_read_back() {
    let folder = TempDir::new().unwrap();
    for kind in StoredType::ALL {
        for endian in ENDIANS {
            let options = RawOptions { endian: Some(endian), ..RawOptions::default() };
            for case in raw_cases(kind, endian) {
                let volume = read(&case.write(folder.path()), &options).unwrap();
                assert_reads(&volume, kind, &case.name);
            }
        }
    }
}

#[test]
fn raw_options_win_over_the_name_and_name_nameless_files() {
    let folder = TempDir::new().unwrap();
    let raw = join(&[b"head", &encode(StoredType::I16, Endian::Big)]);
    let options = RawOptions {
        dims: Some(DIMS),
        kind: Some(StoredType::I16),
        endian: Some(Endian::Big),
        offset: Some(4),
    };
    for (name, bytes) in [
        ("x_9x9x9_uint8.raw", raw.clone()),
        ("x.raw.gz", gzip(&raw)),
        ("x.dat", raw.clone()),
        ("x.dat.gz", gzip(&raw)),
        ("x", raw.clone()),
    ] {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        assert_reads(&read(&path, &options).unwrap(), StoredType::I16, name);
    }
}

#[test]
fn orientations_and_odd_spacings_leave_notes() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.nrrd");
    let with = |line: &str| {
        let header =
            format!("NRRD0005\ntype: uint8\ndimension: 3\nsizes: 2 1 1\nencoding: raw\n{line}\n\n12");
        fs::write(&path, header).unwrap();
        read_plainly(&path).unwrap()
    };
    let tilted = with("space directions: (3,4,0) (-4,3,0) (0,0,2)");
    assert_eq!(tilted.spacing, DVec3::new(5.0, 5.0, 2.0));
    assert_eq!(tilted.notes, ["the space directions are not the positive axes: only the spacing is used"]);
    let odd = with("spacings: 0 nan -3");
    assert_eq!(odd.spacing, DVec3::new(1.0, 1.0, 3.0));
    assert_eq!(odd.notes.len(), 3, "{:?}", odd.notes);
    assert_eq!(with("space origin: (1,2,3)").notes, [""; 0]);
}

#[test]
fn four_axes_with_one_of_size_one_are_a_volume() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.nrrd");
    let header = "NRRD0005\ntype: uint8\ndimension: 4\nsizes: 1 2 1 3\nspacings: nan 4 5 6\nencoding: raw\n";
    for (line, dims, spacing) in [
        ("", [1, 2, 3], DVec3::new(1.0, 4.0, 6.0)),
        ("space directions: none (4,0,0) (0,5,0) (0,0,6)\n", [2, 1, 3], DVec3::new(4.0, 5.0, 6.0)),
    ] {
        fs::write(&path, format!("{header}{line}\nabcdef")).unwrap();
        let volume = read_plainly(&path).unwrap();
        assert_eq!((volume.dims, volume.spacing), (dims, spacing));
    }
}

#[test]
fn floats_that_are_not_finite_are_counted() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("x_5x1x1_float64.raw");
    let values = [f64::NAN, f64::INFINITY, 1e300, -1e300, 2.5];
    fs::write(&path, values.map(f64::to_le_bytes).concat()).unwrap();
    let volume = read_plainly(&path).unwrap();
    assert_eq!((volume.nan, volume.infinite), (1, 3));
    assert_eq!(volume.data_range(), Some((2.5, 2.5)));
    assert_eq!(volume.remarks().len(), 2);
}

#[test]
fn plain_files_are_read_in_either_byte_order_and_at_any_offset() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("large.raw");
    let bytes = 4 << 20;
    let mut file = fs::File::create(&path).unwrap();
    file.set_len(bytes + 2).unwrap();
    file.seek(SeekFrom::Start(bytes - 1)).unwrap();
    file.write_all(&[1, 2, 3]).unwrap();
    let open = |kind, offset, endian, x| {
        let options = RawOptions {
            dims: Some([x, 1024, 2]),
            kind: Some(kind),
            endian: Some(endian),
            offset: Some(offset),
        };
        let volume = read(&path, &options).unwrap();
        volume.value(x - 1, 1023, 1)
    };
    let (native, other) = match Endian::NATIVE {
        Endian::Little => (Endian::Little, Endian::Big),
        Endian::Big => (Endian::Big, Endian::Little),
    };
    let number = |bytes| f64::from(u16::from_ne_bytes(bytes));
    assert_eq!(open(StoredType::U16, 2, native, 1024), number([2, 3]));
    assert_eq!(open(StoredType::U16, 2, other, 1024), number([3, 2]));
    assert_eq!(open(StoredType::U8, 2, other, 2048), 3.0);
    // One byte off, voxels of two bytes lie askew.
    file.set_len(bytes + 1).unwrap();
    assert_eq!(open(StoredType::U16, 1, native, 1024), number([1, 2]));
}

/// A mapping of the file would end the process by SIGBUS.
#[test]
fn what_becomes_of_a_file_that_was_read_does_not_matter() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("large.raw");
    let file = fs::File::create(&path).unwrap();
    file.set_len(64 << 20).unwrap();
    let options =
        RawOptions { dims: Some([1024, 1024, 64]), kind: Some(StoredType::U8), ..Default::default() };
    let volume = read(&path, &options).unwrap();
    file.set_len(0).unwrap();
    assert_eq!(volume.data_range(), Some((0.0, 0.0)));
    let error = read(&path, &options).unwrap_err().to_string();
    assert!(error.contains("expected 67108864 bytes of voxels") && error.contains("found 0"), "{error}");
}

#[test]
fn the_shipped_head_reads() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/data/brain.nrrd");
    let volume = read_plainly(&path).unwrap();
    assert_eq!((volume.dims, volume.spacing), ([128, 128, 84], DVec3::ONE));
    assert_eq!(volume.voxel_type().name(), "uint8");
    assert_eq!(volume.notes, [""; 0]);
}

#[test]
fn nifti_rejects_what_it_cannot_hold_by_name() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.nii");
    let with = |at: usize, bytes: &[u8]| {
        let mut file = join(&[
            &nifti_header(StoredType::F32, Endian::Little, b"n+1\0"),
            &encode(StoredType::F32, Endian::Little),
        ]);
        file[at..at + bytes.len()].copy_from_slice(bytes);
        fs::write(&path, file).unwrap();
        read_plainly(&path)
    };
    let text = |at, bytes: &[u8]| with(at, bytes).unwrap_err().to_string();
    assert!(text(70, &8i16.to_le_bytes()).contains("its voxel type is Int32; convert it to one of uint8"));
    assert!(text(70, &77i16.to_le_bytes()).contains("of the unknown code 77"));
    assert!(text(48, &2i16.to_le_bytes()).contains("has 4 axes of sizes [3, 4, 5, 2]"));
    assert!(text(108, &f32::NAN.to_le_bytes()).contains("vox_offset = NaN; a whole number from 352"));
    assert!(text(108, &100f32.to_le_bytes()).contains("a whole number from 352"));
    assert!(text(108, &1e9f32.to_le_bytes()).contains("should begin at byte 1000000000"));
    assert!(text(0, &540i32.to_le_bytes()).contains("is a NIfTI-2 file; convert it to NIfTI-1"));
    assert!(text(40, &0i16.to_le_bytes()).contains("it has 0 axes"));
    let scaled = with(112, &join(&[&2f32.to_le_bytes(), &(-5f32).to_le_bytes()])).unwrap();
    assert_eq!((scaled.slope, scaled.intercept), (2.0, -5.0));
    assert_eq!(scaled.value(1, 0, 0), 2.0 * value(StoredType::F32, 1) - 5.0);
    let unscaled = with(112, &join(&[&0f32.to_le_bytes(), &9f32.to_le_bytes()])).unwrap();
    assert_eq!((unscaled.slope, unscaled.intercept), (1.0, 0.0));
    let odd = with(112, &f32::NAN.to_le_bytes()).unwrap();
    assert_eq!((odd.slope, odd.notes.len()), (1.0, 1), "{:?}", odd.notes);
    let mirrored = with(80, &(-1f32).to_le_bytes()).unwrap();
    assert_eq!(mirrored.spacing, DVec3::new(1.0, 2.0, 0.5));
    assert!(mirrored.notes[0].contains("absolute value"), "{:?}", mirrored.notes);
}
