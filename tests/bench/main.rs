//! `svetlo bench` and `svetlo ladder`: suites that are wrong, results that are right, and benches that go on.

mod errors;
mod ladder;
mod light;
mod pictures;
mod planted;
mod resume;
#[path = "../cli/support.rs"]
#[allow(dead_code)]
mod support;
mod truths;

use std::path::Path;
use support::{Folder, Ran};
use svetlo::bench::results::Results;

/// A folder with the sphere of the other tests, and this suite.
pub fn folder(suite: &str) -> Folder {
    let folder = Folder::new();
    folder.write("suite.toml", suite);
    folder
}

/// Runs the suite of a folder into `out`, with more arguments.
pub fn bench(folder: &Folder, more: &[&str]) -> Ran {
    let arguments = ["bench", "suite.toml", "-o", "out", "--no-selftest"];
    folder.run(&arguments.iter().chain(more).collect::<Vec<_>>())
}

/// The results of a folder.
pub fn results(folder: &Folder, name: impl AsRef<Path>) -> Results {
    let text = std::fs::read_to_string(folder.path(name)).expect("results");
    serde_json::from_str(&text).expect("the data model of results")
}
