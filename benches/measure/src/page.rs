//! The table in Markdown, and its place in the page that explains it. The lines contain the verdicts.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context as _, Result};

use crate::figure::{Line, Verdict};
use crate::table::cells;

/// The first line of the table, by which it is found in the page.
const HEADER: &str = "| what | ours | yardstick | its | ratio | goal | |";

/// Returns all lines of all rows as one table.
pub fn markdown(rows: &[(String, Vec<Line>)]) -> String {
    let mut text = format!("{HEADER}\n| --- | --- | --- | --- | --- | --- | --- |\n");
    for line in rows.iter().flat_map(|(_, lines)| lines) {
        let verdict = match line.verdict() {
            Verdict::Missed => "**missed**",
            Verdict::Met => "met",
            Verdict::ReportOnly => "",
        };
        let cells = cells(line).map(|cell| match cell.strip_suffix(" us") {
            _ if cell == "-" => String::new(),
            Some(number) => format!("{number} µs"),
            None => cell.replace('|', "\\|"),
        });
        let _ = writeln!(text, "| {} | {verdict} |", cells[..6].join(" | "));
    }
    text
}

/// Replaces the table of the page in a file.
///
/// # Errors
/// The file cannot be read or written, or has no table.
pub fn save(file: &Path, rows: &[(String, Vec<Line>)]) -> Result<()> {
    let page = fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))?;
    let page = replace_table(&page, &markdown(rows))
        .with_context(|| format!("{} has no table to replace", file.display()))?;
    fs::write(file, page).with_context(|| format!("cannot write {}", file.display()))
}

/// Returns the page with its table replaced, or `None` if it has no table.
pub fn replace_table(page: &str, table: &str) -> Option<String> {
    let (before, rest) = page.split_once(HEADER)?;
    // The old table ends before the first line that is not a row.
    let after = rest.split_inclusive('\n').skip(1);
    let after: String = after.skip_while(|line| line.starts_with('|')).collect();
    Some(format!("{before}{table}{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::{Figure, Goal};

    fn rows() -> Vec<(String, Vec<Line>)> {
        let lines = vec![
            Line::compared(
                "a",
                Figure::Time(5e3),
                "theirs",
                Figure::Time(1e3),
                Goal::AtMost(2.0),
            ),
            Line::new("b", Figure::Count(3.0), Goal::ReportOnly),
        ];
        vec![(String::from("row"), lines)]
    }

    #[test]
    fn each_line_is_a_row_and_missed_goals_are_marked() {
        let expected = "\
| what | ours | yardstick | its | ratio | goal | |
| --- | --- | --- | --- | --- | --- | --- |
| a | 5.00 µs | theirs | 1.00 µs | 5.00 | at most 2x | **missed** |
| b | 3 |  |  |  |  |  |
";
        assert_eq!(markdown(&rows()), expected);
    }

    #[test]
    fn only_the_table_of_a_page_is_replaced() {
        let page = format!("# Before\n\n{HEADER}\n| --- |\n| old |\n\nAfter.\n\n| another |\n");
        let table = markdown(&rows());
        let replaced = replace_table(&page, &table).unwrap();
        assert_eq!(replaced, format!("# Before\n\n{table}\nAfter.\n\n| another |\n"));
        assert_eq!(
            replace_table(&replaced, &table).as_ref(),
            Some(&replaced),
            "the table must be found again"
        );
        assert_eq!(replace_table("| another |\n", &table), None);
    }
}
