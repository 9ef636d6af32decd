//! From the bytes behind a header to voxels, whatever the format of the header was.
//!
//! Nothing is allocated that the file does not justify: plain data are checked against its length first, and so are
//! compressed data, or, where they could yield more than four times that, by decompressing them once for nothing.

use super::error::VolumeError;
use super::source::{self, describe};
use super::stored::{Endian, Stored, StoredType, with_stored};
use super::text;
use super::voxels::{Voxel, Voxels};
use super::{Volume, voxel_count};
use crate::{host_memory, input};
use bytemuck::Zeroable;
use flate2::bufread::{MultiGzDecoder, ZlibDecoder};
use glam::DVec3;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// Bytes decoded at a time; a multiple of every voxel size.
const CHUNK: usize = 1 << 20;

/// Where the data begin in their file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Start {
    /// So many bytes from the beginning.
    At(u64),
    /// So that the last voxel ends with the file.
    FromEnd,
}

/// How the voxels are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Coding {
    Plain,
    Gzip,
    Zlib,
    /// Decimal numbers between blanks or commas.
    Text,
}

/// What data beyond the last voxel mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Excess {
    /// The description of the grid is wrong: without a header, length is the only check there is.
    Refuse,
    /// Harmless, but worth a remark.
    Note,
}

/// Everything a header says about the voxels.
pub(super) struct Payload<'a> {
    pub path: &'a Path,
    pub dims: [usize; 3],
    pub kind: StoredType,
    pub order: Endian,
    pub coding: Coding,
    pub start: Start,
    /// Bytes to skip after decompression.
    pub skip: u64,
    pub excess: Excess,
}

/// Why a stream did not fill the grid.
enum Shortfall {
    /// It ended, or was damaged, after so many bytes of voxels.
    Ended(u64, Option<io::Error>),
    Memory,
}

impl Payload<'_> {
    /// Reads the voxels into a volume with that spacing.
    pub(super) fn volume(&self, spacing: DVec3, mut notes: Vec<String>) -> Result<Volume, VolumeError> {
        voxel_count(self.dims).map_err(|e| VolumeError::grid(self.path, &e))?;
        let voxels = self.load(&mut notes)?;
        if self.kind == StoredType::F64 {
            notes.push("float64 voxels are stored as float32".into());
        }
        let volume = Volume::new(self.dims, spacing, voxels).map_err(|e| VolumeError::grid(self.path, &e))?;
        Ok(Volume { notes, ..volume })
    }

    fn load(&self, notes: &mut Vec<String>) -> Result<Voxels, VolumeError> {
        let (file, length) = source::open(self.path)?;
        match self.coding {
            Coding::Plain => self.plain(file, length, notes),
            Coding::Text => text::load(self, file, length, notes),
            Coding::Gzip => self.packed(file, length, notes, MultiGzDecoder::new),
            Coding::Zlib => self.packed(file, length, notes, ZlibDecoder::new),
        }
    }

    /// Voxels of the grid. `volume` has checked that this does not overflow.
    pub(super) fn count(&self) -> usize {
        self.dims.iter().product()
    }

    fn bytes(&self) -> u64 {
        self.count() as u64 * self.kind.bytes() as u64
    }

    /// The byte the data begin at, once known to lie within the file.
    pub(super) fn start(&self, length: u64) -> Result<u64, VolumeError> {
        let start = match self.start {
            Start::At(start) => start,
            Start::FromEnd => length.checked_sub(self.bytes()).ok_or_else(|| self.short(length))?,
        };
        if start > length {
            let problem = format!("its data should begin at byte {start}, but it has only {length} bytes");
            return Err(VolumeError::length(self.path, problem, "correct the offset or complete the file"));
        }
        Ok(start)
    }

    fn plain(&self, mut file: File, length: u64, notes: &mut Vec<String>) -> Result<Voxels, VolumeError> {
        let begin = self.start(length)?.saturating_add(self.skip).min(length);
        let found = length - begin;
        if found < self.bytes() {
            return Err(self.short(found));
        }
        if found > self.bytes() {
            self.beyond(&format!("{found} bytes"), notes)?;
        }
        file.seek(SeekFrom::Start(begin)).map_err(|e| VolumeError::io(self.path, e))?;
        self.collect(&mut file, self.count())
    }

    fn packed<D: Read>(
        &self,
        file: File,
        length: u64,
        notes: &mut Vec<String>,
        decoder: impl Fn(BufReader<File>) -> D,
    ) -> Result<Voxels, VolumeError> {
        let begin = self.start(length)?;
        if self.kept_bytes() > input::credible(length) {
            self.check_all_there(&mut self.unpacked(&file, begin, &decoder)?)?;
        }
        let mut stream = self.unpacked(&file, begin, &decoder)?;
        let voxels = self.collect(&mut stream, 0)?;
        // One byte more also makes the decoder reach and verify the checksum at the end of the stream.
        match read_some(&mut stream, &mut [0]) {
            Ok(0) => {}
            Ok(_) => self.beyond("more", notes)?,
            Err(e) => return Err(self.damaged(self.bytes(), &e)),
        }
        Ok(voxels)
    }

    /// The decompressed data from the first voxel on.
    fn unpacked<D: Read>(
        &self,
        file: &File,
        begin: u64,
        decoder: impl Fn(BufReader<File>) -> D,
    ) -> Result<D, VolumeError> {
        let mut file = file.try_clone().map_err(|e| VolumeError::io(self.path, e))?;
        file.seek(SeekFrom::Start(begin)).map_err(|e| VolumeError::io(self.path, e))?;
        let mut stream = decoder(BufReader::with_capacity(CHUNK / 4, file));
        let skipped = io::copy(&mut stream.by_ref().take(self.skip), &mut io::sink())
            .map_err(|e| self.damaged(0, &e))?;
        if skipped < self.skip {
            return Err(self.short(0));
        }
        Ok(stream)
    }

    /// Decompresses all voxels and keeps none: so much is allocated only once it is known to be there.
    fn check_all_there(&self, stream: &mut impl Read) -> Result<(), VolumeError> {
        let mut chunk = vec![0; CHUNK];
        let mut found = 0;
        while found < self.bytes() {
            let wanted = usize::try_from(self.bytes() - found).unwrap_or(CHUNK).min(CHUNK);
            let (read, error) = read_fully(stream, &mut chunk[..wanted]);
            found += read as u64;
            if read < wanted {
                return Err(error.map_or_else(|| self.short(found), |e| self.damaged(found, &e)));
            }
        }
        Ok(())
    }

    /// Bytes of the voxels in memory.
    fn kept_bytes(&self) -> u64 {
        let each = with_stored!(self.kind, T => size_of::<<T as Stored>::Kept>());
        self.count() as u64 * each as u64
    }

    fn collect(&self, reader: &mut impl Read, reserve: usize) -> Result<Voxels, VolumeError> {
        if host_memory::available().is_some_and(|available| self.kept_bytes() > available) {
            return Err(VolumeError::memory(self.path, self.kept_bytes()));
        }
        let voxels = with_stored!(self.kind, T => {
            fill::<T>(reader, self.order, self.count(), reserve).map(<T as Stored>::Kept::voxels)
        });
        voxels.map_err(|shortfall| match shortfall {
            Shortfall::Ended(found, None) => self.short(found),
            Shortfall::Ended(found, Some(e)) => self.damaged(found, &e),
            Shortfall::Memory => VolumeError::memory(self.path, self.bytes()),
        })
    }

    fn short(&self, found: u64) -> VolumeError {
        let grid = describe(&self.dims, self.kind);
        let problem = format!("expected {} bytes of voxels ({grid}), found {found}", self.bytes());
        VolumeError::length(self.path, problem, "complete the file or correct the sizes and the type")
    }

    fn damaged(&self, found: u64, error: &io::Error) -> VolumeError {
        if error.kind() == io::ErrorKind::UnexpectedEof && found < self.bytes() {
            return self.short(found);
        }
        if self.coding == Coding::Plain {
            return VolumeError::io(self.path, io::Error::new(error.kind(), error.to_string()));
        }
        let problem =
            format!("its compressed data are damaged after {found} of {} bytes ({error})", self.bytes());
        VolumeError::malformed(self.path, problem, "fetch or compress the file again")
    }

    /// There is more than the grid needs; `found` says how much in words.
    pub(super) fn beyond(&self, found: &str, notes: &mut Vec<String>) -> Result<(), VolumeError> {
        let (bytes, grid) = (self.bytes(), describe(&self.dims, self.kind));
        match self.excess {
            Excess::Refuse => {
                let problem = format!("expected {bytes} bytes of voxels ({grid}), found {found}");
                Err(VolumeError::length(self.path, problem, "correct `dims`, `type` or `offset`"))
            }
            Excess::Note => {
                notes.push(format!(
                    "the grid takes {bytes} bytes ({grid}), found {found}: the rest is ignored"
                ));
                Ok(())
            }
        }
    }
}

/// Decodes `count` voxels, of which `reserve` are allocated beforehand.
fn fill<T: Stored>(
    reader: &mut impl Read,
    order: Endian,
    count: usize,
    reserve: usize,
) -> Result<Vec<T::Kept>, Shortfall> {
    let mut values: Vec<T::Kept> = Vec::new();
    values.try_reserve_exact(reserve).map_err(|_| Shortfall::Memory)?;
    let as_they_are = T::BYTES == size_of::<T::Kept>() && (T::BYTES == 1 || order == Endian::NATIVE);
    if as_they_are && reserve == count {
        values.resize(count, T::Kept::zeroed());
        let (read, error) = read_fully(reader, bytemuck::cast_slice_mut(&mut values));
        let whole = read == count * T::BYTES;
        return if whole { Ok(values) } else { Err(Shortfall::Ended(read as u64, error)) };
    }
    let mut chunk = vec![0; CHUNK.min(count * T::BYTES)];
    while values.len() < count {
        let wanted = chunk.len().min((count - values.len()) * T::BYTES);
        let (read, error) = read_fully(reader, &mut chunk[..wanted]);
        if read < wanted {
            return Err(Shortfall::Ended((values.len() * T::BYTES + read) as u64, error));
        }
        grow(&mut values, wanted / T::BYTES, count)?;
        values.extend(chunk[..wanted].chunks_exact(T::BYTES).filter_map(|bytes| T::decode(bytes, order)));
    }
    Ok(values)
}

/// Makes room for `more` values by doubling, never beyond `limit` values in all.
fn grow<T>(values: &mut Vec<T>, more: usize, limit: usize) -> Result<(), Shortfall> {
    let needed = values.len() + more;
    if needed <= values.capacity() {
        return Ok(());
    }
    let target = values.capacity().saturating_mul(2).clamp(needed, limit.max(needed));
    values.try_reserve_exact(target - values.len()).map_err(|_| Shortfall::Memory)
}

/// Fills the buffer as far as the stream goes, and says how far and why no further.
fn read_fully(reader: &mut impl Read, buffer: &mut [u8]) -> (usize, Option<io::Error>) {
    let mut filled = 0;
    while filled < buffer.len() {
        match read_some(reader, &mut buffer[filled..]) {
            Ok(0) => break,
            Ok(read) => filled += read,
            Err(e) => return (filled, Some(e)),
        }
    }
    (filled, None)
}

fn read_some(reader: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    loop {
        match reader.read(buffer) {
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            other => return other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The length was right when the file was opened.
    #[test]
    fn a_file_that_shrinks_while_it_is_read_is_short() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.raw");
        std::fs::write(&path, [7; 5]).unwrap();
        for (kind, order) in [(StoredType::U8, Endian::Little), (StoredType::U16, Endian::Big)] {
            let payload = Payload {
                path: &path,
                dims: [8 / kind.bytes(), 1, 1],
                kind,
                order,
                coding: Coding::Plain,
                start: Start::At(0),
                skip: 0,
                excess: Excess::Refuse,
            };
            let error = payload.plain(File::open(&path).unwrap(), 8, &mut Vec::new()).unwrap_err();
            let text = error.to_string();
            assert!(text.contains("expected 8 bytes of voxels") && text.contains("found 5"), "{text}");
        }
    }
}
