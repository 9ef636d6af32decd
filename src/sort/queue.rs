//! Launches that are counted.

use crate::Result;
use crate::device::{Arg, Device, Kernel};

/// Bytes of a 32-bit number.
pub(super) const WORD: usize = size_of::<u32>();

/// What sorting or filling asked of the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Kernel launches.
    pub launches: u32,
    /// Bytes read and written in global memory, as if no cache kept any.
    pub bytes: u64,
}

/// Kernel arguments from buffers and numbers.
macro_rules! arguments {
    ($($value:expr),* $(,)?) => { &[$($crate::device::Arg::from($value)),*] };
}
pub(super) use arguments;

/// A device with a count of what it is asked for.
pub(super) struct Queue<'a> {
    pub device: &'a Device,
    pub work: Work,
}

impl<'a> Queue<'a> {
    pub fn new(device: &'a Device) -> Self {
        Self { device, work: Work::default() }
    }

    /// Enqueues `items` work-items that move so many bytes.
    pub fn launch(
        &mut self,
        kernel: &mut Kernel,
        arguments: &[Arg<'_>],
        items: usize,
        bytes: usize,
    ) -> Result<()> {
        kernel.enqueue(self.device, arguments, [items, 1, 1])?;
        self.work.launches += 1;
        self.work.bytes += bytes as u64;
        Ok(())
    }

    /// Enqueues so many work-groups of the kernel's size.
    pub fn launch_groups(
        &mut self,
        kernel: &mut Kernel,
        arguments: &[Arg<'_>],
        groups: usize,
        bytes: usize,
    ) -> Result<()> {
        let items = groups * kernel.work_group();
        self.launch(kernel, arguments, items, bytes)
    }
}
