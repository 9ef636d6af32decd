//! What a validated suite is made of.

use super::results::{Measure, Quantity, SuiteInfo};
use crate::scene::Scene;
use std::path::PathBuf;
use std::time::Duration;

/// A suite that can be run.
#[derive(Clone, Debug)]
pub struct Suite {
    /// Title and origin.
    pub info: SuiteInfo,
    /// Device selectors; empty for the default device.
    pub devices: Vec<String>,
    /// Seed of the first repeat.
    pub seed: u64,
    /// The cases that are rendered.
    pub cases: Vec<CaseSpec>,
    /// Those that must be refused; not both are empty.
    pub refusals: Vec<RefusalSpec>,
    /// Relative errors whose times are reported, descending.
    pub errors: Vec<f64>,
    /// Growth of a time that counts against a baseline, a fraction.
    pub slower: f64,
    /// What others published.
    pub published: Vec<PublishedSpec>,
}

/// A case that can be run.
#[derive(Clone, Debug)]
pub struct CaseSpec {
    /// Unique in the suite.
    pub name: String,
    /// What it is about; may be empty.
    pub about: String,
    /// The plot it belongs to.
    pub group: String,
    /// The curve of that plot it is a point of, if it has none to itself.
    pub curve: Option<String>,
    /// The scene file as the suite names it.
    pub scene_name: String,
    /// The scene file.
    pub scene_path: PathBuf,
    /// Overrides, in order.
    pub overrides: Vec<String>,
    /// The scene with them.
    pub scene: Scene,
    /// Independent runs, ≥ 1.
    pub repeats: u32,
    /// Samples before the measurement.
    pub warmup: u32,
    /// Where errors are measured.
    pub checkpoints: Checkpoints,
    /// What errors are measured against.
    pub reference: ReferenceSpec,
    /// Limits.
    pub gates: Gates,
    /// What is known of its picture.
    pub truth: Option<TruthSpec>,
    /// Most time for the samples of a run.
    pub limit: Option<Duration>,
}

/// A case that must be refused.
#[derive(Clone, Debug)]
pub struct RefusalSpec {
    /// Unique in the suite.
    pub name: String,
    /// What it is about; may be empty.
    pub about: String,
    /// The part of the table it belongs to.
    pub group: String,
    /// The scene file as the suite names it.
    pub scene_name: String,
    /// The scene file.
    pub scene_path: PathBuf,
    /// Overrides, in order.
    pub overrides: Vec<String>,
    /// What the message must contain.
    pub message: String,
}

/// What is known of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct TruthSpec {
    /// Per channel.
    pub value: [f64; 3],
    /// Of what.
    pub of: Quantity,
    /// Left, top, right, bottom; within the image.
    pub region: [u32; 4],
    /// Standard error of the value.
    pub error: f64,
    /// Share of the value that is no fault.
    pub tolerance: f64,
    /// Standard errors that are no fault.
    pub sigmas: f64,
    /// Where it is from.
    pub source: String,
}

/// Where errors are measured; ascending, at least one.
#[derive(Clone, Debug, PartialEq)]
pub enum Checkpoints {
    /// Samples per pixel.
    Samples(Vec<u32>),
    /// Times since the first sample.
    Times(Vec<Duration>),
}

/// What errors are measured against.
#[derive(Clone, Debug)]
pub enum ReferenceSpec {
    /// The same radiance everywhere.
    Constant([f64; 3]),
    /// None but the case's truth, as if it were everywhere.
    Truth([f64; 3]),
    /// A picture.
    File {
        /// As the suite names it.
        name: String,
        /// Where it is.
        path: PathBuf,
    },
    /// To be rendered.
    Computed(Box<ComputedReference>),
}

/// A reference to be rendered.
#[derive(Clone, Debug)]
pub struct ComputedReference {
    /// The scene with the seeds of its independent streams.
    pub scenes: Vec<Scene>,
    /// Overrides beyond those of the case.
    pub overrides: Vec<String>,
    /// Estimated relative error to reach.
    pub error: f64,
    /// When to end even so.
    pub time: Option<Duration>,
}

/// Limits of a case at its last checkpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gates {
    /// Of the RMSE over the mean of the reference.
    pub max_relative_rmse: Option<f64>,
    /// Of |bias| in standard errors.
    pub max_bias_z: Option<f64>,
    /// Of |bias| over the mean of the reference.
    pub max_relative_bias: Option<f64>,
    /// Of the slope's interval's low end.
    pub max_slope: Option<f64>,
    /// Least PSNR in dB.
    pub min_psnr: Option<f64>,
}

/// A number that others published.
#[derive(Clone, Debug, PartialEq)]
pub struct PublishedSpec {
    /// Where.
    pub source: String,
    /// On what.
    pub label: String,
    /// Name of the case.
    pub case: String,
    /// What it is of the case.
    pub measure: Measure,
    /// The number.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// What to know.
    pub note: String,
}
