//! The table in Markdown, and its place in the page that explains it. Judges nothing; the lines do.

use std::fmt::Write as _;

use crate::figure::{Line, Verdict};
use crate::table::cells;

/// The first line of the table, by which it is found in the page.
const HEAD: &str = "| what | ours | yardstick | its | ratio | goal | |";

/// Returns all lines of all rows as one table.
pub fn markdown(rows: &[(String, Vec<Line>)]) -> String {
    let mut text = format!("{HEAD}\n| --- | --- | --- | --- | --- | --- | --- |\n");
    for line in rows.iter().flat_map(|(_, lines)| lines) {
        let verdict = match line.verdict() {
            Verdict::Missed => "**missed**",
            Verdict::Met => "met",
            Verdict::Reported => "",
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

/// Returns the page with its table replaced, or `None` if it has no table.
pub fn put_into(page: &str, table: &str) -> Option<String> {
    let (before, rest) = page.split_once(HEAD)?;
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
            Line::beside(
                "a",
                Figure::Time(5e3),
                "theirs",
                Figure::Time(1e3),
                Goal::AtMost(2.0),
            ),
            Line::alone("b", Figure::Count(3.0), Goal::Reported),
        ];
        vec![(String::from("row"), lines)]
    }

    #[test]
    fn a_line_is_a_row_and_a_missed_goal_is_marked() {
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
        let page = format!("# Before\n\n{HEAD}\n| --- |\n| old |\n\nAfter.\n\n| another |\n");
        let table = markdown(&rows());
        let replaced = put_into(&page, &table).unwrap();
        assert_eq!(replaced, format!("# Before\n\n{table}\nAfter.\n\n| another |\n"));
        assert_eq!(
            put_into(&replaced, &table).as_ref(),
            Some(&replaced),
            "the table is not found again"
        );
        assert_eq!(put_into("| another |\n", &table), None);
    }
}
