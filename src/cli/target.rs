//! The files of a picture on its way: a full disk or a folder that is gone ends no render, and loses nothing.

use super::stderr::say;
use crate::picture::{Picture, Tonemap, write_exr, write_png};
use crate::{Error, Result};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Where a picture goes.
pub(super) struct Target {
    image: PathBuf,
    preview: PathBuf,
    /// The image as it was last seen.
    seen: Option<Stamp>,
    /// Whether the user knows that another program writes the image.
    is_shared: bool,
    /// Whether the user knows that the files cannot be written.
    is_stuck: bool,
}

/// When a file was changed, and its length.
type Stamp = (SystemTime, u64);

impl Target {
    /// An image and its preview. They are found by their whole paths: a folder that is removed or unmounted while the
    /// render runs may come back, but the place where the process was started does not.
    pub fn new(image: &Path, preview: &Path) -> Self {
        let whole = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let image = whole(image);
        Self { preview: whole(preview), seen: stamp(&image), image, is_shared: false, is_stuck: false }
    }

    /// Writes the picture while the render goes on. That it cannot be written is said once, and tried again next time.
    pub fn update(&mut self, picture: &Picture, tonemap: &Tonemap) {
        let written =
            self.write_image(picture).and_then(|()| write_png(&self.preview, picture, tonemap)).err();
        match &written {
            Some(error) if !self.is_stuck => {
                say(&format!("warning: {error} (the render goes on and tries again)"));
            }
            None if self.is_stuck => say(&format!("note: {} is written again", self.image.display())),
            _ => {}
        }
        self.is_stuck = written.is_some();
    }

    /// Writes the last picture: its preview, and the image if it was `changed` since it was read. An image that its
    /// place does not take is kept in the folder of temporary files.
    ///
    /// # Errors
    /// [`Error::Failed`] that says what could not be written, and where the image is.
    pub fn finish(&mut self, picture: &Picture, tonemap: &Tonemap, changed: bool) -> Result<()> {
        if changed && let Err(error) = self.write_image(picture) {
            return Err(self.keep_elsewhere(picture, &error));
        }
        write_png(&self.preview, picture, tonemap).map_err(|error| {
            Error::Failed(format!("{error} (the image itself is whole: {})", self.image.display()))
        })
    }

    fn write_image(&mut self, picture: &Picture) -> Result<()> {
        let found = stamp(&self.image);
        if found.is_some() && found != self.seen && !self.is_shared {
            self.is_shared = true;
            say(&format!(
                "note: another program has changed {} since this render last saw it; if that is a second render, \
                 the last to write wins",
                self.image.display()
            ));
        }
        write_exr(&self.image, picture)?;
        self.seen = stamp(&self.image);
        Ok(())
    }

    /// Saves the image where temporary files go, in a folder of its own; the error that says so.
    fn keep_elsewhere(&self, picture: &Picture, error: &Error) -> Error {
        let name = self.image.file_name().unwrap_or_default();
        let keep = |folder: tempfile::TempDir| {
            let path = folder.path().join(name);
            write_exr(&path, picture).map(|()| folder.keep().join(name))
        };
        let folder = tempfile::Builder::new().prefix("svetlo-").tempdir();
        Error::Failed(match folder.map_err(|cause| Error::Failed(cause.to_string())).and_then(keep) {
            Ok(path) => format!(
                "{error}; the image is kept as {}: move it there, and --resume goes on from it",
                path.display()
            ),
            Err(second) => format!("{error}; nor can it be kept elsewhere: {second}"),
        })
    }
}

fn stamp(path: &Path) -> Option<Stamp> {
    let found = std::fs::metadata(path).ok()?;
    Some((found.modified().ok()?, found.len()))
}
