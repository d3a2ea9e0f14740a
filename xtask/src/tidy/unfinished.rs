//! No unfinished work: no placeholder code, no notes of work undone, no silenced dead code.

use super::rust::SourceLine;
use super::tree::{File, Tree, Violation};

/// Placeholder code, and what to do instead.
const CODE: &[(&str, &str)] = &[
    (
        "todo!",
        "write it, or leave it out and say so to its caller with an error",
    ),
    (
        "unimplemented!",
        "write it, or leave it out and say so to its caller with an error",
    ),
    ("dbg!", "remove it"),
];

/// Words that mark unfinished work.
const NOTES: &[&str] = &["FIXME", "XXX", "HACK", "TODO"];
/// The same in softer words.
const SOFT_NOTE: &str = "for now";

pub(super) fn check(tree: &Tree) -> Vec<Violation> {
    tree.files.iter().flat_map(check_file).collect()
}

fn check_file(file: &File) -> Vec<Violation> {
    let mut found = Vec::new();
    for (number, line) in file.numbered() {
        for (mark, help) in CODE.iter().copied() {
            if has_word(&line.code, mark) {
                found.push(Violation::new(
                    file.path.as_str(),
                    number,
                    format!("`{mark}`"),
                    help,
                ));
            }
        }
    }
    for (number, _) in file.numbered().filter(|(_, line)| silences(line)) {
        found.push(Violation::new(
            file.path.as_str(),
            number,
            "dead code is silenced",
            "remove the code that nothing uses; what tests share says so: `reason = \"...\"`",
        ));
    }
    let notes: Vec<&str> = if file.has_extension(&["rs"]) {
        file.lines.iter().map(|line| line.comment.as_str()).collect()
    } else {
        file.text.lines().collect()
    };
    for (index, text) in notes.iter().enumerate() {
        let hard = NOTES.iter().copied().find(|note| has_word(text, note));
        let soft = has_word(&text.to_lowercase(), SOFT_NOTE).then_some(SOFT_NOTE);
        if let Some(note) = hard.or(soft) {
            found.push(Violation::new(
                file.path.as_str(),
                index + 1,
                format!("`{note}`: a note of work undone"),
                "do it, or state how it is and why",
            ));
        }
    }
    found
}

/// Returns whether a line silences dead code without permission. A reason permits it in test code, for files
/// that several tests share, and in builds without a feature, for modules that both builds share.
fn silences(line: &SourceLine) -> bool {
    let named = has_word(&line.code, "allow") && has_word(&line.code, "dead_code");
    // rustfmt puts the second argument of a long `cfg_attr` on a line of its own.
    let partial = line.code.contains("cfg_attr(") || line.code.trim_start().starts_with("allow(");
    named && !((line.test || partial) && has_word(&line.code, "reason"))
}

/// Returns whether the text contains a word, and not only as a part of a longer one.
pub(super) fn has_word(text: &str, word: &str) -> bool {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(word).any(|(at, _)| {
        let before = text[..at].chars().next_back();
        let after = text[at + word.len()..].chars().next();
        !before.is_some_and(is_name) && !after.is_some_and(is_name)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(path: &str, text: &str) -> Vec<usize> {
        check_file(&File::new(path, text))
            .iter()
            .map(|violation| violation.line)
            .collect()
    }

    #[test]
    fn placeholder_code_fails() {
        assert_eq!(lines("a.rs", "fn a() {\n    todo!()\n}\n"), [2]);
        assert_eq!(
            lines("a.rs", "fn a() { unimplemented!(\"b\") }\nlet c = dbg!(d);\n"),
            [1, 2]
        );
    }

    #[test]
    fn silenced_dead_code_fails() {
        assert_eq!(lines("a.rs", "#[allow(dead_code)]\nfn a() {}\n"), [1]);
        assert_eq!(
            lines("a.rs", "#![allow(unused, dead_code, reason = \"shared\")]\n"),
            [1]
        );
        assert_eq!(lines("tests/a.rs", "#![allow(dead_code)]\n"), [1]);
        assert_eq!(
            lines(
                "tests/a.rs",
                "#![allow(dead_code, reason = \"shared by tests\")]\n"
            ),
            [0; 0]
        );
        let shared = "#![cfg_attr(not(feature = \"f\"), allow(dead_code, reason = \"f uses it\"))]\n";
        assert_eq!(lines("a.rs", shared), [0; 0]);
    }

    #[test]
    fn notes_about_unfinished_work_fail() {
        assert_eq!(
            lines(
                "a.rs",
                "// FIXME: b\n/* XXX */\n//! HACK\nlet a; // only for now\n"
            ),
            [1, 2, 3, 4]
        );
        assert_eq!(lines("a.md", "Works for now.\n"), [1]);
        assert_eq!(lines("a.toml", "# For now\n"), [1]);
    }

    #[test]
    fn the_same_words_elsewhere_pass() {
        assert_eq!(
            lines("a.rs", "let a = \"todo!() FIXME\";\nlet mastodo = HACKNEY;\n"),
            [0; 0]
        );
        assert_eq!(lines("a.md", "A list for nowhere: XXXL, HACKING.\n"), [0; 0]);
    }
}
