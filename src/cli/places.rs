//! Which devices a render uses.

use super::render_args::RenderArgs;
use super::stderr::say;
use crate::Result;
use crate::cluster::Place;
use crate::device::{Catalog, Device, DeviceInfo};
use crate::render::announced_memory;
use crate::scene::Scene;

/// The devices that the user wants this process to use.
///
/// Processes on one machine share those that are named; where none is, those that are like the best.
///
/// # Errors
/// As [`Catalog::select_several`].
pub fn chosen<'a>(
    arguments: &RenderArgs,
    catalog: &'a Catalog,
    place: &Place,
) -> Result<Vec<&'a DeviceInfo>> {
    let selectors = selectors(arguments);
    let devices = if selectors.is_empty() && place.local_size > 1 {
        catalog.like(catalog.select(None)?)
    } else {
        catalog.select_several(&selectors)?
    };
    Ok(place.deal(devices))
}

/// `--device`, else `SVETLO_DEVICE` unless it is empty, as an unset variable of a script is.
fn selectors(arguments: &RenderArgs) -> Vec<String> {
    if !arguments.device.is_empty() {
        return arguments.device.clone();
    }
    let variable = std::env::var("SVETLO_DEVICE").unwrap_or_default();
    let words = variable.split(',').map(str::trim).filter(|word| !word.is_empty());
    words.map(str::to_owned).collect()
}

/// Those of the devices that have room for what the scene announces; of the others the user is told.
///
/// # Errors
/// What is said of the last, where there are no others.
pub fn with_room<'a>(infos: Vec<&'a DeviceInfo>, scene: &Scene, quiet: bool) -> Result<Vec<&'a DeviceInfo>> {
    let needed = announced_memory(scene);
    let mut able = Vec::new();
    let mut refusals = Vec::new();
    for info in infos {
        match needed.check(info) {
            Ok(()) => able.push(info),
            Err(error) => refusals.push(error),
        }
    }
    if able.is_empty()
        && let Some(error) = refusals.pop()
    {
        return Err(error);
    }
    if !quiet {
        refusals.iter().for_each(|error| say(&format!("note: left out: {error}")));
    }
    Ok(able)
}

/// The devices that can be opened, and why others cannot.
pub fn open(infos: &[&DeviceInfo]) -> (Vec<Device>, Vec<String>) {
    let mut devices = Vec::new();
    let mut refusals = Vec::new();
    for info in infos {
        match Device::open(info) {
            Ok(device) => devices.push(device),
            Err(error) => refusals.push(error.to_string()),
        }
    }
    (devices, refusals)
}
