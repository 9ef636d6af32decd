//! Lines on stderr. A reader that went away, or a full disk behind it, is no reason to end a render.

use std::io::Write;

/// Prints a line to stderr, or nothing where stderr takes nothing.
pub fn say(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}
