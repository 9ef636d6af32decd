//! What is wrong with a file is said, together with what would be right.

use crate::corpus::*;
use std::fs;
use std::path::Path;
use svetlo::volume::{Endian, RawOptions, StoredType, VolumeErrorKind, read};
use tempfile::TempDir;

/// A file cut anywhere is refused: even one that only lacks its checksum.
#[test]
fn every_truncation_is_an_error() {
    let folder = TempDir::new().unwrap();
    let mut cases: Vec<Case> = Vec::new();
    cases.extend(nrrd_cases(StoredType::I16, Endian::Little));
    cases.extend(nifti_cases(StoredType::I16, Endian::Big));
    cases.extend(meta_cases(StoredType::I16, Endian::Little));
    cases.extend(raw_cases(StoredType::I16, Endian::Little));
    for case in cases {
        // A number cut short is another number, and a detached header may end where it likes.
        let textual = case.bytes.ends_with(&text(StoredType::I16));
        if textual || (case.second.is_some() && case.name != "c.img") {
            continue;
        }
        let path = case.write(folder.path());
        for length in 0..case.bytes.len() {
            fs::write(&path, &case.bytes[..length]).unwrap();
            let error = read_plainly(&path).expect_err(&format!("{} cut at {length}", case.name)).to_string();
            let named = error.starts_with(&folder.path().display().to_string());
            assert!(named && error.contains(": ") && error.contains("; "), "{error}");
        }
    }
}

/// What is wrong, and what would be right.
#[test]
fn messages_say_what_would_be_right() {
    use VolumeErrorKind::{Length, Malformed, Options, Unsupported};
    let none = RawOptions::default();
    let nrrd = |more: &str| format!("NRRD0005\n{more}\n\n");
    let ok = "type: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw";
    let meta = |more: &str| format!("NDims = 3\nDimSize = 2 2 2\n{more}ElementDataFile = LOCAL\n12345678");
    #[rustfmt::skip]
    let table = [
        ("a_2x2x2_uint8.raw", "1234567".to_owned(), Length, "expected 8 bytes of voxels (2x2x2 uint8), found 7; complete the file"),
        ("a_2x2x2_uint8.raw", "123456789".into(), Length, "expected 8 bytes of voxels (2x2x2 uint8), found 9 bytes; correct `dims`"),
        ("a_0x2x2_uint8.raw", String::new(), Malformed, "is empty; each extent must be at least 1"),
        ("a_4294967295x4294967295x4294967295_uint8.raw", String::new(), Malformed, "more than memory can address"),
        ("a_1000000x1000000x1000_uint8.raw", "x".into(), Length, "expected 1000000000000000 bytes"),
        ("a_2x2x2.raw", String::new(), Options, "tells no voxel type; give `type`"),
        ("a.dat", "12345678".into(), Unsupported, "give `dims` and `type`"),
        ("a.nrrd", "NOPE".into(), Malformed, "does not begin with NRRD"),
        ("a.nrrd", "NRRD0009\n".into(), Unsupported, "unknown NRRD version"),
        ("a.nrrd", nrrd(&ok.replace("uint8", "int")), Unsupported, "its voxel type is \"int\"; convert it to one of uint8"),
        ("a.nrrd", nrrd(&ok.replace("uint8", "short")), Malformed, "has no `endian`; add `endian: little`"),
        ("a.nrrd", nrrd(&ok.replace("raw", "bzip2")), Unsupported, "its encoding is \"bzip2\"; convert it to raw"),
        ("a.nrrd", nrrd(&ok.replace("2 2 2", "2 2")), Malformed, "3 whole numbers are needed"),
        ("a.nrrd", nrrd(&ok.replace("2 2 2", "2 -2 2")), Malformed, "3 whole numbers are needed"),
        ("a.nrrd", nrrd(&ok.replace("2 2 2", "2 0 2")), Malformed, "2x0x2 voxels is empty"),
        ("a.nrrd", nrrd("type: uint8\ndimension: 2\nsizes: 2 2\nencoding: raw"), Unsupported, "has 2 axes; 3 axes are needed"),
        ("a.nrrd", nrrd("type: uint8\ndimension: 4\nsizes: 3 2 2 2\nencoding: raw"), Unsupported, "extract one scalar volume"),
        ("a.nrrd", nrrd("type: uint8\ndimension: 3"), Malformed, "has no `sizes`; add a `sizes: …` line"),
        ("a.nrrd", nrrd(&format!("{ok}\ntype: uint8")), Malformed, "line 6 of its header gives `type` again"),
        ("a.nrrd", nrrd(&format!("{ok}\nwhat is this")), Malformed, "line 6 of its header is \"what is this\""),
        ("a.nrrd", nrrd(&format!("{ok}\nspacings: 1 1")), Malformed, "3 numbers are needed"),
        ("a.nrrd", nrrd(&format!("{ok}\nspace directions: (1,0,0)")), Malformed, "one (x,y,z) or none per axis"),
        ("a.nrrd", nrrd(&format!("{ok}\nbyte skip: -2")), Malformed, "it must not be negative"),
        ("a.nrrd", nrrd(&format!("{ok}\nbyte skip: 99")), Length, "should begin at byte"),
        ("a.nrrd", nrrd(&format!("{ok}\nline skip: 99")), Length, "correct `line skip`"),
        ("a.nrrd", format!("NRRD0005\n{ok}"), Malformed, "its header does not end"),
        ("a.nhdr", nrrd(&format!("{ok}\ndata file: LIST\na.raw")), Malformed, "line 7 of its header is \"a.raw\""),
        ("a.nhdr", nrrd(&format!("{ok}\ndata file: LIST")), Unsupported, "join them into one file"),
        ("a.nhdr", nrrd(&format!("{ok}\ndata file: a%03d.raw 1 3 1")), Unsupported, "join them into one file"),
        ("a.nrrd", nrrd(&ok.replace("raw", "ascii")) + "1 2 3 4 5 6 7 300", Malformed, "its number 8 is \"300\"; write a uint8 there"),
        ("a.nrrd", nrrd(&ok.replace("raw", "ascii")) + "1 2 3           ", Length, "expected 8 numbers (2x2x2 uint8), found 3"),
        ("a.nrrd", nrrd(&ok.replace("2 2 2", "9999999 9999999 9999").replace("raw", "ascii")), Length, "room for at most 0"),
        ("a.nrrd", nrrd(&ok.replace("raw", "gzip")) + "this is not gzip", Malformed, "compressed data are damaged"),
        ("a.mha", meta("ElementType = MET_INT\n"), Unsupported, "its voxel type is MET_INT; convert"),
        ("a.mha", meta(""), Malformed, "has no `ElementType`"),
        ("a.mha", meta("ElementType = MET_UCHAR\nElementNumberOfChannels = 3\n"), Unsupported, "has 3 channels per voxel"),
        ("a.mha", meta("ElementType = MET_UCHAR\nElementSpacing = 1 1\n"), Malformed, "3 numbers are needed"),
        ("a.mha", meta("ElementType = MET_UCHAR\nCompressedData = maybe\n"), Malformed, "it must be True or False"),
        ("a.mha", meta("ElementType = MET_UCHAR\nHeaderSize = -2\n"), Malformed, "-1 for data at the end"),
        ("a.mha", meta("ElementType = MET_UCHAR\nElementToIntensityFunctionSlope = 0\n"), Malformed, "a slope other than 0"),
        ("a.mha", "NDims = 3\n".into(), Malformed, "has no `ElementDataFile`"),
        ("a.mhd", "DimSize\n".into(), Malformed, "line 1 of its header is \"DimSize\""),
        ("a.nii", "short".into(), Length, "expected a header of 348 bytes, found 5"),
        ("a.nii", "x".repeat(400), Malformed, "has no NIfTI-1 magic"),
        ("a.nii.gz", "x".repeat(400), Malformed, "its compressed header is damaged"),
    ];
    let folder = TempDir::new().unwrap();
    for (name, content, kind, expected) in table {
        let path = folder.path().join(name);
        fs::write(&path, content).unwrap();
        let error = read(&path, &none).expect_err(expected);
        let text = error.to_string();
        assert!(text.contains(expected), "{text}\nlacks: {expected}");
        assert!(text.starts_with(&format!("{}: ", path.display())), "{text}");
        assert_eq!(error.kind(), kind, "{text}");
        assert_eq!(svetlo::Error::from(error).exit_code(), 2);
    }
}

#[test]
fn what_is_not_a_file_is_refused_before_it_is_opened() {
    let folder = TempDir::new().unwrap();
    let text = |path: &Path| read_plainly(path).unwrap_err().to_string();
    let missing = text(&folder.path().join("none.nrrd"));
    assert!(missing.contains("there is no such file; check the path"), "{missing}");
    assert!(text(folder.path()).contains("is not a regular file; name one volume file"));
    if cfg!(unix) {
        assert!(text(Path::new("/dev/null")).contains("is not a regular file"));
    }
    let header = folder.path().join("a.nhdr");
    fs::write(&header, nrrd_header(StoredType::U8, Endian::Little, "raw", "data file: gone.raw\n")).unwrap();
    assert!(text(&header).contains("gone.raw: there is no such file"), "{}", text(&header));
}

#[test]
fn raw_options_do_not_apply_to_files_with_a_header() {
    let folder = TempDir::new().unwrap();
    let path = nrrd_cases(StoredType::U8, Endian::Little)[0].write(folder.path());
    let options = RawOptions { dims: Some(DIMS), offset: Some(0), ..RawOptions::default() };
    let text = read(&path, &options).unwrap_err().to_string();
    assert!(text.contains("has a header, so `dims`, `offset` cannot be given; leave that out"), "{text}");
}

/// What a stream holds beyond the grid is neither kept nor decompressed.
#[test]
fn a_gzip_bomb_does_not_grow_the_volume() {
    let folder = TempDir::new().unwrap();
    let bomb = gzip(&vec![0; 64 << 20]);
    let header = b"NRRD0005\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: gzip\n\n";
    let path = folder.path().join("bomb.nrrd");
    fs::write(&path, join(&[header, &bomb])).unwrap();
    let volume = read_plainly(&path).unwrap();
    assert_eq!(volume.notes, ["the grid takes 8 bytes (2x2x2 uint8), found more: the rest is ignored"]);
    let path = folder.path().join("bomb_2x2x2_uint8.raw.gz");
    fs::write(&path, &bomb).unwrap();
    assert_eq!(read_plainly(&path).unwrap_err().kind(), VolumeErrorKind::Length);
    // The other way round: a small stream that a header claims to be 64 TiB.
    let path = folder.path().join("claim_65536x32768x32768_uint8.raw.gz");
    fs::write(&path, gzip(b"small")).unwrap();
    let text = read_plainly(&path).unwrap_err().to_string();
    assert!(text.contains("expected 70368744177664 bytes of voxels") && text.contains("found 5"), "{text}");
}
