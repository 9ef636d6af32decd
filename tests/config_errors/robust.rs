//! Whatever the bytes, reading a scene ends with a scene or an error, never with a panic; and what the
//! checker lets through is never refused later without a place.

use proptest::prelude::*;
use svetlo::scene::Scene;

use super::examples::{EXAMPLES, with_rest};
use super::read;

/// Pieces that scenes are made of, to get past the parser more often than noise does.
const PIECES: [&str; 24] = [
    "\n",
    "=",
    "[",
    "]",
    "{",
    "}",
    "\"",
    ",",
    ".",
    " = 1\n",
    "inf",
    "nan",
    "-1",
    "0",
    "1e400",
    "[[light]]\n",
    "kind = \"mip\"\n",
    "\"\"",
    "true",
    "1979-05-27",
    "é",
    "# ",
    "\r\n",
    "99999999999999999999",
];

/// The texts, so that a gap in the checker shows: it may not leave the refusal to the deserialiser.
fn must_not_panic(text: &str, sets: &[&str]) {
    if let Err(error) = read(text, sets) {
        assert!(!error.contains("the scene cannot be read"), "{error}\n{text}");
        assert!(error.contains("problem"), "{error}");
    }
}

fn floor(text: &str, index: usize) -> usize {
    (0..=index.min(text.len())).rev().find(|&i| text.is_char_boundary(i)).unwrap_or(0)
}

/// Replaces `length` bytes at `at` by a piece.
fn mutate(text: &mut String, at: usize, length: usize, piece: &str) {
    let at = at % (text.len() + 1);
    let (start, end) = (floor(text, at), floor(text, at + length));
    text.replace_range(start..end, piece);
}

/// Replaces what stands right of the n-th `=` of the text.
fn replace_value(text: &str, n: usize, value: &str) -> String {
    let places: Vec<usize> = text.match_indices(" = ").map(|(at, _)| at + 3).collect();
    let Some(&start) = places.get(n % places.len().max(1)) else { return text.to_owned() };
    let end = text[start..].find('\n').map_or(text.len(), |length| start + length);
    format!("{}{value}{}", &text[..start], &text[end..])
}

fn any_scene() -> impl Strategy<Value = String> {
    prop::sample::select(EXAMPLES.to_vec()).prop_map(|(_, text)| with_rest(text))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, &bytes).expect("written");
        prop_assert!(Scene::load(&path, &[]).is_err());
    }

    #[test]
    fn any_text(text in any::<String>(), set in any::<String>()) {
        must_not_panic(&text, &[&set]);
    }

    #[test]
    fn any_mutation(
        scene in any_scene(),
        edits in prop::collection::vec((any::<usize>(), 0usize..20, prop::sample::select(PIECES.to_vec())), 1..4),
    ) {
        let mut text = scene;
        for (at, length, piece) in edits {
            mutate(&mut text, at, length, piece);
        }
        must_not_panic(&text, &[]);
    }

    #[test]
    fn any_value_anywhere(scene in any_scene(), n in any::<usize>(), value in prop::sample::select(vec![
        "0", "-1", "1.5", "1e308", "-1e308", "5e-324", "18446744073709551615", "\"x\"", "\"\"", "true", "[]",
        "[1]", "[1, 2]", "[1, 2, 3]", "[0, 0, 0]", "[1e200, 1e200, 1e200]", "[[1]]", "{}", "{ kind = \"point\" }",
        "[{}]", "\"#ffffff\"", "\"1%\"", "\"1s\"", "\"2d\"", "\"..\"", "\"\\u0000\"",
    ])) {
        must_not_panic(&replace_value(&scene, n, value), &[]);
    }

    #[test]
    fn any_override(
        scene in any_scene(),
        path in "(camera|light|transfer|points|image|0|1|kind|[a-z]{1,4}|\\PC)(\\.(kind|0|1|points|width|\\PC{1,3})){0,3}",
        value in "\\PC{0,12}",
    ) {
        must_not_panic(&scene, &[&format!("{path}={value}")]);
    }
}
