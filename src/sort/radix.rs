//! Radix sort: passes over digits from the lowest, each of which counts and moves.

use super::queue::{Queue, WORD, arguments};
use super::sorter::{Form, Job, SOURCE_KEYS, SOURCE_PASS, SOURCE_UPPER, SortKey, program};
use crate::Result;
use crate::device::{Buffer, Device, DeviceInfo, Kernel, MemoryPlan};

/// Chunks per compute unit, so that none waits long for the slowest.
const CHUNKS_PER_UNIT: usize = 4;
/// Items that are worth a chunk's counters.
const SMALLEST_CHUNK: usize = 4096;
/// Items of a tile, and work-items of a group (`TILE` and `MAX_GROUP` in `cl/sort/radix_groups.cl`).
const TILE: usize = 1024;
const GROUP: usize = 256;
const PAIR: usize = 2 * WORD;

/// Kernels and what is kept between passes.
pub(super) struct Radix {
    form: Form,
    /// Counts a chunk's digits, or sorts a tile by them first.
    count: Kernel,
    offsets: Kernel,
    scatter: Kernel,
    /// (word, number): from pass to pass by turns; or of the pass before, and of tiles.
    pairs: [Buffer<[u32; 2]>; 2],
    counts: Buffer<u32>,
    totals: Buffer<u32>,
}

/// A digit, and where its pass reads.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pass {
    source: u32,
    shift: u32,
    digits: u32,
    last: bool,
}

impl Radix {
    pub fn new(device: &Device, form: Form, key_bits: u32, capacity: usize) -> Result<Self> {
        let (entry, count, items) = match form {
            Form::Items => ("sort/radix_items.cl", "radix_count", 1),
            Form::Groups => ("sort/radix_groups.cl", "radix_tiles", GROUP),
        };
        let program = program(device, entry, key_bits)?;
        let kernel = |name, items| -> Result<Kernel> {
            let mut kernel = program.kernel(device, name)?;
            kernel.set_work_group(items);
            Ok(kernel)
        };
        let lengths = Lengths::new(device.info(), form, capacity);
        let pairs = || Buffer::uninitialised(device, lengths.pairs);
        Ok(Self {
            form,
            count: kernel(count, items)?,
            offsets: kernel("radix_offsets", GROUP)?,
            scatter: kernel("radix_scatter", items)?,
            pairs: [pairs()?, pairs()?],
            counts: Buffer::uninitialised(device, lengths.counts)?,
            totals: Buffer::uninitialised(device, 1 << widest(form))?,
        })
    }

    pub fn add_memory(plan: &mut MemoryPlan, info: &DeviceInfo, form: Form, capacity: usize) {
        let lengths = Lengths::new(info, form, capacity);
        plan.add("pairs of a radix sort", 2 * lengths.pairs as u64, PAIR);
        plan.add("counters of a radix sort", lengths.counts as u64, WORD);
    }

    /// Sorts at least one key.
    pub fn sort<K: SortKey>(&mut self, queue: &mut Queue<'_>, job: &Job<'_, K>, bits: u32) -> Result<()> {
        for (number, pass) in passes(bits, widest(self.form)).into_iter().enumerate() {
            match self.form {
                Form::Items => self.move_chunks(queue, job, pass, number)?,
                Form::Groups => self.move_tiles(queue, job, pass)?,
            }
        }
        Ok(())
    }

    fn move_chunks<K: SortKey>(
        &mut self,
        queue: &mut Queue<'_>,
        &Job { keys, count, out }: &Job<'_, K>,
        Pass { source, shift, digits, last }: Pass,
        number: usize,
    ) -> Result<()> {
        let (chunk, chunks) = chunks(queue.device.info(), count);
        let counters = chunks * digits as usize * WORD;
        let read = count * if source == SOURCE_PASS { PAIR } else { WORD };
        let (from, to) = (&self.pairs[number % 2], &self.pairs[(number + 1) % 2]);
        let (counts, totals) = (&self.counts, &self.totals);
        let [chunk, items] = [chunk as u32, count as u32];
        let arguments = arguments![counts, keys, from, source, shift, digits, chunk, items];
        queue.launch(&mut self.count, arguments, chunks, read + counters)?;
        let arguments = arguments![counts, totals, digits, chunks as u32];
        queue.launch(&mut self.offsets, arguments, digits as usize, 2 * counters)?;
        let arguments = arguments![
            to,
            &out.keys,
            &out.indices,
            counts,
            totals,
            keys,
            from,
            source,
            shift,
            digits,
            u32::from(last),
            chunk,
            items
        ];
        queue.launch(&mut self.scatter, arguments, chunks, read + count * PAIR + 2 * counters)
    }

    fn move_tiles<K: SortKey>(
        &mut self,
        queue: &mut Queue<'_>,
        &Job { keys, count, out }: &Job<'_, K>,
        Pass { source, shift, digits, last }: Pass,
    ) -> Result<()> {
        let tiles = count.div_ceil(TILE);
        let counters = tiles * digits as usize * WORD;
        let read = count * if source == SOURCE_PASS { PAIR } else { WORD };
        let [passed, sorted] = &self.pairs;
        let (counts, totals) = (&self.counts, &self.totals);
        let [tiles_, items] = [tiles as u32, count as u32];
        let arguments = arguments![sorted, counts, keys, passed, source, shift, digits, tiles_, items];
        queue.launch_groups(&mut self.count, arguments, tiles, read + count * PAIR + counters)?;
        let arguments = arguments![counts, totals, tiles_];
        queue.launch_groups(&mut self.offsets, arguments, digits as usize, 2 * counters)?;
        let arguments = arguments![
            passed,
            &out.keys,
            &out.indices,
            counts,
            totals,
            keys,
            sorted,
            shift,
            digits,
            u32::from(last),
            tiles_,
            items
        ];
        queue.launch_groups(&mut self.scatter, arguments, tiles, 2 * count * PAIR + counters)
    }
}

/// Bits of a digit at most. For chunks, measured: rows of 2 KiB; for tiles, what local memory holds (`MAX_DIGITS`).
fn widest(form: Form) -> u32 {
    match form {
        Form::Items => 9,
        Form::Groups => 8,
    }
}

/// The passes for keys of so many bits, as few as there can be and alike: the lower word's, then the upper's.
fn passes(bits: u32, widest: u32) -> Vec<Pass> {
    let mut passes = Vec::new();
    for (first, bits) in [(SOURCE_KEYS, bits.min(u32::BITS)), (SOURCE_UPPER, bits.saturating_sub(u32::BITS))]
    {
        let count = bits.div_ceil(widest);
        for number in 0..count {
            let width = bits.div_ceil(count);
            let source = if number == 0 { first } else { SOURCE_PASS };
            passes.push(Pass { source, shift: number * width, digits: 1 << width, last: false });
        }
    }
    passes.last_mut().expect("a key has at least one bit").last = true;
    passes
}

/// Items of a chunk, and chunks.
fn chunks(info: &DeviceInfo, count: usize) -> (usize, usize) {
    let most = CHUNKS_PER_UNIT * info.compute_units.max(1) as usize;
    let chunk = count.div_ceil(most).max(SMALLEST_CHUNK);
    (chunk, count.div_ceil(chunk))
}

/// Elements of buffers.
struct Lengths {
    pairs: usize,
    counts: usize,
}

impl Lengths {
    fn new(info: &DeviceInfo, form: Form, capacity: usize) -> Self {
        let (pairs, rows) = match form {
            Form::Items => (capacity, CHUNKS_PER_UNIT * info.compute_units.max(1) as usize),
            Form::Groups => (capacity.next_multiple_of(TILE), capacity.div_ceil(TILE)),
        };
        Self { pairs, counts: rows << widest(form) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_cover_the_bits_once() {
        for widest in [8, 9] {
            for bits in 1..=64 {
                let passes = passes(bits, widest);
                let of_word = |upper: bool| {
                    let first =
                        passes.iter().position(|pass| pass.source == SOURCE_UPPER).unwrap_or(passes.len());
                    if upper { &passes[first..] } else { &passes[..first] }
                };
                for (word, bits) in [(of_word(false), bits.min(32)), (of_word(true), bits.saturating_sub(32))]
                {
                    assert_eq!(word.len() as u32, bits.div_ceil(widest), "{bits} bits");
                    let mut covered = 0;
                    for pass in word {
                        assert_eq!(pass.shift, covered);
                        assert!(pass.shift < 32 && pass.digits <= 1 << widest);
                        covered += pass.digits.ilog2();
                    }
                    assert!(covered >= bits);
                }
                assert!(passes.iter().enumerate().all(|(k, pass)| pass.last == (k + 1 == passes.len())));
                assert_eq!(passes[0].source, SOURCE_KEYS);
            }
        }
    }
}
