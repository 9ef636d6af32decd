//! Ctrl-C: asked for once, the work so far is written; asked for twice, the process ends.

use super::stderr::say;
use crate::{Error, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Ctrl-C (and termination) sets a flag; work stops after the launch that runs, and what is done is written.
///
/// # Errors
/// [`Error::Failed`] when the system does not let us watch.
pub fn watch_interrupt() -> Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    let set = Arc::clone(&flag);
    ctrlc::set_handler(move || {
        if set.swap(true, Ordering::Relaxed) {
            // A second request does not wait for the files.
            leave_now(130);
        }
    })
    .map_err(|error| Error::Failed(format!("cannot watch for Ctrl-C: {error}")))?;
    Ok(flag)
}

/// Ends the process without running exit handlers: those of an OpenCL driver do not expect its other threads to be in
/// the middle of a build, and turn the exit code into their own.
fn leave_now(code: i32) -> ! {
    #[cfg(unix)]
    signal_hook::low_level::exit(code);
    #[cfg(not(unix))]
    std::process::exit(code);
}

/// A failure after an interrupt is the interrupt's: drivers give up builds and launches when a signal ends one of
/// their system calls.
pub fn or_interrupted(requested: &AtomicBool, error: Error) -> Error {
    if !requested.load(Ordering::Relaxed) {
        return error;
    }
    say(&format!("interrupted; the device gave up: {error}"));
    Error::Interrupted
}
