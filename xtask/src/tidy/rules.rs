//! Every rule of action selection is named by a test. The rules are read from the page that lists them. The
//! quality of the tests is not checked.

use std::collections::BTreeMap;

use super::links::prose;
use super::tree::{File, Tree, Violation};

pub(super) fn check(tree: &Tree) -> Vec<Violation> {
    let rules = listed(tree);
    if rules.is_empty() {
        return vec![Violation::new(
            "docs",
            1,
            "no page lists the rules",
            "give the rules a page under docs/, each as `- **R1 Name.** What it says.`",
        )];
    }
    let named: Vec<u32> = tree.files.iter().flat_map(named).collect();
    let lost = rules.into_iter().filter(|(rule, _)| !named.contains(rule));
    lost.map(|(rule, (page, line))| {
        Violation::new(
            page,
            line,
            format!("no test names rule R{rule}"),
            format!("name the test that holds it `r{rule}_...`; if there is none, write it"),
        )
    })
    .collect()
}

/// Returns the rules with the page and line that states each.
fn listed(tree: &Tree) -> BTreeMap<u32, (String, usize)> {
    let mut rules = BTreeMap::new();
    for page in tree
        .with_extension(&["md"])
        .filter(|file| file.path.starts_with("docs/"))
    {
        for (number, line) in prose(&page.text) {
            let name = line
                .trim_start()
                .strip_prefix("- **R")
                .and_then(|rest| rest.split(' ').next());
            if let Some(rule) = name.and_then(|digits| digits.parse().ok()) {
                rules.entry(rule).or_insert_with(|| (page.path.clone(), number));
            }
        }
    }
    rules
}

/// Returns the rules that a test or a scenario names: `r5_...` in a function name, `R5` in a comment or a
/// string.
fn named(file: &File) -> Vec<u32> {
    if file.path.starts_with("scenarios/") {
        return in_words(&file.text);
    }
    let mut rules = Vec::new();
    for (_, line) in file.numbered().filter(|(_, line)| line.test) {
        if let Some((_, name)) = line.code.split_once("fn ") {
            let name = name
                .split(|c: char| !c.is_alphanumeric() && c != '_')
                .next()
                .unwrap_or_default();
            rules.extend(
                name.split('_')
                    .filter_map(|part| part.strip_prefix('r')?.parse::<u32>().ok()),
            );
        }
        rules.extend(in_words(&line.comment));
        rules.extend(in_words(&line.literal));
    }
    rules
}

fn in_words(text: &str) -> Vec<u32> {
    let words = text.split(|c: char| !c.is_alphanumeric());
    words
        .filter_map(|word| word.strip_prefix('R')?.parse().ok())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: (&str, &str) = (
        "docs/rules.md",
        "# Rules\n\n- **R1 One.** Only one.\n- **R12 Two.**\n",
    );

    fn found(test: (&str, &str)) -> Vec<(usize, String)> {
        let found = check(&Tree::of(&[PAGE, test]));
        found
            .into_iter()
            .map(|violation| (violation.line, violation.message))
            .collect()
    }

    #[test]
    fn rules_that_tests_name_pass() {
        assert_eq!(found(("tests/a.rs", "fn r1_and_r12_hold() {}\n")), []);
        assert_eq!(found(("tests/a.rs", "// R1, R12.\nfn a() {}\n")), []);
        assert_eq!(found(("scenarios/a.toml", "rules = [\"R1\", \"R12\"]\n")), []);
    }

    #[test]
    fn a_rule_that_no_test_names_fails() {
        let lost = [(4, "no test names rule R12".to_owned())];
        assert_eq!(found(("tests/a.rs", "fn r1_holds() { let r12 = 1; }\n")), lost);
        assert_eq!(found(("tests/a.rs", "// R1, R120, PR12\n")), lost);
    }

    #[test]
    fn a_rule_named_outside_of_tests_does_not_count() {
        assert_eq!(found(("src/a.rs", "// R1 and R12\nfn r1_r12() {}\n")).len(), 2);
    }

    #[test]
    fn the_page_of_the_rules_is_required() {
        assert_eq!(check(&Tree::of(&[]))[0].message, "no page lists the rules");
    }
}
