//! Typed buffers in device memory.

use super::{Call, Device};
use crate::{Error, Result};
use bytemuck::Pod;
use ocl::core::{self, MemFlags};
use ocl::ffi;
use std::marker::PhantomData;

/// `len` elements of `T` in device memory; never empty on the device (OpenCL has no empty buffers).
pub struct Buffer<T> {
    pub(super) mem: core::Mem,
    len: usize,
    element: PhantomData<T>,
}

impl<T: Pod> Buffer<T> {
    /// Allocates `len` elements, uninitialised.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device has no room.
    pub fn uninitialised(device: &Device, len: usize) -> Result<Self> {
        let bytes = len.saturating_mul(size_of::<T>());
        let mut raw = std::ptr::null_mut();
        device.call(Call::Allocate, format_args!("allocating {bytes} bytes by clCreateBuffer"), || {
            let (flags, mut status) = (MemFlags::READ_WRITE.bits(), 0);
            let context = device.context_ptr();
            // SAFETY: no host pointer is given, and `status` outlives the call.
            raw = unsafe {
                ffi::clCreateBuffer(context, flags, bytes.max(1), std::ptr::null_mut(), &mut status)
            };
            status
        })?;
        // SAFETY: `raw` is a fresh buffer whose single reference is handed over here.
        let mem = unsafe { core::Mem::from_raw_create_ptr(raw) };
        Ok(Self { mem, len, element: PhantomData })
    }

    /// Allocates and fills from `data`.
    ///
    /// # Errors
    /// As [`Buffer::uninitialised`].
    pub fn from_slice(device: &Device, data: &[T]) -> Result<Self> {
        let buffer = Self::uninitialised(device, data.len())?;
        buffer.write(device, 0, data)?;
        Ok(buffer)
    }

    /// Allocates `len` elements whose bytes are all zero.
    ///
    /// # Errors
    /// As [`Buffer::uninitialised`].
    pub fn zeroed(device: &Device, len: usize) -> Result<Self> {
        let buffer = Self::uninitialised(device, len)?;
        let zero = vec![T::zeroed(); len.min(1 << 16)];
        let mut offset = 0;
        while offset < len {
            let part = zero.len().min(len - offset);
            buffer.write(device, offset, &zero[..part])?;
            offset += part;
        }
        Ok(buffer)
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Overwrites the elements from `offset` on; waits until the copy is done.
    ///
    /// # Errors
    /// [`Error::Failed`] when the range does not fit or the device fails.
    pub fn write(&self, device: &Device, offset: usize, data: &[T]) -> Result<()> {
        self.check_range(offset, data.len())?;
        if data.is_empty() {
            return Ok(());
        }
        // SAFETY: the range was checked, the call blocks, so `data` outlives the copy.
        device.call(Call::Write, "clEnqueueWriteBuffer", || unsafe {
            ffi::clEnqueueWriteBuffer(
                device.queue.as_ptr(),
                self.mem.as_ptr(),
                ffi::CL_TRUE,
                offset * size_of::<T>(),
                size_of_val(data),
                data.as_ptr().cast(),
                0,
                std::ptr::null(),
                std::ptr::null_mut(),
            )
        })
    }

    /// Reads all elements; waits for the work enqueued before.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device fails.
    pub fn read(&self, device: &Device) -> Result<Vec<T>> {
        self.read_part(device, 0, self.len)
    }

    /// Reads `len` elements from `offset` on; waits for the work enqueued before.
    ///
    /// # Errors
    /// [`Error::Failed`] when the range does not fit or the device fails.
    pub fn read_part(&self, device: &Device, offset: usize, len: usize) -> Result<Vec<T>> {
        self.check_range(offset, len)?;
        let mut data = vec![T::zeroed(); len];
        if data.is_empty() {
            return Ok(data);
        }
        // SAFETY: the range was checked, `data` has its size, the call blocks, and every bit pattern is a valid `T: Pod`.
        device.call(Call::Read, "clEnqueueReadBuffer", || unsafe {
            ffi::clEnqueueReadBuffer(
                device.queue.as_ptr(),
                self.mem.as_ptr(),
                ffi::CL_TRUE,
                offset * size_of::<T>(),
                size_of_val(data.as_slice()),
                data.as_mut_ptr().cast(),
                0,
                std::ptr::null(),
                std::ptr::null_mut(),
            )
        })?;
        Ok(data)
    }

    fn check_range(&self, offset: usize, len: usize) -> Result<()> {
        match offset.checked_add(len) {
            Some(end) if end <= self.len => Ok(()),
            _ => Err(Error::Failed(format!(
                "a copy of {len} elements at {offset} does not fit a device buffer of {} elements",
                self.len
            ))),
        }
    }
}
