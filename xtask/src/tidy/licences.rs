//! The licences of all libraries that are built in must permit the project's own licences.

use std::collections::{BTreeMap, BTreeSet};

use super::tree::Violation;
use crate::metadata::{Kind, Metadata};

/// Licences that shipped libraries may have.
const ALLOWED_LICENCES: &[&str] = &[
    "0BSD",
    "Apache-2.0",
    "BSD-1-Clause",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "ISC",
    "MIT",
    "MIT-0",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
];

/// Licences that fonts may have. They are shipped unchanged.
const ALLOWED_FOR_FONTS: &[&str] = &["OFL-1.1", "Ubuntu-font-1.0"];

/// Shipped libraries with other licences, each assessed individually.
const REVIEWED_LIBRARIES: &[(&str, &str)] = &[
    // Helpers of a few lines that Zenoh uses. The licence covers the library's own files, which are shipped
    // unchanged.
    ("option-ext", "MPL-2.0"),
    // The certificates that browsers trust, as data, for Zenoh's TLS. The licence only requires its own text
    // beside them.
    ("webpki-roots", "CDLA-Permissive-2.0"),
];

/// Licences that libraries for building and testing may have too.
const ALLOWED_FOR_DEVELOPMENT: &[&str] = &["MPL-2.0"];

pub(super) fn check(metadata: &Metadata) -> Vec<Violation> {
    let packages = metadata.by_id();
    let shipped = shipped(metadata);
    let edges = edges(metadata, |_| true);
    let outside = reach(metadata.workspace_members.iter().map(String::as_str), &edges);
    let outside = outside
        .into_iter()
        .filter(|id| !metadata.workspace_members.contains(*id));
    let mut found = Vec::new();
    for id in outside {
        let Some(package) = packages.get(id) else { continue };
        let is_shipped = shipped.contains(id);
        let is_font = package.name.contains("font");
        let fits = |licence: &str| {
            ALLOWED_LICENCES.contains(&licence)
                || (is_font && ALLOWED_FOR_FONTS.contains(&licence))
                || (!is_shipped && ALLOWED_FOR_DEVELOPMENT.contains(&licence))
                || REVIEWED_LIBRARIES.contains(&(package.name.as_str(), licence))
        };
        let licence = package.license.as_deref().unwrap_or("none");
        if !satisfies(licence, &fits) {
            found.push(Violation::new(
                "Cargo.lock",
                1,
                format!("the licence of {} {}: {licence}", package.name, package.version),
                "use another library, or weigh the licence and add it in xtask/src/tidy/licences.rs",
            ));
        }
    }
    found
}

type Edges<'a> = BTreeMap<&'a str, Vec<&'a str>>;

fn edges(metadata: &Metadata, includes: impl Fn(Option<Kind>) -> bool) -> Edges<'_> {
    let nodes = metadata.resolve.iter().flat_map(|resolve| &resolve.nodes);
    nodes
        .map(|node| {
            let taken = node
                .deps
                .iter()
                .filter(|edge| edge.dep_kinds.iter().any(|kind| includes(kind.kind)));
            (node.id.as_str(), taken.map(|edge| edge.pkg.as_str()).collect())
        })
        .collect()
}

/// Returns the packages that become part of what users get: the members except this program, and their
/// ordinary dependencies.
pub(crate) fn shipped(metadata: &Metadata) -> BTreeSet<&str> {
    let edges = edges(metadata, |kind| kind.is_none());
    let members = metadata
        .members()
        .filter(|package| package.name != env!("CARGO_PKG_NAME"));
    reach(members.map(|package| package.id.as_str()), &edges)
}

fn reach<'a>(from: impl Iterator<Item = &'a str>, edges: &Edges<'a>) -> BTreeSet<&'a str> {
    let mut reached = BTreeSet::new();
    let mut open: Vec<&str> = from.collect();
    while let Some(id) = open.pop() {
        if reached.insert(id) {
            open.extend(edges.get(id).into_iter().flatten());
        }
    }
    reached
}

/// Returns whether licences that fit can satisfy an SPDX expression. `AND` binds tighter than `OR`.
fn satisfies(expression: &str, fits: &impl Fn(&str) -> bool) -> bool {
    // An older notation of `OR`.
    let expression = expression
        .replace('/', " OR ")
        .replace('(', " ( ")
        .replace(')', " ) ");
    let tokens: Vec<&str> = expression.split_whitespace().collect();
    let mut at = 0;
    let met = either(&tokens, &mut at, fits);
    met && at == tokens.len()
}

fn either(tokens: &[&str], at: &mut usize, fits: &impl Fn(&str) -> bool) -> bool {
    let mut met = both(tokens, at, fits);
    while tokens.get(*at) == Some(&"OR") {
        *at += 1;
        met |= both(tokens, at, fits);
    }
    met
}

fn both(tokens: &[&str], at: &mut usize, fits: &impl Fn(&str) -> bool) -> bool {
    let mut met = single(tokens, at, fits);
    while tokens.get(*at) == Some(&"AND") {
        *at += 1;
        met &= single(tokens, at, fits);
    }
    met
}

fn single(tokens: &[&str], at: &mut usize, fits: &impl Fn(&str) -> bool) -> bool {
    let Some(token) = tokens.get(*at) else {
        return false;
    };
    *at += 1;
    if *token == "(" {
        let met = either(tokens, at, fits);
        let closed = tokens.get(*at) == Some(&")");
        *at += 1;
        return met && closed;
    }
    if tokens.get(*at) == Some(&"WITH") {
        // An exception only adds permissions to its licence.
        *at += 2;
    }
    fits(token)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn met(expression: &str) -> bool {
        satisfies(expression, &|licence| ALLOWED_LICENCES.contains(&licence))
    }

    #[test]
    fn permissive_licences_pass() {
        for expression in [
            "MIT",
            "MIT/Apache-2.0",
            "GPL-3.0-only OR MIT",
            "(MIT OR Apache-2.0) AND Unicode-3.0",
            "MIT OR GPL-3.0-only AND Zlib",
            "Apache-2.0 WITH LLVM-exception OR GPL-2.0-only",
            "(Apache-2.0 OR MIT) AND (BSD-3-Clause OR (GPL-2.0-only AND MIT))",
        ] {
            assert!(met(expression), "{expression}");
        }
    }

    #[test]
    fn other_licences_fail() {
        for expression in [
            "none",
            "GPL-3.0-only",
            "MIT AND GPL-3.0-only",
            "MPL-2.0",
            "(MIT",
            "MIT)",
            "",
            "MIT Apache-2.0",
        ] {
            assert!(!met(expression), "{expression}");
        }
    }

    #[test]
    fn shipped_packages_have_stricter_rules_than_those_for_tests() {
        let metadata = |kind: &str| -> Metadata {
            serde_json::from_str(&format!(
                r#"{{"workspace_members": ["ours"], "target_directory": "target", "packages": [
                {{"id": "ours", "name": "jde-host", "version": "1.0.0", "manifest_path": "Cargo.toml"}},
                {{"id": "theirs", "name": "theirs", "version": "2.0.0", "license": "MPL-2.0",
                  "manifest_path": "Cargo.toml"}}],
                "resolve": {{"nodes": [{{"id": "ours", "deps": [{{"pkg": "theirs",
                  "dep_kinds": [{{"kind": {kind}}}]}}]}}, {{"id": "theirs", "deps": []}}]}}}}"#
            ))
            .unwrap()
        };
        let found = check(&metadata("null"));
        assert_eq!(
            found.iter().map(|it| it.message.as_str()).collect::<Vec<_>>(),
            ["the licence of theirs 2.0.0: MPL-2.0"]
        );
        assert_eq!(check(&metadata("\"dev\"")), []);
    }
}
