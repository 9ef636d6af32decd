//! `svetlo merge`.

use super::output::exr_path;
use super::stderr::say;
use super::{energy, outlive_file_size_limit, photons, pretty, print_line};
use crate::picture::{check_writable, write_exr, write_png};
use crate::render::{Merged, merge, parts_in_words};
use crate::{Error, Result};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Arguments of `svetlo merge`.
#[derive(clap::Args)]
pub struct MergeArgs {
    /// Parts of one picture, in any order: images of `svetlo render --part I/N`, or of this command with parts missing.
    #[arg(required = true, value_name = "PART.exr")]
    parts: Vec<PathBuf>,
    /// The image to write; the preview goes beside it as .png. With parts missing it is the picture without their samples,
    /// to be merged with them later.
    #[arg(short, long, value_name = "OUT.exr")]
    output: PathBuf,
    /// Print nothing but errors.
    #[arg(long)]
    quiet: bool,
    /// Print a JSON summary to stdout at the end, and nothing else there.
    #[arg(long)]
    json: bool,
}

/// Adds up the parts.
///
/// # Errors
/// With the documented exit codes; see [`Error`].
pub fn run(arguments: &MergeArgs) -> Result<()> {
    outlive_file_size_limit()?;
    let output = exr_path(&arguments.output)?;
    let preview = output.with_extension("png");
    for path in [&output, &preview] {
        check_writable(path)?;
        check_parts_survive(path, &arguments.parts)?;
    }
    let merged = merge(&arguments.parts)?;
    write_exr(&output, &merged.picture)?;
    write_png(&preview, &merged.picture, &merged.tonemap)?;
    let summary = Summary { merged: &merged, output: &output, preview: &preview };
    if arguments.json {
        print_line(&pretty(&summary.json()))?;
    }
    if !arguments.quiet {
        if !arguments.json {
            say(&summary.line());
        }
        summary.notes().iter().for_each(|note| say(&format!("note: {note}")));
        if !arguments.json {
            print_line(&format!("wrote {} and its preview {}", output.display(), preview.display()))?;
        }
    }
    summary.outcome()
}

/// Refuses an output that is also an input.
fn check_parts_survive(output: &Path, parts: &[PathBuf]) -> Result<()> {
    // A file that is not there yet is no part.
    let Ok(target) = output.canonicalize() else { return Ok(()) };
    if parts.iter().any(|part| part.canonicalize().is_ok_and(|part| part == target)) {
        return Err(Error::Input(format!(
            "{}: it is one of the parts, so the image or its preview cannot go there; choose another name with -o",
            output.display()
        )));
    }
    Ok(())
}

/// What was merged and written.
struct Summary<'a> {
    merged: &'a Merged,
    output: &'a Path,
    preview: &'a Path,
}

impl Summary<'_> {
    fn text(&self, key: &str) -> &str {
        self.merged.picture.metadata.get(&format!("svetlo.{key}")).map_or("", String::as_str)
    }

    fn seconds(&self, key: &str) -> f64 {
        self.text(key).parse().unwrap_or(0.0)
    }

    fn line(&self) -> String {
        let Merged { parts, summary, .. } = self.merged;
        let error = summary.relative_error();
        let error = error.map_or(String::new(), |error| format!(", estimated error {:.3} %", error * 100.0));
        let samples = parts.samples();
        format!(
            "{} of {} parts, {samples} sample{}{error}; {:.2} s in all, {:.2} s the longest ({:.2} s on {})",
            parts.held().len(),
            parts.of(),
            if samples == 1 { "" } else { "s" },
            self.seconds("seconds_wall"),
            self.seconds("seconds_longest"),
            self.seconds("seconds_device"),
            self.text("device"),
        )
    }

    fn notes(&self) -> Vec<String> {
        let parts = &self.merged.parts;
        let missing = parts.missing();
        let mut notes = self.merged.notes.clone();
        if !missing.is_empty() {
            let (are, them) = if missing.len() == 1 { ("is", "it") } else { ("are", "them") };
            notes.push(format!(
                "{} of {} {are} missing: this is the picture without {them}, and can be merged with {them} later",
                parts_in_words(&missing),
                parts.of()
            ));
        }
        notes
    }

    /// The summary for programs.
    fn json(&self) -> Value {
        let Merged { parts, summary, paths, photons, .. } = self.merged;
        let number = |key: &str| self.text(key).parse::<u64>().ok();
        json!({
            "scene_hash": self.text("scene_hash"),
            "method": self.text("method"),
            "output": self.output.to_string_lossy(),
            "preview": self.preview.to_string_lossy(),
            "samples": parts.samples(),
            "parts": {
                "of": parts.of(),
                "held": parts.held().map(|(part, held)| json!({
                    "part": part,
                    "samples": held.samples,
                    // Of some pixels, where the part was interrupted or several devices were at it.
                    "more": held.more,
                })).collect::<Vec<_>>(),
                "missing": parts.missing(),
            },
            "seed": number("seed"),
            "seconds": {
                "wall": self.seconds("seconds_wall"),
                "device": self.seconds("seconds_device"),
                "build": self.seconds("seconds_build"),
                "longest": self.seconds("seconds_longest"),
            },
            "launches": number("launches"),
            "lookups": summary.lookups,
            "lookups_per_ray": summary.lookups as f64 / summary.samples.max(1) as f64,
            "paths": paths.as_ref().map(energy::report),
            "photons": photons.as_ref().map(|ledger| photons::report(ledger, None)),
            "mean": summary.mean,
            "estimated_error": summary.relative_error(),
            "rejected_samples": summary.rejected,
            "device": {
                "name": self.text("device"),
                "platform": self.text("platform"),
                "driver": self.text("driver"),
            },
            "notes": self.notes(),
        })
    }

    /// What the parts' ends mean for the exit code, as for a render's own.
    fn outcome(&self) -> Result<()> {
        let rejected = self.merged.summary.rejected;
        let paths = self.merged.paths.as_ref().and_then(|paths| energy::failure(paths, rejected));
        let samples = || {
            (rejected > 0).then(|| {
                format!(
                    "{rejected} samples were not finite and were left out: the image is not to be trusted"
                )
            })
        };
        match paths.or_else(samples) {
            Some(what) => Err(Error::Failed(format!("{what} (it was written to {})", self.output.display()))),
            None => Ok(()),
        }
    }
}
