//! MetaImage volumes: `.mha` (data in the file) and `.mhd` (data beside it).
//!
//! Source: the MetaIO documentation of ITK. Of the orientation only the spacing is used.

use super::Volume;
use super::error::VolumeError;
use super::payload::{Coding, Excess, Payload, Start};
use super::source::{self, HeaderLines, three_axes};
use super::stored::{Endian, StoredType, supported_types};
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Whether the first bytes of a file are those of a MetaImage header.
pub(super) fn is_header(head: &[u8]) -> bool {
    head.starts_with(b"ObjectType") || head.starts_with(b"NDims")
}

/// Reads a MetaImage volume.
pub(super) fn read(path: &Path) -> Result<Volume, VolumeError> {
    let header = Header::read(path)?;
    let sizes = header.sizes()?;
    let (dims, axes) = three_axes(path, &sizes, None)?;
    header.check_channels()?;
    let (slope, intercept) = header.rescaling()?;
    let (file, base) = header.data()?;
    let mut notes = header.notes();
    let spacing = source::spacing(header.spacings(sizes.len(), axes)?, &mut notes);
    let start = header.start(base)?;
    let payload = Payload {
        path: &file,
        dims,
        kind: header.kind()?,
        order: header.order()?,
        coding: header.coding(&file, start)?,
        start,
        skip: 0,
        excess: Excess::Note,
    };
    let volume = payload.volume(spacing, notes)?;
    Ok(Volume { slope, intercept, ..volume })
}

struct Header<'a> {
    path: &'a Path,
    /// Lower-case key, key as written, value.
    entries: Vec<(String, String, String)>,
    /// The byte behind the `ElementDataFile` line.
    end: u64,
}

impl<'a> Header<'a> {
    fn read(path: &'a Path) -> Result<Self, VolumeError> {
        let mut lines = HeaderLines::open(path)?;
        let mut header = Self { path, entries: Vec::new(), end: 0 };
        let mut number = 0;
        while let Some(line) = lines.next()? {
            number += 1;
            if line.trim().is_empty() {
                continue;
            }
            let Some((key, value)) = line.split_once('=') else {
                let shown: String = line.chars().take(40).collect();
                let problem = format!("line {number} of its header is {shown:?}");
                return Err(
                    header.malformed(problem, "write `Key = value` lines, the last one ElementDataFile")
                );
            };
            let (key, value) = (key.trim(), value.trim());
            header.entries.push((key.to_lowercase(), key.to_owned(), value.to_owned()));
            header.end = lines.offset;
            if key.eq_ignore_ascii_case("ElementDataFile") {
                return Ok(header);
            }
        }
        Err(header.malformed("its header has no `ElementDataFile`", "name the data file there, or LOCAL"))
    }

    /// The first value of any of these keys, with the key as written.
    fn get(&self, keys: &[&str]) -> Option<(&str, &str)> {
        let found = keys.iter().find_map(|key| {
            let key = key.to_lowercase();
            self.entries.iter().find(|(lower, ..)| *lower == key)
        })?;
        Some((&found.1, &found.2))
    }

    fn need(&self, key: &str) -> Result<&str, VolumeError> {
        self.get(&[key]).map(|(_, value)| value).ok_or_else(|| {
            self.malformed(format!("its header has no `{key}`"), format!("add a `{key} = …` line"))
        })
    }

    fn malformed(&self, problem: impl Into<String>, remedy: impl Into<String>) -> VolumeError {
        VolumeError::malformed(self.path, problem, remedy)
    }

    fn wrong(&self, key: &str, given: &str, right: &str) -> VolumeError {
        let shown: String = given.chars().take(60).collect();
        self.malformed(format!("its header says `{key} = {shown}`"), right)
    }

    fn sizes(&self) -> Result<Vec<u64>, VolumeError> {
        let dimensions = self.need("NDims")?;
        let count =
            dimensions.parse::<usize>().map_err(|_| self.wrong("NDims", dimensions, "it must be 3 or 4"))?;
        let given = self.need("DimSize")?;
        let sizes: Option<Vec<u64>> = given.split_whitespace().map(|size| size.parse().ok()).collect();
        sizes
            .filter(|sizes| sizes.len() == count)
            .ok_or_else(|| self.wrong("DimSize", given, &format!("{count} whole numbers are needed")))
    }

    fn check_channels(&self) -> Result<(), VolumeError> {
        match self.get(&["ElementNumberOfChannels"]) {
            None | Some((_, "1")) => Ok(()),
            Some((_, other)) => {
                let problem = format!("has {other} channels per voxel");
                Err(VolumeError::unsupported(self.path, problem, "extract one channel"))
            }
        }
    }

    fn kind(&self) -> Result<StoredType, VolumeError> {
        let given = self.need("ElementType")?;
        Ok(match given {
            "MET_CHAR" => StoredType::I8,
            "MET_UCHAR" => StoredType::U8,
            "MET_SHORT" => StoredType::I16,
            "MET_USHORT" => StoredType::U16,
            "MET_FLOAT" => StoredType::F32,
            "MET_DOUBLE" => StoredType::F64,
            other => {
                let shown: String = other.chars().take(40).collect();
                let problem = format!("its voxel type is {shown}");
                let remedy = format!("convert it to one of {}", supported_types());
                return Err(VolumeError::unsupported(self.path, problem, remedy));
            }
        })
    }

    fn flag(&self, keys: &[&str], default: bool) -> Result<bool, VolumeError> {
        let Some((key, value)) = self.get(keys) else { return Ok(default) };
        match value.to_lowercase().as_str() {
            "true" | "t" | "1" => Ok(true),
            "false" | "f" | "0" => Ok(false),
            _ => Err(self.wrong(key, value, "it must be True or False")),
        }
    }

    fn order(&self) -> Result<Endian, VolumeError> {
        let big = self.flag(&["ElementByteOrderMSB", "BinaryDataByteOrderMSB"], false)?;
        Ok(if big { Endian::Big } else { Endian::Little })
    }

    /// How the data are written. MetaIO writes zlib streams but also accepts gzip, so the first bytes decide.
    fn coding(&self, file: &Path, start: Start) -> Result<Coding, VolumeError> {
        if !self.flag(&["CompressedData"], false)? {
            let binary = self.flag(&["BinaryData"], true)?;
            return Ok(if binary { Coding::Plain } else { Coding::Text });
        }
        let Start::At(offset) = start else {
            let problem = "its header says both `CompressedData = True` and `HeaderSize = -1`";
            return Err(self.malformed(problem, "give the size of the header in bytes"));
        };
        let (mut opened, _) = source::open(file)?;
        let mut magic = Vec::new();
        opened
            .seek(SeekFrom::Start(offset))
            .and_then(|_| opened.take(2).read_to_end(&mut magic))
            .map_err(|e| VolumeError::io(file, e))?;
        Ok(if magic == [0x1f, 0x8b] { Coding::Gzip } else { Coding::Zlib })
    }

    /// The file with the voxels, and where in it their part begins.
    fn data(&self) -> Result<(PathBuf, u64), VolumeError> {
        let name = self.need("ElementDataFile")?;
        if name.eq_ignore_ascii_case("LOCAL") {
            return Ok((self.path.to_owned(), self.end));
        }
        let first = name.split_whitespace().next().unwrap_or_default();
        if first == "LIST" || (name.contains('%') && name.split_whitespace().count() >= 3) {
            let problem = format!("its data are in several files (`ElementDataFile = {name}`)");
            return Err(VolumeError::unsupported(self.path, problem, "join them into one file"));
        }
        if name.is_empty() {
            return Err(self.wrong("ElementDataFile", name, "name the data file, or LOCAL"));
        }
        Ok((source::beside(self.path, name), 0))
    }

    fn start(&self, base: u64) -> Result<Start, VolumeError> {
        let Some((key, given)) = self.get(&["HeaderSize"]) else { return Ok(Start::At(base)) };
        match given.parse::<i64>() {
            Ok(-1) => Ok(Start::FromEnd),
            // Of a file with its own header, the size counts from the beginning when it is given at all.
            Ok(size) if size >= 0 => Ok(Start::At(base.max(size.unsigned_abs()))),
            _ => Err(self.wrong(key, given, "it must be a number of bytes, or -1 for data at the end")),
        }
    }

    fn spacings(&self, count: usize, axes: [usize; 3]) -> Result<[Option<f64>; 3], VolumeError> {
        let Some((key, given)) = self.get(&["ElementSpacing", "ElementSize"]) else { return Ok([None; 3]) };
        let all: Option<Vec<f64>> = given.split_whitespace().map(|h| h.parse().ok()).collect();
        let all = all
            .filter(|all| all.len() == count)
            .ok_or_else(|| self.wrong(key, given, &format!("{count} numbers are needed")))?;
        Ok(axes.map(|axis| all.get(axis).copied()))
    }

    /// Data value = slope · stored value + intercept.
    fn rescaling(&self) -> Result<(f64, f64), VolumeError> {
        let number = |key: &str, default: f64| match self.get(&[key]) {
            None => Ok(default),
            Some((key, given)) => given
                .parse::<f64>()
                .ok()
                .filter(|n| n.is_finite())
                .ok_or_else(|| self.wrong(key, given, "a finite number is needed")),
        };
        let slope = number("ElementToIntensityFunctionSlope", 1.0)?;
        let intercept = number("ElementToIntensityFunctionOffset", 0.0)?;
        if slope == 0.0 {
            return Err(self.wrong("ElementToIntensityFunctionSlope", "0", "a slope other than 0 is needed"));
        }
        Ok((slope, intercept))
    }

    fn notes(&self) -> Vec<String> {
        let matrix = self.get(&["TransformMatrix", "Rotation", "Orientation"]).map(|(_, value)| value);
        let numbers: Vec<f64> =
            matrix.unwrap_or_default().split_whitespace().filter_map(|n| n.parse().ok()).collect();
        let side = numbers.len().isqrt();
        let identity =
            numbers.iter().enumerate().all(|(i, n)| *n == f64::from(u8::from(i % (side + 1) == 0)));
        if identity {
            return Vec::new();
        }
        vec!["the transform matrix is not the identity: only the spacing is used".into()]
    }
}
