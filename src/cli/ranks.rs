//! `svetlo render` as several processes.

use super::interrupt::watch_interrupt;
use super::render;
use super::render_args::RenderArgs;
use super::stderr::say;
use super::{load_scene, places, report};
use crate::Result;
use crate::cluster::{Fleet, Process, Rank, serve};
use crate::device::Catalog;
use crate::post::Exchange;
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
        return follow(arguments, process, exchange).map(End::from);
    }
    let mut fleet = Fleet::new(exchange, place.size);
    // Nobody may leave before all know that it is over, and why is said once.
    let code = report(render::run(arguments, place, Some(&mut fleet)));
    let silent = fleet.end(code, PATIENCE);
    if !silent.is_empty() {
        let names = silent.join(", ");
        say(&format!("warning: no answer from {names}: all processes are ended by force"));
    }
    Ok(End { code, by_force: !silent.is_empty() })
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
