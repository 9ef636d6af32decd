//! Headerless raw files, plain or gzip-compressed, x fastest.
//!
//! What the file cannot say comes from its name, `name_WxHxD_type.raw` or `….raw.gz` (the convention of the Open
//! SciVis Datasets), or from [`RawOptions`], which win.

use super::Volume;
use super::error::VolumeError;
use super::payload::{Coding, Excess, Payload, Start};
use super::stored::{Endian, StoredType, supported_types};
use glam::DVec3;
use std::path::Path;

/// What the reader of a headerless file cannot know. Files with a header take none of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RawOptions {
    /// Voxels along x, y, z; by default from the name.
    pub dims: Option<[usize; 3]>,
    /// Voxel type; by default from the name.
    pub kind: Option<StoredType>,
    /// Byte order; little by default.
    pub endian: Option<Endian>,
    /// Bytes before the first voxel, counted after decompression; 0 by default.
    pub offset: Option<u64>,
}

impl RawOptions {
    /// The keys that are given, as scene files spell them.
    pub(super) fn given(&self) -> Vec<&'static str> {
        let keys = [
            ("`dims`", self.dims.is_some()),
            ("`type`", self.kind.is_some()),
            ("`endian`", self.endian.is_some()),
            ("`offset`", self.offset.is_some()),
        ];
        keys.into_iter().filter(|(_, given)| *given).map(|(key, _)| key).collect()
    }
}

/// Reads a headerless file; `gzip` says whether it is compressed.
pub(super) fn read(path: &Path, gzip: bool, options: &RawOptions) -> Result<Volume, VolumeError> {
    let named = Named::parse(path);
    let dims = options.dims.or(named.dims);
    let kind = options.kind.or(named.kind);
    let (Some(dims), Some(kind)) = (dims, kind) else {
        return Err(incomplete(path, dims.is_none(), kind.is_none(), named.other));
    };
    let offset = options.offset.unwrap_or(0);
    let payload = Payload {
        path,
        dims,
        kind,
        order: options.endian.unwrap_or_default(),
        coding: if gzip { Coding::Gzip } else { Coding::Plain },
        start: Start::At(if gzip { 0 } else { offset }),
        skip: if gzip { offset } else { 0 },
        excess: Excess::Refuse,
    };
    payload.volume(DVec3::ONE, Vec::new())
}

/// What a file name says.
#[derive(Debug, Default, PartialEq)]
struct Named {
    dims: Option<[usize; 3]>,
    kind: Option<StoredType>,
    /// A type that looks like one but is not supported.
    other: Option<&'static str>,
}

impl Named {
    fn parse(path: &Path) -> Self {
        let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
        let mut named = Self::default();
        for part in name.split(['_', '.']) {
            named.dims = dims(part).or(named.dims);
            named.kind = StoredType::from_name(part).or(named.kind);
            let unsupported = ["int32", "uint32", "int64", "uint64"].into_iter().find(|other| *other == part);
            named.other = unsupported.or(named.other);
        }
        named
    }
}

/// `WxHxD`.
fn dims(text: &str) -> Option<[usize; 3]> {
    let mut numbers = text.split('x').map(|n| {
        let digits = !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit());
        digits.then(|| n.parse().ok()).flatten()
    });
    let dims = [numbers.next()??, numbers.next()??, numbers.next()??];
    numbers.next().is_none().then_some(dims)
}

fn incomplete(path: &Path, no_dims: bool, no_kind: bool, other: Option<&str>) -> VolumeError {
    let types = supported_types();
    if let (true, Some(other)) = (no_kind, other) {
        let problem = format!("its name says the voxels are {other}");
        return VolumeError::unsupported(path, problem, format!("convert them to one of {types}"));
    }
    let (lacks, keys) = match (no_dims, no_kind) {
        (true, true) => ("extents nor voxel type", "`dims = [W, H, D]` and `type`"),
        (true, false) => ("extents", "`dims = [W, H, D]`"),
        (false, _) => ("voxel type", "`type`"),
    };
    let verb = if no_dims && no_kind { "neither" } else { "no" };
    let problem = format!("is headerless and its name tells {verb} {lacks}");
    let mut remedy = format!("give {keys}, or name it like name_WxHxD_type.raw");
    if no_kind {
        remedy += &format!(" (types: {types})");
    }
    VolumeError::options(path, problem, remedy)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(name: &str) -> (Option<[usize; 3]>, Option<StoredType>) {
        let named = Named::parse(Path::new(name));
        (named.dims, named.kind)
    }

    #[test]
    fn names_tell_dims_and_type() {
        assert_eq!(named("a/bonsai_256x255x7_uint8.raw"), (Some([256, 255, 7]), Some(StoredType::U8)));
        assert_eq!(named("x_y_1x2x3_float64.raw.gz"), (Some([1, 2, 3]), Some(StoredType::F64)));
        assert_eq!(named("Head_4X5X6_INT16.RAW"), (Some([4, 5, 6]), Some(StoredType::I16)));
        assert_eq!(named("a_1x2_uint8.raw"), (None, Some(StoredType::U8)));
        assert_eq!(named("a_1x2x3x4_b.raw"), (None, None));
        assert_eq!(named("a_+1x2x3_b.raw"), (None, None));
        assert_eq!(named("a_99999999999999999999999x2x3_b.raw"), (None, None));
    }

    #[test]
    fn a_nameless_file_is_told_which_keys_to_give() {
        let text = |name: &str| read(Path::new(name), false, &RawOptions::default()).unwrap_err().to_string();
        let types = "(types: uint8, int8, uint16, int16, float32, float64)";
        assert_eq!(
            text("x.raw"),
            format!(
                "x.raw: is headerless and its name tells neither extents nor voxel type; give `dims = [W, H, D]` \
                 and `type`, or name it like name_WxHxD_type.raw {types}"
            )
        );
        assert!(text("x_uint8.raw").contains("tells no extents; give `dims = [W, H, D]`, or name it"));
        assert!(text("x_1x1x1.raw").contains("tells no voxel type; give `type`, or name it"));
        assert!(text("x_1x1x1_int32.raw").contains("says the voxels are int32; convert"));
    }
}
