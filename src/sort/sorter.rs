//! The sorts' common part: buffers of the result, checks, which form a device is best at.

use super::bitonic::Bitonic;
use super::queue::{Queue, WORD, Work, arguments};
use super::radix::Radix;
use crate::device::{Buffer, Device, DeviceInfo, DeviceKind, Kernel, MemoryPlan, Program, ProgramSpec};
use crate::{Error, Result};
use bytemuck::Pod;

/// How to sort.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SortKind {
    /// By digits from the lowest, as many passes as the keys' bits need: O(n).
    Radix,
    /// By a bitonic network over the next power of two, whatever the bits: O(n log² n).
    Bitonic,
}

/// What a work-item does. Both forms give the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// A work-item goes through a block of items, which the cache holds: for CPUs.
    Items,
    /// A work-group goes through a block of items in local memory: for GPUs.
    Groups,
}

impl Form {
    /// The form that a device is best at.
    pub fn of(info: &DeviceInfo) -> Self {
        // Blocks of one work-item have more turns of loops than such devices allow.
        if info.kind == DeviceKind::Cpu && !info.ends_long_loops() { Self::Items } else { Self::Groups }
    }
}

/// Keys: `u32` or `u64`. That of all ones is no item's.
pub trait SortKey: Pod + sealed::Sealed {
    /// Bits of a key.
    const BITS: u32;
}

impl SortKey for u32 {
    const BITS: u32 = Self::BITS;
}

impl SortKey for u64 {
    const BITS: u32 = Self::BITS;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for u32 {}
    impl Sealed for u64 {}
}

/// Sorts up to `capacity` items on one device.
pub struct Sorter<K: SortKey> {
    method: Method,
    valid: Kernel,
    output: Output<K>,
    capacity: usize,
    count: usize,
    work: Work,
}

enum Method {
    Radix(Radix),
    Bitonic(Bitonic),
}

/// What a method is asked for: to sort the first `count` keys, at least one.
pub(super) struct Job<'a, K> {
    pub keys: &'a Buffer<K>,
    pub count: usize,
    pub out: &'a Output<K>,
}

/// Where a pass reads (`SOURCE_…` in `cl/sort/words.cl`).
pub(super) const SOURCE_KEYS: u32 = 0;
pub(super) const SOURCE_PASS: u32 = 1;
pub(super) const SOURCE_UPPER: u32 = 2;

/// Where the result goes.
pub(super) struct Output<K> {
    pub keys: Buffer<K>,
    pub indices: Buffer<u32>,
    pub valid: Buffer<u32>,
}

/// Items in the order of their keys. The buffers may be longer than `count`.
#[derive(Clone, Copy)]
pub struct Sorted<'a, K> {
    /// The keys, ascending.
    pub keys: &'a Buffer<K>,
    /// The number of each item.
    pub indices: &'a Buffer<u32>,
    /// One element: how many keys are not all ones.
    pub valid: &'a Buffer<u32>,
    /// Items, with those that have no key.
    pub count: usize,
    /// What it took.
    pub work: Work,
}

impl<K> Sorted<'_, K> {
    /// How many items have a key; waits.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device fails.
    pub fn valid(&self, device: &Device) -> Result<usize> {
        Ok(self.valid.read(device)?[0] as usize)
    }
}

/// The program of a file of `cl/sort/` for keys of so many bits.
pub(super) fn program(device: &Device, entry: &'static str, key_bits: u32) -> Result<Program> {
    let spec = ProgramSpec::new(entry).define("KEY_BITS", key_bits);
    let spec = if device.info().can_force_inlining() { spec } else { spec.define("INLINE", "inline") };
    Program::build(device, &spec)
}

impl<K: SortKey> Sorter<K> {
    /// A sorter in the form that the device is best at.
    ///
    /// # Errors
    /// [`Error::Failed`] when the kernels do not build, the device has no room, or nothing can count so many items.
    pub fn new(device: &Device, kind: SortKind, capacity: usize) -> Result<Self> {
        Self::with_form(device, kind, Form::of(device.info()), capacity)
    }

    /// A sorter in a given form.
    ///
    /// # Errors
    /// As [`Sorter::new`].
    pub fn with_form(device: &Device, kind: SortKind, form: Form, capacity: usize) -> Result<Self> {
        // The next power of two and one more tile must fit 32 bits.
        const LARGEST: usize = 1 << 31;
        if capacity > LARGEST {
            return Err(Error::Failed(format!("cannot sort {capacity} items, only up to {LARGEST}")));
        }
        let method = match kind {
            SortKind::Radix => Method::Radix(Radix::new(device, form, K::BITS, capacity)?),
            SortKind::Bitonic => Method::Bitonic(Bitonic::new(device, form, K::BITS, capacity)?),
        };
        let output = Output {
            keys: Buffer::uninitialised(device, capacity)?,
            indices: Buffer::uninitialised(device, capacity)?,
            valid: Buffer::from_slice(device, &[0])?,
        };
        let valid = program(device, "sort/valid.cl", K::BITS)?.kernel(device, "sorted_valid")?;
        Ok(Self { method, valid, output, capacity, count: 0, work: Work::default() })
    }

    /// What a sorter takes of a device.
    pub fn memory(info: &DeviceInfo, kind: SortKind, capacity: usize) -> MemoryPlan {
        let mut plan = MemoryPlan::default();
        plan.add("sorted keys", capacity as u64, size_of::<K>());
        plan.add("sorted numbers", capacity as u64, size_of::<u32>());
        let form = Form::of(info);
        match kind {
            SortKind::Radix => Radix::add_memory(&mut plan, info, form, capacity),
            SortKind::Bitonic => Bitonic::add_memory(&mut plan, K::BITS, capacity),
        }
        plan
    }

    /// Sorts the first `count` keys, each below 2^`bits` − 1 or all ones. Does not wait.
    ///
    /// # Errors
    /// [`Error::Failed`] when there are more keys than the capacity, more bits than a key has, or the device fails.
    pub fn sort(
        &mut self,
        device: &Device,
        keys: &Buffer<K>,
        count: usize,
        bits: u32,
    ) -> Result<Sorted<'_, K>> {
        let most = self.capacity.min(keys.len());
        if count > most || !(1..=K::BITS).contains(&bits) {
            return Err(Error::Failed(format!(
                "cannot sort {count} keys of {bits} bits: this sorter takes up to {most} keys of 1 to {} bits",
                K::BITS
            )));
        }
        let mut queue = Queue::new(device);
        let out = &self.output;
        let job = Job { keys, count, out };
        match &mut self.method {
            _ if count == 0 => (),
            Method::Radix(radix) => radix.sort(&mut queue, &job, bits)?,
            Method::Bitonic(bitonic) => bitonic.sort(&mut queue, &job, bits)?,
        }
        queue.launch(&mut self.valid, arguments![&out.valid, &out.keys, count as u32], 1, WORD)?;
        (self.count, self.work) = (count, queue.work);
        Ok(self.sorted())
    }

    /// What the last sort gave; nothing before the first.
    pub fn sorted(&self) -> Sorted<'_, K> {
        let Output { keys, indices, valid } = &self.output;
        Sorted { keys, indices, valid, count: self.count, work: self.work }
    }
}
