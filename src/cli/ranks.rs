//! `svetlo render` as several processes.

use super::interrupt::watch_interrupt;
use super::render;
use super::render_args::RenderArgs;
use super::stderr::say;
use super::{load_scene, places, report};
use crate::cluster::{Fleet, Process, Rank, serve};
use crate::device::Catalog;
use crate::post::Exchange;
use crate::{Error, Result};
use std::time::Duration;

/// How long a process that is told of the end may take to say that it knows.
const PATIENCE: Duration = Duration::from_secs(10);

/// The end of a command.
pub struct End {
    /// The exit code.
    pub code: u8,
    /// Whether other processes must be ended by force.
    pub by_force: bool,
}

impl From<u8> for End {
    fn from(code: u8) -> Self {
        Self { code, by_force: false }
    }
}

/// Renders, alone or with the others.
///
/// # Errors
/// As [`render::run`], and where there are others that do not work together.
pub fn run(arguments: &RenderArgs, process: &Process) -> Result<End> {
    let place = process.place();
    let Some(exchange) = process.exchange() else {
        process.check_alone("render")?;
        return render::run(arguments, place, None).map(|()| End::from(0));
    };
    if place.rank > 0 {
        return Ok(followed(follow(arguments, process, exchange)));
    }
    let mut fleet = Fleet::new(exchange, place.size);
    let code = report(render::run(arguments, place, Some(&mut fleet)));
    Ok(end(fleet, code))
}

/// What becomes of a process that renders with others, but cannot read its arguments; `None` where there are no others.
pub fn refuse(process: &Process, error: &clap::Error) -> Option<End> {
    let exchange = process.exchange()?;
    let place = process.place();
    if place.rank == 0 {
        let _ = error.print();
        return Some(end(Fleet::new(exchange, place.size), code_of(error)));
    }
    // Those whose arguments are right learn it from rank 0.
    let what = || Error::Input(error.to_string().trim_end().to_owned());
    let rank = Rank { host: host(), scene: Err(what()), part: None, devices: Err(what()) };
    Some(followed(serve(exchange, &rank)))
}

/// The exit code of a command line that is not run.
pub fn code_of(error: &clap::Error) -> u8 {
    u8::from(error.use_stderr()) * 2
}

/// Nobody may leave before all know that it is over, and why is said once.
fn end(fleet: Fleet<'_>, code: u8) -> End {
    let silent = fleet.end(code, PATIENCE);
    if !silent.is_empty() {
        let names = silent.join(", ");
        say(&format!("warning: no answer from {names}: all processes are ended by force"));
    }
    End { code, by_force: !silent.is_empty() }
}

/// The end of a process that worked for rank 0: that would wait for one that leaves untold.
fn followed(code: Result<u8>) -> End {
    match code {
        Ok(code) => End::from(code),
        Err(error) => End { code: report(Err(error)), by_force: true },
    }
}

/// Works for rank 0; its exit code.
fn follow(arguments: &RenderArgs, process: &Process, exchange: &Exchange) -> Result<u8> {
    // A launcher passes signals on to all: rank 0 says what follows from them.
    let _interrupt = watch_interrupt()?;
    let catalog = Catalog::enumerate();
    let rank = Rank {
        host: host(),
        scene: load_scene(&arguments.scene, &arguments.sets()),
        part: arguments.part,
        devices: places::chosen(arguments, &catalog, process.place()),
    };
    serve(exchange, &rank)
}

/// The name of this machine; empty where it has none.
fn host() -> String {
    #[cfg(unix)]
    return rustix::system::uname().nodename().to_string_lossy().into_owned();
    #[cfg(not(unix))]
    std::env::var("COMPUTERNAME").unwrap_or_default()
}
