//! Every dependency comes from crates.io under a licence that `deny.toml` allows.
//!
//! The same rules as `cargo deny check licenses sources`, with nothing to install.

use std::process::Command;

/// The packages of the lock file, as `cargo metadata` lists them.
fn packages() -> Vec<serde_json::Value> {
    let metadata = |extra: &[&str]| {
        Command::new(env!("CARGO"))
            .args(["metadata", "--format-version", "1", "--locked"])
            .args(["--manifest-path", concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml")])
            .args(extra)
            .output()
            .expect("cargo starts")
    };
    let mut output = metadata(&[]);
    if !output.status.success() {
        // Without a network, only what this machine's own build has fetched can be read.
        let host = host();
        println!("checking the dependencies on {host} only");
        output = metadata(&["--offline", "--filter-platform", &host]);
    }
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("metadata is JSON");
    json["packages"].as_array().expect("metadata lists packages").clone()
}

/// The target triple that `rustc` compiles for by default.
fn host() -> String {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc).arg("-vV").output().expect("rustc starts");
    let text = String::from_utf8(output.stdout).expect("rustc prints UTF-8");
    text.lines().find_map(|line| line.strip_prefix("host: ")).expect("rustc names its host").to_owned()
}

/// The licences that `deny.toml` allows.
fn allowed() -> Vec<String> {
    let rules: toml::Table = include_str!("../deny.toml").parse().expect("deny.toml is TOML");
    let list = rules["licenses"]["allow"].as_array().expect("licenses.allow is a list");
    list.iter().map(|licence| licence.as_str().expect("a licence is a string").to_owned()).collect()
}

/// Whether an SPDX expression can be met with the licences in `allowed`.
/// Crates of old write `MIT/Apache-2.0` for `MIT OR Apache-2.0`.
fn permits(expression: &str, allowed: &[String]) -> bool {
    let spaced = expression.replace('/', " OR ").replace('(', " ( ").replace(')', " ) ");
    let tokens: Vec<&str> = spaced.split_whitespace().collect();
    let mut rest = tokens.as_slice();
    let met = any_of(&mut rest, allowed);
    assert!(rest.is_empty(), "not an SPDX expression: {expression}");
    met
}

fn any_of(rest: &mut &[&str], allowed: &[String]) -> bool {
    let mut met = all_of(rest, allowed);
    while take(rest, "OR") {
        met |= all_of(rest, allowed);
    }
    met
}

fn all_of(rest: &mut &[&str], allowed: &[String]) -> bool {
    let mut met = one(rest, allowed);
    while take(rest, "AND") {
        met &= one(rest, allowed);
    }
    met
}

fn one(rest: &mut &[&str], allowed: &[String]) -> bool {
    if take(rest, "(") {
        let met = any_of(rest, allowed);
        assert!(take(rest, ")"), "an SPDX expression without its closing bracket");
        return met;
    }
    let (first, tail) = rest.split_first().expect("an SPDX expression that ends too early");
    *rest = tail;
    let mut licence = (*first).to_owned();
    if take(rest, "WITH") {
        let (exception, tail) = rest.split_first().expect("WITH names an exception");
        *rest = tail;
        licence = format!("{licence} WITH {exception}");
    }
    allowed.contains(&licence)
}

fn take(rest: &mut &[&str], word: &str) -> bool {
    match rest.split_first() {
        Some((first, tail)) if *first == word => {
            *rest = tail;
            true
        }
        _ => false,
    }
}

#[test]
fn dependencies_have_allowed_licences() {
    let allowed = allowed();
    let packages = packages();
    assert!(packages.len() > 1, "no dependency was read");
    let refused: Vec<String> = packages
        .iter()
        .filter(|package| !package["license"].as_str().is_some_and(|licence| permits(licence, &allowed)))
        .map(|package| format!("{} {}: {}", package["name"], package["version"], package["license"]))
        .collect();
    assert!(refused.is_empty(), "not allowed by deny.toml:\n{}", refused.join("\n"));
}

#[test]
fn dependencies_come_from_crates_io() {
    let strangers: Vec<String> = packages()
        .iter()
        .filter(|package| package["name"] != env!("CARGO_PKG_NAME"))
        .filter(|package| {
            let source = package["source"].as_str().unwrap_or("a folder");
            !(source.starts_with("registry+") && source.ends_with("/rust-lang/crates.io-index"))
        })
        .map(|package| format!("{} {}: {}", package["name"], package["version"], package["source"]))
        .collect();
    assert!(strangers.is_empty(), "not from crates.io:\n{}", strangers.join("\n"));
}

#[test]
fn expressions_are_read_as_spdx_means_them() {
    let allowed = ["MIT".to_owned(), "Zlib".to_owned(), "Apache-2.0 WITH LLVM-exception".to_owned()];
    for (expression, met) in [
        ("MIT", true),
        ("GPL-3.0-only", false),
        ("GPL-3.0-only OR MIT", true),
        ("GPL-3.0-only/MIT", true),
        ("GPL-3.0-only AND MIT", false),
        ("MIT AND Zlib OR GPL-3.0-only", true),
        ("GPL-3.0-only OR MIT AND Unlicense", false),
        ("(GPL-3.0-only OR MIT) AND Zlib", true),
        ("(GPL-3.0-only OR MIT) AND Unlicense", false),
        ("Apache-2.0 WITH LLVM-exception", true),
        ("Apache-2.0", false),
    ] {
        assert_eq!(permits(expression, &allowed), met, "{expression}");
    }
}
