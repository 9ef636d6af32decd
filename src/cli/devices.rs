//! `svetlo devices`.

use super::{pretty, print_line};
use crate::device::Catalog;
use crate::device::memory::readable_bytes;
use crate::{Error, Result};
use std::fmt::Write;

/// Arguments of `svetlo devices`.
#[derive(clap::Args)]
pub struct DevicesArgs {
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Lists the devices.
///
/// # Errors
/// [`Error::Failed`] when there is none.
pub fn run(arguments: &DevicesArgs) -> Result<()> {
    let catalog = Catalog::enumerate();
    if arguments.json {
        let value = serde_json::to_value(&catalog)
            .map_err(|error| Error::Failed(format!("cannot describe the devices: {error}")))?;
        print_line(&pretty(&value))?;
    } else if !catalog.devices.is_empty() {
        print_line(&table(&catalog))?;
    }
    let default = catalog.select(None)?;
    if !arguments.json {
        print_line(&format!(
            "default: {} ({}); choose with --device SELECTOR or SVETLO_DEVICE",
            default.selector, default.name
        ))?;
    }
    Ok(())
}

fn table(catalog: &Catalog) -> String {
    let mut text = String::new();
    for device in &catalog.devices {
        let _ = writeln!(text, "{}  {}", device.selector, device.name);
        let _ = writeln!(text, "     platform   {} ({})", device.platform, device.platform_version.trim());
        let _ = writeln!(text, "     driver     {}, {}", device.driver, device.version);
        let _ = writeln!(
            text,
            "     compute    {} units, {} MHz, work-groups up to {}, fp64 {}",
            device.compute_units,
            device.clock_mhz,
            device.max_work_group,
            if device.fp64 { "yes" } else { "no" }
        );
        let _ = writeln!(
            text,
            "     memory     {} in all, {} at once, {} local",
            readable_bytes(device.global_memory),
            readable_bytes(device.max_allocation),
            readable_bytes(device.local_memory)
        );
    }
    for remark in &catalog.remarks {
        let _ = writeln!(text, "note: {remark}");
    }
    text.trim_end().into()
}
