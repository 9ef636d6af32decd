//! Reads the text of a scene or suite.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::error::{Error, Result};

/// Largest file in bytes. Scenes are a few kilobytes; this is more likely a volume.
const LARGEST: u64 = 16 << 20;

/// The text of a scene or suite (`noun`), without a byte order mark.
///
/// # Errors
/// [`Error::Input`] if it is missing, a directory, larger than 16 MiB, or not UTF-8.
pub(super) fn read(path: &Path, noun: &str) -> Result<String> {
    let name = path.display();
    let fail = |reason: String| Error::Input(format!("cannot read the {noun} {name}: {reason}"));
    if path.is_dir() {
        return Err(fail("it is a directory".into()));
    }
    let file = File::open(path).map_err(|error| fail(reason(&error)))?;
    let mut bytes = Vec::new();
    file.take(LARGEST + 1).read_to_end(&mut bytes).map_err(|error| fail(reason(&error)))?;
    if bytes.len() as u64 > LARGEST {
        return Err(fail(format!("it is larger than 16 MiB; a {noun} is a short TOML text")));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let line = error.as_bytes()[..valid].iter().filter(|&&byte| byte == b'\n').count() + 1;
        fail(format!("it is not UTF-8 text (byte {valid}, line {line})"))
    })?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

fn reason(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".into(),
        std::io::ErrorKind::PermissionDenied => "permission denied".into(),
        _ => error.to_string(),
    }
}
