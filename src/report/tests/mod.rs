//! Reports of results made by hand: what they say, and that nothing in them can break or leave the page.

mod content;
mod document;
mod hostile;
mod made;
mod truths;

use std::path::Path;

use self::document::Document;
use super::*;

/// The page of `results` in `folder`, parsed: not well-formed is a panic.
fn page_in(results: &Results, folder: &Path) -> Document {
    write(results, folder).expect("a report");
    Document::parse(&std::fs::read_to_string(folder.join("report.html")).expect("a page"))
}

/// The same in a folder without pictures.
fn page_of(results: &Results) -> Document {
    page_in(results, tempfile::tempdir().expect("a folder").path())
}
