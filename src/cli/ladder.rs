//! `svetlo ladder`.

use super::interrupt::watch_interrupt;
use super::stderr::say;
use super::{outlive_file_size_limit, pretty, print_line};
use crate::bench::files::Folder;
use crate::bench::ladder::{Request, climb};
use crate::bench::{Options, Watch};
use crate::config::formats::{parse_duration, parse_percentage};
use crate::device::Catalog;
use crate::report;
use crate::{Error, Result};
use std::path::PathBuf;
use std::time::Duration;

/// Arguments of `svetlo ladder`.
#[derive(clap::Args)]
pub struct LadderArgs {
    /// The scene file.
    scene: PathBuf,
    /// Override a value of the scene, such as `image.width=128` (repeatable).
    #[arg(long, value_name = "KEY.PATH=VALUE")]
    set: Vec<String>,
    /// The device: a selector of `svetlo devices`, a kind (cpu, gpu) or part of a name [env: SVETLO_DEVICE].
    #[arg(long, value_name = "SELECTOR")]
    device: Option<String>,
    /// The largest relative error that will do.
    #[arg(long, value_name = "ERROR", value_parser = parse_percentage, default_value = "5%")]
    tolerance: f64,
    /// Time for each of three runs of every model; each of two references takes up to six times as long.
    #[arg(long, value_name = "TIME", value_parser = parse_duration, default_value = "3s")]
    time: Duration,
    /// Keep pictures and results in this folder; what is finished there is not done again.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Do not ask first whether the device computes what it should.
    #[arg(long)]
    no_selftest: bool,
    /// Print nothing but the table and errors.
    #[arg(long)]
    quiet: bool,
    /// Print the ladder as JSON.
    #[arg(long)]
    json: bool,
}

/// Renders the scene by every model and says which one will do.
///
/// # Errors
/// With the documented exit codes; see [`Error`].
pub fn run(arguments: &LadderArgs) -> Result<()> {
    outlive_file_size_limit()?;
    super::load_scene(&arguments.scene, &arguments.set)?;
    let temporary = tempfile::tempdir().map_err(|cause| {
        Error::Failed(format!("cannot make a temporary folder ({cause}); give one with -o"))
    })?;
    let folder = Folder::make(arguments.output.as_deref().unwrap_or(temporary.path()))?;
    let interrupt = watch_interrupt()?;
    let catalog = Catalog::enumerate();
    let variable = std::env::var("SVETLO_DEVICE").ok().filter(|text| !text.trim().is_empty());
    let device = catalog.select(arguments.device.clone().or(variable).as_deref())?;
    let tell = |text: &str| {
        if !arguments.quiet {
            say(text);
        }
    };
    let request = Request {
        scene: &arguments.scene,
        sets: &arguments.set,
        tolerance: arguments.tolerance,
        time: arguments.time,
    };
    let options = Options { devices: &[device], selftest: !arguments.no_selftest };
    let ladder = climb(&request, &options, &folder, &Watch::new(&tell, &interrupt)).inspect_err(|error| {
        if matches!(error, Error::Interrupted) {
            say("interrupted before anything was measured");
        }
    })?;
    if arguments.output.is_some() {
        report::write_ladder(&ladder, &folder.path("."))?;
    }
    if arguments.json {
        let value = serde_json::to_value(&ladder)
            .map_err(|cause| Error::Failed(format!("cannot describe the ladder: {cause}")))?;
        print_line(&pretty(&value))?;
    } else {
        print_line(&ladder.table())?;
    }
    if ladder.complete {
        return Ok(());
    }
    say("interrupted; the ladder is incomplete");
    Err(Error::Interrupted)
}
