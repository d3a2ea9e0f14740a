//! Tables of the pages are read at a glance: no cell has more than 25 words. It looks into no fenced block.

use super::links::prose;
use super::tree::{File, Tree, Violation};

/// The greatest length of a cell: a sentence that is read at once.
const MOST_WORDS: usize = 25;

pub(super) fn check(tree: &Tree) -> Vec<Violation> {
    tree.with_extension(&["md"]).flat_map(check_page).collect()
}

fn check_page(page: &File) -> Vec<Violation> {
    let rows = prose(&page.text).filter(|(_, line)| line.trim_start().starts_with('|'));
    rows.filter_map(|(number, row)| {
        let row = row.replace("\\|", "/");
        let words = row.split('|').map(|cell| cell.split_whitespace().count()).max()?;
        (words > MOST_WORDS).then(|| {
            Violation::new(
                page.path.as_str(),
                number,
                format!("a cell has {words} words, over {MOST_WORDS}"),
                "shorten it, or write a paragraph below the table",
            )
        })
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<usize> {
        let found = check_page(&File::new("docs/a.md", text));
        found.iter().map(|violation| violation.line).collect()
    }

    #[test]
    fn a_cell_of_a_sentence_passes() {
        let cell = "word ".repeat(MOST_WORDS);
        assert_eq!(
            lines(&format!("| a | b |\n|---|---|\n| {cell} | {cell} |\n")),
            [0; 0]
        );
        assert_eq!(
            lines(&format!("{cell}{cell}\n```text\n| {cell}{cell} |\n```\n")),
            [0; 0]
        );
    }

    #[test]
    fn a_longer_cell_fails() {
        let cell = "word ".repeat(MOST_WORDS + 1);
        assert_eq!(
            lines(&format!("| a | b |\n|---|---|\n| c | {cell} |\n  | {cell} |\n")),
            [3, 4]
        );
    }

    #[test]
    fn an_escaped_bar_divides_no_cell() {
        let half = "word ".repeat(MOST_WORDS / 2 + 1);
        assert_eq!(lines(&format!("| {half}\\|{half} |\n")), [1]);
    }
}
