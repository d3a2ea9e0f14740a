//! Every library in a crate's manifest is named somewhere in the crate's code.

use super::links::resolve;
use super::tree::{Tree, Violation};
use super::unfinished::has_word;
use crate::metadata::{Metadata, Package};

pub(super) fn check(tree: &Tree, metadata: &Metadata) -> Vec<Violation> {
    metadata
        .members()
        .flat_map(|package| check_package(tree, package))
        .collect()
}

fn check_package(tree: &Tree, package: &Package) -> Vec<Violation> {
    let folder = package.folder(&tree.root);
    let manifest = format!("{folder}/Cargo.toml");
    let within = roots(tree, &folder);
    let used = |name: &str| {
        // Comments count, since examples in doc comments are compiled too.
        let in_line =
            |line: &super::rust::SourceLine| has_word(&line.code, name) || has_word(&line.comment, name);
        tree.rust()
            .filter(|file| within.iter().any(|root| file.path.starts_with(root)))
            .any(|file| file.lines.iter().any(in_line))
    };
    let unused = package.dependencies.iter().filter_map(|dependency| {
        let name = dependency.rename.as_ref().unwrap_or(&dependency.name);
        (!used(&name.replace('-', "_"))).then_some(name)
    });
    unused
        .map(|name| {
            Violation::new(
                manifest.as_str(),
                tree.line_of(&manifest, name),
                format!("nothing in {folder} names {name}"),
                "remove the dependency",
            )
        })
        .collect()
}

/// Returns the folder of a package, and the files and folders of modules that it includes by their paths.
fn roots(tree: &Tree, folder: &str) -> Vec<String> {
    let within = format!("{folder}/");
    let own = tree.rust().filter(|file| file.path.starts_with(&within));
    let included = own.flat_map(|file| {
        let modules = file
            .lines
            .iter()
            .filter(|line| line.code.starts_with("#[path = "));
        modules.map(|line| resolve(&file.path, line.literal.trim_end_matches("mod.rs")))
    });
    included.chain([within.clone()]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(code: &str) -> Vec<String> {
        let tree = Tree::of(&[
            ("rules/by_path/mod.rs", "mod part;\n"),
            ("rules/by_path/part.rs", "use tiny_skia;\n"),
            ("rules/a/Cargo.toml", "[dependencies]\ntiny-skia = \"1\"\n"),
            ("rules/a/src/lib.rs", code),
            ("rules/ab/src/lib.rs", "use tiny_skia;\n"),
        ]);
        let package = r#"{"id": "a", "name": "a", "version": "0.1.0",
            "manifest_path": "no-such-root/rules/a/Cargo.toml",
            "dependencies": [{"name": "tiny-skia", "req": "^1"}]}"#;
        let found = check_package(&tree, &serde_json::from_str(package).unwrap());
        found
            .iter()
            .map(|violation| format!("{}: {}", violation.line, violation.message))
            .collect()
    }

    #[test]
    fn a_library_that_is_named_passes() {
        assert_eq!(found("use tiny_skia::Pixmap;\n"), [""; 0]);
        assert_eq!(found("/// ```\n/// use tiny_skia::Pixmap;\n/// ```\n"), [""; 0]);
    }

    #[test]
    fn a_module_that_is_included_by_its_path_counts() {
        assert_eq!(found("#[path = \"../../by_path/mod.rs\"]\nmod m;\n"), [""; 0]);
    }

    #[test]
    fn a_library_that_no_code_names_fails() {
        assert_eq!(
            found("use tiny_skia_too;\n"),
            ["2: nothing in rules/a names tiny-skia"]
        );
    }
}
