//! Voxels written as decimal numbers (NRRD `encoding: ascii`, MetaImage `BinaryData = False`).

use super::error::VolumeError;
use super::payload::Payload;
use super::source::describe;
use super::stored::{Stored, with_stored};
use super::voxels::{Voxel, Voxels};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

/// Reads the numbers from where the payload starts; blanks and commas separate them.
pub(super) fn load(
    payload: &Payload<'_>,
    mut file: File,
    length: u64,
    notes: &mut Vec<String>,
) -> Result<Voxels, VolumeError> {
    let path = payload.path;
    let begin = payload.start(length)?;
    // A number takes a digit and a separator, so a file too short for the grid is refused before any allocation.
    let most = (length - begin).div_ceil(2);
    if most < payload.count() as u64 {
        return Err(too_few(payload, &format!("room for at most {most}")));
    }
    file.seek(SeekFrom::Start(begin)).map_err(|e| VolumeError::io(path, e))?;
    let mut bytes = Vec::new();
    let room = usize::try_from(length - begin).unwrap_or(usize::MAX);
    bytes.try_reserve_exact(room).map_err(|_| VolumeError::memory(path, length - begin))?;
    file.take(length - begin).read_to_end(&mut bytes).map_err(|e| VolumeError::io(path, e))?;
    with_stored!(payload.kind, T => numbers::<T>(payload, &bytes, notes))
}

fn numbers<T: Stored>(
    payload: &Payload<'_>,
    text: &[u8],
    notes: &mut Vec<String>,
) -> Result<Voxels, VolumeError> {
    let is_between = |byte: &u8| byte.is_ascii_whitespace() || *byte == b',';
    let mut tokens = text.split(is_between).filter(|token| !token.is_empty());
    let mut values: Vec<T::Kept> = Vec::new();
    let bytes = (payload.count() * size_of::<T::Kept>()) as u64;
    values.try_reserve_exact(payload.count()).map_err(|_| VolumeError::memory(payload.path, bytes))?;
    for token in tokens.by_ref().take(payload.count()) {
        let Some(value) = std::str::from_utf8(token).ok().and_then(T::parse) else {
            let shown: String =
                String::from_utf8_lossy(&token[..token.len().min(80)]).chars().take(20).collect();
            let problem = format!("its number {} is {shown:?}", values.len() + 1);
            let remedy = format!("write a {} there", payload.kind.name());
            return Err(VolumeError::malformed(payload.path, problem, remedy));
        };
        values.push(value);
    }
    if values.len() < payload.count() {
        return Err(too_few(payload, &format!("found {}", values.len())));
    }
    if tokens.next().is_some() {
        payload.beyond("more numbers", notes)?;
    }
    Ok(T::Kept::voxels(values))
}

fn too_few(payload: &Payload<'_>, found: &str) -> VolumeError {
    let (count, grid) = (payload.count(), describe(&payload.dims, payload.kind));
    let problem = format!("expected {count} numbers ({grid}), {found}");
    VolumeError::length(payload.path, problem, "complete the file or correct the sizes")
}
