//! One opened device: its context and its queue.

use super::{DeviceInfo, ProgramSpec, api};
use crate::{Error, Result};
use ocl::core::{self, CommandQueue, Context, ContextProperties};
use ocl::ffi;

/// An opened device. All work on it goes through one in-order queue.
pub struct Device {
    info: DeviceInfo,
    pub(super) context: Context,
    pub(super) queue: CommandQueue,
    /// What is done to every program before it is built.
    pub(super) alter: fn(ProgramSpec) -> ProgramSpec,
}

impl Device {
    /// Opens a device of the catalog.
    ///
    /// # Errors
    /// [`Error::Failed`] when the driver refuses a context or a queue.
    pub fn open(info: &DeviceInfo) -> Result<Self> {
        let fail = |what: &str, error: ocl::core::Error| {
            Error::Failed(format!("{}: cannot create an OpenCL {what}: {error}", info.name))
        };
        let properties = ContextProperties::new().platform(info.platform_id);
        let context = core::create_context(Some(&properties), &[info.device_id], None, None)
            .map_err(|error| fail("context", error))?;
        let queue = core::create_command_queue(&context, info.device_id, None)
            .map_err(|error| fail("command queue", error))?;
        Ok(Self { info: info.clone(), context, queue, alter: |spec| spec })
    }

    /// The same with programs that `alter` changes before they are built, which shows what a check of them finds.
    #[must_use]
    pub fn altering(self, alter: fn(ProgramSpec) -> ProgramSpec) -> Self {
        Self { alter, ..self }
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
        api::check(unsafe { ffi::clFinish(self.queue.as_ptr()) }, "clFinish")
    }

    pub(super) fn context_ptr(&self) -> ffi::cl_context {
        self.context.as_ptr()
    }
}
