//! Light volumes in files: NRRD, with what tells which scene's light they hold.

use super::LightData;
use super::light::Directions;
use crate::render::{Fingerprint, Plan};
use crate::volume::Components;
use crate::{Error, Result};
use glam::DVec3;
use std::path::Path;

/// What a file says that it is; a later format has another number.
const FORMAT: &str = "light volume 1";
/// What a cell has where the medium scatters into all directions alike, and where it does not.
const PLAIN: [&str; 2] = ["fluence", "direct"];
const DIRECTED: [&str; 4] = ["scattered", "direct", "drift", "flow"];

impl LightData {
    /// Writes a NRRD file: per cell the fluence of all light and that of unscattered light (RGB). In media that do not
    /// scatter into all directions alike, the first is of all but unscattered light (`scattered`), and its mean direction
    /// (flux over fluence, `drift`) and that of unscattered light (`flow`) follow. With steps in time, all light may be less than unscattered
    /// light: they take from it what they spread. `data_hash`: of [`data_hash`](crate::render::data_hash).
    ///
    /// # Errors
    /// [`Error::Failed`] with the path and the cause.
    pub fn write(&self, path: &Path, plan: &Plan<'_>, data_hash: &str) -> Result<()> {
        let names: &[&str] = if self.directions.is_some() { &DIRECTED } else { &PLAIN };
        let count = 3 * names.len();
        let values = self.values();
        let (spacing, origin) = placed(plan, self.dims);
        let keys = [
            ("svetlo", FORMAT.to_owned()),
            ("svetlo.components", names.join(" ")),
            ("svetlo.version", env!("CARGO_PKG_VERSION").to_owned()),
            ("svetlo.light_hash", plan.scene.light_hash.clone()),
            ("svetlo.data_hash", data_hash.to_owned()),
            ("svetlo.content_hash", self.hash()),
        ];
        let keys = keys.map(|(key, value)| (key.to_owned(), value)).to_vec();
        Components { count, dims: self.dims, spacing, origin, keys, values }.write(path)
    }

    /// The numbers as files have them.
    fn values(&self) -> Vec<f32> {
        let names = if self.directions.is_some() { DIRECTED.len() } else { PLAIN.len() };
        let mut values = Vec::with_capacity(3 * names * self.fluence.len());
        for i in 0..self.fluence.len() {
            values.extend(self.fluence[i]);
            values.extend(self.direct[i]);
            if let Some(Directions { drift, flow }) = &self.directions {
                values.extend(drift[i]);
                values.extend(flow[i]);
            }
        }
        values
    }

    /// A hash of all its numbers.
    pub fn hash(&self) -> String {
        let mut fingerprint = Fingerprint::new();
        fingerprint.add(&format!("light {:?}", self.dims), bytemuck::cast_slice(&self.values()));
        fingerprint.finish()
    }

    /// Reads the light of the plan's scene from a file that [`LightData::write`] wrote.
    ///
    /// # Errors
    /// [`Error::Input`] when the file is none, or holds the light of another scene or other data.
    pub fn read(path: &Path, plan: &Plan<'_>, data_hash: &str) -> Result<Self> {
        let refuse = |what: String| {
            let remedy = "compute the light anew by leaving --load-light out";
            Error::Input(format!("{}: {what}; {remedy}", path.display()))
        };
        let Some(setup) = &plan.method.light else {
            return Err(refuse("this scene's method projects no light volume".into()));
        };
        if matches!(path.try_exists(), Ok(false)) {
            return Err(refuse("there is no such file".into()));
        }
        let file = Components::read(path)?;
        if file.key("svetlo") != Some(FORMAT) {
            return Err(refuse(format!("is no {FORMAT} of svetlo (svetlo:={FORMAT})")));
        }
        let wanted = [
            ("svetlo.light_hash", "was computed for another scene", plan.scene.light_hash.as_str()),
            ("svetlo.data_hash", "was computed from other data", data_hash),
        ];
        for (key, what, wanted) in wanted {
            let found = file.key(key).unwrap_or("unknown");
            if found != wanted {
                return Err(refuse(format!("{what} ({key} is {found}, here {wanted})")));
            }
        }
        let (dims, directed) = (setup.direct_grid.dims, setup.is_directed());
        let count = 3 * if directed { DIRECTED.len() } else { PLAIN.len() };
        if file.dims != dims || file.count != count {
            let [nx, ny, nz] = dims;
            let [mx, my, mz] = file.dims;
            let found = file.count;
            return Err(refuse(format!(
                "has {found} numbers in each of {mx}×{my}×{mz} cells, this scene needs {count} in {nx}×{ny}×{nz}"
            )));
        }
        let names = if directed { DIRECTED.join(" ") } else { PLAIN.join(" ") };
        let found = file.key("svetlo.components").unwrap_or("unknown");
        if found != names {
            return Err(refuse(format!("its numbers are `{found}`, this scene needs `{names}`")));
        }
        if (file.spacing, file.origin) != placed(plan, dims) {
            return Err(refuse("its cells are elsewhere (`space directions`, `space origin`)".into()));
        }
        // Of each cell, fluences are the first six.
        if let Some(wrong) = file.values.iter().enumerate().find(|(i, v)| i % count < 6 && **v < 0.0) {
            return Err(refuse(format!(
                "cell {} has the fluence {}, which is below 0",
                wrong.0 / count,
                wrong.1
            )));
        }
        let triple = |first: usize| -> Vec<[f32; 3]> {
            file.values
                .chunks_exact(count)
                .map(|cell| [cell[first], cell[first + 1], cell[first + 2]])
                .collect()
        };
        let directions = directed.then(|| Directions { drift: triple(6), flow: triple(9) });
        let light = Self { dims, fluence: triple(0), direct: triple(3), directions };
        let (found, hash) = (file.key("svetlo.content_hash").unwrap_or("unknown"), light.hash());
        if found != hash {
            return Err(refuse(format!(
                "its numbers are not those that were written (svetlo.content_hash is {found}, of its numbers it is {hash})"
            )));
        }
        Ok(light)
    }
}

/// Spacing and first centre of so many cells over the plan's volume, scene units.
fn placed(plan: &Plan<'_>, dims: [usize; 3]) -> (DVec3, DVec3) {
    let spacing = plan.local.size() * plan.local.unit / DVec3::from_array(dims.map(|n| n as f64));
    (spacing, plan.local.origin + 0.5 * spacing)
}
