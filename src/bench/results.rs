//! What a bench found: the data model of `results.json`, `results.csv` and the report.
//!
//! Times are in seconds, sizes in bytes, errors in the units of the pictures (linear radiance) unless they are called
//! relative: those are shares of the reference's mean. Paths are relative to the folder of the results.

use crate::caustics::PassFacts;
use crate::irradiance::LightFacts;
use serde::{Deserialize, Serialize};

pub use super::results_truths::{Judged, Quantity, Refusal};

/// A value with its two-sided 95 % confidence interval, which is missing where nothing is known of it.
pub use crate::metrics::Estimate as Interval;

/// The format of `results.json` that this program writes.
pub const FORMAT: u32 = 1;

/// Everything that a bench found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// [`FORMAT`] of the program that wrote it.
    pub format: u32,
    /// Version of svetlo.
    pub version: String,
    /// What was asked.
    pub suite: SuiteInfo,
    /// On which machine.
    pub machine: Machine,
    /// When the bench began, UTC, such as `2026-01-31T12:00:00Z`.
    pub started: String,
    /// Wall time of this run of the bench, references and resumed pieces not included.
    pub seconds: f64,
    /// Whether every piece of the suite is there: an interrupted bench leaves the finished ones.
    pub complete: bool,
    /// Every case on every device.
    pub cases: Vec<Case>,
    /// Every case that must be refused.
    #[serde(default)]
    pub refusals: Vec<Refusal>,
    /// What others published, beside what was measured here.
    pub published: Vec<Published>,
    /// What the reader should know; the worst first.
    pub findings: Vec<Finding>,
}

/// The suite that was run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SuiteInfo {
    /// Its title.
    pub title: String,
    /// What it is about, a few sentences; may be empty.
    pub about: String,
    /// The file's name.
    pub file: String,
    /// Hash of its text.
    pub hash: String,
}

/// The host.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// The processor's name.
    pub cpu: String,
    /// Logical cores that the program may use.
    pub cores: usize,
    /// Physical memory; `None` where the system does not say.
    pub memory_bytes: Option<u64>,
    /// Operating system, kernel and architecture.
    pub os: String,
}

/// One case on one device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// Unique among the cases of a device.
    pub name: String,
    /// What it is about; may be empty.
    #[serde(default)]
    pub about: String,
    /// Cases of one group belong into one plot and share what they are measured against.
    pub group: String,
    /// Cases of one curve are joined in the plot of error against time, each with its last checkpoint.
    #[serde(default)]
    pub curve: Option<String>,
    /// The scene file, as the suite names it.
    pub scene: String,
    /// `key.path=value`, in the order in which they apply.
    pub overrides: Vec<String>,
    /// Hash of the scene with its overrides, without the seed.
    pub scene_hash: String,
    /// Where it ran.
    pub device: DeviceDescription,
    /// Name of the method in scene files.
    pub method: String,
    /// How the method goes about it, one phrase each, such as `transmittance auto`.
    pub estimators: Vec<String>,
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Voxels per axis.
    pub voxels: [usize; 3],
    /// What a session allocates on the device.
    pub device_bytes: u64,
    /// Whether every sample is the same: then there is one checkpoint with one sample, and its error is a bias.
    pub deterministic: bool,
    /// What the errors are against.
    pub reference: ReferenceInfo,
    /// Independent runs, by their seeds; empty where nothing is finished.
    pub repeats: Vec<Repeat>,
    /// The mean picture of all repeats; its noise is that between them, where there are two or more.
    pub pooled: Option<Metrics>,
    /// What the repeats say together.
    pub summary: Summary,
    /// Pictures of the case.
    pub images: Images,
    /// What is known of its picture, and how far that is off; `None` where nothing is known or measured.
    #[serde(default)]
    pub truth: Option<Judged>,
    /// Why it could not be measured, where it could not.
    #[serde(default)]
    pub failed: Option<String>,
}

/// A device and whether it can be trusted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DeviceDescription {
    /// As `--device` takes it.
    pub selector: String,
    /// Device name.
    pub name: String,
    /// Platform name.
    pub platform: String,
    /// Driver version.
    pub driver: String,
    /// OpenCL version of the device.
    pub version: String,
    /// Parallel compute units.
    pub compute_units: u32,
    /// Whether the self-test passed on it; `None` where it was not run.
    pub selftest: Option<bool>,
    /// The checks that failed.
    pub selftest_failures: Vec<String>,
}

/// What the errors of a case are measured against.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceInfo {
    /// Where it comes from.
    pub kind: ReferenceKind,
    /// The same in a sentence.
    pub description: String,
    /// Name of the method that rendered it, where one did: errors against another method's are those of a model.
    pub method: Option<String>,
    /// Its own RMSE over its mean, by its own variance; `None` for one without noise or of unknown noise.
    pub relative_error: Option<f64>,
    /// The relative error that was asked for, where it was rendered.
    pub wanted_error: Option<f64>,
    /// Mean radiance over pixels and channels.
    pub mean: f64,
    /// Wall time to render it, whenever that was; 0 for one that was not rendered here.
    pub seconds: f64,
    /// Samples per pixel, where it was rendered.
    pub samples: Option<u64>,
    /// Its EXR.
    pub image: Option<String>,
}

/// Where a reference comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ReferenceKind {
    /// A value known from theory, the same for every pixel.
    Constant,
    /// A picture in a file.
    File,
    /// Rendered by svetlo with an independent random stream.
    Computed,
    /// None: the case is judged by its truth.
    Truth,
}

/// One run of a case: a session of its own, with random numbers of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Repeat {
    /// Seed of the random numbers.
    pub seed: u64,
    /// To build the program or load it from the cache.
    pub build_seconds: f64,
    /// Whether it came from the cache.
    pub build_cached: bool,
    /// To load the volume, plan, and upload; without `build_seconds`.
    pub prepare_seconds: f64,
    /// Launches before the measurement began.
    pub warmup_seconds: f64,
    /// The light volume, for methods that project one: it is part of every checkpoint's time.
    #[serde(default)]
    pub light: Option<LightRun>,
    /// The passes of photons, for caustics: they are part of every checkpoint's time.
    #[serde(default)]
    pub photons: Option<PhotonRun>,
    /// The states that were measured, in order.
    pub checkpoints: Vec<Checkpoint>,
}

/// How a light volume was computed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LightRun {
    /// Wall time.
    pub seconds: f64,
    /// Steps in time, or estimates of direct light; `None` where there is nothing to count.
    pub iterations: Option<u32>,
}

impl LightRun {
    /// What a session says of it.
    pub fn of(facts: &LightFacts) -> Self {
        Self { seconds: facts.seconds, iterations: facts.steps.or(facts.estimates) }
    }
}

/// How the photons of caustics were traced and brought in order.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhotonRun {
    /// Photons of a pass.
    pub photons: u32,
    /// Time of a pass to trace them.
    pub trace_seconds: f64,
    /// Time of a pass to find their keys, to sort them and to find the ranges of voxels.
    pub sort_seconds: f64,
}

impl PhotonRun {
    /// What a session says of it.
    pub fn of(facts: &PassFacts) -> Self {
        let passes = f64::from(facts.passes.max(1));
        let sorting = [facts.key_seconds, facts.sort_seconds, facts.fill_seconds, facts.order_seconds];
        Self {
            photons: facts.photons,
            trace_seconds: facts.trace_seconds / passes,
            sort_seconds: sorting.iter().sum::<f64>() / passes,
        }
    }
}

/// A state of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    /// Samples per pixel.
    pub samples: u64,
    /// Wall time of all steps of the light volume and the samples; reading the film for earlier checkpoints does not
    /// count.
    pub seconds: f64,
    /// Of this, the time in kernels.
    pub device_seconds: f64,
    /// Launches, and steps of the light volume.
    pub launches: u64,
    /// Look-ups of the volume, by light volume and samples.
    pub lookups: u64,
    /// Bytes of voxels that these ask for: eight voxels each, before any cache.
    pub bytes: u64,
    /// Samples that were not finite and were left out.
    pub rejected: u64,
    /// Look-ups above their majorant and paths without an end: anything but 0 is a mistake of svetlo.
    pub faults: u64,
    /// The error of the picture.
    pub metrics: Metrics,
}

/// The error of one picture, with the reference's own variance taken out where a field says so.
///
/// `svetlo compare` finds the same numbers; intervals are from the picture's blocks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Metrics {
    /// Mean squared error less the reference's variance; negative below its noise.
    pub mse: Interval,
    /// Its root, negative ends of the interval cut at 0; `None` below the reference's noise.
    pub rmse: Option<Interval>,
    /// `rmse` over the mean of the reference.
    pub relative_rmse: Option<f64>,
    /// Mean variance of the reference that was taken out.
    pub reference_noise: f64,
    /// The picture's own estimate of its mean variance; `None` where it has fewer than two samples.
    pub own_noise: Option<f64>,
    /// The largest value of the reference: peak of `psnr_linear_db`.
    pub psnr_peak: f64,
    /// 10 log₁₀(peak²/`mse`); `None` where undefined.
    pub psnr_linear_db: Option<f64>,
    /// The same of sRGB codes clamped to 0..1, with peak 1; the reference's noise is not taken out.
    pub psnr_display_db: Option<f64>,
    /// Mean (x − r)²/(r² + ε), ε = (0.1 mean r)², less the reference's variance; `None` for a black reference.
    pub relmse: Option<Interval>,
    /// Mean |x − r|/(|r| + 0.1 mean r); the reference's noise is not taken out. `None` for a black reference.
    pub mape: Option<Interval>,
    /// Mean x − r, with the interval from the noise of both.
    pub bias: Interval,
    /// `bias` over the mean of the reference.
    pub relative_bias: Option<f64>,
    /// `bias` over its standard error.
    pub bias_z: Option<f64>,
    /// Mean squared error less the noise of both: the squared bias over pixels, however its sign changes; negative
    /// below the noise, `None` where a noise is unknown. The interval is from the noise alone.
    pub squared_bias: Option<Interval>,
}

/// What the repeats of a case say together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// One per checkpoint.
    pub points: Vec<Point>,
    /// Exponent of RMSE against samples, from all checkpoints: −1/2 for an unbiased estimate.
    pub slope: Option<Interval>,
    /// 1/(MSE · seconds) at the last checkpoint.
    pub efficiency: Option<Interval>,
    /// When the error falls below shares of the reference's mean.
    pub time_to_error: Vec<TimeToError>,
    /// Time to build the program.
    pub build: Option<Spread>,
    /// Time to load, plan and upload.
    pub prepare: Option<Spread>,
    /// Time to compute the light volume, for methods that project one.
    #[serde(default)]
    pub light: Option<Spread>,
    /// Its steps or estimates per second.
    #[serde(default)]
    pub light_iterations_per_second: Option<Spread>,
    /// Time of a pass of photons to trace them, for caustics.
    #[serde(default)]
    pub trace_seconds: Option<Spread>,
    /// Time of a pass to bring them in order.
    #[serde(default)]
    pub sort_seconds: Option<Spread>,
    /// Samples per pixel and second at the last checkpoint, the time of the light volume left out.
    pub samples_per_second: Option<Spread>,
    /// Look-ups per pixel and sample, at the last checkpoint.
    pub lookups_per_sample: Option<f64>,
    /// Look-ups per second, at the last checkpoint.
    pub lookups_per_second: Option<f64>,
}

/// A checkpoint over all repeats.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Samples per pixel, the median where checkpoints are in time.
    pub samples: f64,
    /// Wall time.
    pub seconds: Spread,
    /// Time in kernels.
    pub device_seconds: Spread,
    /// Root of the mean MSE of the repeats, the reference's variance taken out; `None` below its noise.
    pub rmse: Option<Interval>,
    /// `rmse` over the mean of the reference.
    pub relative_rmse: Option<Interval>,
    /// 10 log₁₀(peak²/MSE) of the same; peak is the largest value of the reference.
    pub psnr_linear_db: Option<f64>,
    /// Median of the repeats.
    pub relmse: Option<f64>,
    /// Median of the repeats.
    pub mape: Option<f64>,
    /// Median of the repeats.
    pub launches: f64,
    /// Median of the repeats.
    pub lookups: f64,
    /// Median of the repeats.
    pub bytes: f64,
}

/// A median with quartiles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// The median.
    pub median: f64,
    /// The first quartile.
    pub low: f64,
    /// The third quartile.
    pub high: f64,
    /// How many values.
    pub count: usize,
}

/// When the error falls below a limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimeToError {
    /// RMSE over the mean of the reference.
    pub relative_error: f64,
    /// Wall time.
    pub seconds: f64,
    /// Whether it lies between two checkpoints that were measured; else the n^−1/2 law was used.
    pub measured: bool,
}

/// Pictures of a case.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Images {
    /// Mean of all repeats as EXR; with two or more, `samples` is their number and `variance.*` that between them.
    pub image: Option<String>,
    /// Its preview, tone-mapped as the scene says.
    pub preview: Option<String>,
    /// The reference, tone-mapped alike.
    pub reference_preview: Option<String>,
    /// Image less reference, blue-white-red.
    pub difference: Option<String>,
    /// What full red or blue means.
    pub difference_scale: Option<f64>,
}

/// A number that others published, beside ours.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Published {
    /// Where, such as `P0 table 1`.
    pub source: String,
    /// On what, such as `Intel HD 530`.
    pub label: String,
    /// Name of the case that is compared.
    pub case: String,
    /// What it is of the case.
    pub measure: Measure,
    /// The published number.
    pub value: f64,
    /// Its unit, as published.
    pub unit: String,
    /// Ours per device selector, in the unit of `measure`.
    pub ours: Vec<Ours>,
    /// What to know about the comparison; may be empty.
    pub note: String,
}

/// Our side of a published number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ours {
    /// The device's selector.
    pub device: String,
    /// The number, with its quartiles where there are some.
    pub value: f64,
    /// First and third quartile.
    pub quartiles: Option<[f64; 2]>,
}

/// What can stand beside a published number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// Samples per pixel and second.
    SamplesPerSecond,
    /// Seconds per sample of every pixel.
    SecondsPerSample,
    /// Steps or estimates of the light volume per second.
    IterationsPerSecond,
    /// Milliseconds of a pass to bring photons in order: keys, sort, ranges of voxels.
    SortMilliseconds,
    /// PSNR at the last checkpoint, dB.
    Psnr,
    /// RMSE at the last checkpoint.
    Rmse,
}

/// Something that the reader should know.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// How bad it is.
    pub severity: Severity,
    /// What it is about.
    pub kind: FindingKind,
    /// The case, where it is about one.
    pub case: Option<String>,
    /// The device's selector, where it is about one.
    pub device: Option<String>,
    /// One sentence.
    pub text: String,
}

/// How bad a finding is; the worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// A gate is not met: exit code 3.
    Failure,
    /// A number is not what it seems.
    Warning,
    /// Good to know.
    Note,
}

/// What a finding is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FindingKind {
    /// The self-test failed on a device.
    Selftest,
    /// The mean differs from the reference by more than noise.
    Bias,
    /// The reference's own error is not well below the measured one.
    Reference,
    /// The error does not fall as it should.
    Slope,
    /// Samples that were not finite, or paths that went wrong.
    Rejected,
    /// Slower than in the baseline.
    Slower,
    /// Noisier than in the baseline.
    Noisier,
    /// More look-ups than in the baseline.
    Work,
    /// Nothing in the baseline to compare with.
    Baseline,
    /// A gate of the suite.
    Gate,
    /// Times that vary much.
    Spread,
    /// What is known of the picture does not hold.
    Truth,
    /// A case that must be refused was not, or not for its reason.
    Refusal,
    /// A case could not be measured, or took too long.
    Failed,
    /// Something is missing.
    Incomplete,
}
