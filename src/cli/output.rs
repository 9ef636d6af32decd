//! Where `svetlo render` writes, and that it overwrites nothing it reads.

use crate::render::Share;
use crate::scene::{Background, Scene, SurfaceShape, Table2d, Transfer, VolumeSource};
use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// `-o`, or the scene's name with `.exr` in the current folder; with `.2-of-8.exr` for a part.
///
/// # Errors
/// [`Error::Input`] when `-o` does not end in `.exr`.
pub fn output_path(scene: &Path, given: Option<&Path>, part: Option<Share>) -> Result<PathBuf> {
    let Some(path) = given else {
        // Not `with_extension`, which would take the end off `head.ct`.
        let mut name = scene.file_stem().unwrap_or_default().to_owned();
        if let Some(share) = part {
            name.push(format!(".{}-of-{}", share.number(), share.of()));
        }
        name.push(".exr");
        return Ok(name.into());
    };
    exr_path(path)
}

/// The path, if it is one of an EXR image.
///
/// # Errors
/// [`Error::Input`] when it does not end in `.exr`.
pub fn exr_path(path: &Path) -> Result<PathBuf> {
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr")) {
        return Ok(path.to_owned());
    }
    Err(Error::Input(format!(
        "{}: the image is written as EXR, so its name must end in .exr (a .png preview appears beside it)",
        path.display()
    )))
}

/// The image of each of a scene's `views`: [`output_path`] where there is one, else `NAME.0001.exr` and so on.
///
/// # Errors
/// As [`output_path`].
pub fn output_paths(
    scene: &Path,
    given: Option<&Path>,
    part: Option<Share>,
    views: usize,
) -> Result<Vec<PathBuf>> {
    let path = output_path(scene, given, part)?;
    if views == 1 {
        return Ok(vec![path]);
    }
    let extension = path.extension().unwrap_or_default().to_owned();
    let numbered = |number: usize| {
        let mut name = path.file_stem().unwrap_or_default().to_owned();
        name.push(format!(".{number:04}."));
        name.push(&extension);
        path.with_file_name(name)
    };
    Ok((1..=views).map(numbered).collect())
}

/// Refuses an output that is also an input: such as the picture `head.png` of a transfer function, where the
/// preview of `head.toml` would go.
///
/// # Errors
/// [`Error::Input`] naming the file.
pub fn check_inputs_survive(output: &Path, scene_file: &Path, scene: &Scene) -> Result<()> {
    // A file that is not there yet is no input.
    let Ok(target) = output.canonicalize() else { return Ok(()) };
    let is_target = |input: &&Path| input.canonicalize().is_ok_and(|input| input == target);
    match inputs(scene_file, scene).into_iter().find(is_target) {
        Some(_) => Err(Error::Input(format!(
            "{}: the scene reads this file, so the image or its preview cannot go there; choose another name with -o",
            output.display()
        ))),
        None => Ok(()),
    }
}

fn inputs<'a>(scene_file: &'a Path, scene: &'a Scene) -> Vec<&'a Path> {
    let mut inputs = vec![scene_file];
    if let Some(VolumeSource::File { path, .. }) = scene.volume.as_ref().map(|volume| &volume.source) {
        inputs.push(path);
    }
    inputs.extend(scene.surfaces.iter().filter_map(|surface| match &surface.shape {
        SurfaceShape::Mesh { path, .. } => Some(path.as_path()),
        _ => None,
    }));
    if let Background::Environment { path, .. } = &scene.background {
        inputs.push(path);
    }
    if let Transfer::TwoD(transfer) = &scene.transfer
        && let Table2d::File(path) = &transfer.table
    {
        inputs.push(path);
    }
    inputs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_name_is_the_whole_stem_here() {
        let name = |scene: &str| output_path(Path::new(scene), None, None).unwrap();
        assert_eq!(name("scans/head.toml"), Path::new("head.exr"));
        assert_eq!(name("scans/head.ct.toml"), Path::new("head.ct.exr"));
        assert_eq!(name("head"), Path::new("head.exr"));
        assert_eq!(name(".toml"), Path::new(".toml.exr"));
        let part = output_path(Path::new("scans/head.ct.toml"), None, Share::new(2, 8)).unwrap();
        assert_eq!(part, Path::new("head.ct.2-of-8.exr"));
    }
}
