//! Bitonic sort: runs of 2, 4, 8, … elements are merged, blocks of them at once where they fit.

use super::queue::{Queue, WORD, arguments};
use super::sorter::{Form, Job, SOURCE_KEYS, SOURCE_UPPER, SortKey, program};
use crate::Result;
use crate::device::{Buffer, Device, Kernel, MemoryPlan};

/// Elements that a work-item exchanges between blocks, of each stream (`SPAN` in `cl/sort/bitonic_items.cl`).
const SPAN: usize = 1024;
/// Elements of a work-item's vector: a block has at least one.
const VECTOR: usize = 8;
/// Work-items of a group at most.
const GROUP: usize = 256;
const ELEMENT: usize = size_of::<u64>();

/// Kernels and what is kept between launches.
pub(super) struct Bitonic {
    form: Form,
    sort: Kernel,
    merge: Kernel,
    exchange: Kernel,
    /// Word, and number in the lower half.
    elements: Buffer<u64>,
    /// The order of the lower words, while that of the upper ones is sought.
    order: Buffer<u32>,
}

impl Bitonic {
    pub fn new(device: &Device, form: Form, key_bits: u32, capacity: usize) -> Result<Self> {
        let (entry, group) = match form {
            Form::Items => ("sort/bitonic_items.cl", 1),
            Form::Groups => ("sort/bitonic_groups.cl", GROUP),
        };
        let program = program(device, entry, key_bits)?;
        let kernel = |name| -> Result<Kernel> {
            let mut kernel = program.kernel(device, name)?;
            kernel.set_work_group(group);
            Ok(kernel)
        };
        Ok(Self {
            form,
            sort: kernel("bitonic_sort")?,
            merge: kernel("bitonic_merge")?,
            exchange: kernel("bitonic_exchange")?,
            elements: Buffer::uninitialised(device, padded(capacity))?,
            order: Buffer::uninitialised(device, order(key_bits, capacity))?,
        })
    }

    pub fn add_memory(plan: &mut MemoryPlan, key_bits: u32, capacity: usize) {
        plan.add("elements of a bitonic sort", padded(capacity) as u64, ELEMENT);
        plan.add("order of lower words", order(key_bits, capacity) as u64, WORD);
    }

    /// Sorts at least one key.
    pub fn sort<K: SortKey>(&mut self, queue: &mut Queue<'_>, job: &Job<'_, K>, bits: u32) -> Result<()> {
        if bits <= u32::BITS {
            return self.sort_words(queue, job, SOURCE_KEYS, true);
        }
        self.sort_words(queue, job, SOURCE_KEYS, false)?;
        self.sort_words(queue, job, SOURCE_UPPER, true)
    }

    /// Sorts by one word of the keys; `finish`: it is the last.
    fn sort_words<K: SortKey>(
        &mut self,
        queue: &mut Queue<'_>,
        &Job { keys, count, out }: &Job<'_, K>,
        source: u32,
        finish: bool,
    ) -> Result<()> {
        let padded = padded(count);
        let block = padded.min(block(self.form));
        let blocks = padded / block;
        let (sorted, elements, order) = (&out.keys, &self.elements, &self.order);
        let indices = if finish { &out.indices } else { order };
        let [block_, blocks_, items] = [block, blocks, count].map(|number| number as u32);
        let left = |last: bool| if last { 2 * count * WORD } else { padded * ELEMENT };

        let last = u32::from(blocks == 1);
        let arguments =
            arguments![elements, sorted, indices, source, keys, order, last, block_, blocks_, items];
        queue.launch_groups(&mut self.sort, arguments, blocks, count * WORD + left(last == 1))?;
        let mut run = 2 * block;
        while run <= padded {
            exchange(queue, &mut self.exchange, self.form, elements, [padded, run, block])?;
            let (run_, last) = (run as u32, u32::from(run == padded));
            let arguments = arguments![
                elements, sorted, indices, source, keys, order, last, run_, block_, blocks_, items
            ];
            queue.launch_groups(&mut self.merge, arguments, blocks, padded * ELEMENT + left(last == 1))?;
            run *= 2;
        }
        Ok(())
    }
}

/// All strides of runs that are not within blocks.
fn exchange(
    queue: &mut Queue<'_>,
    kernel: &mut Kernel,
    form: Form,
    elements: &Buffer<u64>,
    [padded, run, block]: [usize; 3],
) -> Result<()> {
    let mut stride = run / 2;
    while stride >= block {
        // Two strides at once where there are two.
        let two = stride > block;
        let streams = if two { 4 } else { 2 };
        let items = padded / streams / if form == Form::Items { SPAN } else { 1 };
        let [run, stride_, items_] = [run, stride, items].map(|number| number as u32);
        let arguments = arguments![elements, run, stride_, u32::from(two), items_];
        queue.launch(kernel, arguments, items, 2 * padded * ELEMENT)?;
        stride /= streams;
    }
    Ok(())
}

/// Elements of a block: what a core's own cache or local memory (`TILE`) holds.
fn block(form: Form) -> usize {
    match form {
        Form::Items => 1 << 14,
        Form::Groups => 1 << 11,
    }
}

/// Elements for so many items: a power of two.
fn padded(items: usize) -> usize {
    items.next_power_of_two().max(VECTOR)
}

/// Elements of the order of lower words, which only keys with an upper one need.
fn order(key_bits: u32, capacity: usize) -> usize {
    if key_bits > u32::BITS { capacity } else { 0 }
}
