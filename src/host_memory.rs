//! What the host can still hold, asked before a large allocation: an overcommitting system would grant it and
//! end the program later.

use crate::device::memory::readable_bytes;
use crate::{Error, Result};

/// Refuses `bytes` of `what` beyond the memory that the host has available, with both numbers.
///
/// # Errors
/// [`Error::Failed`]. Where the system does not say what it has, nothing is refused.
pub(crate) fn check(what: &str, bytes: u64) -> Result<()> {
    match available() {
        Some(available) if bytes > available => Err(Error::Failed(format!(
            "{what} needs {}, but this machine has {} of memory available; use fewer voxels or another machine",
            readable_bytes(bytes),
            readable_bytes(available)
        ))),
        _ => Ok(()),
    }
}

/// Linux: what may be allocated without swapping, within the limit of the process's container.
pub(crate) fn available() -> Option<u64> {
    let machine = mem_available(&std::fs::read_to_string("/proc/meminfo").ok()?)?;
    let number = |file: &str| -> Option<u64> {
        std::fs::read_to_string(format!("/sys/fs/cgroup/{file}")).ok()?.trim().parse().ok()
    };
    let container = number("memory.max").zip(number("memory.current"));
    Some(container.map_or(machine, |(most, used)| machine.min(most.saturating_sub(used))))
}

fn mem_available(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meminfo_is_in_kibibytes() {
        let text = "MemTotal:       24689764 kB\nMemFree:  1 kB\nMemAvailable:   17000000 kB\n";
        assert_eq!(mem_available(text), Some(17_000_000 * 1024));
        assert_eq!(mem_available("MemTotal: 1 kB\n"), None);
    }

    #[test]
    fn more_than_any_machine_has_is_refused_with_both_numbers() {
        if available().is_none() {
            return; // Not Linux: nothing to ask.
        }
        let error = check("the field", u64::MAX).unwrap_err();
        assert_eq!(error.exit_code(), 1);
        let text = error.to_string();
        assert!(text.starts_with("the field needs 16384 PiB, but this machine has "), "{text}");
        assert!(check("the field", 1).is_ok());
    }
}
