//! Checks that docs/sdk.md names every method that a schema or its test may call.

use std::fs;
use std::path::Path;

#[test]
fn the_sdk_page_names_every_public_method() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(root.join("../../docs/sdk.md")).expect("the page");
    let mut missing = Vec::new();
    for file in [
        "context",
        "input",
        "output",
        "child",
        "level",
        "hysteresis",
        "memory",
        "bench/mod",
    ] {
        let source = fs::read_to_string(root.join(format!("src/{file}.rs"))).expect("a source");
        for (at, _) in source.match_indices("    pub fn ") {
            let name = source[at + 11..].split(['(', '<']).next().unwrap_or_default();
            let hidden = source[..at]
                .trim_end()
                .lines()
                .rev()
                .take(3)
                .any(|line| line.contains("doc(hidden)"));
            if !hidden && !["foreign", "try_new"].contains(&name) && !page.contains(&format!("{name}(")) {
                missing.push(format!("{file}: {name}"));
            }
        }
    }
    assert!(missing.is_empty(), "docs/sdk.md does not name {missing:?}");
}
