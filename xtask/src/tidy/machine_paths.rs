//! No path of a particular machine in files that run on every machine.

use super::tree::{File, Tree, Violation};

/// The folders below `/` that differ from machine to machine.
const FOLDERS: &[&str] = &["home", "root", "tmp", "Users"];

pub(super) fn check(tree: &Tree) -> Vec<Violation> {
    tree.with_extension(&["rs", "toml", "sh", "c", "h", "cpp", "hpp", "cmake"])
        .flat_map(check_file)
        .collect()
}

fn check_file(file: &File) -> Vec<Violation> {
    let texts: Vec<String> = if file.has_extension(&["rs"]) {
        // Tests may contain such paths.
        let text = |line: &super::rust::SourceLine| format!("{}\n{}", line.literal, line.comment);
        file.lines
            .iter()
            .map(|line| if line.test { String::new() } else { text(line) })
            .collect()
    } else {
        file.text.lines().map(str::to_owned).collect()
    };
    let places = texts
        .iter()
        .enumerate()
        .filter_map(|(index, text)| Some((index + 1, machine_path(text)?)));
    places
        .map(|(number, folder)| {
            Violation::new(
                file.path.as_str(),
                number,
                format!("a path of one machine: /{folder}"),
                "make it relative, ask the system for it (a temporary folder, the home), or take it as an option",
            )
        })
        .collect()
}

/// Returns the first of these folders with which a path in the text begins.
fn machine_path(text: &str) -> Option<&'static str> {
    text.match_indices('/').find_map(|(at, _)| {
        let before = text[..at].chars().next_back();
        if before.is_some_and(|c| c.is_alphanumeric() || "_-./~}*)>".contains(c)) {
            return None;
        }
        FOLDERS.iter().copied().find(|folder| {
            text[at + 1..]
                .strip_prefix(folder)
                .is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_of_one_machine_fails() {
        let found = check_file(&File::new("src/a.rs", "let a;\nlet b = \"/tmp/c\";\n"));
        assert_eq!((found.len(), found[0].line), (1, 2));
        assert_eq!(
            check_file(&File::new("src/a.rs", "// In /home/somebody/b.\n")).len(),
            1
        );
        assert_eq!(check_file(&File::new("a.toml", "b = \"/root/c\"\n")).len(), 1);
    }

    #[test]
    fn paths_within_the_project_pass() {
        let text = "let a = \"crates/home/x\"; // and/root, {}/tmp, ../home, /homestead, /usr/lib\n";
        assert_eq!(check_file(&File::new("src/a.rs", text)), []);
    }

    #[test]
    fn tests_may_contain_such_paths() {
        assert_eq!(check_file(&File::new("tests/a.rs", "let a = \"/tmp/b\";\n")), []);
    }
}
