//! Problems with the input, and how they are shown: file:line:col, the line, a caret, and help.

use std::fmt::Write as _;
use std::io::IsTerminal;
use std::ops::Range;

use codespan_reporting::diagnostic::{Diagnostic, Label};
use codespan_reporting::files::{Files, SimpleFiles};
use codespan_reporting::term::{self, termcolor};

use super::tree::{Source, SourceId};

/// More problems than this are counted, not shown: a file that is no scene at all has thousands.
const MOST_SHOWN: usize = 50;
/// Lines longer than this (bytes) are not shown, only pointed at.
const WIDEST_LINE: usize = 400;

/// A place in a source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Spot {
    /// The text.
    pub source: SourceId,
    /// Bytes of the text.
    pub span: Range<usize>,
}

/// One thing that is wrong with the input.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// What is wrong, in one line.
    pub message: String,
    /// Where.
    pub spot: Spot,
    /// What to say beside the caret; may be empty.
    pub label: String,
    /// Help, one line each.
    pub notes: Vec<String>,
}

impl Problem {
    /// A problem at a place.
    pub fn new(message: impl Into<String>, spot: Spot) -> Self {
        Self { message: message.into(), spot, label: String::new(), notes: Vec::new() }
    }

    /// Says something beside the caret.
    #[must_use]
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = label.into();
        self
    }

    /// Adds a line of help.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }
}

/// True if messages on stderr may be coloured: it is a terminal and `NO_COLOR` is unset or empty.
pub fn stderr_takes_colour() -> bool {
    std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty()) && std::io::stderr().is_terminal()
}

/// Renders the problems, sorted by position, with a line that counts them at the end.
pub fn render(problems: &[Problem], sources: &[Source], colour: bool) -> String {
    let mut files = SimpleFiles::new();
    for source in sources {
        files.add(source.name.clone(), source.text.as_str());
    }
    let mut sorted: Vec<_> = problems.iter().collect();
    sorted.sort_by_key(|p| (p.spot.source, p.spot.span.start, p.spot.span.end));
    sorted.dedup();
    let mut text = String::new();
    for problem in sorted.iter().take(MOST_SHOWN) {
        text.push_str(&render_one(problem, sources, &files, colour));
    }
    if sorted.len() > MOST_SHOWN {
        let _ = writeln!(text, "… and {} more", sorted.len() - MOST_SHOWN);
    }
    let noun = if sorted.len() == 1 { "problem" } else { "problems" };
    let name = sources.first().map_or("the scene", |source| source.name.as_str());
    let _ = write!(text, "{} {noun} in {name}", sorted.len());
    text
}

type SourceFiles<'s> = SimpleFiles<String, &'s str>;

fn render_one(problem: &Problem, sources: &[Source], files: &SourceFiles<'_>, colour: bool) -> String {
    let id = problem.spot.source.0;
    let source = sources.get(id).map_or("", |source| source.text.as_str());
    let span = clamp(source, &problem.spot.span);
    if line_is_too_wide(source, span.start) {
        return without_snippet(problem, files, span.start);
    }
    let diagnostic = Diagnostic::error()
        .with_message(&problem.message)
        .with_label(Label::primary(id, span.clone()).with_message(&problem.label))
        .with_notes(problem.notes.clone());
    let mut buffer = if colour { termcolor::Buffer::ansi() } else { termcolor::Buffer::no_color() };
    match term::emit_to_write_style(&mut buffer, &term::Config::default(), files, &diagnostic) {
        Ok(()) => trim_line_ends(&String::from_utf8_lossy(buffer.as_slice())),
        // The source is unknown to the renderer: what is wrong matters more than where.
        Err(_) => without_snippet(problem, files, span.start),
    }
}

/// The message, place and notes as plain lines.
fn without_snippet(problem: &Problem, files: &SourceFiles<'_>, start: usize) -> String {
    let mut text = format!("error: {}\n", problem.message);
    let id = problem.spot.source.0;
    if let (Ok(name), Ok(place)) = (files.name(id), files.location(id, start)) {
        let _ = writeln!(text, "  at {name}:{}:{}", place.line_number, place.column_number);
    }
    for line in std::iter::once(&problem.label).chain(&problem.notes).filter(|line| !line.is_empty()) {
        let _ = writeln!(text, "  = {line}");
    }
    text.push('\n');
    text
}

/// Keeps a span inside its text, on character boundaries and on its first line.
fn clamp(text: &str, span: &Range<usize>) -> Range<usize> {
    let start = floor_boundary(text, span.start);
    let line_end = text[start..].find(['\n', '\r']).map_or(text.len(), |length| start + length);
    let end = floor_boundary(text, span.end).clamp(start, line_end.max(start));
    start..end
}

fn floor_boundary(text: &str, index: usize) -> usize {
    let index = index.min(text.len());
    (0..=index).rev().find(|&i| text.is_char_boundary(i)).unwrap_or(0)
}

fn line_is_too_wide(text: &str, at: usize) -> bool {
    let before = text[..at].rfind('\n').map_or(at, |newline| at - newline);
    let after = text[at..].find('\n').unwrap_or(text.len() - at);
    before + after > WIDEST_LINE
}

/// The renderer pads empty labels with blanks; nobody wants those in logs.
fn trim_line_ends(text: &str) -> String {
    text.lines().flat_map(|line| [line.trim_end(), "\n"]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(text: &str) -> Vec<Source> {
        vec![Source { name: "s.toml".into(), text: text.into() }]
    }

    fn problem(span: Range<usize>) -> Problem {
        Problem::new("wrong", Spot { source: SourceId(0), span })
    }

    #[test]
    fn spans_outside_the_text_or_inside_a_character_do_no_harm() {
        let sources = source("é = 1\n");
        for span in [0..1, 1..1, 1..2, 5..900, 900..901, 0..usize::MAX] {
            let text = render(&[problem(span)], &sources, false);
            assert!(text.ends_with("1 problem in s.toml"), "{text}");
        }
        let nowhere = Problem::new("wrong", Spot { source: SourceId(7), span: 0..1 });
        assert_eq!(render(&[nowhere], &sources, false), "error: wrong\n\n1 problem in s.toml");
    }

    #[test]
    fn a_very_long_line_is_not_printed() {
        let sources = source(&"x".repeat(100_000));
        let text = render(&[problem(50_000..50_001)], &sources, false);
        assert_eq!(text, "error: wrong\n  at s.toml:1:50001\n\n1 problem in s.toml");
    }

    #[test]
    fn only_the_first_problems_are_shown_but_all_are_counted() {
        let sources = source(&"x\n".repeat(100));
        let problems: Vec<_> = (0..80).map(|i| problem(2 * i..2 * i + 1)).collect();
        let text = render(&problems, &sources, false);
        assert!(text.ends_with("… and 30 more\n80 problems in s.toml"), "{text}");
    }

    #[test]
    fn colour_only_when_asked_for() {
        let sources = source("x\n");
        assert!(render(&[problem(0..1)], &sources, true).contains('\x1b'));
        assert!(!render(&[problem(0..1)], &sources, false).contains('\x1b'));
    }
}
