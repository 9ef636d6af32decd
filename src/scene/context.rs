//! What the conversions share: the places of the values, the scene's folder, and the problems so far.

use std::path::{Path, PathBuf};

use crate::config::{Document, Problem, quote};

pub(super) struct Context<'d> {
    document: &'d Document,
    folder: &'d Path,
    problems: Vec<Problem>,
}

impl<'d> Context<'d> {
    pub fn new(document: &'d Document, folder: &'d Path) -> Self {
        Self { document, folder, problems: Vec::new() }
    }

    pub fn into_problems(self) -> Vec<Problem> {
        self.problems
    }

    /// True if the scene says something at this path.
    pub fn has(&self, path: &str) -> bool {
        self.document.has(path)
    }

    /// Reports a wrong value: `label` stands beside the caret.
    pub fn wrong(&mut self, path: &str, message: impl Into<String>, label: impl Into<String>) {
        self.push(Problem::new(message, self.document.spot(path)).label(label));
    }

    /// Reports a key that has no use here.
    pub fn useless(&mut self, path: &str, reason: &str, label: &str) {
        if self.has(path) {
            let problem = Problem::new(format!("`{path}` {reason}"), self.document.key_spot(path));
            self.push(problem.label(label));
        }
    }

    /// Reports a value together with a line of help.
    pub fn wrong_with_help(&mut self, path: &str, message: impl Into<String>, label: &str, help: &str) {
        self.push(Problem::new(message, self.document.spot(path)).label(label).note(help));
    }

    fn push(&mut self, problem: Problem) {
        self.problems.push(problem);
    }

    /// Resolves the file name at `path` against the scene's folder and makes sure that it is a file.
    pub fn file(&mut self, path: &str, name: &str) -> PathBuf {
        let file = self.folder.join(name);
        let looked = || format!("looked for {}", file.display());
        if file.is_dir() {
            self.wrong(path, format!("{} is a directory, not a file", quote(name)), looked());
        } else if !file.exists() {
            self.wrong(path, format!("there is no file {}", quote(name)), looked());
        }
        file
    }
}
