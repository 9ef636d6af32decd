//! NIfTI-1 volumes: `.nii`, and pairs of `.hdr` and `.img`, each also compressed with gzip.
//!
//! Source: the NIfTI-1 data format of the NIfTI Data Format Working Group. Of the orientation only the spacing is
//! used: x is the fastest axis of the file.

use super::Volume;
use super::error::VolumeError;
use super::payload::{Coding, Excess, Payload, Start};
use super::source::{self, three_axes};
use super::stored::{Endian, StoredType, supported_types};
use flate2::read::MultiGzDecoder;
use nifti::{Endianness, NiftiHeader, NiftiType};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Bytes of a NIfTI-1 header.
pub(super) const HEADER_BYTES: usize = 348;
/// Where the data of a single file begin at the earliest: behind the header and the extension flag.
const SINGLE_FILE_DATA: f32 = 352.0;
/// `sizeof_hdr` of NIfTI-2.
const NIFTI_2: i32 = 540;

/// Whether the first bytes of a file are those of a NIfTI-1 header.
pub(super) fn is_header(head: &[u8]) -> bool {
    matches!(head.get(344..348), Some(b"n+1\0" | b"ni1\0"))
}

/// Reads a NIfTI-1 volume.
pub(super) fn read(path: &Path) -> Result<Volume, VolumeError> {
    let header_path = with_extension(path, "img", "hdr");
    let header = header(&header_path)?;
    let (dims, axes) = dims(&header_path, &header)?;
    let mut notes = orientation(&header);
    let given = axes.map(|axis| header.pixdim.get(axis + 1).map(|h| f64::from(*h)));
    let spacing = source::spacing(given, &mut notes);
    let (slope, intercept) = rescaling(&header, &mut notes);
    let offset = offset(&header_path, &header)?;
    let file = if single(&header) { header_path.clone() } else { with_extension(&header_path, "hdr", "img") };
    let gzip = is_gzip(&file)?;
    let payload = Payload {
        path: &file,
        dims,
        kind: kind(&header_path, &header)?,
        order: if header.endianness == Endianness::Little { Endian::Little } else { Endian::Big },
        coding: if gzip { Coding::Gzip } else { Coding::Plain },
        start: Start::At(if gzip { 0 } else { offset }),
        skip: if gzip { offset } else { 0 },
        excess: Excess::Note,
    };
    let volume = payload.volume(spacing, notes)?;
    Ok(Volume { slope, intercept, ..volume })
}

/// The other file of a pair: `from` in the name replaced by `to`, `.gz` kept. Other names stay as they are.
fn with_extension(path: &Path, from: &str, to: &str) -> PathBuf {
    let packed = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"));
    let plain = if packed { path.with_extension("") } else { path.to_owned() };
    if !plain.extension().is_some_and(|e| e.eq_ignore_ascii_case(from)) {
        return path.to_owned();
    }
    let other = plain.with_extension(to);
    let packed_other = plain.with_extension(format!("{to}.gz"));
    // Either file of a pair may be compressed, whatever the other one is.
    let prefer_packed = if other.exists() == packed_other.exists() { packed } else { packed_other.exists() };
    if prefer_packed { packed_other } else { other }
}

fn is_gzip(path: &Path) -> Result<bool, VolumeError> {
    let (file, _) = source::open(path)?;
    let mut magic = Vec::new();
    file.take(2).read_to_end(&mut magic).map_err(|e| VolumeError::io(path, e))?;
    let named = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"));
    // Data without a header may begin with any bytes, so for them only the name counts.
    let data_only = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("img"));
    Ok(named || (!data_only && magic == [0x1f, 0x8b]))
}

fn header(path: &Path) -> Result<NiftiHeader, VolumeError> {
    let gzip = is_gzip(path)?;
    let (file, _) = source::open(path)?;
    let mut head = Vec::new();
    let limit = HEADER_BYTES as u64;
    let read = if gzip {
        MultiGzDecoder::new(file).take(limit).read_to_end(&mut head)
    } else {
        file.take(limit).read_to_end(&mut head)
    };
    let remedy = "check that this is a NIfTI-1 file";
    match read {
        Err(e) if gzip => {
            let problem = format!("its compressed header is damaged after {} bytes ({e})", head.len());
            return Err(VolumeError::malformed(path, problem, "fetch or compress the file again"));
        }
        Err(e) => return Err(VolumeError::io(path, e)),
        Ok(_) => {}
    }
    if head.len() < HEADER_BYTES {
        let problem = format!("expected a header of {HEADER_BYTES} bytes, found {}", head.len());
        return Err(VolumeError::length(path, problem, remedy));
    }
    let size = head.first_chunk().map_or(0, |size| i32::from_le_bytes(*size));
    if size == NIFTI_2 || size.swap_bytes() == NIFTI_2 {
        return Err(VolumeError::unsupported(path, "is a NIfTI-2 file", "convert it to NIfTI-1"));
    }
    if !is_header(&head) {
        return Err(VolumeError::malformed(path, "has no NIfTI-1 magic (n+1 or ni1) at byte 344", remedy));
    }
    NiftiHeader::from_reader(head.as_slice())
        .map_err(|e| VolumeError::malformed(path, format!("its header cannot be read ({e})"), remedy))
}

/// Whether header and data share a file.
fn single(header: &NiftiHeader) -> bool {
    &header.magic == b"n+1\0"
}

fn dims(path: &Path, header: &NiftiHeader) -> Result<([usize; 3], [usize; 3]), VolumeError> {
    let given = header.dim.split_first().and_then(|(count, sizes)| sizes.get(..usize::from(*count)));
    let Some(mut given) = given.filter(|sizes| !sizes.is_empty()) else {
        let problem = format!("its header says it has {} axes", header.dim[0]);
        return Err(VolumeError::malformed(path, problem, "dim[0] must be 3 (or more, if the others are 1)"));
    };
    // Time, and everything after it, may be present as long as it is single.
    while let [front @ .., 1] = given {
        if front.len() < 3 {
            break;
        }
        given = front;
    }
    let sizes: Vec<u64> = given.iter().map(|size| u64::from(*size)).collect();
    three_axes(path, &sizes, None)
}

fn kind(path: &Path, header: &NiftiHeader) -> Result<StoredType, VolumeError> {
    Ok(match header.data_type() {
        Ok(NiftiType::Uint8) => StoredType::U8,
        Ok(NiftiType::Int8) => StoredType::I8,
        Ok(NiftiType::Uint16) => StoredType::U16,
        Ok(NiftiType::Int16) => StoredType::I16,
        Ok(NiftiType::Float32) => StoredType::F32,
        Ok(NiftiType::Float64) => StoredType::F64,
        other => {
            let name = other.map_or(format!("of the unknown code {}", header.datatype), |t| format!("{t:?}"));
            let remedy = format!("convert it to one of {}", supported_types());
            return Err(VolumeError::unsupported(path, format!("its voxel type is {name}"), remedy));
        }
    })
}

/// Where the data begin, in bytes. The format keeps it in a float.
fn offset(path: &Path, header: &NiftiHeader) -> Result<u64, VolumeError> {
    let given = header.vox_offset;
    // Some writers leave 0 in single files; the data then follow the extension flag.
    let offset = if single(header) && given == 0.0 { SINGLE_FILE_DATA } else { given };
    let least = if single(header) { SINGLE_FILE_DATA } else { 0.0 };
    // Beyond 2^24 a float skips whole numbers, yet such offsets still name the byte they round to.
    if !offset.is_finite() || offset < least || offset.fract() != 0.0 || offset >= 2f32.powi(63) {
        let problem = format!("its header says vox_offset = {given}");
        return Err(VolumeError::malformed(path, problem, format!("a whole number from {least} is needed")));
    }
    Ok(offset as u64)
}

/// Data value = slope · stored value + intercept; by the standard a slope of 0 means none.
fn rescaling(header: &NiftiHeader, notes: &mut Vec<String>) -> (f64, f64) {
    let (slope, intercept) = (header.scl_slope, header.scl_inter);
    if slope == 0.0 {
        return (1.0, 0.0);
    }
    if !slope.is_finite() || !intercept.is_finite() {
        notes.push(format!("scl_slope = {slope}, scl_inter = {intercept} is not finite: ignored"));
        return (1.0, 0.0);
    }
    (f64::from(slope), f64::from(intercept))
}

fn orientation(header: &NiftiHeader) -> Vec<String> {
    let rows = [header.srow_x, header.srow_y, header.srow_z];
    let diagonal = rows.iter().enumerate().all(|(i, row)| {
        row.iter().take(3).enumerate().all(|(k, c)| if k == i { *c > 0.0 } else { *c == 0.0 })
    });
    let unrotated = [header.quatern_b, header.quatern_c, header.quatern_d] == [0.0; 3];
    let by_sform = header.sform_code > 0 && !diagonal;
    let by_qform = header.sform_code <= 0 && header.qform_code > 0 && (!unrotated || header.pixdim[0] < 0.0);
    if by_sform || by_qform {
        return vec!["the header turns or mirrors the axes: only the spacing is used".into()];
    }
    Vec::new()
}
