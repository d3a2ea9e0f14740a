//! The workspace uses one major version of each library.

use std::collections::BTreeMap;

use super::tree::{Tree, Violation};
use crate::metadata::Metadata;

/// A manifest, and the version requirement in it.
type Use = (String, String);

pub(super) fn check(tree: &Tree, metadata: &Metadata) -> Vec<Violation> {
    let mut uses: BTreeMap<&str, Vec<Use>> = BTreeMap::new();
    for package in metadata.members() {
        let manifest = format!("{}/Cargo.toml", package.folder(&tree.root));
        for dependency in package
            .dependencies
            .iter()
            .filter(|dependency| dependency.path.is_none())
        {
            uses.entry(&dependency.name)
                .or_default()
                .push((manifest.clone(), dependency.req.clone()));
        }
    }
    uses.iter()
        .flat_map(|(library, uses)| check_library(tree, library, uses))
        .collect()
}

/// Compares every use of a library with the newest one.
fn check_library(tree: &Tree, library: &str, uses: &[Use]) -> Vec<Violation> {
    let Some((newest_in, newest)) = uses.iter().max_by_key(|(_, requirement)| major(requirement)) else {
        return Vec::new();
    };
    let older = uses
        .iter()
        .filter(|(_, requirement)| major(requirement) != major(newest));
    older
        .map(|(manifest, requirement)| {
            Violation::new(
                manifest.as_str(),
                tree.line_of(manifest, library),
                format!("{library} {requirement} here, {newest} in {newest_in}"),
                "use the same major version everywhere",
            )
        })
        .collect()
}

/// Returns the part of a version that decides about compatibility: `1` of 1.2.3, `0.9` of 0.9.1.
fn major(requirement: &str) -> Vec<u32> {
    let digits = requirement.trim_start_matches(|c: char| !c.is_ascii_digit());
    let mut parts = Vec::new();
    for part in digits
        .split(|c: char| !c.is_ascii_digit())
        .map_while(|part| part.parse().ok())
    {
        parts.push(part);
        if part != 0 {
            break;
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(requirements: &[&str]) -> Vec<String> {
        let uses: Vec<Use> = requirements
            .iter()
            .enumerate()
            .map(|(index, requirement)| (format!("rules/{index}/Cargo.toml"), (*requirement).to_owned()))
            .collect();
        check_library(&Tree::of(&[]), "toml", &uses)
            .iter()
            .map(ToString::to_string)
            .collect()
    }

    #[test]
    fn compatible_versions_pass() {
        assert_eq!(found(&["^1.2", "^1", "=1.0.3"]), [""; 0]);
        assert_eq!(found(&["^0.9", "^0.9.4"]), [""; 0]);
    }

    #[test]
    fn two_major_versions_fail() {
        assert_eq!(
            found(&["^1.2", "^0.9"]),
            [
                "rules/1/Cargo.toml:1: toml ^0.9 here, ^1.2 in rules/0/Cargo.toml\n    \
                help: use the same major version everywhere"
            ]
        );
        assert_eq!(found(&["^0.9", "^0.10"]).len(), 1);
        assert_eq!(found(&["^2", "^10"]).len(), 1);
    }
}
