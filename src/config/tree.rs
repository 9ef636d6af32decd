//! TOML as a tree that knows where each value was written.
//!
//! The scene file and every `--set` are sources; a node carries the source and the byte range of its
//! text, so that any later problem can show the place it comes from.

use std::collections::BTreeMap;
use std::ops::Range;

use serde_json::Value;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::diagnostic::{Problem, Spot};

/// Which text a node was written in: an index into [`Document::sources`](super::Document::sources).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct SourceId(pub usize);

/// A text that values come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// What it is called in messages: the file's path as given, or `--set`.
    pub name: String,
    /// The whole text.
    pub text: String,
}

/// A value and where it was written.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// The value.
    pub value: NodeValue,
    /// The text it was written in.
    pub source: SourceId,
    /// Byte range of the value; of the header for a `[table]`.
    pub span: Range<usize>,
    /// Byte range of its key; equal to `span` where there is none (the root, list entries).
    pub key_span: Range<usize>,
}

/// What a [`Node`] holds.
#[derive(Debug, Clone, PartialEq)]
pub enum NodeValue {
    /// A text.
    Text(String),
    /// A whole number that fits into `i64` or `u64`.
    Integer(i128),
    /// A decimal number; may be infinite or not a number.
    Float(f64),
    /// `true` or `false`.
    Boolean(bool),
    /// A date or time, which no key of a scene takes.
    Datetime,
    /// A list.
    List(Vec<Node>),
    /// A table.
    Table(BTreeMap<String, Node>),
}

impl Node {
    /// Where the value was written.
    pub fn spot(&self) -> Spot {
        Spot { source: self.source, span: self.span.clone() }
    }

    /// Where the key was written.
    pub fn key_spot(&self) -> Spot {
        Spot { source: self.source, span: self.key_span.clone() }
    }

    /// The entry with this key or index, if there is one.
    pub fn child(&self, step: &str) -> Option<&Node> {
        match &self.value {
            NodeValue::Table(table) => table.get(step),
            NodeValue::List(list) => list.get(step.parse::<usize>().ok()?),
            _ => None,
        }
    }

    /// The value in plain words, to follow "found".
    pub fn describe(&self) -> String {
        match &self.value {
            NodeValue::Text(text) => format!("the text {}", quote(text)),
            NodeValue::Integer(value) => format!("the whole number {value}"),
            NodeValue::Float(value) => format!("the decimal number {value:?}"),
            NodeValue::Boolean(value) => format!("{value}"),
            NodeValue::Datetime => "a date or time".into(),
            NodeValue::List(list) => match list.len() {
                0 => "an empty list".into(),
                1 => "a list of 1 entry".into(),
                n => format!("a list of {n} entries"),
            },
            NodeValue::Table(_) => "a table".into(),
        }
    }

    /// The same tree as JSON. Numbers that JSON lacks become null.
    pub fn to_json(&self) -> Value {
        match &self.value {
            NodeValue::Text(text) => Value::from(text.as_str()),
            NodeValue::Integer(value) => i64::try_from(*value)
                .map(Value::from)
                .or_else(|_| u64::try_from(*value).map(Value::from))
                .unwrap_or(Value::Null),
            NodeValue::Float(value) => Value::from(*value),
            NodeValue::Boolean(value) => Value::from(*value),
            NodeValue::Datetime => Value::Null,
            NodeValue::List(list) => list.iter().map(Node::to_json).collect(),
            NodeValue::Table(table) => {
                Value::Object(table.iter().map(|(key, node)| (key.clone(), node.to_json())).collect())
            }
        }
    }
}

/// A text in quotes for a message: shortened, and without control characters.
pub(crate) fn quote(text: &str) -> String {
    const LONGEST: usize = 40;
    let mut shown: String = text.chars().take(LONGEST).flat_map(char::escape_debug).collect();
    if text.chars().nth(LONGEST).is_some() {
        shown.push('…');
    }
    format!("\"{}\"", shown.replace("\\'", "'"))
}

/// Parses a whole TOML text. All syntax errors are reported at once; the tree holds what could be read.
pub(super) fn parse(text: &str, source: SourceId, problems: &mut Vec<Problem>) -> Node {
    let (root, errors) = DeTable::parse_recoverable(text);
    let errors = without_consequences(errors, text);
    problems.extend(errors.iter().map(|error| syntax_problem(error, source)));
    let mut reader = Reader { source, problems };
    let value = reader.table(root.get_ref());
    Node { value, source, span: 0..0, key_span: 0..0 }
}

/// Parses a text that is one TOML value, `shift` bytes into its source; `None` if it is none.
pub(super) fn parse_value(
    text: &str,
    shift: usize,
    source: SourceId,
    problems: &mut Vec<Problem>,
) -> Option<Node> {
    let value = DeValue::parse(text).ok()?;
    let mut node = Reader { source, problems }.node(&value);
    shift_spans(&mut node, shift);
    Some(node)
}

fn shift_spans(node: &mut Node, shift: usize) {
    for span in [&mut node.span, &mut node.key_span] {
        *span = span.start + shift..span.end + shift;
    }
    match &mut node.value {
        NodeValue::List(list) => list.iter_mut().for_each(|child| shift_spans(child, shift)),
        NodeValue::Table(table) => table.values_mut().for_each(|child| shift_spans(child, shift)),
        _ => {}
    }
}

/// Drops the errors that only follow from others: all but the first of a line, and after a bracket that
/// is never closed all but the first and that one, since the parser reads the rest of the file inside it.
fn without_consequences(mut errors: Vec<toml::de::Error>, text: &str) -> Vec<toml::de::Error> {
    let start = |error: &toml::de::Error| error.span().map_or(0, |span| span.start);
    errors.sort_by_key(start);
    let unclosed = errors.iter().any(|error| error.message().starts_with("unclosed"));
    let mut last: Option<usize> = None;
    errors.retain(|error| {
        let at = start(error);
        let between = last.and_then(|last| text.get(last..at));
        let keep = match last {
            None => true,
            Some(_) if unclosed => error.message().starts_with("unclosed"),
            Some(_) => between.is_none_or(|between| between.contains('\n')),
        };
        last = Some(at);
        keep
    });
    errors
}

fn syntax_problem(error: &toml::de::Error, source: SourceId) -> Problem {
    let spot = Spot { source, span: error.span().unwrap_or(0..0) };
    // The parser's messages may have several lines: the first says what is wrong, the others what is expected.
    let mut lines = error.message().lines();
    let message = format!("not valid TOML: {}", lines.next().unwrap_or("syntax error"));
    lines.fold(Problem::new(message, spot), |problem, line| problem.note(line))
}

struct Reader<'p> {
    source: SourceId,
    problems: &'p mut Vec<Problem>,
}

impl Reader<'_> {
    fn node(&mut self, spanned: &Spanned<DeValue<'_>>) -> Node {
        let span = spanned.span();
        let value = match spanned.get_ref() {
            DeValue::String(text) => NodeValue::Text(text.clone().into_owned()),
            DeValue::Integer(number) => self.integer(number.as_str(), number.radix(), &span),
            DeValue::Float(number) => NodeValue::Float(number.as_str().parse().unwrap_or(f64::NAN)),
            DeValue::Boolean(value) => NodeValue::Boolean(*value),
            DeValue::Datetime(_) => NodeValue::Datetime,
            DeValue::Array(array) => NodeValue::List(array.iter().map(|entry| self.node(entry)).collect()),
            DeValue::Table(table) => self.table(table),
        };
        Node { value, source: self.source, key_span: span.clone(), span }
    }

    fn table(&mut self, table: &DeTable<'_>) -> NodeValue {
        let entries = table.iter().map(|(key, value)| {
            let mut node = self.node(value);
            node.key_span = key.span();
            (key.get_ref().clone().into_owned(), node)
        });
        NodeValue::Table(entries.collect())
    }

    fn integer(&mut self, digits: &str, radix: u32, span: &Range<usize>) -> NodeValue {
        let fits = i128::from(i64::MIN)..=i128::from(u64::MAX);
        match i128::from_str_radix(digits, radix).ok().filter(|value| fits.contains(value)) {
            Some(value) => NodeValue::Integer(value),
            None => {
                let spot = Spot { source: self.source, span: span.clone() };
                self.problems.push(
                    Problem::new("this whole number is too large", spot).label("does not fit into 64 bits"),
                );
                NodeValue::Integer(0)
            }
        }
    }
}
