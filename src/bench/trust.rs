//! Whether a device can be trusted: the self-test, once per device and driver.

use super::files::{Folder, read_json, write_json};
use super::suite::short_hash;
use super::watch::Watch;
use crate::Result;
use crate::device::{DeviceInfo, sources_hash};
use crate::selftest::{self, Status};
use serde::{Deserialize, Serialize};

/// What the self-test said of a device.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Trust {
    /// Whether it passed; `None` where it was not run.
    pub passed: Option<bool>,
    /// The checks that failed, each once.
    pub failures: Vec<String>,
}

impl Trust {
    /// Tests the device, unless that was done with this program, folder and driver.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device cannot be opened or the disk fails.
    pub fn of(device: &DeviceInfo, folder: &Folder, watch: &Watch<'_>) -> Result<Self> {
        let DeviceInfo { selector, platform, name, driver, version, .. } = device;
        let program = format!("{} {}", env!("CARGO_PKG_VERSION"), sources_hash());
        let key = short_hash(format!("{program} {selector} {platform} {name} {driver} {version}").as_bytes());
        let path = folder.path(&format!("runs/selftest-{key}.json"));
        if let Ok(known) = read_json(&path, "a self-test") {
            return Ok(known);
        }
        watch.say(&format!("self-test on {selector} ({name})"));
        let verdicts = selftest::run(device, &mut |_| ())?;
        let failed = verdicts.iter().filter(|verdict| verdict.status == Status::Failed);
        let mut failures: Vec<String> = failed.map(|verdict| verdict.check.clone()).collect();
        failures.dedup();
        let trust = Self { passed: Some(selftest::passed(&verdicts)), failures };
        write_json(&path, &trust)?;
        Ok(trust)
    }
}
