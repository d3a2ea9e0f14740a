//! No tabs, no blanks at the end of a line, and a newline at the end of each file.

use super::tree::{File, Tree, Violation};

pub(super) fn check(tree: &Tree) -> Vec<Violation> {
    tree.with_extension(&["rs", "toml", "md"])
        .flat_map(check_file)
        .collect()
}

fn check_file(file: &File) -> Vec<Violation> {
    let mut found = Vec::new();
    for (index, line) in file.text.split('\n').enumerate() {
        let mut report = |what: &str, help: &str| {
            found.push(Violation::new(file.path.as_str(), index + 1, what, help));
        };
        if line.contains('\t') {
            report("a tab", "use spaces, or `\\t` within a literal");
        }
        if line.ends_with([' ', '\t', '\r']) {
            report("blanks at the end of the line", "remove them");
        }
    }
    if !file.text.is_empty() && !file.text.ends_with('\n') {
        let last = file.text.split('\n').count();
        found.push(Violation::new(
            file.path.as_str(),
            last,
            "no newline at the end of the file",
            "add one",
        ));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Vec<(usize, String)> {
        let file = File::new("a.md", text);
        check_file(&file)
            .into_iter()
            .map(|violation| (violation.line, violation.message))
            .collect()
    }

    #[test]
    fn clean_text_passes() {
        assert_eq!(found(""), []);
        assert_eq!(found("a\n\n  b c\n"), []);
    }

    #[test]
    fn tabs_and_trailing_blanks_fail() {
        assert_eq!(found("a\n\tb\n"), [(2, "a tab".to_owned())]);
        assert_eq!(
            found("a  \nb\r\n")
                .iter()
                .map(|found| found.0)
                .collect::<Vec<_>>(),
            [1, 2]
        );
        assert_eq!(
            found("a\nb"),
            [(2, "no newline at the end of the file".to_owned())]
        );
    }
}
