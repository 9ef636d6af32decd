//! The folder of the results: pieces, pictures, and the tables, each written whole or not at all.

use super::results::{Case, Checkpoint, Repeat, Results};
use crate::picture::write_atomically;
use crate::{Error, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::io::Write;
use std::path::{Path, PathBuf};

/// The folder of a bench's results.
pub struct Folder(PathBuf);

impl Folder {
    /// Makes the folder with its parts.
    ///
    /// # Errors
    /// [`Error::Input`] when it cannot be made.
    pub fn make(path: &Path) -> Result<Self> {
        for part in ["runs", "references", "images"] {
            let part = path.join(part);
            std::fs::create_dir_all(&part).map_err(|cause| {
                Error::Input(format!(
                    "{}: cannot be made ({cause}); choose another folder with -o",
                    part.display()
                ))
            })?;
        }
        Ok(Self(path.to_owned()))
    }

    /// The path of a file in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Writes `results.json` and `results.csv`.
    ///
    /// # Errors
    /// [`Error::Failed`] when the disk fails.
    pub fn write_results(&self, results: &Results) -> Result<()> {
        write_json(&self.path("results.json"), results)?;
        let csv = csv_text(results)?;
        write_atomically(&self.path("results.csv"), |file| file.write_all(csv.as_bytes()))
    }
}

/// Writes a value as JSON for people.
///
/// # Errors
/// [`Error::Failed`] when the disk fails.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value)
        .map_err(|cause| Error::Failed(format!("{}: cannot be written ({cause})", path.display())))?;
    write_atomically(path, |file| writeln!(file, "{text}"))
}

/// Reads a value from JSON.
///
/// # Errors
/// [`Error::Input`] when there is no such file or it holds something else.
pub fn read_json<T: DeserializeOwned>(path: &Path, noun: &str) -> Result<T> {
    let text = std::fs::read_to_string(path).map_err(|cause| {
        Error::Input(format!("{}: {noun} cannot be read ({cause}); check the path", path.display()))
    })?;
    serde_json::from_str(&text)
        .map_err(|cause| Error::Input(format!("{}: this is not {noun} ({cause})", path.display())))
}

/// One line of `results.csv`: a checkpoint of a repeat.
#[derive(Serialize)]
struct Row<'a> {
    case: &'a str,
    group: &'a str,
    method: &'a str,
    device: &'a str,
    device_name: &'a str,
    width: u32,
    height: u32,
    voxels_x: usize,
    voxels_y: usize,
    voxels_z: usize,
    seed: u64,
    samples: u64,
    seconds: f64,
    device_seconds: f64,
    build_seconds: f64,
    prepare_seconds: f64,
    warmup_seconds: f64,
    light_seconds: Option<f64>,
    trace_seconds: Option<f64>,
    sort_seconds: Option<f64>,
    launches: u64,
    lookups: u64,
    bytes: u64,
    rejected: u64,
    faults: u64,
    mse: f64,
    rmse: Option<f64>,
    relative_rmse: Option<f64>,
    reference_noise: f64,
    psnr_linear_db: Option<f64>,
    psnr_display_db: Option<f64>,
    relmse: Option<f64>,
    mape: Option<f64>,
    bias: f64,
    bias_z: Option<f64>,
}

/// All checkpoints of all repeats as CSV with a header; what is undefined is empty.
///
/// # Errors
/// [`Error::Failed`], in theory.
pub fn csv_text(results: &Results) -> Result<String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let failed =
        |cause: &dyn std::fmt::Display| Error::Failed(format!("results.csv: cannot be written ({cause})"));
    for case in &results.cases {
        for repeat in &case.repeats {
            for checkpoint in &repeat.checkpoints {
                writer.serialize(row(case, repeat, checkpoint)).map_err(|cause| failed(&cause))?;
            }
        }
    }
    let bytes = writer.into_inner().map_err(|cause| failed(&cause))?;
    String::from_utf8(bytes).map_err(|cause| failed(&cause))
}

fn row<'a>(case: &'a Case, repeat: &Repeat, checkpoint: &Checkpoint) -> Row<'a> {
    let metrics = &checkpoint.metrics;
    let [voxels_x, voxels_y, voxels_z] = case.voxels;
    Row {
        case: &case.name,
        group: &case.group,
        method: &case.method,
        device: &case.device.selector,
        device_name: &case.device.name,
        width: case.width,
        height: case.height,
        voxels_x,
        voxels_y,
        voxels_z,
        seed: repeat.seed,
        samples: checkpoint.samples,
        seconds: checkpoint.seconds,
        device_seconds: checkpoint.device_seconds,
        build_seconds: repeat.build_seconds,
        prepare_seconds: repeat.prepare_seconds,
        warmup_seconds: repeat.warmup_seconds,
        light_seconds: repeat.light.map(|light| light.seconds),
        trace_seconds: repeat.photons.map(|photons| photons.trace_seconds),
        sort_seconds: repeat.photons.map(|photons| photons.sort_seconds),
        launches: checkpoint.launches,
        lookups: checkpoint.lookups,
        bytes: checkpoint.bytes,
        rejected: checkpoint.rejected,
        faults: checkpoint.faults,
        mse: metrics.mse.value,
        rmse: metrics.rmse.map(|rmse| rmse.value),
        relative_rmse: metrics.relative_rmse,
        reference_noise: metrics.reference_noise,
        psnr_linear_db: metrics.psnr_linear_db,
        psnr_display_db: metrics.psnr_display_db,
        relmse: metrics.relmse.map(|relmse| relmse.value),
        mape: metrics.mape.map(|mape| mape.value),
        bias: metrics.bias.value,
        bias_z: metrics.bias_z,
    }
}
