//! Files that users name, opened only where reading them comes to an end.
//!
//! A pipe makes whoever opens it wait, a device such as `/dev/zero` never ends, and a folder fails with a riddle: they
//! are refused before they are opened. Scenes and suites alone may come from a pipe, see `config`.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

/// Opens a regular file, and tells its length in bytes.
///
/// # Errors
/// What the system says, or [`io::ErrorKind::InvalidInput`] for what is no regular file.
pub(crate) fn open(path: &Path) -> io::Result<(File, u64)> {
    regular(&fs::metadata(path)?)?;
    let file = File::open(path)?;
    // Whoever replaced it in between has not made it another kind of file.
    let length = regular(&file.metadata()?)?;
    Ok((file, length))
}

/// The bytes of a regular file: as many as it had when it was opened, at most.
///
/// # Errors
/// As [`open`].
pub(crate) fn bytes(path: &Path) -> io::Result<Vec<u8>> {
    let (file, length) = open(path)?;
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(usize::try_from(length).unwrap_or(usize::MAX))?;
    file.take(length).read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn regular(meta: &fs::Metadata) -> io::Result<u64> {
    if meta.is_file() {
        return Ok(meta.len());
    }
    let what = if meta.is_dir() { "it is a folder" } else { "it is not a regular file" };
    Err(io::Error::new(io::ErrorKind::InvalidInput, what))
}

/// The most bytes that are taken for what a file claims without a look at all of it: four times its length, and 64 MiB.
/// Compressed files may hold more; whether one does is found by unpacking it once and keeping nothing.
pub(crate) fn credible(length: u64) -> u64 {
    length.saturating_mul(4).saturating_add(64 << 20)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_file_is_refused_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        for path in [&pipe, Path::new("/dev/zero")] {
            let error = bytes(path).unwrap_err();
            assert_eq!(
                (error.kind(), error.to_string().as_str()),
                (io::ErrorKind::InvalidInput, "it is not a regular file")
            );
        }
        assert_eq!(bytes(folder.path()).unwrap_err().to_string(), "it is a folder");
        fs::write(folder.path().join("file"), "text").unwrap();
        assert_eq!(bytes(&folder.path().join("file")).unwrap(), b"text");
    }
}
