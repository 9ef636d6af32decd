//! `svetlo bench`.

use super::interrupt::watch_interrupt;
use super::stderr::say;
use super::{outlive_file_size_limit, print_line};
use crate::bench::files::{Folder, read_json};
use crate::bench::results::{FORMAT, Results, Severity};
use crate::bench::suite::{CaseSpec, Checkpoints, ReferenceSpec, Suite};
use crate::bench::table::table;
use crate::bench::{Alarm, Options, Watch, baseline, findings, run as run_suite};
use crate::device::{Catalog, DeviceInfo};
use crate::render::method_name;
use crate::report;
use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// Exit code of a device that hangs.
const OUT_OF_TOLERANCE: i32 = 3;

/// Arguments of `svetlo bench`.
#[derive(clap::Args)]
pub struct BenchArgs {
    /// The suite file.
    suite: PathBuf,
    /// The folder of the results; what is finished there already is kept [default: the suite's name with .bench, here].
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// A device, instead of those of the suite (repeatable) [env: SVETLO_DEVICE].
    #[arg(long, value_name = "SELECTOR")]
    device: Vec<String>,
    /// The results.json of an earlier run: what became slower or noisier since is exit code 3.
    #[arg(long, value_name = "results.json")]
    baseline: Option<PathBuf>,
    /// Only cases with this text in their names (repeatable).
    #[arg(long, value_name = "TEXT")]
    case: Vec<String>,
    /// Validate the suite, print its cases, and run nothing.
    #[arg(long)]
    list: bool,
    /// Do not ask whether the devices compute what they should; the results say so.
    #[arg(long)]
    no_selftest: bool,
    /// Print nothing but the table and errors.
    #[arg(long)]
    quiet: bool,
}

/// Runs the suite.
///
/// # Errors
/// With the documented exit codes; see [`Error`].
pub fn run(arguments: &BenchArgs) -> Result<()> {
    outlive_file_size_limit()?;
    let mut suite = Suite::load(&arguments.suite)?;
    suite.keep(&arguments.case)?;
    if arguments.list {
        return print_line(&list(&suite));
    }
    let old = arguments.baseline.as_deref().map(read_baseline).transpose()?;
    let folder = Folder::make(&arguments.output.clone().unwrap_or_else(|| default_folder(&arguments.suite)))?;
    let interrupt = watch_interrupt()?;
    let catalog = Catalog::enumerate();
    let devices = devices(&catalog, arguments, &suite)?;
    let tell = |text: &str| {
        if !arguments.quiet {
            say(text);
        }
    };
    let options = Options { devices: &devices, selftest: !arguments.no_selftest };
    let alarm = Alarm::new(hangs);
    let watch = Watch::new(&tell, &interrupt).with_alarm(&alarm);
    let mut results = run_suite(&suite, &options, &folder, &watch)?;
    if let Some(old) = &old {
        results.findings.extend(baseline::compare(&results, old, suite.slower));
        findings::sort(&mut results.findings);
        folder.write_results(&results)?;
    }
    report::write(&results, &folder.path("."))?;
    print_line(&table(&results))?;
    outcome(&results)
}

/// A thread that waits for a driver cannot be ended, so the program is.
fn hangs(what: &str) {
    say(&format!(
        "{what}: a launch does not come back, the device hangs; what is finished is kept: go on without it by --case"
    ));
    std::process::exit(OUT_OF_TOLERANCE);
}

fn read_baseline(path: &Path) -> Result<Results> {
    let old: Results = read_json(path, "a results.json of svetlo bench")?;
    if old.format == FORMAT {
        return Ok(old);
    }
    Err(Error::Input(format!(
        "{}: results of format {}, which this version does not compare with its own, {FORMAT}; run the bench anew",
        path.display(),
        old.format
    )))
}

/// One line per case.
fn list(suite: &Suite) -> String {
    let line = |case: &CaseSpec| {
        let image = &case.scene.image;
        let checkpoints = match &case.checkpoints {
            Checkpoints::Samples(samples) => format!("{samples:?} samples"),
            Checkpoints::Times(times) => format!("{times:?}"),
        };
        let reference = match &case.reference {
            ReferenceSpec::Constant(color) => format!("constant {color:?}"),
            ReferenceSpec::Truth(color) => format!("none, truth {color:?}"),
            ReferenceSpec::File { name, .. } => format!("file {name}"),
            ReferenceSpec::Computed(spec) => format!("computed to {} %", spec.error * 100.0),
        };
        format!(
            "{}: {}, {}×{}, {} runs of {checkpoints}, reference {reference}",
            case.name,
            method_name(&case.scene.method),
            image.width,
            image.height,
            case.repeats
        )
    };
    let mut lines: Vec<String> = suite.cases.iter().map(line).collect();
    lines.extend(
        suite.refusals.iter().map(|case| format!("{}: must be refused: {}", case.name, case.message)),
    );
    lines.push(format!("{} cases are valid", suite.cases.len() + suite.refusals.len()));
    lines.join("\n")
}

/// The suite's name with `.bench` in the current folder.
fn default_folder(suite: &Path) -> PathBuf {
    let mut name = suite.file_stem().unwrap_or_default().to_owned();
    name.push(".bench");
    name.into()
}

/// `--device`, else the suite's, else `SVETLO_DEVICE`, else the default; each once.
fn devices<'c>(catalog: &'c Catalog, arguments: &BenchArgs, suite: &Suite) -> Result<Vec<&'c DeviceInfo>> {
    let variable = std::env::var("SVETLO_DEVICE").ok().filter(|text| !text.trim().is_empty());
    let given = [&arguments.device, &suite.devices].into_iter().find(|list| !list.is_empty());
    let selectors: Vec<Option<String>> = match given {
        Some(list) => list.iter().cloned().map(Some).collect(),
        None => vec![variable],
    };
    let mut devices: Vec<&DeviceInfo> = Vec::new();
    for selector in selectors {
        let device = catalog.select(selector.as_deref())?;
        if devices.iter().all(|known| known.selector != device.selector) {
            devices.push(device);
        }
    }
    Ok(devices)
}

fn outcome(results: &Results) -> Result<()> {
    if !results.complete {
        say("interrupted; what is finished is kept: run it again with the same folder to go on");
        return Err(Error::Interrupted);
    }
    let failures = results.findings.iter().filter(|finding| finding.severity == Severity::Failure);
    let texts: Vec<String> = failures
        .map(|finding| format!("{}: {}", finding.case.as_deref().unwrap_or("the suite"), finding.text))
        .collect();
    if texts.is_empty() { Ok(()) } else { Err(Error::Tolerance(texts.join("; "))) }
}
