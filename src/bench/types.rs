//! Raw types of suite files, from which their JSON Schema is made. What is valid key by key but wrong together is
//! checked in [`super::suite`].

use super::results::{Measure, Quantity};
use crate::config::values::{ErrorTarget, Radiance, TimeLimit};
use schemars::JsonSchema;
use serde::Deserialize;

/// A suite of benchmarks: cases, how they are measured, and what others published.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "svetlo suite")]
pub struct SuiteConfig {
    /// Title of the report.
    pub title: String,
    /// What the suite is about, a few sentences.
    #[serde(default)]
    pub about: String,
    /// Devices, as `--device` takes them; every case runs on each. Default: the default device.
    #[serde(default)]
    pub devices: Vec<String>,
    /// Seed of the first repeat; the others follow.
    #[serde(default = "one")]
    pub seed: u64,
    /// Overrides of every scene, as `--set` takes them.
    #[serde(default)]
    pub set: Vec<String>,
    /// Independent runs of every case; intervals of times need at least 3.
    #[serde(default = "three")]
    #[schemars(range(min = 1, max = 1000))]
    pub repeats: u32,
    /// Samples per pixel that are rendered and thrown away before each measurement.
    #[serde(default = "first")]
    #[schemars(range(max = 1000))]
    pub warmup: u32,
    /// Where the error is measured.
    #[serde(default)]
    pub checkpoints: CheckpointsConfig,
    /// Variants of every case: a list of axes, each a list of variants; every combination is a case.
    #[serde(default)]
    pub vary: Vec<Vec<VariantConfig>>,
    /// What errors are measured against.
    #[serde(default)]
    pub reference: ReferenceConfig,
    /// Limits; whoever exceeds them makes the exit code 3.
    #[serde(default)]
    pub gates: GatesConfig,
    /// Time that the samples of a run may take; a case that takes longer is ended, and makes the exit code 3.
    pub limit: Option<TimeLimit>,
    /// Relative errors whose times are reported.
    #[serde(default = "usual_errors")]
    pub errors: Vec<ErrorTarget>,
    /// With `--baseline`: times that grow by more than this, and beyond their spread, make the exit code 3.
    #[serde(default = "tenth")]
    pub slower: ErrorTarget,
    /// The cases, one `[[case]]` table each.
    pub case: Vec<CaseConfig>,
    /// Numbers that others published, one `[[published]]` table each.
    #[serde(default)]
    pub published: Vec<PublishedConfig>,
}

/// A scene and how it is measured; what is not given is that of the suite.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CaseConfig {
    /// Its name in tables and plots.
    pub name: String,
    /// What it is about, or why it is hard, in one line.
    #[serde(default)]
    pub about: String,
    /// Cases of one group share a plot. Default: the name.
    pub group: Option<String>,
    /// Cases of one curve are joined in the plot of error against time, each with its last checkpoint: one method with
    /// more and more iterations of a light volume, or with finer and finer steps.
    pub curve: Option<String>,
    /// Path of the scene, relative to the suite file.
    pub scene: String,
    /// Overrides of the scene, after those of the suite.
    #[serde(default)]
    pub set: Vec<String>,
    /// Variants, instead of those of the suite.
    pub vary: Option<Vec<Vec<VariantConfig>>>,
    /// Independent runs.
    #[schemars(range(min = 1, max = 1000))]
    pub repeats: Option<u32>,
    /// Samples per pixel that are rendered and thrown away first.
    #[schemars(range(max = 1000))]
    pub warmup: Option<u32>,
    /// Where the error is measured.
    pub checkpoints: Option<CheckpointsConfig>,
    /// What errors are measured against.
    pub reference: Option<ReferenceConfig>,
    /// Limits, instead of those of the suite.
    pub gates: Option<GatesConfig>,
    /// Time that the samples of a run may take.
    pub limit: Option<TimeLimit>,
    /// What is known of the picture from elsewhere. A deviation makes the exit code 3. Without a `reference` of its own,
    /// the case is judged by this alone.
    pub truth: Option<TruthConfig>,
    /// Part of the message with which the scene must be refused: it is not rendered.
    pub refuses: Option<String>,
}

/// One variant of an axis.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VariantConfig {
    /// What is added to the names of cases.
    pub name: String,
    /// Overrides of the scene, after those of the case.
    #[serde(default)]
    pub set: Vec<String>,
    /// Group of the cases, instead of that of the case; where several axes name one, all of them together.
    pub group: Option<String>,
    /// What errors are measured against, instead of that of the case.
    pub reference: Option<ReferenceConfig>,
    /// What is known of the picture, instead of that of the case.
    pub truth: Option<TruthConfig>,
    /// Part of the message with which the scene must be refused, instead of that of the case.
    pub refuses: Option<String>,
}

/// What is known of a picture from a closed form or a published table. It is right where every channel deviates by no
/// more than `sigmas` standard errors (of the picture, from its own variance, and of the truth) and `tolerance` of the
/// value. Where pixels share their noise (light volumes, photons) the picture's own is not counted.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TruthConfig {
    /// The value, one number or [r, g, b].
    pub value: Radiance,
    /// Of what.
    #[serde(default)]
    pub of: Quantity,
    /// The pixels that count, [left, top, right, bottom], the last two not included. Default: all.
    pub region: Option<[u32; 4]>,
    /// Standard error of the value itself.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub error: f64,
    /// Deviation, as a share of the value, that is no fault: rounding, a known error of the method. Default: 10⁻⁵.
    #[serde(default = "rounding")]
    pub tolerance: ErrorTarget,
    /// Standard errors that chance may make of it.
    #[serde(default = "five")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub sigmas: f64,
    /// Where the value is from.
    #[serde(default)]
    pub source: String,
}

/// Where the error is measured: after numbers of samples, or after times. Default: 1, 4, 16 and 64 samples.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CheckpointsConfig {
    /// Samples per pixel, ascending. Methods without randomness stop at one sample.
    #[schemars(inner(range(min = 1, max = 1_000_000_000)))]
    pub samples: Option<Vec<u32>>,
    /// Times since the first sample, ascending.
    pub times: Option<Vec<TimeLimit>>,
}

/// What errors are measured against: `kind = "computed"` (default), `"constant"` or `"file"`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
#[schemars(transform = crate::config::default_kind_first)]
pub enum ReferenceConfig {
    /// The same scene, rendered with random numbers of its own; kept in the folder of the results.
    Computed {
        /// Overrides of the case's scene for the reference.
        #[serde(default)]
        set: Vec<String>,
        /// Estimated relative error that it is rendered to.
        #[serde(default = "half_percent")]
        error: ErrorTarget,
        /// Time after which it ends even so.
        time: Option<TimeLimit>,
    },
    /// A radiance known from theory, the same for every pixel.
    Constant {
        /// The radiance.
        value: Radiance,
    },
    /// A picture (EXR, or PNG taken as sRGB).
    File {
        /// Its path, relative to the suite file.
        path: String,
    },
}

impl Default for ReferenceConfig {
    fn default() -> Self {
        Self::Computed { set: Vec::new(), error: half_percent(), time: None }
    }
}

/// Limits of a case, at its last checkpoint.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GatesConfig {
    /// Largest RMSE over the mean of the reference.
    pub max_relative_rmse: Option<ErrorTarget>,
    /// Largest |bias| of all repeats together, in standard errors.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub max_bias_z: Option<f64>,
    /// Largest |bias| of all repeats together over the mean of the reference.
    pub max_relative_bias: Option<ErrorTarget>,
    /// Largest exponent of RMSE against samples, such as -0.45; exceeded when its whole interval lies above.
    pub max_slope: Option<f64>,
    /// Smallest PSNR (peak: largest value of the reference), dB.
    pub min_psnr: Option<f64>,
}

/// A number that others published.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PublishedConfig {
    /// Where it was published, such as "P0 table 1".
    pub source: String,
    /// What it was measured on.
    pub label: String,
    /// Name of the case that it is compared with.
    pub case: String,
    /// What it is of the case.
    pub measure: Measure,
    /// The number.
    pub value: f64,
    /// Its unit, as published.
    pub unit: String,
    /// What to know about the comparison.
    #[serde(default)]
    pub note: String,
}

fn rounding() -> ErrorTarget {
    ErrorTarget(1e-5)
}

fn five() -> f64 {
    5.0
}

fn one() -> u64 {
    1
}

fn first() -> u32 {
    1
}

fn three() -> u32 {
    3
}

fn half_percent() -> ErrorTarget {
    ErrorTarget(0.005)
}

fn tenth() -> ErrorTarget {
    ErrorTarget(0.1)
}

fn usual_errors() -> Vec<ErrorTarget> {
    [0.1, 0.05, 0.02, 0.01].map(ErrorTarget).into()
}
