//! Pictures on disk: EXR and PNG, written atomically, and tone mapping.
//!
//! A [`Picture`] is a set of named planes of linear data with text metadata. EXR holds all of it
//! without loss; PNG is a display-referred preview made by a [`Tonemap`]. Every file is replaced
//! whole or not at all ([`write_atomically`]).

mod atomic;
mod environment;
mod exr;
mod exr_lent;
mod png;
mod tonemap;
mod types;

pub use atomic::{check_writable, remove_leftovers, write_atomically};
pub use environment::{Environment, MAX_TEXELS};
pub use exr::{MAX_BYTES, MAX_PIXELS, read_exr, read_exr_header, write_exr};
pub use png::{read_png, write_png, write_png_rgb8};
pub use tonemap::{BAD_PIXEL, Curve, Encoding, Tonemap, srgb_decode, srgb_encode};
pub use types::{Channel, Picture, Plane, Samples};

use std::{io::Read, path::Path};

use crate::error::{Error, Result};
use crate::input;

/// Reads an EXR or PNG file; the first bytes of the file decide which, not its name.
///
/// EXR samples come as stored. PNG samples are decoded to linear light, see [`read_png`].
///
/// # Errors
/// [`Error::Input`] where the file cannot be opened, is neither format, or is damaged.
pub fn read_picture(path: &Path) -> Result<Picture> {
    let mut magic = [0; 4];
    let found = input::open(path)
        .and_then(|(mut file, _)| file.read_exact(&mut magic))
        .map(|()| magic)
        .map_err(|cause| unreadable(path, &cause))?;
    match found {
        [0x76, 0x2f, 0x31, 0x01] => read_exr(path),
        [0x89, b'P', b'N', b'G'] => read_png(path),
        _ => Err(Error::Input(format!(
            "{}: neither an EXR nor a PNG file; give a picture in one of these formats",
            path.display()
        ))),
    }
}

/// The error for a file that cannot be opened or read at all.
fn unreadable(path: &Path, cause: &std::io::Error) -> Error {
    use std::io::ErrorKind;
    let advice = match cause.kind() {
        ErrorKind::NotFound => "check the path",
        ErrorKind::PermissionDenied => "check its permissions",
        ErrorKind::UnexpectedEof => "it is too short to be a picture; write it again",
        _ => "give a regular, readable picture file",
    };
    Error::Input(format!("{}: cannot be read ({cause}); {advice}", path.display()))
}
