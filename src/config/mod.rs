//! Scene files: TOML with spans, checked against the JSON Schema of the scene language, all problems at once.
