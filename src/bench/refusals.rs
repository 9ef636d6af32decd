//! Cases that must be refused, before anything is rendered.

use super::results::Refusal;
use super::spec::RefusalSpec;
use crate::device::DeviceInfo;
use crate::render::{BRICK_SHIFT, Plan, SceneData};
use crate::scene::Scene;
use crate::{Error, Result};

/// Tries to prepare every case, as a render on the devices would.
pub fn try_all(specs: &[RefusalSpec], devices: &[&DeviceInfo]) -> Vec<Refusal> {
    let tried = |spec: &RefusalSpec| {
        let RefusalSpec { name, about, group, scene_name, overrides, message, .. } = spec.clone();
        let message_found = match prepare(spec, devices) {
            Ok(()) => None,
            Err(Error::Input(text)) => Some(text),
            // Not found out in time is not refused.
            Err(_) => None,
        };
        Refusal { name, about, group, scene: scene_name, overrides, wanted: message, message: message_found }
    };
    specs.iter().map(tried).collect()
}

fn prepare(spec: &RefusalSpec, devices: &[&DeviceInfo]) -> Result<()> {
    let scene = Scene::load(&spec.scene_path, &spec.overrides)?;
    let loaded = SceneData::load(&scene)?;
    let plan = Plan::new(&scene, &loaded, BRICK_SHIFT)?;
    let memory = plan.memory();
    devices.iter().try_for_each(|device| memory.check(device))
}
