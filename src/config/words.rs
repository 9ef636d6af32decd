//! Plain words for what the schema asks for, and suggestions for misspelt names.

use serde_json::{Map, Value};

use super::formats;
use super::schema::tag_of;
use super::tree::{Node, NodeValue};

/// Names longer than this get no suggestion: they are no misspelling, and comparing them is slow.
const LONGEST_NAME: usize = 64;

/// The candidate most like `name`, if any is close enough to be what was meant.
pub(crate) fn nearest<'c>(name: &str, candidates: impl IntoIterator<Item = &'c str>) -> Option<&'c str> {
    if name.len() > LONGEST_NAME {
        return None;
    }
    let name = name.to_lowercase();
    let close = |candidate: &&str| {
        let distance = strsim::damerau_levenshtein(&name, candidate);
        (3 * distance <= name.chars().count().max(candidate.len())).then_some(distance)
    };
    let scored = candidates.into_iter().filter_map(|c| close(&c).map(|distance| (distance, c)));
    scored.min_by_key(|&(distance, _)| distance).map(|(_, candidate)| candidate)
}

/// The schema that a chain of references ends at.
pub(super) fn resolve<'s>(root: &'s Value, mut schema: &'s Value) -> &'s Value {
    while let Some(target) = schema.get("$ref").and_then(Value::as_str) {
        match root.pointer(target.trim_start_matches('#')) {
            Some(next) => schema = next,
            None => break,
        }
    }
    schema
}

/// The alternatives of a schema, if it has any.
pub(super) fn alternatives(schema: &Value) -> Option<&Vec<Value>> {
    ["oneOf", "anyOf"].iter().find_map(|key| schema.get(key)).and_then(Value::as_array)
}

/// The words a schema allows, if it allows nothing else.
pub(super) fn allowed_words(schema: &Value) -> Option<Vec<&str>> {
    if let Some(word) = schema.get("const") {
        return Some(vec![word.as_str()?]);
    }
    if let Some(Value::Array(words)) = schema.get("enum") {
        return words.iter().map(Value::as_str).collect();
    }
    let parts: Option<Vec<_>> = alternatives(schema)?.iter().map(allowed_words).collect();
    Some(parts?.concat())
}

/// The property that tells the variants of a schema apart, if there is one.
pub(super) fn common_tag(options: &[Value]) -> Option<&str> {
    let tag = tag_of(options.first()?.as_object()?)?;
    options.iter().all(|option| option.as_object().and_then(tag_of) == Some(tag)).then_some(tag)
}

/// Whether a node has the type that a schema (without alternatives) asks for.
pub(super) fn has_type(node: &Node, schema: &Value) -> bool {
    let wanted = schema.get("type").and_then(Value::as_str);
    match (&node.value, wanted) {
        (_, None) => true,
        (NodeValue::Integer(_), Some(t)) => t == "integer" || t == "number",
        (NodeValue::Float(_), Some(t)) => t == "number",
        (NodeValue::Text(_), Some(t)) => t == "string",
        (NodeValue::Boolean(_), Some(t)) => t == "boolean",
        (NodeValue::List(_), Some(t)) => t == "array",
        (NodeValue::Table(_), Some(t)) => t == "object",
        (NodeValue::Datetime, Some(_)) => false,
    }
}

/// What a schema asks for, to follow "must be".
pub(super) fn describe(root: &Value, schema: &Value) -> String {
    let schema = resolve(root, schema);
    if let Some(words) = allowed_words(schema) {
        return one_of(&words);
    }
    if let Some(options) = alternatives(schema) {
        let mut parts: Vec<String> = options.iter().map(|option| describe(root, option)).collect();
        parts.dedup();
        return join(&parts, "or");
    }
    match schema.get("type").and_then(Value::as_str) {
        Some("integer") => "a whole number".into(),
        Some("number") => "a number".into(),
        Some("boolean") => "true or false".into(),
        Some("array") => describe_list(root, schema),
        Some("object") => "a table".into(),
        Some("string") => schema
            .get("format")
            .and_then(Value::as_str)
            .and_then(formats::by_name)
            .map_or("a text in quotes", |format| format.description)
            .into(),
        _ => "something else".into(),
    }
}

fn describe_list(root: &Value, schema: &Value) -> String {
    let item = schema.get("items").map(|items| describe(root, items));
    let items = match item.as_deref() {
        Some("a number") => "numbers",
        Some("a whole number") => "whole numbers",
        Some("a table") => "tables",
        _ => "entries",
    };
    match (count(schema, "minItems"), count(schema, "maxItems")) {
        (Some(min), Some(max)) if min == max => format!("a list of {max} {items}"),
        _ => format!("a list of {items}"),
    }
}

/// A non-negative whole number in a schema.
pub(super) fn count(schema: &Value, key: &str) -> Option<usize> {
    schema.get(key)?.as_u64()?.try_into().ok()
}

/// "`a`, `b` or `c`" of words in double quotes.
pub(super) fn one_of(words: &[&str]) -> String {
    let quoted: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
    join(&quoted, "or")
}

fn join(parts: &[String], conjunction: &str) -> String {
    match parts {
        [] => String::new(),
        [only] => only.clone(),
        [first @ .., last] => format!("{} {conjunction} {last}", first.join(", ")),
    }
}

/// The range a number must lie in, to follow "must be"; `None` if any number will do.
pub(super) fn range(schema: &Map<String, Value>) -> Option<String> {
    let limit = |key: &str| schema.get(key).map(plain_number);
    let low = limit("minimum").map(|v| format!("at least {v}"));
    let low = low.or_else(|| limit("exclusiveMinimum").map(|v| format!("more than {v}")));
    let high = limit("maximum").map(|v| format!("at most {v}"));
    let high = high.or_else(|| limit("exclusiveMaximum").map(|v| format!("less than {v}")));
    match (low, high) {
        (Some(low), Some(high)) => Some(format!("{low} and {high}")),
        (low, high) => low.or(high),
    }
}

/// A JSON number without a trailing ".0".
fn plain_number(value: &Value) -> String {
    match value.as_f64() {
        Some(number) if value.is_f64() => format!("{number}"),
        _ => value.to_string(),
    }
}

/// Whether a finite number lies in the range of a schema.
pub(super) fn in_range(value: f64, schema: &Map<String, Value>) -> bool {
    let limit = |key: &str| schema.get(key).and_then(Value::as_f64);
    limit("minimum").is_none_or(|low| value >= low)
        && limit("exclusiveMinimum").is_none_or(|low| value > low)
        && limit("maximum").is_none_or(|high| value <= high)
        && limit("exclusiveMaximum").is_none_or(|high| value < high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suggestions_are_close_or_absent() {
        let keys = ["sigma_max", "mode", "reference_length"];
        assert_eq!(nearest("sigma_mx", keys), Some("sigma_max"));
        assert_eq!(nearest("Mode", keys), Some("mode"));
        assert_eq!(nearest("colour", ["color", "colormap"]), Some("color"));
        assert_eq!(nearest("albedo", keys), None);
        assert_eq!(nearest(&"m".repeat(1_000_000), keys), None);
    }

    #[test]
    fn ranges_in_words() {
        let words = |json: Value| range(json.as_object().expect("an object"));
        assert_eq!(words(serde_json::json!({})), None);
        assert_eq!(
            words(serde_json::json!({ "minimum": 1, "maximum": 65536 })).as_deref(),
            Some("at least 1 and at most 65536")
        );
        assert_eq!(
            words(serde_json::json!({ "exclusiveMinimum": 0.0, "exclusiveMaximum": 180.0 })).as_deref(),
            Some("more than 0 and less than 180")
        );
    }
}
