//! Prints the documentation that plugins carry: each paragraph is a line, and a table in Markdown is aligned.

use std::io::{self, Write};

use crate::remote::table::{Alignment, Table};

/// Writes a documentation.
///
/// # Errors
/// The output cannot be written.
pub(super) fn write(doc: &str, output: &mut dyn Write) -> io::Result<()> {
    let mut lines = doc.lines().map(str::trim).peekable();
    while let Some(line) = lines.next() {
        if line.is_empty() {
            continue;
        }
        let is_row = |line: &str| line.starts_with('|');
        let mut block = vec![line];
        let in_block =
            |next: &&str| !next.is_empty() && !next.starts_with("- ") && is_row(next) == is_row(line);
        while let Some(next) = lines.next_if(in_block) {
            block.push(next);
        }
        if is_row(line) {
            table(&block).write(output)?;
        } else {
            writeln!(output, "{}", block.join(" "))?;
        }
    }
    Ok(())
}

/// Joins the lines of a documentation.
pub(super) fn join_lines(doc: &str) -> String {
    doc.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Returns the first paragraph of a documentation as one line.
pub(crate) fn first_paragraph(doc: &str) -> String {
    let lines = doc.lines().map(str::trim).skip_while(|line| line.is_empty());
    lines
        .take_while(|line| !line.is_empty())
        .collect::<Vec<_>>()
        .join(" ")
}

/// The table of rows in Markdown, of which the first has the titles.
fn table(rows: &[&str]) -> Table {
    let split = |row: &str| -> Vec<String> {
        let row = row.trim_matches('|');
        row.split('|').map(|cell| cell.trim().to_owned()).collect()
    };
    let is_separator = |row: &&&str| row.chars().all(|letter| matches!(letter, '|' | '-' | ':' | ' '));
    let titles = rows.first().map(|row| split(row)).unwrap_or_default();
    let mut table = Table::new(titles.into_iter().map(|title| (title, Alignment::Left))).indented(2);
    for row in rows.iter().skip(1).filter(|row| !is_separator(row)) {
        table.add_row(split(row).into_iter().map(Into::into));
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOC: &str = "Leads through tasks,\neach a child.\n\n| task | due |\n|---|:--|\n| dock | at a low charge |\n\
                       | map | until closed |\n\n- one\n  goes on\n- two\nThe end.";

    #[test]
    fn a_paragraph_is_a_line_and_a_table_is_aligned() {
        let mut text = Vec::new();
        write(DOC, &mut text).unwrap();
        let expected = "\
Leads through tasks, each a child.
  task  due
  dock  at a low charge
  map   until closed
- one goes on
- two The end.
";
        assert_eq!(
            jde_terminal::escape::without_styles(&String::from_utf8(text).unwrap()),
            expected
        );
    }

    #[test]
    fn the_first_paragraph_ends_at_an_empty_line() {
        assert_eq!(first_paragraph(DOC), "Leads through tasks, each a child.");
        assert_eq!(first_paragraph("\n One\ntwo."), "One two.");
        assert_eq!(first_paragraph(""), "");
    }
}
