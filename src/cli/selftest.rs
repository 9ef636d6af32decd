//! `svetlo selftest`: one table per device, or one JSON document.

use super::{pretty, print_line};
use crate::device::{Catalog, DeviceInfo};
use crate::selftest::{self, CHECKS, Status, Verdict};
use crate::{Error, Result};
use serde_json::json;
use std::time::Instant;

/// Arguments of `svetlo selftest`.
#[derive(clap::Args)]
pub struct SelftestArgs {
    /// Device to test, as `svetlo devices` lists them; without it, every device.
    #[arg(long, value_name = "SELECTOR", env = "SVETLO_DEVICE")]
    device: Option<String>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Tests devices.
///
/// # Errors
/// [`Error::Tolerance`] when a check fails, [`Error::Failed`] when there is no device, [`Error::Input`] when none matches.
pub fn run(arguments: &SelftestArgs) -> Result<()> {
    let catalog = Catalog::enumerate();
    let selected = catalog.select(arguments.device.as_deref())?;
    let devices = match arguments.device {
        Some(_) => std::slice::from_ref(selected),
        None => &catalog.devices,
    };
    let mut reports = Vec::new();
    let mut failed = Vec::new();
    for device in devices {
        let start = Instant::now();
        let verdicts = test(device, arguments.json)?;
        let seconds = start.elapsed().as_secs_f64();
        let passed = selftest::passed(&verdicts);
        if !passed {
            failed.push(format!("{} ({})", device.selector, device.name));
        }
        if arguments.json {
            reports.push(json!({
                "device": device, "passed": passed, "seconds": seconds, "verdicts": verdicts,
            }));
        } else {
            print_line(&summary(&verdicts, seconds))?;
        }
    }
    if arguments.json {
        print_line(&pretty(&json!({ "passed": failed.is_empty(), "devices": reports })))?;
    }
    if failed.is_empty() {
        return Ok(());
    }
    Err(Error::Tolerance(format!(
        "pictures made on {} are not to be trusted: choose another device with --device, or another driver",
        failed.join(" and ")
    )))
}

fn test(device: &DeviceInfo, quiet: bool) -> Result<Vec<Verdict>> {
    if quiet {
        return selftest::run(device, &mut |_| {});
    }
    print_line(&format!(
        "{}  {} ({}, driver {})\n{}",
        device.selector,
        device.name,
        device.platform,
        device.driver,
        row(["check", "measured", "expected", "tolerance", "", "what, and where the tolerance comes from"])
    ))?;
    let mut check = String::new();
    selftest::run(device, &mut |verdict| {
        // A check's name stands at its first row; a closed pipe shows when the summary is printed.
        let name = if verdict.check == check { "" } else { &verdict.check };
        let _ = print_line(&line(name, verdict));
        check.clone_from(&verdict.check);
    })
}

fn line(name: &str, verdict: &Verdict) -> String {
    let status = match verdict.status {
        Status::Passed => "ok",
        Status::Failed => "FAILED",
        Status::Limited => "limit",
    };
    let Some(measured) = verdict.measured else {
        let problem = verdict.problem.as_deref().unwrap_or("no number came out");
        return row([name, "-", "-", "-", status, &format!("{}: {problem}", verdict.proves)]);
    };
    let mut what = format!("{} ({})", verdict.quantity, verdict.reason);
    if let Some(problem) = &verdict.problem {
        what = format!("{what}; {problem}");
    }
    let [measured, expected] = [measured, verdict.expected].map(|x| number(x, verdict.tolerance));
    row([name, &measured, &expected, &number(verdict.tolerance, 0.0), status, &what])
}

fn row([check, measured, expected, tolerance, status, what]: [&str; 6]) -> String {
    format!("{check:<20} {measured:>11} {expected:>11} {tolerance:>9} {status:<6}  {what}")
}

/// As many decimals as the tolerance has, and one more; powers of ten where these would be many.
fn number(x: f64, tolerance: f64) -> String {
    if x == x.round() {
        return format!("{x}");
    }
    let decimals = (1.0 - tolerance.max(1e-9).log10().floor()) as usize;
    if x.abs() < 1e-3 || decimals > 9 { format!("{x:.1e}") } else { format!("{x:.decimals$}") }
}

fn summary(verdicts: &[Verdict], seconds: f64) -> String {
    let count = |status: Status| verdicts.iter().filter(|verdict| verdict.status == status).count();
    let (failed, limited) = (count(Status::Failed), count(Status::Limited));
    let mut text = format!("{} checks, {} comparisons in {seconds:.1} s: ", CHECKS.len(), verdicts.len());
    text += &if failed == 0 { "passed".into() } else { format!("{failed} FAILED") };
    if limited > 0 {
        text += &format!(", {limited} beyond a known limit of this device");
    }
    text + "\n"
}
