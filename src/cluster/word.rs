//! What rank 0 and the others say to each other about a render as a whole.

use crate::device::{DeviceName, sources_hash};
use crate::render::Share;
use crate::scene::Scene;
use serde::{Deserialize, Serialize};

/// The line by which it is said.
pub(super) const CONTROL: u64 = 0;

/// From rank 0.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Order {
    /// To make ready for this view of the scene; devices have lines from this port on.
    View { index: usize, port: u64 },
    /// The view is done.
    Close,
    /// All is done, with this exit code.
    End { code: u8 },
}

/// From the others.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Report {
    /// At first.
    Hello(Hello),
    /// Ready for a view.
    Ready(Ready),
    /// The end is known.
    Bye,
}

/// Who a process is.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Hello {
    /// The machine it runs on.
    pub host: String,
    /// What it is about to render, or why it cannot.
    pub scene: Result<Identity, String>,
}

/// Who puts devices at the disposal of rank 0.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Ready {
    /// The hash of the scene's data, or why they cannot be rendered.
    pub data: Result<String, String>,
    /// Its devices.
    pub devices: Vec<DeviceName>,
    /// Why there are not more, if there should be.
    pub remarks: Vec<String>,
}

/// What must be the same everywhere.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    version: String,
    kernels: String,
    machine: String,
    scene: String,
    views: usize,
    auxiliary: bool,
    part: Option<String>,
}

impl Identity {
    /// Of a render of this scene by this program on this machine.
    pub fn of(scene: &Scene, part: Option<Share>) -> Self {
        let endian = if cfg!(target_endian = "little") { "little" } else { "big" };
        Self {
            version: env!("CARGO_PKG_VERSION").into(),
            kernels: sources_hash(),
            machine: format!("{endian}-endian, {} bits", usize::BITS),
            scene: scene.hash.clone(),
            views: scene.views.len(),
            auxiliary: scene.film.auxiliary,
            part: part.map(|share| share.to_string()),
        }
    }

    /// The first thing in which another differs: its name, its value here, and there.
    pub(super) fn difference(&self, other: &Self) -> Option<(&'static str, String, String)> {
        let whole = |part: &Option<String>| part.clone().unwrap_or_else(|| "the whole picture".into());
        [
            ("version of svetlo", self.version.clone(), other.version.clone()),
            ("hash of the kernels", self.kernels.clone(), other.kernels.clone()),
            ("machine", self.machine.clone(), other.machine.clone()),
            ("hash of the scene", self.scene.clone(), other.scene.clone()),
            ("number of views", self.views.to_string(), other.views.to_string()),
            ("film.auxiliary", self.auxiliary.to_string(), other.auxiliary.to_string()),
            ("--part", whole(&self.part), whole(&other.part)),
        ]
        .into_iter()
        .find(|(_, here, there)| here != there)
    }
}
