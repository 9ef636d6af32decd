//! Continuing a render from its own image: what the file must be, and the film in it.

use super::auxiliary::Auxiliary;
use super::kept::{self, Kept};
use super::ledger::{self, PathLedger};
use super::output::units;
use super::parts::{Parts, in_words};
use super::plan::Plan;
use super::session::{Progress, TILE};
use super::share::Share;
use super::state::FORMAT;
use crate::caustics::PassLedger;
use crate::device::DeviceInfo;
use crate::film::FilmPixel;
use crate::picture::{Picture, read_exr};
use crate::scene::Scene;
use crate::{Error, Result};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How far the runs before this one came, and what they took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent {
    /// Samples and tiles of the film, and launches and device time of all runs.
    pub progress: Progress,
    /// Time from start to end of the commands.
    pub wall: Duration,
    /// Time to build programs.
    pub build: Duration,
}

/// An image that a render of the same scene left: to be continued.
pub struct Saved {
    path: PathBuf,
    picture: Picture,
}

/// A film and how it came to be.
pub struct SavedFilm {
    /// The pixels, row by row from the top.
    pub pixels: Vec<FilmPixel>,
    /// The auxiliary images, where the plan has some.
    pub auxiliary: Option<Vec<Auxiliary>>,
    /// What the paths did, where the method follows paths.
    pub paths: Option<PathLedger>,
    /// Where the flux of photons went, for caustics.
    pub photons: Option<PassLedger>,
    /// The runs that made it.
    pub spent: Spent,
}

impl Saved {
    /// Reads the image at `path`, which must be one of `scene`; `None` where there is no file.
    ///
    /// # Errors
    /// [`Error::Input`] when it is damaged, holds no state or is of another scene, seed or size.
    pub fn open(path: &Path, scene: &Scene) -> Result<Option<Self>> {
        if matches!(path.try_exists(), Ok(false)) {
            return Ok(None);
        }
        let picture = read_exr(path).map_err(|error| Error::Input(format!("cannot resume: {error}")))?;
        let saved = Self { path: path.to_owned(), picture };
        saved.check_scene(scene).map_err(|what| saved.refusal(&what))?;
        Ok(Some(saved))
    }

    /// The film, which must have been made from the data of this `plan`.
    ///
    /// # Errors
    /// [`Error::Input`] when the data are others, or the film is not as it was written.
    pub fn film(&self, plan: &Plan<'_>, data_hash: &str) -> Result<SavedFilm> {
        self.read_film(plan, data_hash).map_err(|what| self.refusal(&what))
    }

    /// Refuses to go on with another light volume than the image was begun with; `hash`: of one that is read from a file,
    /// `None` where it is computed.
    ///
    /// # Errors
    /// [`Error::Input`] that says so.
    pub fn check_light(&self, hash: Option<&str>) -> Result<()> {
        let begun = self.text("light_hash");
        match (hash, begun) {
            (Some(hash), Some(begun)) if begun != hash => Err(self.refusal(&format!(
                "it was begun with another light volume (svetlo.light_hash is {begun}, that of --load-light is {hash})"
            ))),
            (None, Some(begun)) if self.text("light_source") == Some("file") => Err(self.refusal(&format!(
                "it was begun with the light volume of a file (svetlo.light_hash is {begun}), which --load-light must give"
            ))),
            _ => Ok(()),
        }
    }

    /// What the user should know before `device` continues the render: what else differs decides bits.
    pub fn note(&self, device: &DeviceInfo) -> Option<String> {
        let now = [
            ("version", env!("CARGO_PKG_VERSION")),
            ("device", &device.name),
            ("platform", &device.platform),
            ("driver", &device.driver),
        ];
        let changed = |&(key, now): &(&str, &str)| {
            let then = self.text(key).unwrap_or("unknown");
            (then != now).then(|| format!("{key} {then}, now {now}"))
        };
        if self.text("part").is_some_and(|part| part.contains(':')) {
            return Some(format!(
                "{} was merged of parts: its sums are rounded otherwise than those of a picture that was rendered at once",
                self.path.display()
            ));
        }
        let changes: Vec<String> = now.iter().filter_map(changed).collect();
        (!changes.is_empty()).then(|| {
            format!(
                "{} was begun elsewhere ({}): what this run adds may differ by rounding from what that one would add",
                self.path.display(),
                changes.join("; ")
            )
        })
    }

    fn refusal(&self, what: &str) -> Error {
        Error::Input(format!(
            "{}: cannot be resumed: {what}; leave --resume out to render anew, or choose another file with -o",
            self.path.display()
        ))
    }

    fn text(&self, key: &str) -> Option<&str> {
        self.picture.metadata.get(&format!("svetlo.{key}")).map(String::as_str)
    }

    fn number<T: std::str::FromStr>(&self, key: &str) -> Result<T, String> {
        ledger::number(&self.picture.metadata, key)
    }

    fn seconds(&self, key: &str) -> Result<Duration, String> {
        let seconds = self.number(key)?;
        Duration::try_from_secs_f64(seconds)
            .map_err(|_| format!("svetlo.{key} in its header is {seconds}, not a time"))
    }

    fn check_scene(&self, scene: &Scene) -> Result<(), String> {
        let Some(format) = self.text("state") else {
            return Err("it holds no state of a render (svetlo.state)".into());
        };
        if format != FORMAT.to_string() {
            return Err(format!("its state has the format {format}, this svetlo reads {FORMAT}"));
        }
        let seed: u64 = self.number("seed")?;
        if seed != scene.seed {
            return Err(format!("it was rendered with seed {seed}, this render has seed {}", scene.seed));
        }
        let size = (self.picture.width, self.picture.height);
        let wanted = (scene.image.width as usize, scene.image.height as usize);
        if size != wanted {
            let (w, h) = wanted;
            return Err(format!("it has {}×{} pixels, this render has {w}×{h}", size.0, size.1));
        }
        let hash = self.text("scene_hash").unwrap_or("none");
        if hash != scene.hash {
            return Err(format!("it is of another scene (its hash is {hash}, this one's {})", scene.hash));
        }
        Ok(())
    }

    /// Whether the image is of the share of samples that is rendered.
    fn check_part(&self, wanted: Option<Share>) -> Result<(), String> {
        let Some(text) = self.text("part") else {
            return match wanted {
                None => Ok(()),
                Some(share) => Err(format!("it is a whole picture, this render is part {share} of one")),
            };
        };
        if wanted.is_some_and(|share| text == share.to_string()) {
            return Ok(());
        }
        let parts = Parts::read(text, self.number("samples")?)?;
        let single = parts.single().filter(|share| text == share.to_string());
        let missing = parts.missing();
        Err(match (single, wanted) {
            (Some(share), Some(wanted)) => {
                format!("it is part {share} of a picture, this render is part {wanted}")
            }
            (None, Some(wanted)) => {
                format!("it was merged of parts, this render is part {wanted}, which has a file of its own")
            }
            (_, None) if parts.is_whole() => return Ok(()),
            (Some(share), None) => format!(
                "it is part {share} of a picture, not a whole one: --part {share} continues it, `svetlo merge` adds parts"
            ),
            (None, None) if !missing.is_empty() => {
                let are = if missing.len() == 1 { "is" } else { "are" };
                format!(
                    "it was merged of parts, and {} of {} {are} missing: merge with what there is of them, or continue \
                     the parts themselves",
                    in_words(&missing),
                    parts.of()
                )
            }
            (None, None) => format!(
                "it was merged of parts that are not equally far (svetlo.part is {text}), so samples are missing in \
                 between: continue the parts to the same --samples and merge them again"
            ),
        })
    }

    fn read_film(&self, plan: &Plan<'_>, data_hash: &str) -> Result<SavedFilm, String> {
        self.check_part(plan.part)?;
        let hash = self.text("data_hash").unwrap_or("unknown");
        if hash != data_hash {
            return Err(format!(
                "the files that the scene reads held other data then (their hash was {hash}, it is {data_hash})"
            ));
        }
        let has_auxiliary = self.text("auxiliary").is_some();
        if has_auxiliary != plan.has_auxiliary() {
            let now = !has_auxiliary;
            return Err(format!(
                "it was rendered with film.auxiliary = {has_auxiliary}, this render has film.auxiliary = {now}"
            ));
        }
        let Kept { pixels, auxiliary, .. } = kept::read(&self.picture, units(plan), has_auxiliary)?;
        let (samples, tiles) = position(&pixels, plan.scene.image.width)?;
        let progress = Progress {
            samples,
            tiles,
            launches: self.number("launches")?,
            device_time: self.seconds("seconds_device")?,
            light: 1.0,
        };
        let (wall, build) = (self.seconds("seconds_wall")?, self.seconds("seconds_build")?);
        let paths = plan.method.paths.then(|| PathLedger::read(&self.picture.metadata)).transpose()?;
        let caustics = plan.method.caustics.as_ref();
        let photons = caustics.map(|_| PassLedger::read(&self.picture.metadata)).transpose()?;
        Ok(SavedFilm { pixels, auxiliary, paths, photons, spent: Spent { progress, wall, build } })
    }
}

/// Samples that every pixel has had, and how many tiles have had one more: always the first ones.
pub(super) fn position(film: &[FilmPixel], width: u32) -> Result<(u32, u32), String> {
    let width = width as usize;
    let tile = TILE as usize;
    let per_row = width.div_ceil(tile);
    let tile_of = |pixel: usize| (pixel / width / tile) * per_row + pixel % width / tile;
    let attempts = |pixel: &FilmPixel| u64::from(pixel.count) + u64::from(pixel.rejected);
    let least = film.iter().map(attempts).min().unwrap_or(0);
    let ahead = film.iter().enumerate().filter(|(_, pixel)| attempts(pixel) > least);
    let tiles = ahead.map(|(index, _)| tile_of(index) + 1).max().unwrap_or(0);
    let expected = |index: usize| least + u64::from(tile_of(index) < tiles);
    let whole = film.iter().enumerate().all(|(index, pixel)| attempts(pixel) == expected(index));
    match (whole, u32::try_from(least), u32::try_from(tiles)) {
        (true, Ok(samples), Ok(tiles)) => Ok((samples, tiles)),
        _ => Err("the sample counts of its pixels are none that a render stops at".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    /// A film of 19×10 pixels (3×2 tiles) with these sample counts.
    fn film(count: impl Fn(usize, usize) -> u32) -> Vec<FilmPixel> {
        let pixel = |i: usize| FilmPixel { count: count(i % 19, i / 19), ..FilmPixel::zeroed() };
        (0..190).map(pixel).collect()
    }

    #[test]
    fn counts_tell_samples_and_tiles() {
        let tile = |x: usize, y: usize| y / 8 * 3 + x / 8;
        for tiles in 0..6 {
            let found = position(&film(|x, y| 7 + u32::from(tile(x, y) < tiles)), 19);
            assert_eq!(found, Ok((7, tiles as u32)));
        }
    }

    #[test]
    fn rejected_samples_were_tried_too() {
        let mut film = film(|_, _| 5);
        (film[30].count, film[30].rejected) = (3, 2);
        assert_eq!(position(&film, 19), Ok((5, 0)));
    }

    #[test]
    fn counts_that_no_launch_leaves_are_refused() {
        let odd: [&dyn Fn(usize, usize) -> u32; 4] = [
            &|x, y| 7 + u32::from((x, y) == (0, 0)),
            &|x, _| 7 + u32::from(x >= 8),
            &|x, y| 7 + 2 * u32::from(x < 8 && y < 8),
            &|x, y| if (x, y) == (18, 9) { 0 } else { 7 },
        ];
        for count in odd {
            assert!(position(&film(count), 19).is_err());
        }
        let mut film = film(|_, _| u32::MAX);
        film.iter_mut().for_each(|pixel| pixel.rejected = 1);
        assert!(position(&film, 19).is_err());
    }
}
