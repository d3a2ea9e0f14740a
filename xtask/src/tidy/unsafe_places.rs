//! `unsafe` occurs only in listed places. Clippy checks that each use has a `SAFETY:` reason.

use super::tree::{File, Tree, Violation};
use super::unfinished::has_word;

/// The places where `unsafe` is allowed, with the reason.
const ALLOWED_FILES: &[(&str, &str)] = &[
    (
        "plugin/abi/src/",
        "the tables of the ABI are read through pointers",
    ),
    ("plugin/abi/tests/", "its tests build invalid tables"),
    (
        "plugin/macros/src/",
        "the export macro writes the entry point of a plugin",
    ),
    ("plugin/types/src/", "a derived value vouches for its layout"),
    (
        "plugin/schema/src/",
        "the glue between the tables and an author's safe code",
    ),
    (
        "plugin/schema/tests/",
        "the conformance of plugins is tried through the bare tables",
    ),
    (
        "plugin/panel/src/boundary/",
        "lists are built from the tables that plugins fill, and gestures lent as tables",
    ),
    (
        "plugin/panel/tests/",
        "the mistakes that plugins can make with a pen are made with one",
    ),
    ("runtime/board/src/", "the cells of variables"),
    (
        "runtime/board/tests/",
        "the cells are tried with types of the tests' own",
    ),
    (
        "rules/gate/tests/",
        "loom checks the exclusion of the gate through its raw cells",
    ),
    (
        "runtime/isolation/src/",
        "an instance in a process of its own gets that process's table",
    ),
    (
        "programs/validate/src/",
        "a plugin is driven through its table, and gets that of a host that watches it",
    ),
    (
        "runtime/host/src/instance/",
        "an instance is driven through the plugin's table, and gets the host's",
    ),
    (
        "runtime/loader/src/",
        "the loader opens libraries and calls their tables",
    ),
    (
        "devices/device/src/port/modem.rs",
        "no safe function sets the modem signals of a serial line",
    ),
    ("programs/c/src/", "functions for C take and fill in pointers"),
    (
        "programs/python/src/",
        "the functions of schemas in Python are called through tables, with the memory of values",
    ),
    (
        "runtime/host/tests/",
        "its tests build plugins that break their contract",
    ),
    (
        "schemas/fault/src/trouble.rs",
        "a wild pointer is one of the troubles that it makes",
    ),
];

pub(super) fn check(tree: &Tree) -> Vec<Violation> {
    tree.rust().filter_map(check_file).collect()
}

/// Reports one violation per file, since all uses in a file are usually moved together.
fn check_file(file: &File) -> Option<Violation> {
    if ALLOWED_FILES
        .iter()
        .any(|(place, _)| file.path.starts_with(place))
    {
        return None;
    }
    let is_unsafe = |line: &super::rust::SourceLine| {
        has_word(&line.code, "unsafe") || has_word(&line.code, "unsafe_code")
    };
    let uses = file.numbered().filter(|(_, line)| is_unsafe(line)).count();
    let (first, _) = file.numbered().find(|(_, line)| is_unsafe(line))?;
    Some(Violation::new(
        file.path.as_str(),
        first,
        format!("`unsafe` outside its places, on {uses} lines of this file"),
        "do it safely, or move it to one of the places in xtask/src/tidy/unsafe_places.rs",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unsafe_in_its_places_passes() {
        assert_eq!(
            check_file(&File::new("runtime/board/src/cell.rs", "unsafe { a() }\n")),
            None
        );
    }

    #[test]
    fn unsafe_elsewhere_fails() {
        for code in [
            "fn a() { unsafe { b() } }\n",
            "#![allow(unsafe_code)]\n",
            "#[unsafe(no_mangle)]\n",
        ] {
            let text = format!("fn c() {{}}\n{code}{code}");
            let found = check_file(&File::new("schemas/stop/src/lib.rs", text)).unwrap();
            assert_eq!(found.line, 2, "{code}");
            assert_eq!(
                found.message,
                "`unsafe` outside its places, on 2 lines of this file"
            );
        }
    }

    #[test]
    fn the_word_in_other_contexts_passes() {
        let text = "// unsafe\nlet unsafe_places = \"unsafe\";\n";
        assert_eq!(check_file(&File::new("schemas/stop/src/lib.rs", text)), None);
    }
}
