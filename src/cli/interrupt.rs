//! Ctrl-C: asked for once, the work so far is written; asked for twice, the process ends.

use super::stderr::say;
use crate::{Error, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Ctrl-C, termination (SIGTERM) and the end of the terminal (SIGHUP) set a flag; work stops after the launch that runs,
/// and what is done is written. The second request ends the process at once, with the exit code 130.
///
/// # Errors
/// [`Error::Failed`] when the system does not let us watch.
pub fn watch_interrupt() -> Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    watch(&flag).map_err(|error| Error::Failed(format!("cannot watch for Ctrl-C: {error}")))?;
    Ok(flag)
}

/// Registers the flag; SIGHUP not where the caller has the process ignore it, as `nohup` does.
#[cfg(unix)]
fn watch(flag: &Arc<AtomicBool>) -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        if signal == SIGHUP && ignores(SIGHUP) {
            continue;
        }
        // In this order: the first request finds the flag not set yet. The process ends without exit handlers: those
        // of an OpenCL driver do not expect its other threads to be in the middle of a build, and turn the exit code
        // into their own.
        signal_hook::flag::register_conditional_shutdown(signal, 130, Arc::clone(flag))?;
        signal_hook::flag::register(signal, Arc::clone(flag))?;
    }
    Ok(())
}

/// Whether a signal is ignored, where the system tells.
#[cfg(unix)]
fn ignores(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    // Bit 0 is signal 1.
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

#[cfg(not(unix))]
fn watch(flag: &Arc<AtomicBool>) -> Result<(), ctrlc::Error> {
    let flag = Arc::clone(flag);
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    })
}

/// A failure after an interrupt is the interrupt's: drivers give up builds and launches when a signal ends one of
/// their system calls.
pub fn or_interrupted(requested: &AtomicBool, error: Error) -> Error {
    if !requested.load(Ordering::Relaxed) || matches!(error, Error::Interrupted) {
        return error;
    }
    say(&format!("interrupted; the device gave up: {error}"));
    Error::Interrupted
}
