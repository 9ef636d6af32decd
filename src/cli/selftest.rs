//! `svetlo selftest`: one table per device, or one JSON document.

use super::{pretty, print_line};
use crate::device::{Catalog, DeviceInfo};
use crate::selftest::{self, CHECKS, Check, Status, Verdict};
use crate::{Error, Result};
use clap::builder::PossibleValuesParser;
use serde_json::json;
use std::time::Instant;

/// Arguments of `svetlo selftest`.
#[derive(clap::Args)]
pub struct SelftestArgs {
    /// The device: a selector of `svetlo devices`, a kind (cpu, gpu) or part of a name [env: SVETLO_DEVICE]
    /// [default: every device].
    #[arg(long, value_name = "SELECTOR")]
    device: Option<String>,
    /// Run only this check; may be given again.
    #[arg(long, value_name = "CHECK", value_parser = PossibleValuesParser::new(CHECKS.iter().map(|check| check.name)))]
    only: Vec<String>,
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
    let variable = std::env::var("SVETLO_DEVICE").ok().filter(|text| !text.trim().is_empty());
    let selector = arguments.device.clone().or(variable);
    let selected = catalog.select(selector.as_deref())?;
    let devices = match selector {
        Some(_) => std::slice::from_ref(selected),
        None => &catalog.devices,
    };
    let wanted =
        |check: &&Check| arguments.only.is_empty() || arguments.only.iter().any(|name| name == check.name);
    let checks: Vec<&Check> = CHECKS.iter().filter(wanted).collect();
    let mut reports = Vec::new();
    for device in devices {
        let start = Instant::now();
        let verdicts = test(device, &checks, arguments.json)?;
        let seconds = start.elapsed().as_secs_f64();
        if !arguments.json {
            print_line(&summary(checks.len(), &verdicts, seconds))?;
        }
        reports.push(Report { device, passed: selftest::passed(&verdicts), seconds, verdicts });
    }
    if arguments.json {
        let passed = reports.iter().all(|report| report.passed);
        print_line(&pretty(&json!({ "passed": passed, "devices": reports })))?;
    }
    outcome(&reports)
}

/// How a device did.
#[derive(serde::Serialize)]
struct Report<'a> {
    device: &'a DeviceInfo,
    passed: bool,
    seconds: f64,
    verdicts: Vec<Verdict>,
}

fn outcome(reports: &[Report<'_>]) -> Result<()> {
    let failed: Vec<String> = reports
        .iter()
        .filter(|report| !report.passed)
        .map(|report| format!("{} ({})", report.device.selector, report.device.name))
        .collect();
    if failed.is_empty() {
        return Ok(());
    }
    Err(Error::Tolerance(format!(
        "pictures made on {} are not to be trusted: choose another device with --device, or another driver",
        failed.join(" and ")
    )))
}

fn test(device: &DeviceInfo, checks: &[&'static Check], quiet: bool) -> Result<Vec<Verdict>> {
    let run = |each: &mut dyn FnMut(&Verdict)| selftest::run_altered(device, checks, |spec| spec, each);
    if quiet {
        return run(&mut |_| {});
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
    run(&mut |verdict| {
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
    let mut what = format!("{} ({})", verdict.quantity, verdict.reason);
    if let Some(problem) = &verdict.problem {
        what = format!("{what}; {problem}");
    }
    let measured = verdict.measured.map_or("-".into(), |x| number(x, verdict.tolerance));
    let expected = number(verdict.expected, verdict.tolerance);
    row([name, &measured, &expected, &number(verdict.tolerance, 0.0), status, &what])
}

fn row([check, measured, expected, tolerance, status, what]: [&str; 6]) -> String {
    format!("{check:<20} {measured:>12} {expected:>12} {tolerance:>9} {status:<6}  {what}")
}

/// As many decimals as the tolerance has, and one more; powers of ten where these would be many.
fn number(x: f64, tolerance: f64) -> String {
    if x == x.round() {
        return format!("{x}");
    }
    let decimals = (1.0 - tolerance.max(1e-9).log10().floor()) as usize;
    if x.abs() < 1e-3 || decimals > 10 { format!("{x:.1e}") } else { format!("{x:.decimals$}") }
}

fn summary(checks: usize, verdicts: &[Verdict], seconds: f64) -> String {
    let count = |status: Status| verdicts.iter().filter(|verdict| verdict.status == status).count();
    let (failed, limited) = (count(Status::Failed), count(Status::Limited));
    let mut text = format!("{checks} checks, {} comparisons in {seconds:.1} s: ", verdicts.len());
    text += &if failed == 0 { "passed".into() } else { format!("{failed} FAILED") };
    if limited > 0 {
        text += &format!(", {limited} beyond a known limit of this device");
    }
    text + "\n"
}
