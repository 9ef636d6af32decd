//! Benches: suites of scenes × methods × devices, measured for speed and error together.
//!
//! A [`Suite`](suite::Suite) is read from TOML ([`types`]); [`run`] measures it into [`results`], piece by piece:
//! a piece is one repeat of a case on a device, kept by a hash of everything it depends on, so that an interrupted
//! bench goes on. [`summary`] puts the repeats together, [`findings`] says what the reader should know, [`baseline`]
//! compares with earlier results.

pub mod baseline;
mod computed;
pub mod files;
pub mod findings;
mod gallery;
pub mod ladder;
mod machine;
pub mod measure;
mod piece;
mod pool;
mod published;
mod reference;
mod refusals;
pub mod results;
mod results_truths;
mod run;
mod spec;
pub mod statistics;
pub mod suite;
pub mod summary;
pub mod table;
mod trust;
mod truth;
pub mod truth_table;
pub mod types;
mod watch;

pub use run::{Options, run};
pub use watch::{Alarm, Watch};
