//! `--set key.path=value`: one value of the scene, overridden on the command line.
//!
//! Each override is a source of its own, whose text is what the user typed, so problems with it, here
//! or later, point into that text.

use std::collections::BTreeMap;
use std::ops::Range;

use super::diagnostic::{Problem, Spot};
use super::tree::{Node, NodeValue, SourceId, parse_value, quote};

/// Longest path; no scene is deeper than a handful, and it bounds recursion over the tree.
const DEEPEST: usize = 16;

/// Applies one override to the tree. Missing tables on the way are created.
pub(super) fn apply(root: &mut Node, text: &str, source: SourceId, problems: &mut Vec<Problem>) {
    match try_apply(root, text, source, problems) {
        Ok(()) => {}
        Err(problem) => problems.push(*problem),
    }
}

fn try_apply(
    root: &mut Node,
    text: &str,
    source: SourceId,
    problems: &mut Vec<Problem>,
) -> Result<(), Box<Problem>> {
    let spot = |span: Range<usize>| Spot { source, span };
    let Some(equals) = text.find('=') else {
        return Err(Problem::new("an override needs a value", spot(0..text.len()))
            .label("no `=` in here")
            .note("write it as --set key.path=value, for example --set image.width=256")
            .into());
    };
    let path = segments(&text[..equals]);
    if let Some((_, span)) = path.iter().find(|(name, _)| name.is_empty()) {
        return Err(Problem::new("the path of this override has an empty part", spot(span.clone()))
            .label("a key is missing here")
            .into());
    }
    if path.len() > DEEPEST {
        return Err(Problem::new("the path of this override is too deep", spot(0..equals))
            .label(format!("at most {DEEPEST} keys"))
            .into());
    }
    let value = value_node(text, equals + 1, source, problems);
    insert(root, &path, value)
}

/// The keys of a path and where they stand; blanks around them do not count.
fn segments(path: &str) -> Vec<(&str, Range<usize>)> {
    let mut start = 0;
    let split = path.split('.').map(|part| {
        let name = part.trim();
        let at = start + (part.len() - part.trim_start().len());
        start += part.len() + 1;
        (name, at..at + name.len())
    });
    split.collect()
}

/// The value of an override: a TOML value, else the text as it stands.
fn value_node(text: &str, start: usize, source: SourceId, problems: &mut Vec<Problem>) -> Node {
    let raw = &text[start..];
    let value = raw.trim();
    let start = start + (raw.len() - raw.trim_start().len());
    parse_value(value, start, source, problems).unwrap_or_else(|| {
        let span = start..start + value.len();
        Node { value: NodeValue::Text(value.into()), source, key_span: span.clone(), span }
    })
}

fn insert(root: &mut Node, path: &[(&str, Range<usize>)], mut value: Node) -> Result<(), Box<Problem>> {
    let source = value.source;
    let Some(((last, last_span), parents)) = path.split_last() else { return Ok(()) };
    let mut node = root;
    let mut walked = String::new();
    for (name, span) in parents {
        let fresh = Node {
            value: NodeValue::Table(BTreeMap::new()),
            source,
            span: span.clone(),
            key_span: span.clone(),
        };
        node = slot(node, name, Spot { source, span: span.clone() }, &walked, fresh)?;
        walked = if walked.is_empty() { (*name).into() } else { format!("{walked}.{name}") };
    }
    value.key_span = last_span.clone();
    let target = slot(node, last, Spot { source, span: last_span.clone() }, &walked, value.clone())?;
    *target = value;
    Ok(())
}

/// The entry of `node` named `name`; put there as `fresh` if a table lacks it.
fn slot<'n>(
    node: &'n mut Node,
    name: &str,
    spot: Spot,
    walked: &str,
    fresh: Node,
) -> Result<&'n mut Node, Box<Problem>> {
    let found = node.describe();
    match &mut node.value {
        NodeValue::Table(table) => {
            if table.is_empty() && !walked.is_empty() && name.parse::<usize>().is_ok() {
                return Err(Problem::new(format!("`{walked}` has no entry {name}"), spot)
                    .label("there is no such list to change")
                    .into());
            }
            Ok(table.entry(name.to_owned()).or_insert(fresh))
        }
        NodeValue::List(list) => {
            let count = list.len();
            name.parse::<usize>()
                .ok()
                .and_then(|index| list.get_mut(index))
                .ok_or_else(|| list_problem(walked, name, count, spot).into())
        }
        _ => Err(Problem::new(format!("`{walked}` has no keys inside"), spot)
            .label(format!("`{walked}` is {found}"))
            .into()),
    }
}

fn list_problem(walked: &str, name: &str, count: usize, spot: Spot) -> Problem {
    let range = match count {
        0 => "the list is empty".to_owned(),
        1 => "the only entry is 0".to_owned(),
        n => format!("its entries are 0 to {}", n - 1),
    };
    let message = match name.parse::<usize>() {
        Ok(_) => format!("`{walked}` has no entry {name}"),
        Err(_) => format!("`{walked}` is a list, and {} is not the number of an entry", quote(name)),
    };
    Problem::new(message, spot).label(range)
}
