//! A render under way, wherever its samples are computed: one device ([`Session`](super::Session)) or several
//! ([`Crew`](crate::crew::Crew)).

use super::auxiliary::Auxiliary;
use super::ledger::PathLedger;
use super::session::{Progress, Session};
use crate::Result;
use crate::caustics::{PassFacts, PassLedger};
use crate::device::DeviceName;
use crate::film::FilmPixel;
use crate::irradiance::{LightData, LightFacts};
use serde::Serialize;
use std::time::Duration;

/// A render to which samples are added step by step.
pub trait Rendering {
    /// Goes a short way, about as long as a launch, towards `target` samples in every pixel.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when no device is left that works, [`crate::Error::Interrupted`] after an interrupt.
    fn step(&mut self, target: u32) -> Result<()>;

    /// How far it has come.
    fn progress(&self) -> Progress;

    /// The film, row by row from the top. Until the next step, all else is what it was when this was last asked for.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device fails.
    fn film(&self) -> Result<Vec<FilmPixel>>;

    /// The auxiliary images, row by row from the top, when the scene asks for them and the method makes them.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device fails.
    fn auxiliary(&self) -> Result<Option<Vec<Auxiliary>>>;

    /// What the paths of all runs did, when the method follows paths.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device fails.
    fn ledger(&self) -> Result<Option<PathLedger>>;

    /// Where and how it is computed.
    fn facts(&self) -> Facts<'_>;

    /// The light volume, once it is computed, of methods that project one.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device fails.
    fn light(&self) -> Result<Option<LightData>>;

    /// Computes the light volume, if there is one to compute and it is not done, as long as `go_on` says so.
    ///
    /// # Errors
    /// As [`Rendering::step`], and [`crate::Error::Interrupted`].
    fn compute_light(&mut self, go_on: &dyn Fn() -> bool) -> Result<()>;

    /// Whether what was added is still whole after a device has failed.
    fn outlives_devices(&self) -> bool {
        false
    }

    /// What each device has done, where there are several.
    fn shifts(&self) -> Vec<Shift> {
        Vec::new()
    }

    /// What has happened since the last call that the user should know.
    fn take_notes(&mut self) -> Vec<String> {
        Vec::new()
    }
}

/// Where and how a render is computed.
#[derive(Clone, Debug)]
pub struct Facts<'a> {
    /// The devices, at least one; those that failed on the way included.
    pub devices: Vec<DeviceName>,
    /// Time to build programs, or to load them from the cache; with that of the runs it continues.
    pub build_time: Duration,
    /// Whether the programs came from the binary cache.
    pub build_cached: bool,
    /// What the computation of the light volume did, once it is done in this run.
    pub light: Option<&'a LightFacts>,
    /// The hash of the light volume, once there is one.
    pub light_hash: Option<&'a str>,
    /// Whether the light volume was read from a file.
    pub light_from_file: bool,
    /// What the passes of this run did, for caustics.
    pub passes: Option<PassFacts>,
    /// Where the flux of the photons of all runs went, for caustics.
    pub photons: Option<PassLedger>,
}

/// What a device has done for a render that it shares with others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shift {
    /// The device, as `svetlo devices` lists it.
    pub selector: String,
    /// Its name.
    pub name: String,
    /// Samples that came into the picture, over all pixels.
    pub samples: u64,
    /// Seconds that it has worked for them.
    pub seconds: f64,
    /// Why it was left out, if it was.
    pub lost: Option<String>,
}

/// A property of devices, for people: each once.
pub fn of_devices(devices: &[DeviceName], property: impl Fn(&DeviceName) -> &str) -> String {
    let mut listed: Vec<&str> = Vec::new();
    for device in devices {
        let text = property(device);
        if !listed.contains(&text) {
            listed.push(text);
        }
    }
    listed.join(" + ")
}

impl Rendering for Session {
    fn step(&mut self, target: u32) -> Result<()> {
        Self::step(self, target)
    }

    fn progress(&self) -> Progress {
        Self::progress(self)
    }

    fn film(&self) -> Result<Vec<FilmPixel>> {
        Self::film(self)
    }

    fn auxiliary(&self) -> Result<Option<Vec<Auxiliary>>> {
        Self::auxiliary(self)
    }

    fn ledger(&self) -> Result<Option<PathLedger>> {
        Self::ledger(self)
    }

    fn light(&self) -> Result<Option<LightData>> {
        Self::light(self)
    }

    fn compute_light(&mut self, go_on: &dyn Fn() -> bool) -> Result<()> {
        Self::compute_light(self, go_on)
    }

    fn facts(&self) -> Facts<'_> {
        Facts {
            devices: vec![self.device.info().names()],
            build_time: self.build_time,
            build_cached: self.build_cached,
            light: self.light_facts(),
            light_hash: self.light_hash(),
            light_from_file: self.is_light_from_file(),
            passes: self.pass_facts().copied(),
            photons: self.photons().copied(),
        }
    }
}
