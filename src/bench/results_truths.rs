//! What is known of cases, beside what was found: part of the data model of `results.json`.

use super::results::{Case, ReferenceKind};
use serde::{Deserialize, Serialize};

impl Case {
    /// Whether it is judged by its truth alone.
    pub fn is_only_truth(&self) -> bool {
        self.reference.kind == ReferenceKind::Truth
    }

    /// Whether samples were not finite, or paths went wrong.
    pub fn is_faulty(&self) -> bool {
        let last = self.repeats.iter().filter_map(|repeat| repeat.checkpoints.last());
        last.into_iter().any(|last| last.rejected + last.faults > 0)
    }
}

/// What is known of a picture, beside what was found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// Per channel.
    pub value: [f64; 3],
    /// Of what.
    pub of: Quantity,
    /// Left, top, right, bottom in pixels, the last two not included.
    pub region: [u32; 4],
    /// Standard error of `value`.
    pub error: f64,
    /// Share of `value` that is no fault.
    pub tolerance: f64,
    /// Standard errors that are no fault.
    pub sigmas: f64,
    /// Where `value` is from.
    pub source: String,
    /// What the picture has; of single pixels, that which is furthest off.
    pub found: [f64; 3],
    /// Standard error of `found` from the pixels' own variance; `None` where nothing is random, or pixels share noise.
    pub standard_error: Option<[f64; 3]>,
    /// The largest deviation of a channel in standard errors, of both; `None` where there is none, or less of it than the
    /// tolerance allows for.
    pub z: Option<f64>,
    /// The largest deviation of a channel over its value; `None` for 0.
    pub relative: Option<f64>,
    /// The largest deviation of a channel over what is allowed: at most 1 is right. `None` where any is too much.
    pub share: Option<f64>,
    /// Values of the whole picture that are not finite.
    pub not_finite: u64,
    /// Values of the whole picture below 0 by more than `sigmas` standard errors of their own.
    pub negative: u64,
    /// Whether it agrees.
    pub right: bool,
}

/// What a truth is of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Quantity {
    /// The mean of the pixels.
    #[default]
    Mean,
    /// Every pixel by itself; noise is not allowed for.
    Each,
}

/// A case that must be refused, and what happened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Refusal {
    /// Unique in the suite.
    pub name: String,
    /// What it is about; may be empty.
    pub about: String,
    /// The part of the table it belongs to.
    pub group: String,
    /// The scene file, as the suite names it.
    pub scene: String,
    /// `key.path=value`, in the order in which they apply.
    pub overrides: Vec<String>,
    /// What the message must contain.
    pub wanted: String,
    /// The message; `None` where the scene was taken.
    pub message: Option<String>,
}

impl Refusal {
    /// Whether it was refused, and for that.
    pub fn right(&self) -> bool {
        self.message.as_ref().is_some_and(|message| message.contains(&self.wanted))
    }
}
