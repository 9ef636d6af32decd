//! One opened device: its context and its queue.

use super::{Call, DeviceInfo, Faults, ProgramSpec, api};
use crate::{Error, Result};
use ocl::core::{self, CommandQueue, Context, ContextProperties};
use ocl::ffi;
use std::fmt::Display;
use std::sync::Arc;

/// An opened device. All work on it, and on its clones, goes through one in-order queue.
#[derive(Clone)]
pub struct Device {
    info: DeviceInfo,
    pub(super) context: Context,
    pub(super) queue: CommandQueue,
    /// What is done to every program before it is built.
    pub(super) alter: fn(ProgramSpec) -> ProgramSpec,
    /// Which calls fail, in tests.
    faults: Option<Arc<Faults>>,
}

impl Device {
    /// Opens a device of the catalog.
    ///
    /// # Errors
    /// [`Error::Failed`] when the driver refuses a context or a queue; [`Error::Input`] for a `SVETLO_FAULT` that is none.
    pub fn open(info: &DeviceInfo) -> Result<Self> {
        let faults = Faults::of_environment(&info.selector)?;
        call(info, faults.as_deref(), Call::Open, "clCreateContext", || 0)?;
        let fail = |what: &str, error: ocl::core::Error| {
            Error::Failed(format!("{}: cannot create an OpenCL {what}: {error}", info.name))
        };
        let properties = ContextProperties::new().platform(info.platform_id);
        let context = core::create_context(Some(&properties), &[info.device_id], None, None)
            .map_err(|error| fail("context", error))?;
        let queue = core::create_command_queue(&context, info.device_id, None)
            .map_err(|error| fail("command queue", error))?;
        Ok(Self { info: info.clone(), context, queue, alter: |spec| spec, faults })
    }

    /// The same with programs that `alter` changes before they are built, which shows what a check of them finds.
    #[must_use]
    pub fn altering(self, alter: fn(ProgramSpec) -> ProgramSpec) -> Self {
        Self { alter, ..self }
    }

    /// The same with calls that fail as planned; what was planned before is forgotten.
    ///
    /// # Errors
    /// [`Error::Failed`] when opening a device is planned to fail.
    pub fn failing(self, faults: impl Into<Arc<Faults>>) -> Result<Self> {
        let faults = faults.into();
        call(&self.info, Some(&faults), Call::Open, "clCreateContext", || 0)?;
        Ok(Self { faults: Some(faults), ..self })
    }

    /// What the device can do.
    pub fn info(&self) -> &DeviceInfo {
        &self.info
    }

    /// Waits until all enqueued work is done.
    ///
    /// # Errors
    /// [`Error::Failed`] when work on the queue failed.
    pub fn finish(&self) -> Result<()> {
        // SAFETY: the queue is alive as long as `self`.
        self.call(Call::Finish, "clFinish", || unsafe { ffi::clFinish(self.queue.as_ptr()) })
    }

    /// Runs an OpenCL call and makes an error of its status that names the device and `what` failed.
    pub(super) fn call(&self, kind: Call, what: impl Display, run: impl FnOnce() -> i32) -> Result<()> {
        call(&self.info, self.faults.as_deref(), kind, what, run)
    }

    /// Notes the launch of a kernel, where a plan of failures counts calls.
    pub(super) fn launched(&self, kernel: &'static str) {
        if let Some(faults) = &self.faults {
            faults.launched(kernel);
        }
    }

    pub(super) fn context_ptr(&self) -> ffi::cl_context {
        self.context.as_ptr()
    }
}

fn call(
    info: &DeviceInfo,
    faults: Option<&Faults>,
    kind: Call,
    what: impl Display,
    run: impl FnOnce() -> i32,
) -> Result<()> {
    let planned = faults.and_then(|faults| faults.next(kind));
    api::check(planned.unwrap_or_else(run), what)
        .map_err(|error| Error::Failed(format!("{}: {error}", info.name)))
}
