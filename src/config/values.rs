//! Value types of the scene language that accept more than one spelling: colours, spacing, origin,
//! durations and error targets.
//!
//! Each type knows three things about itself: how it is read, how it is described in the JSON Schema,
//! and its one canonical form, to which every spelling is reduced (so that the scene hash does not
//! depend on the spelling).

use std::borrow::Cow;
use std::time::Duration;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, de::Error as _};

use super::formats::{parse_colour, parse_duration, parse_percentage};

/// A linear-sRGB colour, written `[r, g, b]`, as one number (grey), or `"#rrggbb"` (sRGB, converted).
///
/// With `UNIT` every component lies in 0..=1 (an albedo); without it in 0..∞ (a radiance or intensity).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Color<const UNIT: bool>(pub [f64; 3]);

/// A colour whose components lie in 0..=1.
pub type Albedo = Color<true>;
/// A colour whose components are at least 0.
pub type Radiance = Color<false>;

#[derive(Deserialize)]
#[serde(untagged)]
enum RawColor {
    Grey(f64),
    Rgb([f64; 3]),
    Hex(String),
}

impl<'de, const UNIT: bool> Deserialize<'de> for Color<UNIT> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match RawColor::deserialize(deserializer)? {
            RawColor::Grey(value) => Ok(Self([value; 3])),
            RawColor::Rgb(rgb) => Ok(Self(rgb)),
            RawColor::Hex(text) => parse_colour(&text).map(Self).map_err(D::Error::custom),
        }
    }
}

impl<const UNIT: bool> JsonSchema for Color<UNIT> {
    fn inline_schema() -> bool {
        false
    }

    fn schema_name() -> Cow<'static, str> {
        if UNIT { "Albedo".into() } else { "Radiance".into() }
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let mut component = serde_json::json!({ "type": "number", "minimum": 0.0 });
        let range = if UNIT { "0 to 1" } else { "at least 0" };
        if UNIT {
            component["maximum"] = 1.0.into();
        }
        json_schema!({
            "description": format!(
                "A linear-sRGB colour: [r, g, b] or one number for grey, each {range}; \
                 or \"#rrggbb\" in sRGB, converted to linear."
            ),
            "anyOf": [
                component,
                { "type": "array", "items": component, "minItems": 3, "maxItems": 3 },
                { "type": "string", "format": "colour", "pattern": "^#[0-9a-fA-F]{6}$" }
            ]
        })
    }
}

/// The size of a voxel per axis in scene units, written as one number or `[x, y, z]`, each > 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spacing(pub [f64; 3]);

impl<'de> Deserialize<'de> for Spacing {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Raw {
            Uniform(f64),
            PerAxis([f64; 3]),
        }
        Ok(match Raw::deserialize(deserializer)? {
            Raw::Uniform(value) => Self([value; 3]),
            Raw::PerAxis(values) => Self(values),
        })
    }
}

impl JsonSchema for Spacing {
    fn schema_name() -> Cow<'static, str> {
        "Spacing".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let component = serde_json::json!({ "type": "number", "exclusiveMinimum": 0.0 });
        json_schema!({
            "description": "The size of a voxel in scene units: one number, or [x, y, z]; each more than 0.",
            "anyOf": [
                component,
                { "type": "array", "items": component, "minItems": 3, "maxItems": 3 }
            ]
        })
    }
}

/// Where the volume's box lies: its low corner in scene units, or `"centre"` for a box centred on 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Origin {
    /// The corner with the lowest coordinates, scene units.
    Corner([f64; 3]),
    /// The box is centred on the origin of the scene.
    Word(OriginWord),
}

/// The one word that [`Origin`] accepts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum OriginWord {
    /// Box centred on 0.
    Centre,
}

impl JsonSchema for Origin {
    fn schema_name() -> Cow<'static, str> {
        "Origin".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "The low corner of the volume's box in scene units, \
                            or \"centre\" for a box centred on 0.",
            "anyOf": [
                { "type": "array", "items": { "type": "number" }, "minItems": 3, "maxItems": 3 },
                { "type": "string", "const": "centre" }
            ]
        })
    }
}

/// A length of time such as `"500ms"`, `"30s"`, `"2m"`, `"1h"`; longer than zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct TimeLimit(pub Duration);

impl<'de> Deserialize<'de> for TimeLimit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        parse_duration(&text).map(Self).map_err(D::Error::custom)
    }
}

impl JsonSchema for TimeLimit {
    fn schema_name() -> Cow<'static, str> {
        "TimeLimit".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A length of time with its unit: \"500ms\", \"30s\", \"2m\" or \"1h\".",
            "type": "string",
            "format": "time-limit",
            "pattern": "^[0-9]+(\\.[0-9]+)?(ms|s|m|h)$"
        })
    }
}

/// A relative error to reach, written `"1%"` or `0.01`; more than 0. Held as a fraction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ErrorTarget(pub f64);

impl<'de> Deserialize<'de> for ErrorTarget {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Raw {
            Fraction(f64),
            Percent(String),
        }
        match Raw::deserialize(deserializer)? {
            Raw::Fraction(value) => Ok(Self(value)),
            Raw::Percent(text) => parse_percentage(&text).map(Self).map_err(D::Error::custom),
        }
    }
}

impl JsonSchema for ErrorTarget {
    fn schema_name() -> Cow<'static, str> {
        "ErrorTarget".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A relative error: a fraction such as 0.01, or a percentage such as \"1%\".",
            "anyOf": [
                { "type": "number", "exclusiveMinimum": 0.0 },
                { "type": "string", "format": "percentage", "pattern": "^[0-9]+(\\.[0-9]+)?%$" }
            ]
        })
    }
}
