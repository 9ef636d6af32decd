//! Checks a tree against the JSON Schema, reporting every problem at once with its place.
//!
//! It knows the part of JSON Schema that the raw types produce: types, words, ranges, lists, tables,
//! references, and alternatives that are told apart by a tag (`kind`, `shape`, `mode`), by their type,
//! or by the keys that are there. Where a tag may be missing, it is filled in with its default.

use serde_json::{Map, Value};

use super::diagnostic::Problem;
use super::formats;
use super::tree::{Node, NodeValue, quote};
use super::words;

/// All problems of the tree; none if it can be read into the raw types.
pub(super) fn check(root: &mut Node, schema: &Value) -> Vec<Problem> {
    let mut checker = Checker { schema, problems: Vec::new() };
    checker.visit(root, schema, "");
    checker.problems
}

struct Checker<'s> {
    schema: &'s Value,
    problems: Vec<Problem>,
}

impl<'s> Checker<'s> {
    fn visit(&mut self, node: &mut Node, schema: &'s Value, path: &str) {
        let schema = words::resolve(self.schema, schema);
        if let Some(allowed) = words::allowed_words(schema) {
            return self.word(node, &allowed, path);
        }
        if let Some(options) = words::alternatives(schema) {
            return self.alternative(node, schema, options, path);
        }
        self.single(node, schema, path, &[]);
    }

    /// A schema without alternatives; `siblings` are the other variants of a tagged table.
    fn single(&mut self, node: &mut Node, schema: &'s Value, path: &str, siblings: &'s [Value]) {
        let Some(rules) = schema.as_object() else { return };
        if !words::has_type(node, schema) {
            return self.wrong_type(node, schema, path);
        }
        match &mut node.value {
            NodeValue::Table(_) => self.table(node, rules, path, siblings),
            NodeValue::List(list) => {
                if let Some(items) = rules.get("items") {
                    for (index, entry) in list.iter_mut().enumerate() {
                        self.visit(entry, items, &format!("{path}.{index}"));
                    }
                }
                self.list_length(node, schema, path);
            }
            NodeValue::Integer(_) | NodeValue::Float(_) => self.number(node, rules, path),
            NodeValue::Text(_) => self.text(node, rules, path),
            NodeValue::Boolean(_) | NodeValue::Datetime => {}
        }
    }

    fn alternative(&mut self, node: &mut Node, schema: &'s Value, options: &'s [Value], path: &str) {
        if let Some(tag) = words::common_tag(options) {
            if !matches!(node.value, NodeValue::Table(_)) {
                return self.wrong_type(node, &options[0], path);
            }
            if let Some(index) = self.variant(node, tag, options, path) {
                self.single(node, &options[index], path, options);
            }
            return;
        }
        let fitting =
            options.iter().filter(|option| words::has_type(node, words::resolve(self.schema, option)));
        // Of several tables the one that shares the most keys is meant; `max_by_key` takes the last of equals.
        match fitting.rev().max_by_key(|option| shared_keys(node, option)) {
            Some(option) => self.visit(node, option, path),
            None => self.wrong_type(node, schema, path),
        }
    }

    /// The index of the variant that the tag names; the default one if there is no tag.
    fn variant(&mut self, node: &mut Node, tag: &str, options: &'s [Value], path: &str) -> Option<usize> {
        let property = |option: &'s Value| option.pointer(&format!("/properties/{tag}"));
        let name = |option: &'s Value| property(option)?.get("const")?.as_str();
        let names: Vec<&str> = options.iter().filter_map(name).collect();
        let (spot, key_spot) = (node.spot(), node.key_spot());
        let NodeValue::Table(table) = &mut node.value else { return None };
        let Some(found) = table.get(tag) else {
            let default =
                options.iter().position(|o| property(o).is_some_and(|p| p.get("default").is_some()));
            match default {
                Some(index) => {
                    let value = NodeValue::Text(names[index].to_owned());
                    let node = Node { value, source: spot.source, span: spot.span, key_span: key_spot.span };
                    table.insert(tag.to_owned(), node);
                }
                None => self.problems.push(
                    Problem::new(format!("missing key `{tag}`{}", in_table(path)), spot)
                        .label(format!("needs `{tag}`: {}", words::one_of(&names))),
                ),
            }
            return default;
        };
        let index = match &found.value {
            NodeValue::Text(text) => names.iter().position(|name| name == text),
            _ => None,
        };
        if index.is_none() {
            let found = found.clone();
            self.word(&found, &names, &join(path, tag));
        }
        index
    }

    fn table(&mut self, node: &mut Node, rules: &'s Map<String, Value>, path: &str, siblings: &'s [Value]) {
        let empty = Map::new();
        let properties = rules.get("properties").and_then(Value::as_object);
        let spot = node.spot();
        let NodeValue::Table(table) = &mut node.value else { return };
        for (key, child) in table.iter_mut() {
            match properties.and_then(|properties| properties.get(key)) {
                Some(schema) => self.visit(child, schema, &join(path, key)),
                None => {
                    self.problems.push(unknown_key(key, child, path, properties.unwrap_or(&empty), siblings))
                }
            }
        }
        let required = rules.get("required").and_then(Value::as_array).into_iter().flatten();
        for key in required.filter_map(Value::as_str).filter(|key| !table.contains_key(*key)) {
            let mut problem = Problem::new(format!("missing key `{key}`{}", in_table(path)), spot.clone())
                .label(format!("needs `{key}`"));
            if let Some(help) = properties.and_then(|p| p.get(key)?.get("description")?.as_str()) {
                problem = problem.note(format!("`{key}`: {help}"));
            }
            self.problems.push(problem);
        }
    }

    fn wrong_type(&mut self, node: &Node, schema: &Value, path: &str) {
        let wanted = words::describe(self.schema, schema);
        let mut problem = Problem::new(format!("`{path}` must be {wanted}"), node.spot())
            .label(format!("this is {}", node.describe()));
        if wanted == "a whole number"
            && let NodeValue::Float(value) = node.value
            && value.fract() == 0.0
        {
            problem = problem.note(format!("write it without a decimal point: {value:.0}"));
        }
        self.problems.push(problem);
    }

    fn word(&mut self, node: &Node, allowed: &[&str], path: &str) {
        let NodeValue::Text(text) = &node.value else {
            let problem = Problem::new(format!("`{path}` must be {}", words::one_of(allowed)), node.spot());
            self.problems.push(problem.label(format!("this is {}", node.describe())));
            return;
        };
        if allowed.contains(&text.as_str()) {
            return;
        }
        let mut problem = Problem::new(format!("`{path}` cannot be {}", quote(text)), node.spot())
            .label("unknown word")
            .note(format!("allowed: {}", words::one_of(allowed)));
        if let Some(meant) = words::nearest(text, allowed.iter().copied()) {
            problem = problem.label(format!("did you mean \"{meant}\"?"));
        }
        self.problems.push(problem);
    }

    fn number(&mut self, node: &Node, rules: &Map<String, Value>, path: &str) {
        let value = match node.value {
            NodeValue::Integer(value) => value as f64,
            NodeValue::Float(value) => value,
            _ => return,
        };
        if !value.is_finite() {
            let problem = Problem::new(format!("`{path}` must be a finite number"), node.spot());
            self.problems.push(problem.label(format!("this is {}", non_finite(value))));
        } else if !words::in_range(value, rules) {
            let allowed = words::range(rules).unwrap_or_default();
            let problem = Problem::new(format!("`{path}` is out of range"), node.spot());
            self.problems.push(problem.label(format!("must be {allowed}")));
        }
    }

    fn text(&mut self, node: &Node, rules: &Map<String, Value>, path: &str) {
        let format = rules.get("format").and_then(Value::as_str).and_then(formats::by_name);
        if let (Some(format), NodeValue::Text(text)) = (format, &node.value)
            && let Err(complaint) = (format.check)(text)
        {
            let problem = Problem::new(format!("`{path}` must be {}", format.description), node.spot());
            self.problems.push(problem.label(complaint));
        }
    }

    fn list_length(&mut self, node: &Node, schema: &Value, path: &str) {
        let NodeValue::List(list) = &node.value else { return };
        let too_few = words::count(schema, "minItems").is_some_and(|least| list.len() < least);
        let too_many = words::count(schema, "maxItems").is_some_and(|most| list.len() > most);
        if too_few && words::count(schema, "maxItems").is_none() {
            let problem = Problem::new(format!("`{path}` has too few entries"), node.spot());
            self.problems.push(problem.label(format!("this is {}", node.describe())));
        } else if too_few || too_many {
            self.wrong_type(node, schema, path);
        }
    }
}

/// How many keys of a table a schema knows.
fn shared_keys(node: &Node, schema: &Value) -> usize {
    let NodeValue::Table(table) = &node.value else { return 0 };
    let properties = schema.get("properties").and_then(Value::as_object);
    properties.map_or(0, |properties| table.keys().filter(|key| properties.contains_key(*key)).count())
}

fn unknown_key(
    key: &str,
    child: &Node,
    path: &str,
    properties: &Map<String, Value>,
    siblings: &[Value],
) -> Problem {
    let name = key.escape_debug().take(60).collect::<String>();
    let owners = owners(key, siblings);
    let list = properties.keys().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", ");
    if let (Some((tag, words)), Some(own)) = (owners, own_word(properties)) {
        return Problem::new(
            format!("`{}` does not go with {tag} = \"{own}\"", join(path, &name)),
            child.key_spot(),
        )
        .label(format!("only with {tag} = {}", words::one_of(&words)))
        .note(format!("keys here: {list}"));
    }
    let problem = Problem::new(format!("unknown key `{name}`{}", in_table(path)), child.key_spot())
        .note(format!("keys here: {list}"));
    match words::nearest(key, properties.keys().map(String::as_str)) {
        Some(meant) => problem.label(format!("did you mean `{meant}`?")),
        None => problem.label("no such key"),
    }
}

/// The tag, and the variants among `siblings` that have this key.
fn owners<'v>(key: &str, siblings: &'v [Value]) -> Option<(&'v str, Vec<&'v str>)> {
    let tag = words::common_tag(siblings)?;
    let having = siblings.iter().filter_map(|option| option.get("properties")?.as_object());
    let words: Vec<&str> = having.filter(|p| p.contains_key(key)).filter_map(own_word).collect();
    (!words.is_empty()).then_some((tag, words))
}

/// The constant word among the properties of a variant: its name.
fn own_word(properties: &Map<String, Value>) -> Option<&str> {
    properties.values().find_map(|property| property.get("const")?.as_str())
}

fn non_finite(value: f64) -> &'static str {
    if value.is_nan() { "not a number" } else { "infinite" }
}

fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

fn in_table(path: &str) -> String {
    if path.is_empty() { String::new() } else { format!(" in `{path}`") }
}
