//! The directions of dependencies: which crate may use which, as the table of `docs/architecture.md` says.
//! Dependencies of tests are not restricted. Cycles of other dependencies are refused by cargo itself.

use super::floors;
use super::tree::{Tree, Violation};
use crate::metadata::{Dependency, Kind, Metadata, Package};

/// The page with the table: a row for each folder, `| `robotics/sim` | contents | nothing of jde |`.
pub(super) const PAGE: &str = "docs/architecture.md";

/// What a folder may use, as its row of the page says.
struct Row<'p> {
    /// The names of crates; or `all`, `nothing of jde`, or `nothing` where no library is allowed either.
    uses: &'p str,
}

/// Checks that the page has a row for every folder, and that the row lists every dependency.
pub(super) fn check(tree: &Tree, metadata: &Metadata) -> Vec<Violation> {
    metadata
        .members()
        .flat_map(|package| check_package(tree, package))
        .chain(floors::check(tree, metadata))
        .collect()
}

fn check_package(tree: &Tree, package: &Package) -> Vec<Violation> {
    let folder = package.folder(&tree.root);
    let manifest = format!("{folder}/Cargo.toml");
    let page = tree.file(PAGE).map_or("", |file| file.text.as_str());
    let Some(row) = Row::of(page, &folder) else {
        return vec![Violation::new(
            manifest,
            1,
            format!("nothing says what {folder} may use"),
            "add its row to the table in docs/architecture.md, and the reason to docs/decisions",
        )];
    };
    let mut found = Vec::new();
    if package.name != expected_name(&folder) {
        found.push(Violation::new(
            manifest.as_str(),
            1,
            format!("the package in {folder} is called {}", package.name),
            format!(
                "a folder and its package share their name: {}",
                expected_name(&folder)
            ),
        ));
    }
    for dependency in package
        .dependencies
        .iter()
        .filter(|dependency| dependency.kind != Some(Kind::Dev))
    {
        let line = tree.line_of(&manifest, &dependency.name);
        match dependency.folder(tree) {
            Some(used) if !row.allows(&used) => found.push(Violation::new(
                manifest.as_str(),
                line,
                format!("{folder} uses {used}, against the direction of the arrows"),
                format!("{folder} may use {}, says docs/architecture.md", row.uses),
            )),
            None if row.uses == "nothing" => found.push(Violation::new(
                manifest.as_str(),
                line,
                format!("{folder} uses the library {}", dependency.name),
                format!("{folder} uses no library; dev-dependencies are free"),
            )),
            Some(_) | None => {}
        }
    }
    found
}

/// Returns the package name for a folder. Crates of a floor have the prefix `jde-`, except two.
fn expected_name(folder: &str) -> String {
    match folder.rsplit_once('/') {
        // The executable has no prefix; `webpki-roots` replaces an external crate of this name.
        Some((_, name @ ("jde" | "webpki-roots"))) => name.to_owned(),
        Some(("schemas" | "drivers", name)) => name.to_owned(),
        Some((_, name)) => format!("jde-{name}"),
        None => folder.to_owned(),
    }
}

impl<'p> Row<'p> {
    /// Returns the row of a folder, or that of all folders beside it: `drivers/`.
    fn of(page: &'p str, folder: &str) -> Option<Self> {
        let all_beside = folder.rsplit_once('/').map(|(parent, _)| format!("`{parent}/`"));
        let (_, table) = page.split_once("\n## What lives where\n")?;
        table.lines().find_map(|line| {
            let cells = line.strip_prefix("| ")?.strip_suffix(" |")?;
            let (name, rest) = cells.split_once(" | ")?;
            let (_, uses) = rest.rsplit_once(" | ")?;
            let is_named = name.trim_matches('`') == folder || all_beside.as_deref() == Some(name);
            is_named.then_some(Self { uses })
        })
    }

    fn allows(&self, folder: &str) -> bool {
        // A name alone is that of a crate: nothing uses a plugin.
        folder
            .split_once('/')
            .filter(|(floor, _)| !["schemas", "drivers"].contains(floor))
            .is_some_and(|(_, name)| self.uses == "all" || self.uses.split(", ").any(|used| used == name))
    }
}

impl Dependency {
    pub(super) fn folder(&self, tree: &Tree) -> Option<String> {
        self.path
            .as_deref()
            .map(|path| crate::metadata::folder(&tree.root, path))
    }
}

impl Tree {
    /// Returns the line of a manifest that first begins with a name, or the first line of the file if none
    /// does.
    pub(super) fn line_of(&self, manifest: &str, name: &str) -> usize {
        let text = self.file(manifest).map_or("", |file| file.text.as_str());
        let begins = |line: &str| {
            line.strip_prefix(name)
                .is_some_and(|rest| rest.starts_with([' ', '=', '.', ']']))
        };
        text.lines().position(begins).map_or(1, |index| index + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check_one(folder: &str, name: &str, dependencies: &str) -> Vec<String> {
        let manifest = format!("{folder}/Cargo.toml");
        let tree = Tree::of(&[
            (&manifest, "[dependencies]\nserde = \"1\"\n"),
            (PAGE, include_str!("../../../docs/architecture.md")),
        ]);
        let package = format!(
            r#"{{"id": "a", "name": "{name}", "version": "0.1.0", "dependencies": [{dependencies}],
            "manifest_path": "no-such-root/{folder}/Cargo.toml"}}"#
        );
        let found = check_package(&tree, &serde_json::from_str(&package).unwrap());
        found
            .iter()
            .map(|violation| format!("{}: {}", violation.line, violation.message))
            .collect()
    }

    fn ours(folder: &str, kind: &str) -> String {
        format!(r#"{{"name": "x", "req": "*", "path": "no-such-root/{folder}", "kind": {kind}}}"#)
    }

    #[test]
    fn an_arrow_of_the_table_passes() {
        assert_eq!(
            check_one("runtime/board", "jde-board", &ours("plugin/abi", "null")),
            [""; 0]
        );
        assert_eq!(
            check_one("drivers/sim", "sim", &ours("robotics/sim", "null")),
            [""; 0]
        );
        assert_eq!(
            check_one("programs/jde", "jde", &ours("robotics/sim", "null")),
            [""; 0]
        );
    }

    #[test]
    fn any_other_arrow_fails() {
        let found = check_one("robotics/sim", "jde-sim", &ours("plugin/schema", "null"));
        assert_eq!(
            found,
            ["1: robotics/sim uses plugin/schema, against the direction of the arrows"]
        );
        assert_eq!(
            check_one("schemas/stop", "stop", &ours("runtime/host", "\"build\"")).len(),
            1
        );
        assert_eq!(check_one("programs/jde", "jde", &ours("xtask", "null")).len(), 1);
    }

    #[test]
    fn tests_may_use_any_crate() {
        assert_eq!(
            check_one("rules/core", "jde-core", &ours("runtime/host", "\"dev\"")),
            [""; 0]
        );
    }

    #[test]
    fn the_rules_use_no_library() {
        let serde = r#"{"name": "serde", "req": "^1"}"#;
        assert_eq!(
            check_one("rules/core", "jde-core", serde),
            ["2: rules/core uses the library serde"]
        );
        assert_eq!(check_one("runtime/host", "jde-host", serde), [""; 0]);
    }

    #[test]
    fn a_folder_without_a_row_fails() {
        assert_eq!(
            check_one("rules/new", "jde-new", ""),
            ["1: nothing says what rules/new may use"]
        );
    }

    #[test]
    fn a_package_is_called_like_its_folder() {
        assert_eq!(
            check_one("plugin/abi", "abi", ""),
            ["1: the package in plugin/abi is called abi"]
        );
    }
}
