//! NRRD volumes: attached headers (`.nrrd`) and detached ones (`.nhdr`) with one data file.
//!
//! Source: G. Kindlmann, *Definition of the NRRD File Format* (Teem). Of the orientation only the spacing is used.

use super::error::VolumeError;
use super::payload::{Coding, Excess, Payload, Start};
use super::source::{self, HeaderLines, three_axes};
use super::stored::{Endian, StoredType, supported_types};
use super::{Volume, Voxels};
use crate::picture::write_atomically;
use glam::DVec3;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

/// More axes than this are no array but damage; the format itself allows 16.
const MAX_AXES: usize = 16;

/// A grid of several numbers per cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Components {
    /// Numbers per cell.
    pub count: usize,
    /// Cells along x, y and z.
    pub dims: [usize; 3],
    /// Distance between cells along x, y and z, scene units.
    pub spacing: DVec3,
    /// Centre of the first cell, scene units.
    pub origin: DVec3,
    /// Keys and values of the header: free text about the data.
    pub keys: Vec<(String, String)>,
    /// The numbers: component fastest, then x.
    pub values: Vec<f32>,
}

impl Components {
    /// Reads a NRRD file whose first axis is that of the components, as [`Components::write`] writes it.
    ///
    /// # Errors
    /// [`VolumeError`] when the file is not of that form, or damaged.
    pub fn read(path: &Path) -> Result<Self, VolumeError> {
        let header = Header::read(path)?;
        let sizes = header.sizes()?;
        let right = || {
            header.wrong("sizes", header.get("sizes").unwrap_or_default(), "four sizes above 0 are needed")
        };
        let all: Option<Vec<usize>> =
            sizes.iter().map(|&n| usize::try_from(n).ok().filter(|&n| n > 0)).collect();
        let all: [usize; 4] = all.and_then(|all| all.try_into().ok()).ok_or_else(right)?;
        let [count, nx, ny, nz] = all;
        if header.kind()? != StoredType::F32 {
            return Err(header.wrong("type", header.need("type")?, "it must be `float`"));
        }
        let coding = header.coding()?;
        let (file, base) = header.data()?;
        let (start, skip) = header.start(&file, base, coding)?;
        let payload = Payload {
            path: &file,
            // The components of a row of cells follow each other.
            dims: [count.checked_mul(nx).ok_or_else(right)?, ny, nz],
            kind: StoredType::F32,
            order: header.order(StoredType::F32, coding)?,
            coding,
            start,
            skip,
            excess: Excess::Refuse,
        };
        let volume = payload.volume(DVec3::ONE, Vec::new())?;
        if volume.nan + volume.infinite > 0 {
            let found = volume.nan + volume.infinite;
            return Err(header.malformed(format!("{found} of its numbers are not finite"), "compute it anew"));
        }
        let values = match volume.voxels {
            Voxels::F32(values) => values,
            _ => return Err(header.malformed("its numbers are not float32", "compute it anew")),
        };
        let (spacing, origin) = header.placed()?;
        let keys = header.keys;
        Ok(Self { count, dims: [nx, ny, nz], spacing, origin, keys, values })
    }

    /// Writes a NRRD file of raw little-endian floats, replacing the file whole or not at all.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] with the path and the cause.
    pub fn write(&self, path: &Path) -> crate::Result<()> {
        write_atomically(path, |out| {
            let [nx, ny, nz] = self.dims;
            let [hx, hy, hz] = self.spacing.to_array();
            let [ox, oy, oz] = self.origin.to_array();
            writeln!(out, "NRRD0005")?;
            writeln!(out, "type: float\ndimension: 4\nsizes: {} {nx} {ny} {nz}", self.count)?;
            writeln!(out, "kinds: list domain domain domain\nspace dimension: 3")?;
            writeln!(out, "space directions: none ({hx},0,0) (0,{hy},0) (0,0,{hz})")?;
            writeln!(out, "space origin: ({ox},{oy},{oz})\nendian: little\nencoding: raw")?;
            for (key, value) in &self.keys {
                writeln!(out, "{key}:={value}")?;
            }
            writeln!(out)?;
            for part in self.values.chunks(1 << 14) {
                let bytes: Vec<u8> = part.iter().flat_map(|value| value.to_le_bytes()).collect();
                out.write_all(&bytes)?;
            }
            Ok(())
        })
    }

    /// The value of a key of the header.
    pub fn key(&self, key: &str) -> Option<&str> {
        self.keys.iter().find(|(name, _)| name == key).map(|(_, value)| value.as_str())
    }
}

/// Reads a NRRD volume.
pub(super) fn read(path: &Path) -> Result<Volume, VolumeError> {
    let header = Header::read(path)?;
    let sizes = header.sizes()?;
    let directions = header.directions(sizes.len())?;
    let no_direction = directions.as_ref().and_then(|all| all.iter().position(Option::is_none));
    let (dims, axes) = three_axes(path, &sizes, no_direction)?;
    let kind = header.kind()?;
    let coding = header.coding()?;
    let (file, base) = header.data()?;
    let mut notes = Vec::new();
    let spacing =
        source::spacing(header.spacings(&sizes, directions.as_deref(), axes, &mut notes)?, &mut notes);
    let (start, skip) = header.start(&file, base, coding)?;
    let payload = Payload {
        path: &file,
        dims,
        kind,
        order: header.order(kind, coding)?,
        coding,
        start,
        skip,
        excess: Excess::Note,
    };
    payload.volume(spacing, notes)
}

/// Direction of an axis in space; `None` for an axis that is not spatial.
type Direction = Option<Vec<f64>>;

struct Header<'a> {
    path: &'a Path,
    /// Lower-case name and description of each field, synonyms resolved.
    fields: BTreeMap<String, String>,
    /// Free text about the data.
    keys: Vec<(String, String)>,
    /// The byte behind the blank line that ends an attached header.
    end: Option<u64>,
}

impl<'a> Header<'a> {
    fn read(path: &'a Path) -> Result<Self, VolumeError> {
        let mut lines = HeaderLines::open(path)?;
        let magic = lines.next()?.unwrap_or_default();
        check_magic(path, magic.trim_end())?;
        let mut header = Self { path, fields: BTreeMap::new(), keys: Vec::new(), end: None };
        let mut number = 1;
        while let Some(line) = lines.next()? {
            number += 1;
            if line.trim().is_empty() {
                header.end = Some(lines.offset);
                break;
            }
            if !line.starts_with('#') {
                header.add(&line, number)?;
            }
        }
        Ok(header)
    }

    fn add(&mut self, line: &str, number: usize) -> Result<(), VolumeError> {
        let Some((name, description)) = line.split_once(':') else {
            let shown: String = line.chars().take(40).collect();
            let problem = format!("line {number} of its header is {shown:?}");
            return Err(
                self.malformed(problem, "write `field: value`, `key:=value`, `# comment` or a blank line")
            );
        };
        if let Some(value) = description.strip_prefix('=') {
            self.keys.push((name.to_owned(), value.trim_end().to_owned()));
            return Ok(());
        }
        let name = resolve(&name.trim().to_lowercase()).to_owned();
        if self.get(&name).is_some() {
            let problem = format!("line {number} of its header gives `{name}` again");
            return Err(self.malformed(problem, "give each field once"));
        }
        self.fields.insert(name, description.trim().to_owned());
        Ok(())
    }

    fn get(&self, name: &str) -> Option<&str> {
        self.fields.get(name).map(String::as_str)
    }

    fn need(&self, name: &str) -> Result<&str, VolumeError> {
        self.get(name).ok_or_else(|| {
            self.malformed(format!("its header has no `{name}`"), format!("add a `{name}: …` line"))
        })
    }

    fn malformed(&self, problem: impl Into<String>, remedy: impl Into<String>) -> VolumeError {
        VolumeError::malformed(self.path, problem, remedy)
    }

    fn wrong(&self, name: &str, given: &str, right: &str) -> VolumeError {
        let shown: String = given.chars().take(60).collect();
        self.malformed(format!("its header says `{name}: {shown}`"), right)
    }

    fn sizes(&self) -> Result<Vec<u64>, VolumeError> {
        let dimension = self.need("dimension")?;
        let count = dimension.parse::<usize>().ok().filter(|n| (1..=MAX_AXES).contains(n));
        let count =
            count.ok_or_else(|| self.wrong("dimension", dimension, "it must be 3, or 4 with one size 1"))?;
        let given = self.need("sizes")?;
        let sizes: Option<Vec<u64>> = given.split_whitespace().map(|size| size.parse().ok()).collect();
        sizes
            .filter(|sizes| sizes.len() == count)
            .ok_or_else(|| self.wrong("sizes", given, &format!("{count} whole numbers are needed")))
    }

    fn kind(&self) -> Result<StoredType, VolumeError> {
        let given = self.need("type")?;
        kind_of(&given.to_lowercase()).ok_or_else(|| {
            let remedy = format!("convert it to one of {}", supported_types());
            VolumeError::unsupported(self.path, format!("its voxel type is {given:?}"), remedy)
        })
    }

    fn coding(&self) -> Result<Coding, VolumeError> {
        let given = self.need("encoding")?;
        match given.to_lowercase().as_str() {
            "raw" => Ok(Coding::Plain),
            "gz" | "gzip" => Ok(Coding::Gzip),
            "txt" | "text" | "ascii" => Ok(Coding::Text),
            _ => {
                let problem = format!("its encoding is {given:?}");
                Err(VolumeError::unsupported(self.path, problem, "convert it to raw, gzip or ascii"))
            }
        }
    }

    fn order(&self, kind: StoredType, coding: Coding) -> Result<Endian, VolumeError> {
        match self.get("endian").map(str::to_lowercase).as_deref() {
            Some("little") => Ok(Endian::Little),
            Some("big") => Ok(Endian::Big),
            None if kind.bytes() == 1 || coding == Coding::Text => Ok(Endian::Little),
            None => {
                Err(self.malformed("its header has no `endian`", "add `endian: little` or `endian: big`"))
            }
            Some(other) => Err(self.wrong("endian", other, "it must be `little` or `big`")),
        }
    }

    /// The file with the voxels, and where in it their part begins.
    fn data(&self) -> Result<(PathBuf, u64), VolumeError> {
        let Some(name) = self.get("data file") else {
            let remedy = "end the header with a blank line before the data, or name them by `data file: …`";
            let end = self.end.ok_or_else(|| self.malformed("its header does not end", remedy))?;
            return Ok((self.path.to_owned(), end));
        };
        let pattern = name.contains('%') && name.split_whitespace().count() >= 4;
        if pattern || name.split_whitespace().next() == Some("LIST") {
            let problem = format!("its data are in several files (`data file: {name}`)");
            return Err(VolumeError::unsupported(self.path, problem, "join them into one file"));
        }
        Ok((source::beside(self.path, name), 0))
    }

    /// Where the data start in their file, and what to skip after decompression.
    fn start(&self, file: &Path, base: u64, coding: Coding) -> Result<(Start, u64), VolumeError> {
        let number = |name: &str| match self.get(name) {
            None => Ok(0),
            Some(given) => {
                given.parse::<i64>().map_err(|_| self.wrong(name, given, "a whole number is needed"))
            }
        };
        let (lines, bytes) = (number("line skip")?, number("byte skip")?);
        if bytes == -1 && coding == Coding::Plain {
            return Ok((Start::FromEnd, 0));
        }
        let lines = u64::try_from(lines)
            .map_err(|_| self.wrong("line skip", &lines.to_string(), "it must not be negative"))?;
        let skip = u64::try_from(bytes).map_err(|_| {
            self.wrong(
                "byte skip",
                &bytes.to_string(),
                "it must not be negative (except -1 with encoding raw)",
            )
        })?;
        let base = if lines == 0 { base } else { self.after_lines(file, base, lines)? };
        // Compressed data are skipped after decompression, all others in the file.
        Ok(match coding {
            Coding::Gzip | Coding::Zlib => (Start::At(base), skip),
            Coding::Plain | Coding::Text => (Start::At(base.saturating_add(skip)), 0),
        })
    }

    fn after_lines(&self, file: &Path, base: u64, lines: u64) -> Result<u64, VolumeError> {
        use std::io::{Seek, SeekFrom};
        let (mut opened, _) = source::open(file)?;
        opened.seek(SeekFrom::Start(base)).map_err(|e| VolumeError::io(file, e))?;
        let mut reader = BufReader::new(opened);
        let mut position = base;
        for line in 0..lines {
            let read = reader.skip_until(b'\n').map_err(|e| VolumeError::io(file, e))?;
            if read == 0 {
                let problem = format!("has {line} lines, of which `line skip: {lines}` should be skipped");
                return Err(VolumeError::length(file, problem, "correct `line skip` or complete the file"));
            }
            position += read as u64;
        }
        Ok(position)
    }

    /// Spacing and origin of a grid of components along the axes.
    fn placed(&self) -> Result<(DVec3, DVec3), VolumeError> {
        let given = self.need("space directions")?;
        let wrong = || self.wrong("space directions", given, "none and the axes are needed");
        let all = vectors(given).filter(|all| all.len() == 4 && all[0].is_none()).ok_or_else(wrong)?;
        let mut spacing = [0.0; 3];
        for (axis, direction) in all[1..].iter().enumerate() {
            let direction =
                direction.as_ref().filter(|d| d.len() == 3 && along(d, axis)).ok_or_else(wrong)?;
            spacing[axis] = direction[axis];
        }
        let given = self.need("space origin")?;
        let origin = match vectors(given).as_deref() {
            Some([Some(origin)]) if origin.len() == 3 => DVec3::from_slice(origin),
            _ => return Err(self.wrong("space origin", given, "it must be a point")),
        };
        Ok((spacing.into(), origin))
    }

    /// `space directions`, one entry per axis.
    fn directions(&self, count: usize) -> Result<Option<Vec<Direction>>, VolumeError> {
        let Some(given) = self.get("space directions") else { return Ok(None) };
        let right = "give one (x,y,z) or none per axis";
        let all = vectors(given).ok_or_else(|| self.wrong("space directions", given, right))?;
        if all.len() == count { Ok(Some(all)) } else { Err(self.wrong("space directions", given, right)) }
    }

    /// The spacing of the three kept axes, as given.
    fn spacings(
        &self,
        sizes: &[u64],
        directions: Option<&[Direction]>,
        axes: [usize; 3],
        notes: &mut Vec<String>,
    ) -> Result<[Option<f64>; 3], VolumeError> {
        if let Some(all) = directions {
            let kept = axes.map(|axis| all.get(axis).and_then(Option::as_deref));
            if kept.iter().enumerate().any(|(k, direction)| direction.is_some_and(|d| !along(d, k))) {
                notes.push("the space directions are not the positive axes: only the spacing is used".into());
            }
            return Ok(kept.map(|direction| direction.map(norm)));
        }
        let Some(given) = self.get("spacings") else { return Ok([None; 3]) };
        let all: Option<Vec<f64>> = given.split_whitespace().map(|h| h.parse().ok()).collect();
        let all = all
            .filter(|all| all.len() == sizes.len())
            .ok_or_else(|| self.wrong("spacings", given, &format!("{} numbers are needed", sizes.len())))?;
        Ok(axes.map(|axis| all.get(axis).copied()))
    }
}

fn check_magic(path: &Path, magic: &str) -> Result<(), VolumeError> {
    match magic {
        "NRRD0001" | "NRRD0002" | "NRRD0003" | "NRRD0004" | "NRRD0005" | "NRRD00.01" => Ok(()),
        other if other.starts_with("NRRD") => {
            let shown: String = other.chars().take(16).collect();
            let problem = format!("is of the unknown NRRD version {shown:?}");
            Err(VolumeError::unsupported(path, problem, "save it as NRRD0005 or older"))
        }
        _ => Err(VolumeError::malformed(path, "does not begin with NRRD", "check that this is a NRRD file")),
    }
}

/// The spelling of a field that this reader looks up.
fn resolve(name: &str) -> &str {
    match name {
        "datafile" => "data file",
        "lineskip" => "line skip",
        "byteskip" => "byte skip",
        other => other,
    }
}

/// The type for any spelling the format allows.
fn kind_of(name: &str) -> Option<StoredType> {
    Some(match name {
        "signed char" | "int8" | "int8_t" => StoredType::I8,
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => StoredType::U8,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => StoredType::I16,
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => StoredType::U16,
        "float" => StoredType::F32,
        "double" => StoredType::F64,
        _ => return None,
    })
}

/// `(1,0,0) none (0, 0, 2)` as vectors; `None` when it is not of that form.
fn vectors(text: &str) -> Option<Vec<Direction>> {
    let mut rest = text.trim();
    let mut all = Vec::new();
    while !rest.is_empty() {
        if let Some(after) = rest.strip_prefix("none") {
            all.push(None);
            rest = after.trim_start();
        } else {
            let (inner, after) = rest.strip_prefix('(')?.split_once(')')?;
            let numbers: Option<Vec<f64>> = inner.split(',').map(|n| n.trim().parse().ok()).collect();
            all.push(Some(numbers?));
            rest = after.trim_start();
        }
    }
    Some(all)
}

fn norm(vector: &[f64]) -> f64 {
    vector.iter().fold(0.0, |length: f64, c| length.hypot(*c))
}

/// Whether the vector points along the positive axis `axis` and nowhere else.
fn along(vector: &[f64], axis: usize) -> bool {
    vector.iter().enumerate().all(|(k, c)| if k == axis { *c > 0.0 } else { *c == 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_with_blanks_and_none() {
        let all = vectors("(1,0,0) none (0, -3, 4e0)").unwrap();
        assert_eq!(all, [Some(vec![1.0, 0.0, 0.0]), None, Some(vec![0.0, -3.0, 4.0])]);
        assert_eq!(norm(&[0.0, -3.0, 4.0]), 5.0);
        for bad in ["(1,0,0", "1,0,0)", "(1,x,0)", "nine", "()"] {
            assert_eq!(vectors(bad), None, "{bad}");
        }
    }

    #[test]
    fn only_the_positive_axes_are_along() {
        assert!(along(&[0.0, 2.0, 0.0], 1));
        assert!(!along(&[0.0, -2.0, 0.0], 1));
        assert!(!along(&[0.0, 2.0, 0.1], 1));
    }
}
