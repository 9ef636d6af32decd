//! Reads scene files: TOML with the places of all values, `--set` overrides, and a check of everything
//! against the JSON Schema that the raw types define.
//!
//! All problems are reported at once, each with file:line:col, the line, a caret and what is allowed.
//! What is valid key by key but wrong together is checked by [`crate::scene`], which uses the
//! [`Document`] to point at the places.

mod check;
mod diagnostic;
mod file;
pub mod formats;
mod schema;
mod set;
mod tree;
pub mod types;
mod types_caustics;
mod types_medium;
mod types_method;
mod types_surface;
mod types_transfer;
mod types_volume;
pub mod values;
mod words;

use std::path::Path;

pub use diagnostic::{Problem, Spot, render, stderr_takes_colour};
pub(crate) use schema::default_kind_first;
pub use schema::schema;
pub(crate) use tree::quote;
pub use tree::{Node, NodeValue, Source, SourceId};
pub use types::SceneConfig;
pub(crate) use words::nearest;

use crate::error::{Error, Result};
use schemars::JsonSchema;
use serde::de::DeserializeOwned;

/// A scene file with its overrides, as a tree that knows where each value was written.
#[derive(Debug, Clone, PartialEq)]
pub struct Document {
    /// The scene file, then one source for each `--set`.
    pub sources: Vec<Source>,
    /// The whole scene.
    pub root: Node,
}

impl Document {
    /// The node at a path such as `light.0.intensity`, if it was written.
    pub fn node(&self, path: &str) -> Option<&Node> {
        path.split('.').try_fold(&self.root, |node, step| node.child(step))
    }

    /// True if something was written at this path.
    pub fn has(&self, path: &str) -> bool {
        self.node(path).is_some()
    }

    /// Where the value at this path was written; if it was not, where the innermost table around it was.
    pub fn spot(&self, path: &str) -> Spot {
        let mut node = &self.root;
        for step in path.split('.') {
            match node.child(step) {
                Some(child) => node = child,
                None => break,
            }
        }
        node.spot()
    }

    /// Where the key at this path was written; like [`spot`](Self::spot) if it was not.
    pub fn key_spot(&self, path: &str) -> Spot {
        self.node(path).map_or_else(|| self.spot(path), Node::key_spot)
    }

    /// The problems as one error for the user (exit code 2), coloured if stderr is a terminal.
    pub fn error(&self, problems: &[Problem]) -> Error {
        Error::Input(render(problems, &self.sources, stderr_takes_colour()))
    }
}

/// A file whose every key is valid by itself, as raw values of type `T`.
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded<T = SceneConfig> {
    /// What was written, with defaults filled in.
    pub config: T,
    /// The texts and places behind it.
    pub document: Document,
}

/// Reads a scene file and applies the overrides (`key.path=value`) in order.
///
/// # Errors
/// [`Error::Input`] with every problem rendered, if the file cannot be read, is not TOML, or breaks the
/// scene's schema.
pub fn load(path: &Path, sets: &[String]) -> Result<Loaded> {
    load_as(path, "scene", sets)
}

/// Like [`load`], for another kind of TOML file: `noun` says what it is.
///
/// # Errors
/// As [`load`].
pub fn load_as<T: DeserializeOwned + JsonSchema>(
    path: &Path,
    noun: &str,
    sets: &[String],
) -> Result<Loaded<T>> {
    let text = file::read(path, noun)?;
    parse_as(&path.display().to_string(), noun, &text, sets)
}

/// Like [`load`], for a text that is called `name` in messages.
///
/// # Errors
/// As [`load`].
pub fn parse(name: &str, text: &str, sets: &[String]) -> Result<Loaded> {
    parse_as(name, "scene", text, sets)
}

/// Like [`parse`], for another kind of TOML file: `noun` says what it is.
///
/// # Errors
/// As [`load`].
pub fn parse_as<T: DeserializeOwned + JsonSchema>(
    name: &str,
    noun: &str,
    text: &str,
    sets: &[String],
) -> Result<Loaded<T>> {
    let mut sources = vec![Source { name: name.to_owned(), text: text.to_owned() }];
    sources.extend(sets.iter().map(|set| Source { name: "--set".into(), text: set.clone() }));
    let mut problems = Vec::new();
    let mut root = tree::parse(text, SourceId(0), &mut problems);
    for (index, set) in sets.iter().enumerate() {
        set::apply(&mut root, set, SourceId(index + 1), &mut problems);
    }
    let mut document = Document { sources, root };
    if problems.is_empty() {
        problems = check::check(&mut document.root, &schema::schema_of::<T>());
    }
    if !problems.is_empty() {
        return Err(document.error(&problems));
    }
    match T::deserialize(document.root.to_json()) {
        Ok(config) => Ok(Loaded { config, document }),
        // The checker takes its rules from the same types, so this is a gap in the checker.
        Err(error) => {
            let problem = Problem::new(format!("the {noun} cannot be read: {error}"), document.root.spot());
            Err(document.error(&[problem]))
        }
    }
}
