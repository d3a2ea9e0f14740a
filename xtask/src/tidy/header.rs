//! Every Rust file opens with `//!`: what it is, and what it refuses to do.

use super::tree::{File, Tree, Violation};

pub(super) fn check(tree: &Tree) -> Vec<Violation> {
    tree.rust().filter_map(check_file).collect()
}

fn check_file(file: &File) -> Option<Violation> {
    let first = file.text.lines().next().unwrap_or_default();
    let says_something = first
        .strip_prefix("//!")
        .is_some_and(|rest| !rest.trim().is_empty());
    (!says_something).then(|| {
        Violation::new(
            file.path.as_str(),
            1,
            "the file does not open with `//!`",
            "state in the first line what it is, then what it refuses to do",
        )
    })
}

/// Returns the `//!` lines at the head of a file, without their marks.
pub(super) fn text(file: &File) -> String {
    let lines = file.text.lines().map_while(|line| line.strip_prefix("//!"));
    lines.collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_with_a_header_passes() {
        assert_eq!(check(&Tree::of(&[("a.rs", "//! What it is.\n")])), []);
        assert_eq!(
            text(&File::new("a.rs", "//! One\n//! two.\n\n//! Not this.\n")),
            " One\n two."
        );
    }

    #[test]
    fn a_file_without_a_header_fails() {
        for opening in [
            "",
            "use std::fmt;\n",
            "//!\n//! Late.\n",
            "// Plain.\n",
            "\n//! Late.\n",
        ] {
            let found = check(&Tree::of(&[("a.rs", opening)]));
            assert_eq!((found.len(), found[0].line), (1, 1), "{opening:?}");
        }
    }
}
