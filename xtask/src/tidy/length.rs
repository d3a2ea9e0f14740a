//! Small files: at most 500 lines, unless the header gives a reason, and four of five files have at most 200
//! lines of code.

use super::header;
use super::tree::{File, Tree, Violation};

/// The greatest length of a file, in lines of any kind.
const MAX_LINES: usize = 500;
/// The greatest length of an ordinary file, in lines of code without tests.
const USUAL_LINES: usize = 200;
/// One file in this many may have more code than an ordinary one.
const ONE_IN: usize = 5;
/// The words before the reason in the header of a longer file.
const REASON: &str = "long because";

pub(super) fn check(tree: &Tree) -> Vec<Violation> {
    let mut found: Vec<Violation> = tree.rust().filter_map(check_longest).collect();
    found.extend(check_share(tree));
    found
}

fn check_longest(file: &File) -> Option<Violation> {
    let lines = file.lines.len();
    (lines > MAX_LINES && !header::text(file).to_lowercase().contains(REASON)).then(|| {
        Violation::new(
            file.path.as_str(),
            MAX_LINES + 1,
            format!("the file has {lines} lines, over {MAX_LINES}"),
            format!("split it, or give the reason in its header: `//! {REASON} ...`"),
        )
    })
}

/// Checks the share of ordinary files. Test files are not counted.
fn check_share(tree: &Tree) -> Vec<Violation> {
    let mut files: Vec<(usize, &str)> = tree
        .rust()
        .filter(|file| !file.lines.iter().all(|line| line.test))
        .map(|file| (code_lines(file), file.path.as_str()))
        .collect();
    let all = files.len();
    files.retain(|(lines, _)| *lines > USUAL_LINES);
    if files.len() * ONE_IN <= all {
        return Vec::new();
    }
    let what = |lines| {
        format!(
            "{lines} lines of code: {} of {all} files have over {USUAL_LINES}, more than one in {ONE_IN}",
            files.len()
        )
    };
    let help = "split it by what its parts are for";
    files
        .iter()
        .map(|(lines, path)| Violation::new(*path, 1, what(lines), help))
        .collect()
}

/// Returns the number of lines with code outside tests.
fn code_lines(file: &File) -> usize {
    file.lines
        .iter()
        .filter(|line| !line.test && !line.code.trim().is_empty())
        .count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn long(header: &str, code_lines: usize) -> String {
        format!("{header}\n{}", "let a = 1;\n".repeat(code_lines))
    }

    #[test]
    fn a_long_file_gives_its_reason() {
        let without = File::new("a.rs", long("//! A table.", MAX_LINES));
        assert_eq!(
            check_longest(&without).unwrap().message,
            "the file has 501 lines, over 500"
        );
        let with = File::new(
            "a.rs",
            long("//! A table.\n//! Long because it is one table.", MAX_LINES),
        );
        assert_eq!(check_longest(&with), None);
        assert_eq!(
            check_longest(&File::new("a.rs", long("//! A table.", MAX_LINES - 1))),
            None
        );
    }

    #[test]
    fn one_file_in_five_may_have_more_code() {
        let (big, small) = (long("//! Big.", USUAL_LINES + 1), long("//! Small.", USUAL_LINES));
        let mut files = vec![("a.rs", big.as_str())];
        files.extend([("b.rs", small.as_str()); 3]);
        let found = check_share(&Tree::of(&files));
        assert_eq!((found.len(), found[0].path.as_str()), (1, "a.rs"));
        files.push(("c.rs", small.as_str()));
        assert_eq!(check_share(&Tree::of(&files)), []);
    }

    #[test]
    fn comments_blank_lines_and_tests_are_no_code() {
        let text = "//! A.\n\n// b\nfn c() {}\n#[cfg(test)]\nmod tests {\n    fn d() {}\n}\n";
        assert_eq!(code_lines(&File::new("a.rs", text)), 1);
        let test = long("//! A test.", USUAL_LINES + 1);
        assert_eq!(check_share(&Tree::of(&[("tests/a.rs", &test)])), []);
    }
}
