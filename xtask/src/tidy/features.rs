//! Features of crates are switches of a build. They never choose what a crate depends on inside the workspace otherwise: a
//! build of the workspace unites the features of all its members, and the table of crates would not be true.

use super::tree::{Tree, Violation};
use crate::metadata::{Metadata, Package};

/// The packages with a switch, and their features.
const SWITCHES: &[(&str, &[&str])] = &[
    // Windows need a screen.
    ("jde", &["default", "view"]),
];

pub(super) fn check(tree: &Tree, metadata: &Metadata) -> Vec<Violation> {
    metadata
        .members()
        .flat_map(|package| check_package(tree, package))
        .collect()
}

fn check_package(tree: &Tree, package: &Package) -> Vec<Violation> {
    let manifest = format!("{}/Cargo.toml", package.folder(&tree.root));
    let switches = SWITCHES.iter().find(|(name, _)| *name == package.name);
    let allowed = switches.map_or(&[][..], |(_, features)| features);
    let others = package
        .features
        .keys()
        .filter(|name| !allowed.contains(&name.as_str()));
    others
        .map(|name| {
            Violation::new(
                manifest.as_str(),
                tree.line_of(&manifest, name),
                format!("the feature `{name}` is no switch of a build"),
                "a crate has one set of dependencies: make another crate of what only some need",
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(name: &str, feature: &str) -> usize {
        let package = format!(
            r#"{{"id": "a", "name": "{name}", "version": "0.1.0", "manifest_path": "no-such-root/programs/a/Cargo.toml",
            "features": {{"{feature}": []}}}}"#
        );
        check_package(&Tree::of(&[]), &serde_json::from_str(&package).unwrap()).len()
    }

    #[test]
    fn only_switches_are_features() {
        assert_eq!(found("jde", "view"), 0);
        assert_eq!(found("jde", "tools"), 1);
        assert_eq!(found("jde-log", "view"), 1);
    }
}
