//! Libraries come only from the registry of crates, whose packages never change.

use super::tree::{File, Tree, Violation};

/// The registry's name in a lock file.
const REGISTRY: &str = "\"registry+https://github.com/rust-lang/crates.io-index\"";

pub(super) fn check(tree: &Tree) -> Vec<Violation> {
    tree.with_extension(&["lock"]).flat_map(check_file).collect()
}

fn check_file(file: &File) -> Vec<Violation> {
    let lines = file.text.lines().enumerate();
    let foreign = lines.filter_map(|(index, line)| {
        let source = line.strip_prefix("source = ")?;
        (source != REGISTRY).then_some((index + 1, source))
    });
    foreign
        .map(|(line, source)| {
            Violation::new(
                file.path.as_str(),
                line,
                format!("a library from {source}"),
                "use one that is published on crates.io",
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> usize {
        check(&Tree::of(&[("fuzz/Cargo.lock", text)])).len()
    }

    #[test]
    fn the_registry_and_our_own_folders_pass() {
        assert_eq!(found(&format!("name = \"toml\"\nsource = {REGISTRY}\n")), 0);
        assert_eq!(found("name = \"jde-host\"\nversion = \"0.1.0\"\n"), 0);
    }

    #[test]
    fn whatever_may_change_under_its_name_fails() {
        assert_eq!(found("source = \"git+https://example.org/toml#1234\"\n"), 1);
        assert_eq!(found("source = \"registry+https://example.org/index\"\n"), 1);
    }
}
