//! The hash of a scene.

use std::fmt::Write as _;

use serde_json::Value;
use sha2::{Digest, Sha256};

use crate::config::SceneConfig;

/// Bytes of the SHA-256 that are kept.
const BYTES: usize = 16;
/// Keys of the scene that leave the pixels of the EXR image alone.
const WITHOUT_EFFECT: [&str; 2] = ["stop", "film"];

/// SHA-256 of the canonical form of everything that determines the pixels, but for the keys `without`: its first
/// 16 bytes in hexadecimal.
///
/// The canonical form is the scene as JSON with defaults filled in and keys sorted, so neither order nor
/// comments nor the spelling of colours and lengths matter.
pub(super) fn hash(config: &SceneConfig, without: &[&str]) -> String {
    let mut canonical = String::from("svetlo scene 1\n");
    if let Ok(Value::Object(mut scene)) = serde_json::to_value(config) {
        let counts = |key: &str| !WITHOUT_EFFECT.contains(&key) && !without.contains(&key);
        scene.retain(|key, _| counts(key));
        write_sorted(&Value::Object(scene), &mut canonical);
    }
    let digest = Sha256::digest(canonical.as_bytes());
    digest.iter().take(BYTES).fold(String::new(), |mut hex, byte| {
        let _ = write!(hex, "{byte:02x}");
        hex
    })
}

/// Writes JSON with the keys of each object in order.
fn write_sorted(value: &Value, out: &mut String) {
    match value {
        Value::Object(map) => {
            let mut entries: Vec<_> = map.iter().collect();
            entries.sort_unstable_by_key(|(key, _)| key.as_str());
            out.push('{');
            for (key, value) in entries {
                let _ = write!(out, "{}:", Value::from(key.as_str()));
                write_sorted(value, out);
                out.push(',');
            }
            out.push('}');
        }
        Value::Array(items) => {
            out.push('[');
            for item in items {
                write_sorted(item, out);
                out.push(',');
            }
            out.push(']');
        }
        scalar => {
            let _ = write!(out, "{scalar}");
        }
    }
}
