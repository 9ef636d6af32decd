//! Continuing a render from its own image: what the file must be, and the film in it.

use super::auxiliary::Auxiliary;
use super::kept::{self, Kept};
use super::ledger::{self, PathLedger};
use super::output::units;
use super::parts::{Parts, in_words};
use super::plan::Plan;
use super::rendering::of_devices;
use super::session::Progress;
use super::share::Share;
use super::state::FORMAT;
use super::tiles::{Lag, Standing};
use crate::caustics::PassLedger;
use crate::device::DeviceName;
use crate::film::FilmPixel;
use crate::picture::{Picture, read_exr};
use crate::scene::Scene;
use crate::{Error, Result};
use bytemuck::Zeroable;
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

/// Where and by what an image was computed.
pub struct Origin {
    path: PathBuf,
    /// Keys of the header and what it has there.
    texts: [(&'static str, String); 4],
    is_merged: bool,
}

impl Origin {
    /// What the user should know before `devices` continue the render: what else differs decides bits.
    pub fn note(&self, devices: &[DeviceName]) -> Option<String> {
        let path = self.path.display();
        if self.is_merged {
            return Some(format!(
                "{path} was merged of parts: its sums are rounded otherwise than those of a picture that was rendered at once"
            ));
        }
        let now = [
            env!("CARGO_PKG_VERSION").to_owned(),
            of_devices(devices, |device| &device.name),
            of_devices(devices, |device| &device.platform),
            of_devices(devices, |device| &device.driver),
        ];
        let pairs = self.texts.iter().zip(now).filter(|((_, then), now)| then != now);
        let changes: Vec<String> =
            pairs.map(|((key, then), now)| format!("{key} {then}, now {now}")).collect();
        (!changes.is_empty()).then(|| {
            format!(
                "{path} was begun elsewhere ({}): what this run adds may differ by rounding from what that one would add",
                changes.join("; ")
            )
        })
    }
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
    /// Tiles that have fewer samples than others.
    pub lag: Vec<Lag>,
    /// The runs that made it.
    pub spent: Spent,
}

impl SavedFilm {
    /// The film of `plan` before its first sample.
    pub fn empty(plan: &Plan<'_>) -> Self {
        let image = &plan.scene.image;
        Self {
            pixels: vec![FilmPixel::zeroed(); image.width as usize * image.height as usize],
            auxiliary: None,
            paths: None,
            photons: None,
            lag: Vec::new(),
            spent: Spent::default(),
        }
    }
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

    /// Where it was computed.
    pub fn origin(&self) -> Origin {
        let texts = ["version", "device", "platform", "driver"]
            .map(|key| (key, self.text(key).unwrap_or("unknown").to_owned()));
        let is_merged = self.text("part").is_some_and(|part| part.contains(':'));
        Origin { path: self.path.clone(), texts, is_merged }
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
        let Standing { samples, tiles, lag, .. } = Standing::of(&pixels, plan.scene.image.width)
            .ok_or("the sample counts of its pixels are none that a render stops at")?;
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
        Ok(SavedFilm { pixels, auxiliary, paths, photons, lag, spent: Spent { progress, wall, build } })
    }
}
