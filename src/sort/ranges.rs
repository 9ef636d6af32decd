//! First and last item of every cell, from sorted keys.

use super::queue::{Queue, WORD, Work, arguments};
use super::sorter::{Sorted, program};
use crate::device::{Buffer, Device, Kernel, MemoryPlan};
use crate::{Error, Result};

/// How ranges are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fill {
    /// Firsts and lasts in one launch.
    OnePass,
    /// Firsts, then lasts, as where a pass can write only one component (Bogolepov, Sopin and Turlapov).
    TwoPass,
}

/// The range of items of each of `cells` cells, in the order of sorted keys.
pub struct CellRanges {
    clear: Kernel,
    forget: Kernel,
    both: Kernel,
    first: Kernel,
    last: Kernel,
    fill: Fill,
    ranges: Buffer<[u32; 2]>,
    /// The cells that the last fill used, each where its first item was.
    used: Buffer<u32>,
    /// How many items the last fill went through; none before the first one.
    filled: Option<usize>,
    cells: usize,
}

impl CellRanges {
    /// Ranges of keys 0 to `cells` − 1, for up to `capacity` items. They hold nothing before the first fill.
    ///
    /// # Errors
    /// [`Error::Failed`] when the kernels do not build or the device has no room.
    pub fn new(device: &Device, cells: usize, fill: Fill, capacity: usize) -> Result<Self> {
        if u32::try_from(cells).is_err() {
            return Err(Error::Failed(format!("cannot number {cells} cells, only up to {}", u32::MAX)));
        }
        let program = program(device, "sort/ranges.cl", u32::BITS)?;
        Ok(Self {
            clear: program.kernel(device, "ranges_clear")?,
            forget: program.kernel(device, "ranges_forget")?,
            both: program.kernel(device, "ranges_both")?,
            first: program.kernel(device, "ranges_first")?,
            last: program.kernel(device, "ranges_last")?,
            fill,
            ranges: Buffer::uninitialised(device, cells)?,
            used: Buffer::uninitialised(device, capacity)?,
            filled: None,
            cells,
        })
    }

    /// What the ranges take of a device.
    pub fn memory(cells: usize, capacity: usize) -> MemoryPlan {
        let mut plan = MemoryPlan::default();
        plan.add("ranges of cells", cells as u64, 2 * WORD);
        plan.add("used cells", capacity as u64, WORD);
        plan
    }

    /// Forgets what was there and finds the ranges of sorted keys. Does not wait.
    ///
    /// # Errors
    /// [`Error::Failed`] when there are more items than the capacity or the device fails.
    pub fn fill(&mut self, device: &Device, sorted: &Sorted<'_, u32>) -> Result<Work> {
        let &Sorted { keys, count, .. } = sorted;
        if count > self.used.len() {
            let capacity = self.used.len();
            return Err(Error::Failed(format!("cannot find the cells of {count} items, only of {capacity}")));
        }
        let mut queue = Queue::new(device);
        self.empty(&mut queue)?;
        self.filled = Some(count);
        let (ranges, used) = (&self.ranges, &self.used);
        let [cells, items] = [self.cells, count].map(|number| number as u32);
        let (keys_, first, last) = (count * WORD, 2 * count * WORD, count * WORD);
        match self.fill {
            Fill::OnePass => {
                let arguments = arguments![ranges, used, keys, cells, items];
                queue.launch(&mut self.both, arguments, count, keys_ + first + last)?;
            }
            Fill::TwoPass => {
                let arguments = arguments![ranges, used, keys, cells, items];
                queue.launch(&mut self.first, arguments, count, keys_ + first)?;
                queue.launch(&mut self.last, arguments![ranges, keys, cells, items], count, keys_ + last)?;
            }
        }
        Ok(queue.work)
    }

    /// Clears all cells, or only those that were used when they are certainly fewer.
    fn empty(&mut self, queue: &mut Queue<'_>) -> Result<()> {
        // One used cell costs a key and its line of the cache, 64 bytes, of which clearing all takes 8 per cell.
        const CELLS_PER_LINE: usize = 8;
        match self.filled {
            Some(count) if CELLS_PER_LINE * count < self.cells => {
                let arguments = arguments![&self.ranges, &self.used, count as u32];
                queue.launch(&mut self.forget, arguments, count, 3 * count * WORD)
            }
            _ => {
                let arguments = arguments![&self.ranges, self.cells as u32];
                queue.launch(&mut self.clear, arguments, self.cells, 2 * self.cells * WORD)
            }
        }
    }

    /// Per cell: its first item's place among the sorted, and one past the last one's; both 0 for empty cells.
    pub fn ranges(&self) -> &Buffer<[u32; 2]> {
        &self.ranges
    }
}
