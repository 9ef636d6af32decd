//! The command line: arguments in, one of the documented exit codes out.

mod bench;
mod check;
mod devices;
mod energy;
mod interrupt;
mod ladder;
mod light;
mod merge;
mod output;
mod photons;
mod places;
mod progress;
mod ranks;
mod render;
mod render_args;
mod selftest;
mod stderr;
mod summary;
mod target;
mod watcher;

use crate::cluster::Process;
use crate::metrics::command::CompareArgs;
use crate::scene::Scene;
use crate::{Error, Result};
use clap::{Parser, Subcommand};
use ranks::End;
use std::io::Write;
use std::path::Path;

/// Render volumes on any OpenCL device: a TOML scene in, a progressive EXR image out.
///
/// Exit codes: 0 fine; 1 it failed while running; 2 the input is wrong (arguments, scene, data); 3 a comparison or
/// self-test is out of tolerance; 130 interrupted, after the last image was written whole.
#[derive(Parser)]
#[command(name = "svetlo", version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Render a scene to an EXR image and a PNG preview.
    Render(render_args::RenderArgs),
    /// Add up parts of one picture that `render --part` rendered, anywhere: an image and its preview.
    Merge(merge::MergeArgs),
    /// Validate a scene and print the plan: features, memory per device, launches.
    Check(check::CheckArgs),
    /// List OpenCL platforms and devices, and the selector that picks each.
    Devices(devices::DevicesArgs),
    /// Prove that devices compute what they should: layouts, random numbers, and renders with known results.
    Selftest(selftest::SelftestArgs),
    /// Compare an image with a reference: RMSE, PSNR, relMSE, MAPE, bias.
    Compare(CompareArgs),
    /// Run a suite of benchmarks: speed against error.
    Bench(bench::BenchArgs),
    /// Render a scene by ever better models of light: error and cost of each, and the cheapest that will do.
    Ladder(ladder::LadderArgs),
    /// Print the JSON Schema of scene files, for editors.
    Schema,
}

/// Runs the command of this process and returns its exit code.
pub fn main() -> u8 {
    let process = match Process::join() {
        Ok(process) => process,
        Err(error) => return report(Err(error)),
    };
    // What is wrong with the arguments is so in all of several processes: the first says it.
    let speaks = process.place().rank == 0;
    let end = match Arguments::try_parse() {
        Ok(arguments) => match run(arguments.command, &process) {
            Err(error @ Error::Input(_)) if !speaks => error.exit_code().into(),
            Err(error) => report(Err(error)).into(),
            Ok(end) => end,
        },
        Err(error) => {
            let together = std::env::args_os().nth(1).is_some_and(|command| command == "render");
            together.then(|| ranks::refuse(&process, &error)).flatten().unwrap_or_else(|| {
                if speaks {
                    let _ = error.print();
                }
                ranks::code_of(&error).into()
            })
        }
    };
    if end.by_force {
        process.abort(end.code)
    } else {
        process.leave()
    }
    end.code
}

/// Says why a command has failed, if it has; its exit code.
fn report(ended: Result<()>) -> u8 {
    let Err(error) = ended else { return 0 };
    // The interrupt was reported where it was handled.
    if !matches!(error, Error::Interrupted) {
        stderr::say(&message(&error));
    }
    error.exit_code()
}

/// Scene diagnostics start with their own `error:` and place; everything else gets the word here.
fn message(error: &Error) -> String {
    let text = error.to_string();
    if text.starts_with("error") { text } else { format!("error: {text}") }
}

fn run(command: Command, process: &Process) -> Result<End> {
    let alone = |what| process.check_alone(what);
    match command {
        Command::Render(arguments) => return ranks::run(&arguments, process),
        Command::Merge(arguments) => alone("merge").and_then(|()| merge::run(&arguments)),
        Command::Check(arguments) => check::run(&arguments),
        Command::Devices(arguments) => devices::run(&arguments),
        Command::Selftest(arguments) => selftest::run(&arguments),
        Command::Compare(arguments) => {
            alone("compare").and_then(|()| crate::metrics::command::run(&arguments))
        }
        Command::Bench(arguments) => alone("bench").and_then(|()| bench::run(&arguments)),
        Command::Ladder(arguments) => alone("ladder").and_then(|()| ladder::run(&arguments)),
        Command::Schema => print_line(&pretty(&crate::config::schema())),
    }
    .map(|()| End::from(0))
}

/// The scene of a command line.
fn load_scene(path: &Path, sets: &[String]) -> Result<Scene> {
    if path.as_os_str() == "-" {
        return Err(Error::Input(
            "a scene is read from a file, not from standard input: its paths are relative to that file \
             (a file that is named - is ./-)"
                .into(),
        ));
    }
    Scene::load(path, sets)
}

/// Makes a write beyond `ulimit -f` an error like any other: by default its signal ends the program at once,
/// with the temporary file left behind.
fn outlive_file_size_limit() -> Result<()> {
    #[cfg(unix)]
    {
        let seen = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false));
        signal_hook::flag::register(signal_hook::consts::SIGXFSZ, seen)
            .map_err(|error| Error::Failed(format!("cannot watch for the file size limit: {error}")))?;
    }
    Ok(())
}

/// JSON for people to read.
fn pretty(value: &serde_json::Value) -> String {
    format!("{value:#}")
}

/// Prints to stdout; a reader that went away (`| head`) is not an error.
fn print_line(text: &str) -> Result<()> {
    match writeln!(std::io::stdout(), "{text}") {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::Failed(format!("cannot write to stdout: {error}")))
        }
        _ => Ok(()),
    }
}
