//! What the checks share: scenes from text, renders on the device, functions of the kernels, and what they measure.

use crate::device::{Buffer, Device, DeviceInfo, Program, ProgramSpec};
use crate::film::FilmPixel;
use crate::reference::random::{philox4x32, uniform};
use crate::render::{BRICK_SHIFT, PathLedger, Plan, Session};
use crate::scene::Scene;
use crate::volume::{Volume, Voxels};
use crate::{Error, Result};
use glam::DVec3;
use std::path::Path;

/// Relative error of one float32 operation.
pub const EPS: f64 = 1.0 / (1 << 24) as f64;

/// Standard errors that a comparison may be off: chance exceeds them once in 1.7 million.
pub const K: f64 = 5.0;

/// The device, and what is done to programs before they are built.
pub struct Workbench {
    pub info: DeviceInfo,
    pub alter: fn(ProgramSpec) -> ProgramSpec,
}

/// A number found on the device beside the right one.
pub struct Measurement {
    pub quantity: String,
    pub measured: f64,
    pub expected: f64,
    pub tolerance: f64,
    /// Where the tolerance comes from.
    pub reason: String,
    /// Why this device is known to be outside of it without harm.
    pub limit: Option<String>,
}

impl Measurement {
    /// A count that leaves no room.
    pub fn exact(quantity: impl Into<String>, measured: f64, expected: f64) -> Self {
        Self::within(quantity, measured, expected, 0.0, "exact")
    }

    /// A number with a bound on its rounding.
    pub fn within(
        quantity: impl Into<String>,
        measured: f64,
        expected: f64,
        tolerance: f64,
        reason: impl Into<String>,
    ) -> Self {
        let (quantity, reason) = (quantity.into(), reason.into());
        Self { quantity, measured, expected, tolerance, reason, limit: None }
    }

    /// The mean of random numbers whose standard error is known beforehand; `systematic` is what else it may be off.
    pub fn mean(
        quantity: impl Into<String>,
        measured: f64,
        expected: f64,
        sigma: f64,
        systematic: f64,
        why: &str,
    ) -> Self {
        let reason = format!("{K} σ, σ = {sigma:.1e}: {why}");
        Self::within(quantity, measured, expected, K * sigma + systematic, reason)
    }

    /// Gives the reason for which it may be outside.
    pub fn limited(self, reason: Option<String>) -> Self {
        Self { limit: reason, ..self }
    }
}

/// A finished render.
pub struct Rendered {
    pub film: Vec<FilmPixel>,
    pub paths: PathLedger,
}

impl Rendered {
    /// The mean over the pixels of a channel; samples that were refused make it no number.
    pub fn mean(&self, channel: usize) -> f64 {
        if self.film.iter().any(|pixel| pixel.rejected > 0) {
            return f64::NAN;
        }
        self.film.iter().map(|pixel| pixel.mean()[channel]).sum::<f64>() / self.film.len() as f64
    }

    /// The largest difference from `expected` of all pixels and of the channels given; no number where samples are missing.
    pub fn largest_error(&self, channels: std::ops::Range<usize>, expected: f64) -> f64 {
        let error = |pixel: &FilmPixel| {
            if pixel.rejected > 0 || pixel.count == 0 {
                return f64::NAN;
            }
            pixel.mean()[channels.clone()].iter().map(|v| (v - expected).abs()).fold(0.0, maximum)
        };
        self.film.iter().map(error).fold(0.0, maximum)
    }
}

/// The larger number, or none where one is none.
pub fn maximum(a: f64, b: f64) -> f64 {
    if a.is_nan() || b <= a { a } else { b }
}

/// A scene and its volume.
pub struct Case {
    pub scene: Scene,
    pub volume: Volume,
}

impl Case {
    /// `text`: a scene whose table `[volume]` says only where the box lies.
    ///
    /// # Errors
    /// [`Error::Input`] when the text is no scene.
    pub fn new(text: &str, volume: Volume) -> Result<Self> {
        let text = text.replace("[volume]", "[volume]\nfield = { kind = \"constant\" }\ndims = [1, 1, 1]");
        let scene = Scene::from_loaded(&crate::config::parse("self-test", &text, &[])?, Path::new("/"))?;
        Ok(Self { scene, volume })
    }

    /// The plan with the usual bricks.
    ///
    /// # Errors
    /// As [`Plan::new`].
    pub fn plan(&self) -> Result<Plan<'_>> {
        Plan::new(&self.scene, &self.volume, BRICK_SHIFT)
    }
}

impl Workbench {
    /// A session of the case.
    ///
    /// # Errors
    /// As [`Session::new`].
    pub fn session(&self, case: &Case) -> Result<Session> {
        self.session_on(&self.info, case)
    }

    /// A session on the device described as `info`.
    ///
    /// # Errors
    /// As [`Session::new`].
    pub fn session_on(&self, info: &DeviceInfo, case: &Case) -> Result<Session> {
        let mut plan = case.plan()?;
        plan.spec = (self.alter)(plan.spec);
        Session::new(Device::open(info)?, &plan)
    }

    /// Renders `samples` samples per pixel.
    ///
    /// # Errors
    /// As [`Session::render`].
    pub fn render(&self, case: &Case, samples: u32) -> Result<Rendered> {
        finish(self.session(case)?, samples)
    }

    /// Maps each `[u32; 8]` `x` to four words `out[i]` by statements over the functions of a file below `cl/`.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device fails.
    pub fn map(&self, spec: ProgramSpec, body: &str, inputs: &[[u32; 8]]) -> Result<Vec<[u32; 4]>> {
        let kernel = format!(
            "__kernel void probe(__global const uint8 *in, __global uint4 *out, uint count) {{\n\
             size_t i = get_global_id(0);\nif (i >= count) return;\nuint8 x = in[i];\n{body}\n}}\n"
        );
        let device = Device::open(&self.info)?;
        let program = self.probe(&device, spec, &kernel)?;
        let input = Buffer::from_slice(&device, inputs)?;
        let output = Buffer::<[u32; 4]>::zeroed(&device, inputs.len())?;
        let arguments = [(&input).into(), (&output).into(), (inputs.len() as u32).into()];
        program.kernel(&device, "probe")?.run(&device, &arguments, inputs.len())?;
        output.read(&device)
    }

    /// A file below `cl/` with kernels of a check appended.
    ///
    /// # Errors
    /// [`Error::Failed`] when it does not build.
    pub fn probe(&self, device: &Device, spec: ProgramSpec, kernels: &str) -> Result<Program> {
        Program::build_probe(device, &(self.alter)(spec), kernels)
    }
}

/// Renders a session to its end.
///
/// # Errors
/// [`Error::Failed`] when the device fails.
pub fn finish(mut session: Session, samples: u32) -> Result<Rendered> {
    session.render(samples)?;
    Ok(Rendered { film: session.film()?, paths: session.ledger()?.unwrap_or_default() })
}

/// Uniform numbers in [0, 1), the same in every run.
pub fn noise(count: usize, seed: u32) -> Vec<f64> {
    (0..count as u32).map(|i| uniform(philox4x32([i, seed, 0, 0], [0x5eed, 0])[0])).collect()
}

/// A volume of float32 voxels of spacing 1.
///
/// # Errors
/// [`Error::Failed`] when the numbers are not as many as the voxels.
pub fn volume(dims: [usize; 3], values: impl IntoIterator<Item = f64>) -> Result<Volume> {
    let values: Vec<f32> = values.into_iter().map(|value| value as f32).collect();
    Volume::new(dims, DVec3::ONE, Voxels::F32(values))
        .map_err(|error| Error::Failed(format!("the self-test's volume: {error}")))
}
