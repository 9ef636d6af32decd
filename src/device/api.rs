//! Thin wrappers over the OpenCL calls whose failures carry vendor-specific codes.
//!
//! `ocl` panics on a status that the specification does not list (some drivers return -9999 after a fault),
//! so every call that can meet one goes through [`check`] instead.

use crate::Error;
use ocl::ffi;
use std::fmt::Display;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Held while devices are listed and programs are built: PoCL 3.1 loses its devices, or crashes, when threads do so
/// at the same time.
pub(super) fn one_at_a_time() -> MutexGuard<'static, ()> {
    static DRIVER: Mutex<()> = Mutex::new(());
    DRIVER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Turns an OpenCL status into an error that names the call and explains the code.
pub(super) fn check(status: i32, call: impl Display) -> Result<(), Error> {
    if status == 0 {
        return Ok(());
    }
    Err(Error::Failed(format!("{call} failed with OpenCL status {status} ({})", explain(status))))
}

/// The standard name of a status code and, where there is one, what to do about it.
fn explain(status: i32) -> &'static str {
    match status {
        -1 => "CL_DEVICE_NOT_FOUND",
        -2 => "CL_DEVICE_NOT_AVAILABLE: another program may hold the device exclusively",
        -3 => "CL_COMPILER_NOT_AVAILABLE",
        -4 => "CL_MEM_OBJECT_ALLOCATION_FAILURE: the device is out of memory; try a smaller image or volume",
        -5 => "CL_OUT_OF_RESOURCES: the device is out of memory or the kernel faulted",
        -6 => "CL_OUT_OF_HOST_MEMORY",
        -11 => "CL_BUILD_PROGRAM_FAILURE",
        -14 => "CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST: an earlier launch failed",
        -30 => "CL_INVALID_VALUE",
        -36 => "CL_INVALID_COMMAND_QUEUE: the driver dropped the device after a fault or a watchdog",
        -52 => "CL_INVALID_KERNEL_ARGS",
        -54 => "CL_INVALID_WORK_GROUP_SIZE",
        -61 => "CL_INVALID_BUFFER_SIZE",
        -1001 => "CL_PLATFORM_NOT_FOUND_KHR: no OpenCL runtime is installed",
        _ => "a code of this driver's own",
    }
}

/// Number of OpenCL platforms, without the seconds of retries `ocl` spends when there is none.
pub(super) fn platform_count() -> u32 {
    let mut count = 0;
    // SAFETY: `count` is valid for the call; a null list with zero entries only asks for the number.
    let status = unsafe { ffi::clGetPlatformIDs(0, std::ptr::null_mut(), &mut count) };
    if status == 0 { count } else { 0 }
}
