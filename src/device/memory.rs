//! The memory plan of a run, checked against the device before anything is allocated.

use super::DeviceInfo;
use crate::{Error, Result};
use serde::Serialize;

/// What a run allocates on one device.
#[derive(Clone, Debug, Default, Serialize)]
pub struct MemoryPlan {
    /// Name and size in bytes of each allocation.
    pub items: Vec<(String, u64)>,
}

impl MemoryPlan {
    /// Adds an allocation of `count` elements of `size` bytes.
    pub fn add(&mut self, name: &str, count: u64, size: usize) {
        self.items.push((name.into(), count.saturating_mul(size as u64)));
    }

    /// Sum of all allocations in bytes.
    pub fn total(&self) -> u64 {
        self.items.iter().fold(0, |sum, (_, bytes)| sum.saturating_add(*bytes))
    }

    /// Refuses a plan that the device cannot hold, with both numbers.
    ///
    /// # Errors
    /// [`Error::Failed`] naming the allocation, its size and the device's limit.
    pub fn check(&self, device: &DeviceInfo) -> Result<()> {
        let too_large = |what: &str, bytes: u64, limit: u64, kind: &str| {
            Err(Error::Failed(format!(
                "{}: {what} would take {}, but the device's {kind} is {}; use a smaller volume or image, fewer photons, or another device",
                device.name,
                readable_bytes(bytes),
                readable_bytes(limit)
            )))
        };
        for (name, bytes) in &self.items {
            if device.max_allocation > 0 && *bytes > device.max_allocation {
                return too_large(
                    &format!("the {name}"),
                    *bytes,
                    device.max_allocation,
                    "largest single allocation",
                );
            }
        }
        if device.global_memory > 0 && self.total() > device.global_memory {
            return too_large("this scene", self.total(), device.global_memory, "memory");
        }
        Ok(())
    }
}

/// `bytes` with a binary unit, three significant digits.
pub fn readable_bytes(bytes: u64) -> String {
    const UNITS: [&str; 6] = ["B", "KiB", "MiB", "GiB", "TiB", "PiB"];
    let mut value = bytes as f64;
    let mut unit = 0;
    while value >= 1024.0 && unit + 1 < UNITS.len() {
        value /= 1024.0;
        unit += 1;
    }
    let digits = if unit == 0 || value >= 100.0 {
        0
    } else if value >= 10.0 {
        1
    } else {
        2
    };
    format!("{value:.digits$} {}", UNITS[unit])
}

#[cfg(test)]
mod tests {
    use super::readable_bytes;

    #[test]
    fn bytes_are_readable() {
        assert_eq!(readable_bytes(0), "0 B");
        assert_eq!(readable_bytes(1023), "1023 B");
        assert_eq!(readable_bytes(1536), "1.50 KiB");
        assert_eq!(readable_bytes(u64::MAX), "16384 PiB");
    }
}
