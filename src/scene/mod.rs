//! The validated scene: past this point nothing sees TOML and nothing re-checks.
