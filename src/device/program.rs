//! Programs specialised by `-D` definitions, built for one device, with readable build logs.

use super::kernel::Kernel;
use super::{Call, Device, api, cache, source};
use crate::{Error, Result};
use ocl::core::{self, ClDeviceIdPtr};
use ocl::ffi;
use std::ffi::CString;
use std::time::{Duration, Instant};

/// What to build: an entry file of `cl/` and the definitions that specialise it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ProgramSpec {
    /// Path below `cl/`.
    pub entry: &'static str,
    /// `-D NAME=VALUE` pairs, in a fixed order.
    pub defines: Vec<(&'static str, String)>,
    /// Whether a product and a sum may become one operation, which rounds once.
    contracted: bool,
    /// Text to replace in the source, as (old, new): how tests make a kernel wrong. No scene leads to any.
    patches: Vec<(&'static str, &'static str)>,
}

impl ProgramSpec {
    /// A program of `entry` without definitions.
    pub fn new(entry: &'static str) -> Self {
        Self { entry, defines: Vec::new(), contracted: true, patches: Vec::new() }
    }

    /// Adds `-D name=value`.
    pub fn define(mut self, name: &'static str, value: impl ToString) -> Self {
        self.defines.push((name, value.to_string()));
        self
    }

    /// Adds `-D name=1` when `enabled`: a feature that is compiled in only when the scene needs it.
    pub fn feature(self, name: &'static str, enabled: bool) -> Self {
        if enabled { self.define(name, 1) } else { self }
    }

    /// Rounds every operation: for sums that keep what their rounding loses and have products in them.
    pub fn uncontracted(self) -> Self {
        Self { contracted: false, ..self }
    }

    /// Replaces text of the source, which must be there.
    pub fn patch(mut self, old: &'static str, new: &'static str) -> Self {
        self.patches.push((old, new));
        self
    }

    /// The source text, with everything that it includes.
    fn source(&self) -> Result<String> {
        self.patches.iter().try_fold(source::resolve(self.entry)?, |text, (old, new)| {
            if text.contains(old) {
                return Ok(text.replace(old, new));
            }
            Err(Error::Failed(format!("cl/{}: there is no `{old}` to be replaced", self.entry)))
        })
    }

    /// The compiler options.
    ///
    /// `-cl-mad-enable` is the only licence the compiler gets: every other relaxation would let it
    /// assume finite numbers or reorder sums (the film's two-float sums would be lost).
    pub fn options(&self) -> String {
        let mut text = String::from("-cl-std=CL1.2");
        if self.contracted {
            text.push_str(" -cl-mad-enable");
        }
        for (name, value) in &self.defines {
            text.push_str(&format!(" -D {name}={value}"));
        }
        text
    }
}

/// A built program.
pub struct Program {
    program: core::Program,
    /// Time to build, or to load from the cache.
    pub build_time: Duration,
    /// Whether the binary came from the cache.
    pub cached: bool,
}

impl Program {
    /// Builds `spec` for `device`, from the binary cache when it holds this very build.
    ///
    /// # Errors
    /// [`Error::Failed`] with the device's name, the options and the build log.
    pub fn build(device: &Device, spec: &ProgramSpec) -> Result<Self> {
        Self::build_probe(device, spec, "")
    }

    /// Builds a given source text; [`Program::build`] for everything under `cl/`.
    ///
    /// # Errors
    /// As [`Program::build`].
    pub fn build_source(device: &Device, source: &str, options: &str) -> Result<Self> {
        let _guard = api::one_at_a_time();
        let start = Instant::now();
        device.call(Call::Build, "clBuildProgram", || 0)?;
        let entry = cache::Entry::locate(device.info(), source, options);
        if let Some(program) = entry.as_ref().and_then(|entry| from_binary(device, entry, options)) {
            return Ok(Self { program, build_time: start.elapsed(), cached: true });
        }
        let program = from_source(device, source, options)?;
        if let Some(entry) = entry {
            entry.store(&program);
        }
        Ok(Self { program, build_time: start.elapsed(), cached: false })
    }

    /// Builds `spec` with `kernels` appended, so that a test can call the functions of a file under `cl/`.
    ///
    /// # Errors
    /// As [`Program::build`].
    pub fn build_probe(device: &Device, spec: &ProgramSpec, kernels: &str) -> Result<Self> {
        let spec = (device.alter)(spec.clone());
        let mut source = spec.source()?;
        if !kernels.is_empty() {
            source = source + "#line 1 \"probe\"\n" + kernels;
        }
        if device.info().can_force_inlining() {
            return Self::build_source(device, &source, &spec.options());
        }
        let spec = spec.define("INLINE", "inline");
        Self::build_source(device, &source, &spec.options())
    }

    /// One of the program's kernels.
    ///
    /// # Errors
    /// [`Error::Failed`] when there is no such kernel.
    pub fn kernel(&self, device: &Device, name: &'static str) -> Result<Kernel> {
        Kernel::create(device, &self.program, name)
    }
}

fn from_binary(device: &Device, entry: &cache::Entry, options: &str) -> Option<core::Program> {
    let binary = entry.load()?;
    let ids = [device.info().device_id];
    let program = core::create_program_with_binary(&device.context, &ids, &[&binary]).ok()?;
    compile(device, &program, options).ok()?;
    Some(program)
}

fn from_source(device: &Device, source: &str, options: &str) -> Result<core::Program> {
    let text =
        CString::new(source).map_err(|_| Error::Failed("a kernel source contains a NUL byte".into()))?;
    let program = core::create_program_with_source(&device.context, &[text]).map_err(|error| {
        Error::Failed(format!("{}: cannot create a program: {error}", device.info().name))
    })?;
    compile(device, &program, options)?;
    Ok(program)
}

/// Builds and then asks the device for the status itself: a failed build must not pass because its log is empty.
fn compile(device: &Device, program: &core::Program, options: &str) -> Result<()> {
    let options_text =
        CString::new(options).map_err(|_| Error::Failed("build options contain a NUL byte".into()))?;
    let id = device.info().device_id;
    // SAFETY: one device of this program's context, a NUL-terminated string, no callback.
    let status = unsafe {
        let raw = id.as_ptr();
        ffi::clBuildProgram(program.as_ptr(), 1, &raw, options_text.as_ptr(), None, std::ptr::null_mut())
    };
    let built = matches!(
        core::get_program_build_info(program, id, core::ProgramBuildInfo::BuildStatus),
        Ok(core::ProgramBuildInfoResult::BuildStatus(core::ProgramBuildStatus::Success))
    );
    if status == 0 && built {
        return Ok(());
    }
    let reason =
        api::check(status, "clBuildProgram").err().map_or_else(String::new, |error| error.to_string());
    Err(Error::Failed(format!(
        "{} ({}): the kernels do not build; {reason}\n  options: {options}\n{}",
        device.info().name,
        device.info().driver,
        readable_log(&build_log(program, id))
    )))
}

fn build_log(program: &core::Program, id: core::DeviceId) -> String {
    let mut size = 0;
    let query = ffi::CL_PROGRAM_BUILD_LOG;
    // SAFETY: the first call asks for the size, the second fills a vector of that size.
    let log = unsafe {
        ffi::clGetProgramBuildInfo(program.as_ptr(), id.as_ptr(), query, 0, std::ptr::null_mut(), &mut size);
        let mut log = vec![0_u8; size];
        let target = log.as_mut_ptr().cast();
        ffi::clGetProgramBuildInfo(program.as_ptr(), id.as_ptr(), query, size, target, std::ptr::null_mut());
        log
    };
    String::from_utf8_lossy(&log).trim_end_matches('\0').trim().to_string()
}

/// The first lines of a build log, indented: compilers repeat themselves for pages.
fn readable_log(log: &str) -> String {
    const LINES: usize = 40;
    if log.is_empty() {
        return "  (the compiler gave no log)".into();
    }
    let mut text: String =
        log.lines().take(LINES).map(|line| format!("  {line}")).collect::<Vec<_>>().join("\n");
    let rest = log.lines().count().saturating_sub(LINES);
    if rest > 0 {
        text.push_str(&format!("\n  … and {rest} more lines"));
    }
    text
}
