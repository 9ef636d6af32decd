//! What errors are measured against: made, read or rendered, and kept as EXR among the results.

use super::computed;
use super::files::Folder;
use super::results::{ReferenceInfo, ReferenceKind};
use super::suite::{CaseSpec, ComputedReference, ReferenceSpec, short_hash};
use super::watch::Watch;
use crate::device::DeviceInfo;
use crate::metrics::compare;
use crate::picture::{Picture, read_exr, read_picture, write_exr};
use crate::render::method_name;
use crate::scene::Image;
use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// A reference at hand.
#[derive(Clone)]
pub struct Reference {
    /// What it is.
    pub info: ReferenceInfo,
    /// Identifies its content.
    pub hash: String,
    /// The picture's EXR.
    path: PathBuf,
}

impl Reference {
    /// The reference of a case: rendered on `device` unless it is there already.
    ///
    /// # Errors
    /// [`Error::Input`] when a file is no picture of the case's size, [`Error::Failed`] when the device or the disk
    /// fails, [`Error::Interrupted`].
    pub fn obtain(case: &CaseSpec, device: &DeviceInfo, folder: &Folder, watch: &Watch<'_>) -> Result<Self> {
        match &case.reference {
            ReferenceSpec::Constant(color) => {
                constant(*color, ReferenceKind::Constant, &case.scene.image, folder)
            }
            ReferenceSpec::Truth(color) => constant(*color, ReferenceKind::Truth, &case.scene.image, folder),
            ReferenceSpec::File { name, path } => from_file(name, path, &case.scene.image, folder),
            ReferenceSpec::Computed(spec) => rendered(spec, &case.name, device, folder, watch),
        }
    }

    /// Reads the picture.
    ///
    /// # Errors
    /// [`Error::Input`] when the file is gone or damaged.
    pub fn picture(&self) -> Result<Picture> {
        read_exr(&self.path)
    }
}

fn constant(color: [f64; 3], kind: ReferenceKind, image: &Image, folder: &Folder) -> Result<Reference> {
    let (width, height) = (image.width as usize, image.height as usize);
    let mut picture = Picture::new(width, height);
    for (name, value) in ["R", "G", "B"].into_iter().zip(color) {
        picture = picture.with_channel(name, vec![value as f32; width * height]);
    }
    let hash = short_hash(format!("constant {color:?} {width} {height}").as_bytes());
    let [r, g, b] = color;
    let text = if r == g && g == b { format!("{r}") } else { format!("[{r}, {g}, {b}]") };
    keep(&picture, kind, format!("the radiance {text} everywhere, exactly"), hash, folder)
}

fn from_file(name: &str, path: &Path, image: &Image, folder: &Folder) -> Result<Reference> {
    let picture = read_picture(path)?;
    let (width, height) = (image.width as usize, image.height as usize);
    if (picture.width, picture.height) != (width, height) {
        return Err(Error::Input(format!(
            "{}: the reference has {}×{} pixels, the case {width}×{height}; they must be of one size",
            path.display(),
            picture.width,
            picture.height
        )));
    }
    let bytes = crate::input::bytes(path)
        .map_err(|cause| Error::Input(format!("{}: cannot be read ({cause})", path.display())))?;
    keep(&picture, ReferenceKind::File, format!("the picture {name}"), short_hash(&bytes), folder)
}

fn keep(
    picture: &Picture,
    kind: ReferenceKind,
    description: String,
    hash: String,
    folder: &Folder,
) -> Result<Reference> {
    let name = format!("references/{hash}.exr");
    let path = folder.path(&name);
    write_exr(&path, picture)?;
    let method = picture.metadata.get("svetlo.method").cloned();
    let samples = picture.metadata.get("svetlo.samples").and_then(|text| text.parse().ok());
    let info = ReferenceInfo {
        kind,
        description,
        method,
        relative_error: computed::relative_error(picture)?,
        wanted_error: None,
        mean: compare(picture, picture)?.bias.reference_mean,
        seconds: 0.0,
        samples,
        image: Some(name),
    };
    Ok(Reference { info, hash, path })
}

fn rendered(
    spec: &ComputedReference,
    case: &str,
    device: &DeviceInfo,
    folder: &Folder,
    watch: &Watch<'_>,
) -> Result<Reference> {
    let found = computed::render(spec, case, device, folder, watch)?;
    let with = match spec.overrides.as_slice() {
        [] => String::new(),
        overrides => format!(" with {}", overrides.join(" ")),
    };
    let relative_error = computed::relative_error(&found.picture)?;
    let description = match relative_error {
        Some(_) => format!("the same scene{with}: {} samples in independent streams", found.samples),
        None => format!("the same scene{with}, which is not random"),
    };
    let info = ReferenceInfo {
        kind: ReferenceKind::Computed,
        description,
        method: Some(method_name(&spec.scenes[0].method).into()),
        relative_error,
        wanted_error: Some(spec.error),
        mean: compare(&found.picture, &found.picture)?.bias.reference_mean,
        seconds: found.seconds,
        samples: Some(found.samples),
        image: Some(found.name.clone()),
    };
    Ok(Reference { info, hash: found.hash, path: folder.path(&found.name) })
}
