//! Applications, and files that options name.

use std::path::Path;

use super::files::{app, lines, list, write};

/// Schemas whose type is missing.
pub(super) fn missing_types(folder: &Path) {
    app(
        folder,
        &format!(
            "roots = [\"s0\"]\n{}",
            lines(4_000, |n| format!("[schemas.s{n}]\ndoc = \"\""))
        ),
    );
}

/// Names that are as long as a name may be, each like many others.
pub(super) fn misspelt_roots(folder: &Path) {
    let roots = list(4_000, |n| format!("b{n:063}"));
    let schemas = lines(4_000, |n| format!("[schemas.a{n:063}]\ntype=\"stop\""));
    app(folder, &format!("roots = {roots}\n{schemas}"));
}

/// Levels of roots that name the same schema.
pub(super) fn levels(folder: &Path) {
    let levels = lines(9_999, |n| format!("l{n} = {{ members = [\"a\"] }}"));
    app(
        folder,
        &format!("[schemas.a]\ntype = \"stop\"\n[roots]\n{levels}"),
    );
}

/// Groups of a father in which nothing competes, and members that it does not have.
pub(super) fn groups(folder: &Path) {
    let groups = lines(9_999, |n| format!("g{n} = {{ members = [\"a\", \"b{n}\"] }}"));
    app(
        folder,
        &format!("roots = [\"a\"]\n[schemas.a]\ntype = \"father\"\n[schemas.a.groups]\n{groups}"),
    );
}

/// Children in roles that their father does not have.
pub(super) fn children(folder: &Path) {
    let children = lines(9_999, |n| format!("c{n} = \"s{n}\""));
    let schemas = lines(9_999, |n| format!("[schemas.s{n}]\ntype=\"stop\""));
    app(
        folder,
        &format!(
            "roots = [\"a\"]\n[schemas.a]\ntype=\"example\"\n[schemas.a.children]\n{children}\n{schemas}"
        ),
    );
}

/// Fathers below each other.
pub(super) fn nested(count: usize) -> String {
    let father = |n| format!("[schemas.s{n}]\ntype=\"father\"\nchildren={{a=\"s{}\"}}", n + 1);
    format!(
        "roots = [\"s0\"]\n{}[schemas.s{count}]\ntype=\"stop\"",
        lines(count, father)
    )
}

/// Folders of plugins, and plugins that none of them has.
pub(super) fn folders(folder: &Path) {
    let plugins = list(9_000, |n| format!("folder{n}"));
    let schemas = lines(5_000, |n| format!("[schemas.s{n}]\ntype = \"p{n}\""));
    app(
        folder,
        &format!("roots = [\"s0\"]\nplugins = {plugins}\n{schemas}"),
    );
}

/// Many faults in one long line.
pub(super) fn one_line(folder: &Path) {
    let keys: Vec<_> = (0..9_000).map(|n| format!("key{n:060} = 1")).collect();
    app(
        folder,
        &format!("roots = [\"a\"]\nlink = {{ {} }}", keys.join(", ")),
    );
}

/// Aliases that stand for ten times as many each.
pub(super) fn aliases(folder: &Path) {
    let level = |n: usize| {
        format!(
            "a{}: &a{} [{}]",
            n + 1,
            n + 1,
            vec![format!("*a{n}"); 10].join(", ")
        )
    };
    write(folder, "p", format!("a0: &a0 [1]\n{}", lines(9, level)));
}

/// A key whose password is in an endless file.
pub(super) fn key(folder: &Path) {
    write(
        folder,
        "key.toml",
        "user = \"ana\"\npassword-file = \"/dev/zero\"",
    );
}

/// A library whose header states 2^60 sections.
pub(super) fn sections(folder: &Path) {
    let mut file = vec![0; 128];
    file[..7].copy_from_slice(b"\x7fELF\x02\x01\x01");
    // A shared library, for x86-64, whose sections are at byte 64, the first of which states their number.
    (file[16], file[18], file[40], file[52], file[58]) = (3, 62, 64, 64, 64);
    file[96 + 7] = 0x10;
    write(folder, "lib.so", file);
}

/// Definitions of which each has two of the one before.
pub(super) fn multiplied(folder: &Path) {
    let define = |n: usize| format!("define a{} position ( a{n}() a{n}() )", n + 1);
    let text = format!("define a0 position ( )\n{}a40()\n", lines(40, define));
    write(folder, "multiplied.world", text);
}
