//! Kernels and their launches, checked before the driver sees them.

use super::{Buffer, Call, Device};
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
    /// A float.
    F32(f32),
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

impl From<f32> for Arg<'_> {
    fn from(value: f32) -> Self {
        Self::F32(value)
    }
}

/// A kernel of a built program. Setting arguments is not thread-safe in OpenCL, so launching takes `&mut self`.
pub struct Kernel {
    kernel: core::Kernel,
    name: &'static str,
    arguments: u32,
    work_group: usize,
    /// The most work-items per work-group that driver and device allow.
    largest: usize,
}

impl Kernel {
    pub(super) fn create(device: &Device, program: &core::Program, name: &'static str) -> Result<Self> {
        device.call(Call::Kernel, format_args!("clCreateKernel '{name}'"), || 0)?;
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
        let largest = match limit {
            Ok(KernelWorkGroupInfoResult::WorkGroupSize(size)) if size > 0 => size.min(device_limit),
            _ => device_limit,
        };
        let work_group = largest_power_of_two(largest.min(WORK_GROUP));
        Ok(Self { kernel, name, arguments, work_group, largest })
    }

    /// Launches groups of at most this many work-items from now on.
    pub fn limit_work_group(&mut self, items: usize) {
        self.work_group = largest_power_of_two(self.work_group.min(items.max(1)));
    }

    /// Launches groups of `items`, a power of two, from now on, or of as many as driver and device allow.
    pub fn set_work_group(&mut self, items: usize) {
        self.work_group = largest_power_of_two(self.largest.min(items));
    }

    /// Work-items per work-group of one-dimensional launches: for kernels whose groups share local memory.
    pub fn work_group(&self) -> usize {
        self.work_group
    }

    /// Runs `items` work-items (rounded up to whole work-groups: kernels must guard) and waits for them.
    ///
    /// # Errors
    /// [`Error::Failed`] when the number of arguments is wrong or the device fails.
    pub fn run(&mut self, device: &Device, arguments: &[Arg<'_>], items: usize) -> Result<Duration> {
        let start = Instant::now();
        self.enqueue(device, arguments, [items, 1, 1])?;
        device.finish().map_err(|error| Error::Failed(format!("kernel '{}': {error}", self.name)))?;
        Ok(start.elapsed())
    }

    /// As [`Kernel::run`] over three dimensions (x is the fastest), without waiting: later work on the device comes
    /// after, and what fails shows there.
    ///
    /// # Errors
    /// [`Error::Failed`] when the number of arguments is wrong or the device refuses.
    pub fn enqueue(&mut self, device: &Device, arguments: &[Arg<'_>], items: [usize; 3]) -> Result<()> {
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
                Arg::F32(value) => ArgVal::scalar(value),
            };
            core::set_kernel_arg(&self.kernel, index as u32, value).map_err(|error| {
                Error::Failed(format!("kernel '{}', argument {index}: {error}", self.name))
            })?;
        }
        self.launch(device, items)
    }

    fn launch(&self, device: &Device, items: [usize; 3]) -> Result<()> {
        if items.contains(&0) {
            return Ok(());
        }
        let local = group_shape(self.work_group, items);
        let global: [usize; 3] = std::array::from_fn(|axis| items[axis].next_multiple_of(local[axis]));
        let dimensions = if items[1..] == [1, 1] { 1 } else { 3 };
        device.launched(self.name);
        let kernel = &self.name;
        let what = format!("launching kernel '{kernel}' over {global:?} items in groups of {local:?}");
        // SAFETY: all arguments are set (their number was checked), OpenCL keeps the buffers until the launch is
        // done, and every kernel under `cl/` guards its index against the counts it is given.
        device.call(Call::Launch, what, || unsafe {
            ffi::clEnqueueNDRangeKernel(
                device.queue.as_ptr(),
                self.kernel.as_ptr(),
                dimensions,
                std::ptr::null(),
                global.as_ptr(),
                local.as_ptr(),
                0,
                std::ptr::null(),
                std::ptr::null_mut(),
            )
        })
    }
}

/// A work-group of `size` items, a power of two: in three dimensions a part of a slice. It is the same for every such
/// range, because some drivers compile a kernel again for each shape.
fn group_shape(size: usize, [_, ny, nz]: [usize; 3]) -> [usize; 3] {
    const ALONG_X: usize = 16;
    if [ny, nz] == [1, 1] {
        return [size, 1, 1];
    }
    let x = size.min(ALONG_X);
    [x, size / x, 1]
}

fn largest_power_of_two(limit: usize) -> usize {
    1 << limit.max(1).ilog2()
}

#[cfg(test)]
mod tests {
    use super::group_shape;

    #[test]
    fn groups_follow_the_range() {
        assert_eq!(group_shape(64, [5, 1, 1]), [64, 1, 1]);
        assert_eq!(group_shape(64, [200, 3, 3]), [16, 4, 1]);
        assert_eq!(group_shape(8, [1, 3, 7]), [8, 1, 1]);
    }
}
