//! Small volume files of every supported kind, built byte by byte.

use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use svetlo::volume::{Endian, RawOptions, StoredType, Volume, VolumeError, read};

pub const DIMS: [usize; 3] = [3, 4, 5];
pub const COUNT: usize = 60;
pub const ENDIANS: [Endian; 2] = [Endian::Little, Endian::Big];

/// A file to write: its name, its bytes, and those of a second file it refers to.
#[derive(Clone, Debug)]
pub struct Case {
    pub name: String,
    pub bytes: Vec<u8>,
    pub second: Option<(String, Vec<u8>)>,
    pub kind: StoredType,
}

impl Case {
    pub fn write(&self, folder: &Path) -> PathBuf {
        if let Some((name, bytes)) = &self.second {
            fs::write(folder.join(name), bytes).unwrap();
        }
        let path = folder.join(&self.name);
        fs::write(&path, &self.bytes).unwrap();
        path
    }
}

/// A value that the type holds exactly and that shows its sign and byte order.
pub fn value(kind: StoredType, i: usize) -> f64 {
    let i = i as f64;
    match kind {
        StoredType::U8 => 3.0 * i,
        StoredType::I8 => 4.0 * i - 120.0,
        StoredType::U16 => 1091.0 * i,
        StoredType::I16 => 1091.0 * i - 32768.0,
        StoredType::F32 | StoredType::F64 => 1091.25 * i - 30000.0,
    }
}

pub fn encode(kind: StoredType, endian: Endian) -> Vec<u8> {
    let bytes = |i| {
        let v = value(kind, i);
        let mut bytes = match kind {
            StoredType::U8 => vec![v as u8],
            StoredType::I8 => (v as i8).to_le_bytes().to_vec(),
            StoredType::U16 => (v as u16).to_le_bytes().to_vec(),
            StoredType::I16 => (v as i16).to_le_bytes().to_vec(),
            StoredType::F32 => (v as f32).to_le_bytes().to_vec(),
            StoredType::F64 => v.to_le_bytes().to_vec(),
        };
        if endian == Endian::Big {
            bytes.reverse();
        }
        bytes
    };
    (0..COUNT).flat_map(bytes).collect()
}

pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

pub fn text(kind: StoredType) -> Vec<u8> {
    let numbers: Vec<String> = (0..COUNT).map(|i| value(kind, i).to_string()).collect();
    numbers.join("\n").into_bytes()
}

pub fn join(parts: &[&[u8]]) -> Vec<u8> {
    parts.concat()
}

fn order(endian: Endian) -> &'static str {
    if endian == Endian::Little { "little" } else { "big" }
}

pub fn nrrd_header(kind: StoredType, endian: Endian, encoding: &str, more: &str) -> String {
    let kind = match kind {
        StoredType::F32 => "float",
        StoredType::F64 => "double",
        other => other.name(),
    };
    format!(
        "NRRD0004\n# a comment\ntype: {kind}\ndimension: 3\nsizes: 3 4 5\nspacings: 1 2 0.5\nkey:=value: free text\n\
         endian: {}\nencoding: {encoding}\n{more}",
        order(endian)
    )
}

pub fn nrrd_cases(kind: StoredType, endian: Endian) -> Vec<Case> {
    let (raw, packed) = (encode(kind, endian), gzip(&encode(kind, endian)));
    let attached = |encoding: &str, data: &[u8]| {
        let header = nrrd_header(kind, endian, encoding, "\n");
        Case { name: format!("{encoding}.nrrd"), bytes: join(&[header.as_bytes(), data]), second: None, kind }
    };
    let detached = |encoding: &str, more: &str, data: Vec<u8>| {
        let header = nrrd_header(kind, endian, encoding, &format!("data file: voxels.bin\n{more}"));
        let second = Some(("voxels.bin".to_owned(), data));
        Case { name: "detached.nhdr".into(), bytes: header.into_bytes(), second, kind }
    };
    vec![
        attached("raw", &raw),
        attached("gzip", &packed),
        attached("ascii", &text(kind)),
        detached("raw", "", raw.clone()),
        detached("raw", "line skip: 2\nbyte skip: 3\n", join(&[b"two\nlines\nabc", &raw])),
        detached("raw", "byte skip: -1\n", join(&[b"any\nheader", &raw])),
        detached("gz", "byte skip: 7\n", gzip(&join(&[b"7 bytes", &raw]))),
        detached("text", "", text(kind)),
    ]
}

/// A NIfTI-1 header of 352 bytes, extension flag included.
pub fn nifti_header(kind: StoredType, endian: Endian, magic: &[u8; 4]) -> Vec<u8> {
    let code = match kind {
        StoredType::U8 => 2i16,
        StoredType::I8 => 256,
        StoredType::U16 => 512,
        StoredType::I16 => 4,
        StoredType::F32 => 16,
        StoredType::F64 => 64,
    };
    let mut bytes = vec![0; 352];
    let mut put = |at: usize, mut field: Vec<u8>| {
        if endian == Endian::Big {
            field.reverse();
        }
        bytes[at..at + field.len()].copy_from_slice(&field);
    };
    put(0, 348i32.to_le_bytes().to_vec());
    for (k, size) in [4i16, 3, 4, 5, 1, 1, 1, 1].into_iter().enumerate() {
        put(40 + 2 * k, size.to_le_bytes().to_vec());
    }
    put(70, code.to_le_bytes().to_vec());
    put(72, (8 * kind.bytes() as i16).to_le_bytes().to_vec());
    for (k, spacing) in [1.0f32, 1.0, 2.0, 0.5, 1.0].into_iter().enumerate() {
        put(76 + 4 * k, spacing.to_le_bytes().to_vec());
    }
    let offset = if magic == b"n+1\0" { 352.0f32 } else { 0.0 };
    put(108, offset.to_le_bytes().to_vec());
    bytes[344..348].copy_from_slice(magic);
    bytes
}

pub fn nifti_cases(kind: StoredType, endian: Endian) -> Vec<Case> {
    let raw = encode(kind, endian);
    let single = join(&[&nifti_header(kind, endian, b"n+1\0"), &raw]);
    let pair = nifti_header(kind, endian, b"ni1\0");
    let case = |name: &str, bytes: Vec<u8>, second: Option<(&str, Vec<u8>)>| Case {
        name: name.into(),
        bytes,
        second: second.map(|(name, bytes)| (name.into(), bytes)),
        kind,
    };
    vec![
        case("a.nii", single.clone(), None),
        case("a.nii.gz", gzip(&single), None),
        case("b.hdr", pair.clone(), Some(("b.img", raw.clone()))),
        case("c.img", raw.clone(), Some(("c.hdr", pair.clone()))),
        case("d.hdr.gz", gzip(&pair), Some(("d.img.gz", gzip(&raw)))),
        case("by_content", single, None),
    ]
}

pub fn meta_cases(kind: StoredType, endian: Endian) -> Vec<Case> {
    let element = match kind {
        StoredType::U8 => "MET_UCHAR",
        StoredType::I8 => "MET_CHAR",
        StoredType::U16 => "MET_USHORT",
        StoredType::I16 => "MET_SHORT",
        StoredType::F32 => "MET_FLOAT",
        StoredType::F64 => "MET_DOUBLE",
    };
    let msb = if endian == Endian::Big { "True" } else { "False" };
    let header = |more: &str, file: &str| {
        format!(
            "ObjectType = Image\nNDims = 3\nBinaryDataByteOrderMSB = {msb}\nTransformMatrix = 1 0 0 0 1 0 0 0 1\n\
             DimSize = 3 4 5\nElementSpacing = 1 2 0.5\nElementType = {element}\n{more}ElementDataFile = {file}\n"
        )
    };
    let raw = encode(kind, endian);
    let local = |name: &str, more: &str, data: &[u8]| Case {
        name: name.into(),
        bytes: join(&[header(more, "LOCAL").as_bytes(), data]),
        second: None,
        kind,
    };
    let beside = |more: &str, data: Vec<u8>| Case {
        name: "beside.mhd".into(),
        bytes: header(more, "voxels.dat").into_bytes(),
        second: Some(("voxels.dat".into(), data)),
        kind,
    };
    vec![
        local("plain.mha", "BinaryData = True\n", &raw),
        local("zlib.mha", "CompressedData = True\n", &zlib(&raw)),
        local("text.mha", "BinaryData = False\n", &text(kind)),
        beside("", raw.clone()),
        beside("HeaderSize = 4\n", join(&[b"skip", &raw])),
        beside("HeaderSize = -1\n", join(&[b"any header", &raw])),
        beside("CompressedData = True\n", gzip(&raw)),
    ]
}

pub fn cases_with_header() -> Vec<Case> {
    let mut cases = Vec::new();
    for kind in StoredType::ALL {
        for endian in ENDIANS {
            cases.extend(nrrd_cases(kind, endian));
            cases.extend(nifti_cases(kind, endian));
            cases.extend(meta_cases(kind, endian));
        }
    }
    cases
}

pub fn raw_cases(kind: StoredType, endian: Endian) -> Vec<Case> {
    let raw = encode(kind, endian);
    let case = |suffix: &str, bytes| Case {
        name: format!("x_3x4x5_{}.{suffix}", kind.name()),
        bytes,
        second: None,
        kind,
    };
    vec![case("raw.gz", gzip(&raw)), case("raw", raw)]
}

/// Reads a file that needs no options.
pub fn read_plainly(path: &Path) -> Result<Volume, VolumeError> {
    read(path, &RawOptions::default())
}
