//! Kernels and their launches, checked before the driver sees them.

use super::{Buffer, Device, api};
use crate::{Error, Result};
use bytemuck::Pod;
use ocl::core::{self, ArgVal, KernelInfo, KernelInfoResult, KernelWorkGroupInfo, KernelWorkGroupInfoResult};
use ocl::ffi;
use std::time::{Duration, Instant};

/// Work-items per work-group of all one-dimensional launches: an 8×8 tile of pixels.
pub const WORK_GROUP: usize = 64;

/// A kernel argument.
pub enum Arg<'a> {
    /// A buffer.
    Buffer(&'a core::Mem),
    /// A 32-bit number.
    U32(u32),
}

impl<'a, T: Pod> From<&'a Buffer<T>> for Arg<'a> {
    fn from(buffer: &'a Buffer<T>) -> Self {
        Self::Buffer(&buffer.mem)
    }
}

impl From<u32> for Arg<'_> {
    fn from(value: u32) -> Self {
        Self::U32(value)
    }
}

/// A kernel of a built program. Setting arguments is not thread-safe in OpenCL, so launching takes `&mut self`.
pub struct Kernel {
    kernel: core::Kernel,
    name: &'static str,
    arguments: u32,
    work_group: usize,
}

impl Kernel {
    pub(super) fn create(device: &Device, program: &core::Program, name: &'static str) -> Result<Self> {
        let kernel = core::create_kernel(program, name).map_err(|error| {
            Error::Failed(format!("{}: the program has no kernel '{name}': {error}", device.info().name))
        })?;
        let arguments = match core::get_kernel_info(&kernel, KernelInfo::NumArgs) {
            Ok(KernelInfoResult::NumArgs(count)) => count,
            _ => {
                return Err(Error::Failed(format!(
                    "kernel '{name}': the driver does not say how many arguments it takes"
                )));
            }
        };
        let limit = core::get_kernel_work_group_info(
            &kernel,
            device.info().device_id,
            KernelWorkGroupInfo::WorkGroupSize,
        );
        let device_limit = device.info().max_work_group;
        let work_group = match limit {
            Ok(KernelWorkGroupInfoResult::WorkGroupSize(size)) if size > 0 => size.min(device_limit),
            _ => device_limit,
        };
        Ok(Self { kernel, name, arguments, work_group: largest_power_of_two(work_group.min(WORK_GROUP)) })
    }

    /// Launches groups of at most this many work-items from now on.
    pub fn limit_work_group(&mut self, items: usize) {
        self.work_group = self.work_group.min(items.max(1));
    }

    /// Runs `items` work-items (rounded up to whole work-groups: kernels must guard) and waits for them.
    ///
    /// # Errors
    /// [`Error::Failed`] when the number of arguments is wrong or the device fails.
    pub fn run(&mut self, device: &Device, arguments: &[Arg<'_>], items: usize) -> Result<Duration> {
        if arguments.len() != self.arguments as usize {
            return Err(Error::Failed(format!(
                "kernel '{}' takes {} arguments, {} were given",
                self.name,
                self.arguments,
                arguments.len()
            )));
        }
        for (index, argument) in arguments.iter().enumerate() {
            let value = match argument {
                Arg::Buffer(mem) => ArgVal::mem(mem),
                Arg::U32(value) => ArgVal::scalar(value),
            };
            core::set_kernel_arg(&self.kernel, index as u32, value).map_err(|error| {
                Error::Failed(format!("kernel '{}', argument {index}: {error}", self.name))
            })?;
        }
        let start = Instant::now();
        self.enqueue(device, items)?;
        device.finish().map_err(|error| Error::Failed(format!("kernel '{}': {error}", self.name)))?;
        Ok(start.elapsed())
    }

    fn enqueue(&self, device: &Device, items: usize) -> Result<()> {
        let local = self.work_group;
        let global = items.div_ceil(local) * local;
        if global == 0 {
            return Ok(());
        }
        // SAFETY: all arguments are set (their number was checked), the buffers outlive the launch because `run`
        // waits for it, and every kernel under `cl/` guards its index against the counts it is given.
        let status = unsafe {
            ffi::clEnqueueNDRangeKernel(
                device.queue.as_ptr(),
                self.kernel.as_ptr(),
                1,
                std::ptr::null(),
                &global,
                &local,
                0,
                std::ptr::null(),
                std::ptr::null_mut(),
            )
        };
        api::check(
            status,
            &format!("launching kernel '{}' over {global} items in groups of {local}", self.name),
        )
    }
}

fn largest_power_of_two(limit: usize) -> usize {
    1 << limit.max(1).ilog2()
}
