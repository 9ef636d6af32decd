//! Device sorts of (key, number) pairs, and where the items of each cell lie among them: the voxel structure of photon
//! maps (Bogolepov, Sopin and Turlapov).
//!
//! An item is a key in a buffer; its number is its place there. Items of equal keys stay in the order of their numbers,
//! so every method, form and device gives the same bits. Keys of all ones stand for items without a key (photons that
//! were not stored): they come last. The kernels are `cl/sort/`; nothing here waits for the device but what reads.
//!
//! - `sorter`: the sorts' common part
//! - `radix`, `bitonic`: the two methods
//! - `ranges`: first and last item per cell

mod bitonic;
mod queue;
mod radix;
mod ranges;
mod sorter;

pub use queue::Work;
pub use ranges::{CellRanges, Fill};
pub use sorter::{Form, SortKey, SortKind, Sorted, Sorter};
