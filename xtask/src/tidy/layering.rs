//! The directions of dependencies: which crate may use which. The table of `docs/architecture.md` agrees.
//! Dependencies of tests are not restricted. Cycles of other dependencies are refused by cargo itself.

use super::tree::{Tree, Violation};
use crate::metadata::{Dependency, Kind, Metadata, Package};

/// The dependencies that one folder may have.
struct Row {
    /// A folder, or a folder of folders that ends with `/`. The first row that fits counts.
    folder: &'static str,
    ours: AllowedCrates,
    /// Whether it may use external libraries.
    libraries: bool,
}

enum AllowedCrates {
    Listed(&'static [&'static str]),
    AnyCrate,
}

const fn row(folder: &'static str, ours: &'static [&'static str]) -> Row {
    Row {
        folder,
        ours: AllowedCrates::Listed(ours),
        libraries: true,
    }
}

const fn alone(folder: &'static str) -> Row {
    Row {
        folder,
        ours: AllowedCrates::Listed(&[]),
        libraries: false,
    }
}

const TABLE: &[Row] = &[
    // A feature of a library could change the bytes of a plugin.
    alone("crates/abi"),
    // The rules have no clock, thread or I/O, and need no library.
    alone("crates/core"),
    row("crates/gate", &[]),
    alone("crates/watchdog"),
    alone("crates/test-plugins"),
    row("crates/webpki-roots", &[]),
    // It checks the rules in their tests, and in the campaign of faults.
    row("crates/shadow", &["crates/core"]),
    // The ABI's reader has the only list of the names that application files reserve.
    row("crates/macros", &["crates/abi"]),
    row("crates/launcher", &["crates/jde"]),
    row("crates/sim", &[]),
    row("crates/experiment", &[]),
    row("crates/types", &["crates/abi", "crates/macros"]),
    row("crates/board", &["crates/abi"]),
    row(
        "crates/schema",
        &[
            "crates/abi",
            "crates/core",
            "crates/types",
            "crates/macros",
            "crates/panel",
        ],
    ),
    // An application file is checked without any runtime.
    row(
        "crates/app",
        &["crates/abi", "crates/board", "crates/core", "crates/types"],
    ),
    row(
        "crates/records",
        &[
            "crates/abi",
            "crates/app",
            "crates/core",
            "crates/panel",
            "crates/types",
        ],
    ),
    row(
        "crates/conditions",
        &[
            "crates/abi",
            "crates/app",
            "crates/board",
            "crates/core",
            "crates/records",
            "crates/types",
        ],
    ),
    // The only crate that maps libraries and calls their functions.
    row(
        "crates/loader",
        &[
            "crates/abi",
            "crates/app",
            "crates/core",
            "crates/panel",
            "crates/records",
        ],
    ),
    // The only crate that starts processes for schemas and limits them.
    row(
        "crates/isolation",
        &[
            "crates/abi",
            "crates/app",
            "crates/board",
            "crates/loader",
            "crates/panel",
        ],
    ),
    row(
        "crates/host",
        &[
            "crates/abi",
            "crates/app",
            "crates/board",
            "crates/core",
            "crates/gate",
            "crates/isolation",
            "crates/loader",
            "crates/panel",
            "crates/records",
            "crates/types",
        ],
    ),
    row(
        "crates/log",
        &[
            "crates/abi",
            "crates/app",
            "crates/board",
            "crates/conditions",
            "crates/core",
            // To decide a recording again.
            "crates/host",
            "crates/loader",
            "crates/panel",
            "crates/records",
            "crates/ros",
            "crates/types",
        ],
    ),
    // A report is made from the recording alone, except for the world, which is read from its file.
    row(
        "crates/report",
        &[
            "crates/board",
            "crates/core",
            "crates/log",
            "crates/records",
            "crates/ros",
            "crates/sim",
            "crates/types",
        ],
    ),
    row("crates/ros", &["crates/abi"]),
    // Panel lists are built from the data that plugins pass through the ABI.
    row("crates/panel", &["crates/abi"]),
    // It shows data from the link or from a recording, and cannot reach any control.
    row(
        "crates/view",
        &[
            "crates/abi",
            "crates/app",
            "crates/board",
            "crates/conditions",
            "crates/core",
            "crates/link",
            "crates/panel",
            "crates/records",
            "crates/types",
        ],
    ),
    // The only crate that opens the network.
    row(
        "crates/link",
        &[
            "crates/abi",
            "crates/app",
            "crates/board",
            "crates/core",
            // A running application as the subject of a link.
            "crates/host",
            "crates/loader",
            "crates/panel",
            "crates/records",
            "crates/ros",
        ],
    ),
    Row {
        folder: "crates/jde",
        ours: AllowedCrates::AnyCrate,
        libraries: true,
    },
    // Both ends use the same protocol, which depends on neither.
    row("crates/p2os", &[]),
    // It runs whole applications and observes everything from outside.
    row(
        "crates/faults",
        &[
            "crates/abi",
            "crates/app",
            "crates/board",
            "crates/core",
            "crates/device",
            "crates/host",
            "crates/isolation",
            "crates/loader",
            "crates/p2os-server",
            "crates/records",
            "crates/shadow",
            "crates/sim",
            "crates/types",
            "crates/watchdog",
        ],
    ),
    row("crates/ball", &["crates/types"]),
    row("crates/device", &["crates/schema", "crates/watchdog"]),
    row(
        "crates/p2os-server",
        &["crates/device", "crates/p2os", "crates/sim"],
    ),
    row(
        "drivers/",
        &[
            "crates/schema",
            "crates/sim",
            "crates/p2os",
            "crates/device",
            "crates/log",
            "crates/ros",
        ],
    ),
    row("schemas/", &["crates/schema", "crates/ball"]),
    row(
        "xtask",
        &["crates/abi", "crates/core", "crates/test-plugins", "crates/types"],
    ),
];

/// The page with the same table for readers.
const PAGE: &str = "docs/architecture.md";

/// Checks that the table has every dependency of the workspace and a row for every folder, and that the page
/// shows the same table.
pub(super) fn check(tree: &Tree, metadata: &Metadata) -> Vec<Violation> {
    let packages = metadata.members();
    let mut found: Vec<_> = packages
        .flat_map(|package| check_package(tree, package))
        .collect();
    let page = tree.file(PAGE).map_or("", |file| file.text.as_str());
    found.extend(TABLE.iter().filter_map(|row| row.check_page(page)));
    found
}

fn check_package(tree: &Tree, package: &Package) -> Vec<Violation> {
    let folder = package.folder(&tree.root);
    let manifest = format!("{folder}/Cargo.toml");
    let Some(row) = TABLE.iter().find(|row| row.covers(&folder)) else {
        return vec![Violation::new(
            manifest,
            1,
            format!("nothing says what {folder} may use"),
            "add its row to the table in xtask/src/tidy/layering.rs, and the reason to docs/decisions",
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
                format!("{folder} may use {}; see docs/architecture.md", row.ours()),
            )),
            None if !row.libraries => found.push(Violation::new(
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

/// Returns the package name for a folder. Crates under `crates/` have the prefix `jde-`, except two.
fn expected_name(folder: &str) -> String {
    match folder.rsplit_once('/') {
        // The executable has no prefix; `webpki-roots` replaces an external crate of this name.
        Some(("crates", name @ ("jde" | "webpki-roots"))) => name.to_owned(),
        Some(("crates", name)) => format!("jde-{name}"),
        Some((_, name)) => name.to_owned(),
        None => folder.to_owned(),
    }
}

impl Row {
    fn covers(&self, folder: &str) -> bool {
        if self.folder.ends_with('/') {
            folder.starts_with(self.folder)
        } else {
            folder == self.folder
        }
    }

    fn allows(&self, folder: &str) -> bool {
        match self.ours {
            AllowedCrates::Listed(folders) => folders.contains(&folder),
            AllowedCrates::AnyCrate => folder.starts_with("crates/"),
        }
    }

    /// Checks that the page has this row, with these uses. Folders of folders share a row in words.
    fn check_page(&self, page: &str) -> Option<Violation> {
        let AllowedCrates::Listed(folders) = self.ours else {
            return None;
        };
        if self.folder.ends_with('/') {
            return None;
        }
        let names: Vec<_> = folders
            .iter()
            .map(|folder| folder.trim_start_matches("crates/"))
            .collect();
        let uses = match (names.is_empty(), self.libraries) {
            (true, true) => "nothing of jde".to_owned(),
            (true, false) => "nothing".to_owned(),
            (false, _) => names.join(", "),
        };
        let begin = format!("| `{}` |", self.folder);
        let line = page.lines().position(|line| line.starts_with(&begin));
        let shown = line.and_then(|line| page.lines().nth(line));
        if shown.is_some_and(|shown| shown.ends_with(&format!("| {uses} |"))) {
            return None;
        }
        Some(Violation::new(
            PAGE,
            line.map_or(1, |line| line + 1),
            format!("the page does not say that {} uses {uses}", self.folder),
            "make the row agree with the table in xtask/src/tidy/layering.rs",
        ))
    }

    fn ours(&self) -> String {
        match self.ours {
            AllowedCrates::Listed([]) => "nothing of this workspace".to_owned(),
            AllowedCrates::Listed(folders) => folders.join(", "),
            AllowedCrates::AnyCrate => "every folder of crates/".to_owned(),
        }
    }
}

impl Dependency {
    fn folder(&self, tree: &Tree) -> Option<String> {
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
        let tree = Tree::of(&[(&format!("{folder}/Cargo.toml"), "[dependencies]\nserde = \"1\"\n")]);
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
    fn the_page_has_the_same_uses() {
        let row = row("crates/a", &["crates/b", "crates/c"]);
        assert_eq!(row.check_page("# A\n| `crates/a` | does | b, c |\n"), None);
        let wrong = row.check_page("# A\n| `crates/a` | does | b |\n").unwrap();
        assert_eq!(wrong.line, 2);
        assert_eq!(
            alone("crates/a").check_page("| `crates/a` | does | nothing |"),
            None
        );
        assert!(row.check_page("").is_some());
    }

    #[test]
    fn an_arrow_of_the_table_passes() {
        assert_eq!(
            check_one("crates/board", "jde-board", &ours("crates/abi", "null")),
            [""; 0]
        );
        assert_eq!(
            check_one("drivers/sim", "sim", &ours("crates/sim", "null")),
            [""; 0]
        );
        assert_eq!(
            check_one("crates/jde", "jde", &ours("crates/sim", "null")),
            [""; 0]
        );
    }

    #[test]
    fn any_other_arrow_fails() {
        let found = check_one("crates/sim", "jde-sim", &ours("crates/schema", "null"));
        assert_eq!(
            found,
            ["1: crates/sim uses crates/schema, against the direction of the arrows"]
        );
        assert_eq!(
            check_one("schemas/stop", "stop", &ours("crates/host", "\"build\"")).len(),
            1
        );
        assert_eq!(check_one("crates/jde", "jde", &ours("xtask", "null")).len(), 1);
    }

    #[test]
    fn tests_may_use_any_crate() {
        assert_eq!(
            check_one("crates/core", "jde-core", &ours("crates/host", "\"dev\"")),
            [""; 0]
        );
    }

    #[test]
    fn the_rules_use_no_library() {
        let serde = r#"{"name": "serde", "req": "^1"}"#;
        assert_eq!(
            check_one("crates/core", "jde-core", serde),
            ["2: crates/core uses the library serde"]
        );
        assert_eq!(check_one("crates/host", "jde-host", serde), [""; 0]);
    }

    #[test]
    fn a_folder_without_a_row_fails() {
        assert_eq!(
            check_one("crates/new", "jde-new", ""),
            ["1: nothing says what crates/new may use"]
        );
    }

    #[test]
    fn a_package_is_called_like_its_folder() {
        assert_eq!(
            check_one("crates/abi", "abi", ""),
            ["1: the package in crates/abi is called abi"]
        );
    }
}
