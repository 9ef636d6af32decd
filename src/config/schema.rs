//! The JSON Schema of scene files, generated from the raw types.

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};
use serde_json::{Map, Value};

use super::types::SceneConfig;

/// The JSON Schema (draft 2020-12) of a scene file, as `svetlo schema` prints it.
pub fn schema() -> Value {
    schema_of::<SceneConfig>()
}

/// The JSON Schema of any raw type.
pub(super) fn schema_of<T: JsonSchema>() -> Value {
    let generator = SchemaSettings::draft2020_12().into_generator();
    let mut schema = generator.into_root_schema_for::<T>().to_value();
    tidy(&mut schema);
    schema
}

/// Lets the first variant of a tagged enum be meant when the tag is missing: its tag is no longer
/// required there and gets a default.
pub(crate) fn default_kind_first(schema: &mut Schema) {
    let first = schema.get_mut("oneOf").and_then(|variants| variants.get_mut(0));
    let Some(first) = first.and_then(Value::as_object_mut) else { return };
    let Some(tag) = tag_of(first).map(str::to_owned) else { return };
    if let Some(Value::Object(property)) = first.get_mut("properties").and_then(|p| p.get_mut(&tag))
        && let Some(name) = property.get("const").cloned()
    {
        property.insert("default".into(), name);
    }
    if let Some(Value::Array(required)) = first.get_mut("required") {
        required.retain(|key| key.as_str() != Some(&tag));
    }
}

/// The name of the property that says which variant an object is: the one with a constant value.
pub(super) fn tag_of(variant: &Map<String, Value>) -> Option<&str> {
    let properties = variant.get("properties")?.as_object()?;
    properties.iter().find(|(_, p)| p.get("const").is_some()).map(|(name, _)| name.as_str())
}

/// TOML has no null: an optional key is left out. So `null`, which the generator lists for every
/// `Option`, is taken out of types, alternatives and defaults. Descriptions lose the line breaks of the source.
fn tidy(value: &mut Value) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(tidy),
        Value::Object(map) => {
            map.values_mut().for_each(tidy);
            remove_null_type(map);
            remove_null_alternative(map);
            if let Some(Value::String(text)) = map.get_mut("description") {
                *text = text.replace('\n', " ");
            }
            if map.get("default") == Some(&Value::Null) {
                map.remove("default");
            }
            if let Some(Value::Object(default)) = map.get_mut("default") {
                default.retain(|_, v| !v.is_null());
            }
        }
        _ => {}
    }
}

fn remove_null_type(map: &mut Map<String, Value>) {
    if let Some(Value::Array(types)) = map.get_mut("type") {
        types.retain(|t| t != "null");
        if let [single] = types.as_slice() {
            let single = single.clone();
            map.insert("type".into(), single);
        }
    }
    if let Some(Value::Array(words)) = map.get_mut("enum") {
        words.retain(|word| !word.is_null());
    }
}

fn remove_null_alternative(map: &mut Map<String, Value>) {
    let Some(Value::Array(options)) = map.get_mut("anyOf") else { return };
    options.retain(|option| option.get("type").is_none_or(|t| t != "null"));
    if let [Value::Object(single)] = options.as_slice() {
        let single = single.clone();
        map.remove("anyOf");
        for (key, value) in single {
            map.entry(key).or_insert(value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at<'v>(schema: &'v Value, pointer: &str) -> &'v Value {
        schema.pointer(pointer).unwrap_or_else(|| panic!("{pointer} is missing in {schema:#}"))
    }

    #[test]
    fn names_its_draft_and_has_a_title() {
        let schema = schema();
        assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
        assert_eq!(schema["title"], "svetlo scene");
    }

    #[test]
    fn carries_the_defaults() {
        let schema = schema();
        assert_eq!(*at(&schema, "/properties/seed/default"), 1);
        assert_eq!(*at(&schema, "/$defs/ImageConfig/properties/width/default"), 512);
        assert_eq!(*at(&schema, "/$defs/CameraConfig/oneOf/0/properties/fov/default"), 40.0);
        assert_eq!(*at(&schema, "/$defs/CameraConfig/oneOf/0/properties/kind/default"), "perspective");
        assert_eq!(*at(&schema, "/$defs/MediumConfig/oneOf/0/properties/mode/default"), "extinction");
        assert_eq!(*at(&schema, "/$defs/PhaseConfig/oneOf/0/properties/kind/default"), "isotropic");
        assert_eq!(*at(&schema, "/$defs/BackgroundConfig/properties/sampling/default"), "auto");
        assert_eq!(*at(&schema, "/$defs/TransferConfig/oneOf/0/properties/resolution/default"), 1021);
        assert_eq!(*at(&schema, "/$defs/MethodConfig/oneOf/0/properties/step/default"), 0.5);
        assert_eq!(*at(&schema, "/$defs/MethodConfig/oneOf/0/properties/termination/default"), 1.0 / 1024.0);
        assert_eq!(*at(&schema, "/$defs/StopConfig/properties/samples/default"), 16);
    }

    #[test]
    fn every_key_is_described_and_null_never_appears() {
        fn walk(value: &Value, path: &str) {
            match value {
                Value::Object(map) => {
                    if let Some(Value::Object(properties)) = map.get("properties") {
                        for (name, property) in properties {
                            let described =
                                ["description", "const", "$ref"].iter().any(|k| property.get(k).is_some());
                            assert!(described, "{path}/{name} has no description");
                        }
                    }
                    map.iter().for_each(|(key, value)| walk(value, &format!("{path}/{key}")));
                }
                Value::Array(items) => items.iter().for_each(|item| walk(item, path)),
                Value::String(text) => assert_ne!(text, "null", "{path}"),
                Value::Null => panic!("{path} is null"),
                _ => {}
            }
        }
        walk(&schema(), "");
    }
}
