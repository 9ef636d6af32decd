//! `svetlo compare IMAGE REFERENCE`.

use std::{
    io::{self, Write},
    path::{Path, PathBuf},
};

use serde::Serialize;

use super::{
    compare::{Comparison, compare},
    difference::write_difference,
    thresholds::Thresholds,
};
use crate::{
    error::{Error, Result},
    picture::{check_writable, read_picture},
};

/// Compare a picture with a reference: RMSE, PSNR, relMSE, MAPE, bias.
///
/// Where the files carry their variance (`variance.*` and `samples`), the error is also given
/// with the noise of either side taken out. Exit code 3 if a limit is exceeded.
#[derive(Clone, Debug, clap::Args)]
pub struct CompareArgs {
    /// The picture to judge: EXR, or PNG taken as sRGB.
    pub image: PathBuf,
    /// What it should look like, of the same size.
    pub reference: PathBuf,
    /// Fail if the RMSE is above X.
    #[arg(long, value_name = "X", value_parser = limit)]
    pub max_rmse: Option<f64>,
    /// Fail if the PSNR (peak: largest value of the reference) is below X dB.
    #[arg(long, value_name = "X", value_parser = finite, allow_negative_numbers = true)]
    pub min_psnr: Option<f64>,
    /// Fail if relMSE is above X.
    #[arg(long, value_name = "X", value_parser = limit)]
    pub max_relmse: Option<f64>,
    /// Fail if MAPE is above X (1 is 100 %).
    #[arg(long, value_name = "X", value_parser = limit)]
    pub max_mape: Option<f64>,
    /// Fail if the mean signed error is above X or below -X.
    #[arg(long, value_name = "X", value_parser = limit)]
    pub max_bias: Option<f64>,
    /// Write the difference: signed values as .exr, blue-white-red as .png.
    #[arg(long, value_name = "OUT")]
    pub diff: Option<PathBuf>,
    /// Print JSON instead of a table.
    #[arg(long)]
    pub json: bool,
}

impl CompareArgs {
    /// The limits among the arguments.
    pub fn thresholds(&self) -> Thresholds {
        Thresholds {
            max_rmse: self.max_rmse,
            min_psnr: self.min_psnr,
            max_relmse: self.max_relmse,
            max_mape: self.max_mape,
            max_bias: self.max_bias,
        }
    }
}

fn finite(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(|| "give a finite number".into())
}

fn limit(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|&value| value >= 0.0).ok_or_else(|| "give a finite number of at least 0".into())
}

/// What `--json` prints.
#[derive(Serialize)]
struct Report<'a> {
    image: &'a Path,
    reference: &'a Path,
    #[serde(flatten)]
    comparison: &'a Comparison,
    thresholds: Thresholds,
    violations: &'a [String],
    difference: Option<Difference<'a>>,
}

#[derive(Serialize)]
struct Difference<'a> {
    path: &'a Path,
    /// What full red or blue means; null for EXR.
    scale: Option<f64>,
}

/// Runs the command; the report goes to standard output.
///
/// # Errors
/// [`Error::Input`] for pictures that cannot be read or compared, [`Error::Failed`] where the
/// difference cannot be written, [`Error::Tolerance`] with all violations.
pub fn run(args: &CompareArgs) -> Result<()> {
    run_to(args, &mut io::stdout().lock())
}

fn run_to(args: &CompareArgs, out: &mut impl Write) -> Result<()> {
    let image = read_picture(&args.image)?;
    let reference = read_picture(&args.reference)?;
    let comparison = compare(&image, &reference).map_err(|error| name_files(args, error))?;
    let difference = match &args.diff {
        Some(path) => {
            check_writable(path)?;
            Some(Difference { path, scale: write_difference(path, &image, &reference)? })
        }
        None => None,
    };
    let thresholds = args.thresholds();
    let violations = thresholds.violations(&comparison);
    let report = Report {
        image: &args.image,
        reference: &args.reference,
        comparison: &comparison,
        thresholds,
        violations: &violations,
        difference,
    };
    print(&report, args.json, out)?;
    if violations.is_empty() {
        return Ok(());
    }
    Err(Error::Tolerance(format!("{}: out of tolerance: {}", args.image.display(), violations.join("; "))))
}

fn name_files(args: &CompareArgs, error: Error) -> Error {
    Error::Input(format!("{} and {}: {error}", args.image.display(), args.reference.display()))
}

fn print(report: &Report, json: bool, out: &mut impl Write) -> Result<()> {
    let text = if json { json_text(report)? } else { table(report) };
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        // A reader that has seen enough, such as `head`, is no failure.
        Err(cause) if cause.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::Failed(format!("standard output cannot be written ({cause}); redirect it elsewhere")))
        }
        _ => Ok(()),
    }
}

fn json_text(report: &Report) -> Result<String> {
    let text = serde_json::to_string_pretty(report).map_err(|cause| {
        Error::Failed(format!("the report cannot be written as JSON ({cause}); omit --json"))
    })?;
    Ok(text + "\n")
}

fn table(report: &Report) -> String {
    let mut text = report.comparison.to_string();
    if let Some(Difference { path, scale }) = &report.difference {
        let path = path.display();
        text += &match scale {
            Some(scale) => format!("difference: {path}, blue −{scale:.4e} … white 0 … red +{scale:.4e}\n"),
            None => format!("difference: {path}, signed values\n"),
        };
    }
    text
}

#[cfg(test)]
#[path = "command_tests.rs"]
mod tests;
