//! Voxels straight from a memory-mapped file: nothing is copied, and the system pages them in and out.
#![allow(unsafe_code)]

use bytemuck::Pod;
use memmap2::Mmap;
use std::fs::File;
use std::io;
use std::marker::PhantomData;
use std::ops::Deref;

/// A read-only slice of `T`, in native byte order, inside a mapped file.
pub(super) struct Mapped<T> {
    map: Mmap,
    start: usize,
    end: usize,
    element: PhantomData<T>,
}

impl<T: Pod> Mapped<T> {
    /// Maps `count` elements that begin `offset` bytes into the file.
    ///
    /// `None` when they are not aligned for `T` or the file has become too short; then they must be read instead.
    pub(super) fn new(file: &File, offset: u64, count: usize) -> io::Result<Option<Self>> {
        // SAFETY: the mapping is private to this value, read-only, and lives as long as every slice borrowed from
        // it. `T: Pod` makes any bytes a valid value. The one thing that cannot be ruled out is another process
        // that changes or shortens the file meanwhile; the documentation asks users not to do that.
        let map = unsafe { Mmap::map(file)? };
        let range = usize::try_from(offset).ok().and_then(|start| {
            let bytes = count.checked_mul(size_of::<T>())?;
            Some((start, start.checked_add(bytes)?))
        });
        let Some((start, end)) = range else { return Ok(None) };
        let fits = map.get(start..end).is_some_and(|bytes| bytemuck::try_cast_slice::<u8, T>(bytes).is_ok());
        Ok(fits.then_some(Self { map, start, end, element: PhantomData }))
    }
}

impl<T: Pod> Deref for Mapped<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        // `new` has checked range and alignment, and neither changes: the address of a mapping is fixed.
        bytemuck::cast_slice(&self.map[self.start..self.end])
    }
}
