//! Opening files, and the parts of reading a text header that formats share.

use super::error::{VolumeError, shape};
use super::stored::StoredType;
use crate::input;
use glam::DVec3;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Take};
use std::path::{Path, PathBuf};

/// A text header longer than this is taken for damage; real ones have a few kilobytes.
const HEADER_LIMIT: u64 = 1 << 20;

/// Opens a regular file and tells its length in bytes.
///
/// Pipes, devices and folders are refused before they are opened, since opening a pipe would wait.
pub(super) fn open(path: &Path) -> Result<(File, u64), VolumeError> {
    input::open(path).map_err(|e| match e.kind() {
        io::ErrorKind::InvalidInput => VolumeError::not_a_file(path),
        _ => VolumeError::io(path, e),
    })
}

/// The file that `name` in the header at `header` means: relative names are relative to the header's folder.
pub(super) fn beside(header: &Path, name: &str) -> PathBuf {
    header.parent().unwrap_or(Path::new("")).join(name)
}

/// The lines of a text header, and the byte at which the next one starts.
pub(super) struct HeaderLines<'a> {
    path: &'a Path,
    reader: BufReader<Take<File>>,
    /// Bytes consumed so far.
    pub offset: u64,
}

impl<'a> HeaderLines<'a> {
    pub(super) fn open(path: &'a Path) -> Result<Self, VolumeError> {
        let (file, _) = open(path)?;
        Ok(Self { path, reader: BufReader::new(file.take(HEADER_LIMIT)), offset: 0 })
    }

    /// The next line without its end; bytes that are not UTF-8 are replaced. `None` at the end of the file.
    pub(super) fn next(&mut self) -> Result<Option<String>, VolumeError> {
        let mut line = Vec::new();
        let read = self.reader.read_until(b'\n', &mut line).map_err(|e| VolumeError::io(self.path, e))?;
        self.offset += read as u64;
        if self.offset >= HEADER_LIMIT {
            let problem = format!("its text header does not end within {HEADER_LIMIT} bytes");
            return Err(VolumeError::malformed(self.path, problem, "check that this is a volume file"));
        }
        let text = String::from_utf8_lossy(&line);
        Ok((read > 0).then(|| text.trim_end_matches(['\n', '\r']).to_owned()))
    }
}

/// The three extents among an array's sizes, and which of its axes they are.
///
/// A fourth axis is dropped when its size is 1; of several such axes `prefer` (an axis without a direction in
/// space) goes first, then the last.
pub(super) fn three_axes(
    path: &Path,
    sizes: &[u64],
    prefer: Option<usize>,
) -> Result<([usize; 3], [usize; 3]), VolumeError> {
    let sized_one = |axis: &usize| sizes.get(*axis) == Some(&1);
    let axes = match sizes.len() {
        3 => [0, 1, 2],
        4 => {
            let dropped = prefer.filter(sized_one).or_else(|| (0..4).rev().find(sized_one));
            let Some(dropped) = dropped else {
                let problem = format!("has 4 axes of sizes {sizes:?}");
                return Err(VolumeError::unsupported(
                    path,
                    problem,
                    "extract one scalar volume (3 axes) from it",
                ));
            };
            [0, 1, 2].map(|k| if k < dropped { k } else { k + 1 })
        }
        other => {
            let problem = format!("has {other} axes");
            return Err(VolumeError::unsupported(
                path,
                problem,
                "3 axes are needed (or 4 with one of size 1)",
            ));
        }
    };
    // A size beyond usize saturates: it is refused as too large by the grid check that follows.
    let dims = axes.map(|axis| usize::try_from(sizes[axis]).unwrap_or(usize::MAX));
    Ok((dims, axes))
}

/// A usable spacing from what a header says, with a note for each repair. `None` stands for "not given".
pub(super) fn spacing(given: [Option<f64>; 3], notes: &mut Vec<String>) -> DVec3 {
    let mut repaired = [1.0; 3];
    for ((out, given), axis) in repaired.iter_mut().zip(given).zip(["x", "y", "z"]) {
        *out = match given {
            None => 1.0,
            Some(h) if h.is_finite() && h > 0.0 => h,
            Some(h) if h.is_finite() && h < 0.0 => {
                notes.push(format!("the spacing along {axis} is {h}: its absolute value is used"));
                -h
            }
            Some(h) => {
                notes.push(format!("the spacing along {axis} is {h}: 1 is used"));
                1.0
            }
        };
    }
    DVec3::from_array(repaired)
}

/// `WxHxD type`, as messages name a grid.
pub(super) fn describe(dims: &[usize; 3], kind: StoredType) -> String {
    format!("{} {}", shape(dims), kind.name())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axis_of_size_one_goes() {
        let axes =
            |sizes: &[u64], prefer| three_axes(Path::new("f"), sizes, prefer).map(|(dims, _)| dims).ok();
        assert_eq!(axes(&[1, 5, 6, 7], None), Some([5, 6, 7]));
        assert_eq!(axes(&[5, 6, 7, 1], None), Some([5, 6, 7]));
        assert_eq!(axes(&[1, 6, 7, 1], None), Some([1, 6, 7]));
        assert_eq!(axes(&[1, 6, 7, 1], Some(0)), Some([6, 7, 1]));
        assert_eq!(axes(&[3, 6, 7, 2], Some(0)), None);
        assert_eq!(axes(&[6, 7], None), None);
    }

    #[test]
    fn spacings_are_repaired_with_a_note() {
        let mut notes = Vec::new();
        let h = spacing([Some(-2.0), Some(f64::NAN), None], &mut notes);
        assert_eq!(h, DVec3::new(2.0, 1.0, 1.0));
        assert_eq!(notes.len(), 2, "{notes:?}");
    }
}
