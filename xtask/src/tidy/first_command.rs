//! The first command of a new user builds few packages: each one more is a second of waiting.

use std::collections::BTreeSet;

use anyhow::Result;

use super::tree::{Tree, Violation};
use crate::shell;

/// The packages that `cargo run -- demo` builds at most. The robot is to move within 90 s on two cores.
const MAX_PACKAGES: usize = 212;

pub(super) fn check(tree: &Tree) -> Result<Vec<Violation>> {
    let mut cargo = shell::cargo();
    cargo
        .args(["tree", "--quiet", "--edges", "normal,build", "--prefix", "none"])
        .args(["--format", "{p}"])
        .current_dir(&tree.root);
    Ok(check_count(count(&shell::read(&mut cargo)?)))
}

/// Counts the packages of a tree. Cargo marks repeated ones.
fn count(packages: &str) -> usize {
    let lines = packages.lines().map(|line| line.trim_end_matches(" (*)"));
    lines
        .filter(|line| !line.is_empty())
        .collect::<BTreeSet<_>>()
        .len()
}

fn check_count(packages: usize) -> Vec<Violation> {
    let violation = Violation::new(
        "Cargo.toml",
        1,
        format!("`cargo run -- demo` builds {packages} packages, more than {MAX_PACKAGES}"),
        "run `cargo tree --edges normal,build`; put what the demonstration does not need into a crate that `jde-session` does not use",
    );
    if packages > MAX_PACKAGES {
        vec![violation]
    } else {
        Vec::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_repeated_package_counts_once() {
        assert_eq!(count("a v1.0.0\nb v1.0.0\na v1.0.0 (*)\n\na v2.0.0\n"), 3);
    }

    #[test]
    fn too_many_packages_are_a_violation() {
        assert_eq!(check_count(MAX_PACKAGES), []);
        assert_eq!(check_count(MAX_PACKAGES + 1).len(), 1);
    }
}
