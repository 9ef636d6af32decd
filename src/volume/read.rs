//! Which reader a file goes to: by its name, and where that says nothing by its first bytes.

use super::error::VolumeError;
use super::raw::{self, RawOptions};
use super::{Volume, metaimage, nifti, nrrd, source};
use flate2::read::MultiGzDecoder;
use std::io::Read;
use std::path::Path;

/// The readers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Nrrd,
    Nifti,
    MetaImage,
    Raw { gzip: bool },
}

/// Reads a volume from a file.
///
/// | name | format |
/// | --- | --- |
/// | `.nrrd`, `.nhdr` | NRRD, attached or detached header; encodings raw, gzip, ascii |
/// | `.nii`, `.nii.gz`, `.hdr` or `.img` (a pair, also `.gz`) | NIfTI-1 |
/// | `.mhd`, `.mha` | MetaImage, also with compressed data |
/// | `.raw`, `.raw.gz` | headerless: see [`RawOptions`] |
/// | any other | one of the above by its first bytes; headerless if `dims` and `type` are given |
///
/// Voxels may be `uint8`, `int8`, `uint16`, `int16`, `float32` or `float64` in either byte order. All are
/// read into memory: what becomes of the file afterwards does not matter.
///
/// # Errors
/// [`VolumeError`], whose text is `PATH: what is wrong; what would be right`.
pub fn read(path: &Path, options: &RawOptions) -> Result<Volume, VolumeError> {
    // Said first: for a missing file every other message would mislead.
    source::open(path)?;
    let format = match by_name(path) {
        Some(format) => format,
        None => by_content(path, options)?,
    };
    let given = options.given();
    if !matches!(format, Format::Raw { .. }) && !given.is_empty() {
        let problem = format!("has a header, so {} cannot be given", given.join(", "));
        return Err(VolumeError::options(path, problem, "leave that out; it is for headerless raw files"));
    }
    match format {
        Format::Nrrd => nrrd::read(path),
        Format::Nifti => nifti::read(path),
        Format::MetaImage => metaimage::read(path),
        Format::Raw { gzip } => raw::read(path, gzip, options),
    }
}

fn by_name(path: &Path) -> Option<Format> {
    let name = path.file_name()?.to_string_lossy().to_lowercase();
    let (stem, gzip) = match name.strip_suffix(".gz") {
        Some(stem) => (stem, true),
        None => (name.as_str(), false),
    };
    match (stem.rsplit_once('.')?.1, gzip) {
        ("nrrd" | "nhdr", false) => Some(Format::Nrrd),
        ("nii" | "hdr" | "img", _) => Some(Format::Nifti),
        ("mhd" | "mha", false) => Some(Format::MetaImage),
        ("raw", gzip) => Some(Format::Raw { gzip }),
        _ => None,
    }
}

fn by_content(path: &Path, options: &RawOptions) -> Result<Format, VolumeError> {
    let (file, _) = source::open(path)?;
    let mut head = Vec::new();
    file.take(nifti::HEADER_BYTES as u64).read_to_end(&mut head).map_err(|e| VolumeError::io(path, e))?;
    let gzip = head.starts_with(&[0x1f, 0x8b]);
    if head.starts_with(b"NRRD") {
        Ok(Format::Nrrd)
    } else if nifti::is_header(&head) || (gzip && nifti::is_header(&unpacked_head(path)?)) {
        Ok(Format::Nifti)
    } else if metaimage::is_header(&head) {
        Ok(Format::MetaImage)
    } else if options.dims.is_some() && options.kind.is_some() {
        Ok(Format::Raw { gzip })
    } else {
        let remedy = "use .nrrd, .nhdr, .nii, .nii.gz, .hdr, .mhd, .mha, .raw or .raw.gz, or give `dims` and `type` \
                      for a headerless file";
        Err(VolumeError::unsupported(path, "is not a volume format known by name or content", remedy))
    }
}

/// The first bytes of a gzip stream, decompressed; fewer when it is short or damaged.
fn unpacked_head(path: &Path) -> Result<Vec<u8>, VolumeError> {
    let (file, _) = source::open(path)?;
    let mut head = Vec::new();
    // A damaged stream is no header; whichever reader takes the file says what is wrong with it.
    let _ = MultiGzDecoder::new(file).take(nifti::HEADER_BYTES as u64).read_to_end(&mut head);
    Ok(head)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_choose_the_reader() {
        let format = |name: &str| by_name(Path::new(name));
        assert_eq!(format("a.b/x.NRRD"), Some(Format::Nrrd));
        assert_eq!(format("x.nii.gz"), Some(Format::Nifti));
        assert_eq!(format("x.img"), Some(Format::Nifti));
        assert_eq!(format("x.mha"), Some(Format::MetaImage));
        assert_eq!(format("x_1x1x1_uint8.raw.gz"), Some(Format::Raw { gzip: true }));
        assert_eq!(format("x.dat"), None);
        assert_eq!(format("x"), None);
        assert_eq!(format("x.gz"), None);
    }
}
