//! The words that `docs/glossary.md` forbids: no item of the code has one in its name.

use super::tree::{File, Tree, Violation};

/// The page with the list.
const GLOSSARY: &str = "docs/glossary.md";
/// The heading above the list.
const HEADING: &str = "## Words that name nothing here";
/// What precedes the name of an item.
const ITEMS: &[&str] = &[
    "struct ", "enum ", "trait ", "type ", "fn ", "mod ", "const ", "static ", "union ",
];

pub(super) fn check(tree: &Tree) -> Vec<Violation> {
    let page = tree.files.iter().find(|file| file.path == GLOSSARY);
    let forbidden = page.map(|page| listed(&page.text)).unwrap_or_default();
    if forbidden.is_empty() {
        let what = format!("there is no list of words under `{HEADING}`");
        return vec![Violation::new(
            GLOSSARY,
            1,
            what,
            "restore the table: the word, and what to write",
        )];
    }
    tree.rust()
        .flat_map(|file| check_file(file, &forbidden))
        .collect()
}

/// Reads the table: the word, and what to write instead.
fn listed(page: &str) -> Vec<(String, String)> {
    let Some((_, list)) = page.split_once(HEADING) else {
        return Vec::new();
    };
    let rows = list.lines().skip_while(|line| !line.starts_with("|---"));
    let rows = rows.skip(1).take_while(|line| line.starts_with('|'));
    let rows = rows.filter_map(|row| {
        let (words, instead) = row.trim_matches('|').split_once('|')?;
        Some((words.to_owned(), instead.trim().to_owned()))
    });
    rows.flat_map(|(words, instead)| {
        let words: Vec<String> = words.split(',').map(|word| word.trim().to_owned()).collect();
        words.into_iter().map(move |word| (word, instead.clone()))
    })
    .collect()
}

fn check_file(file: &File, forbidden: &[(String, String)]) -> Vec<Violation> {
    let mut found = Vec::new();
    for (number, line) in file.numbered().filter(|(_, line)| !line.test) {
        let Some(name) = item(&line.code) else { continue };
        for part in parts(name) {
            if let Some((word, instead)) = forbidden.iter().find(|(word, _)| *word == part) {
                found.push(Violation::new(
                    file.path.as_str(),
                    number,
                    format!("`{name}`: the glossary forbids `{word}`"),
                    format!("name it as the field does: {instead}"),
                ));
            }
        }
    }
    found
}

/// Returns the name of the item that a line of code defines.
fn item(code: &str) -> Option<&str> {
    let code = code.trim_start();
    let after = ITEMS.iter().find_map(|item| {
        let at = code.find(item)?;
        let before = &code[..at];
        // Only visibility and qualifiers stand before an item.
        let is_item = before
            .chars()
            .all(|c| c.is_alphanumeric() || " _():\"".contains(c));
        is_item.then(|| &code[at + item.len()..])
    })?;
    let end = after.find(|c: char| !c.is_alphanumeric() && c != '_');
    let name = &after[..end.unwrap_or(after.len())];
    (!name.is_empty()).then_some(name)
}

/// Splits a name of any case into its words, in lower case.
fn parts(name: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let mut before = '_';
    for c in name.chars() {
        if c == '_' || c.is_uppercase() && !before.is_uppercase() {
            parts.push(String::new());
        }
        if c != '_' {
            parts.last_mut().expect("there is one").extend(c.to_lowercase());
        }
        before = c;
    }
    parts.retain(|part| !part.is_empty());
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = "# G\n\n## Words that name nothing here\n\n| word | write |\n|---|---|\n| seat, desk | slot |\n| tale | analysis |\n\n| a | b |\n";

    fn lines(text: &str) -> Vec<usize> {
        let found = check_file(&File::new("rules/a/src/a.rs", text), &listed(PAGE));
        found.iter().map(|violation| violation.line).collect()
    }

    #[test]
    fn the_list_is_read_from_the_page() {
        let words: Vec<String> = listed(PAGE).into_iter().map(|(word, _)| word).collect();
        assert_eq!(words, ["seat", "desk", "tale"]);
        assert!(listed("# G\n").is_empty());
    }

    #[test]
    fn names_are_split_into_words() {
        assert_eq!(parts("PortDesk"), ["port", "desk"]);
        assert_eq!(parts("tell_tale"), ["tell", "tale"]);
        assert_eq!(parts("MAX_SEATS"), ["max", "seats"]);
    }

    #[test]
    fn an_item_with_a_forbidden_word_in_its_name_fails() {
        assert_eq!(
            lines("struct Desk;\npub(crate) fn take_seat() {}\nmod tale;\n"),
            [1, 2, 3]
        );
        assert_eq!(
            lines("const SEAT: u8 = 1;\npub(super) const fn seat() {}\n"),
            [1, 2]
        );
    }

    #[test]
    fn other_words_uses_and_tests_pass() {
        assert_eq!(lines("struct Desktop;\nlet desk = seat();\n// fn seat\n"), [0; 0]);
        assert_eq!(lines("#[cfg(test)]\nmod tests {\n    fn seat() {}\n}\n"), [0; 0]);
    }
}
