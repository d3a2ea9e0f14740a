//! A table of text. Each column is as wide as its content; numbers are aligned right, words left. Defines no
//! colours.

use std::io::{self, Write};

use jde_session::top::text::{columns, cut};
use jde_terminal::escape::escape;
use jde_terminal::{FAINT, Style};

/// The space between two columns.
const COLUMN_GAP: usize = 2;

/// The alignment of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Alignment {
    /// Words.
    Left,
    /// Numbers.
    Right,
}

/// A text in a table, with its style.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cell {
    text: String,
    style: Style,
}

/// A table: titles above rows.
#[derive(Default)]
pub(crate) struct Table {
    titles: Vec<(Cell, Alignment)>,
    rows: Vec<Vec<Cell>>,
    indent: usize,
}

impl Cell {
    /// Adds a style.
    pub(crate) fn styled(mut self, style: Style) -> Self {
        self.style = style;
        self
    }
}

impl<T: ToString> From<T> for Cell {
    fn from(text: T) -> Self {
        Self {
            // Escape now, so that the width is that of the shown text.
            text: escape(&text.to_string()),
            style: Style::new(),
        }
    }
}

impl Table {
    /// Creates an empty table.
    pub(crate) fn new<T: ToString>(titles: impl IntoIterator<Item = (T, Alignment)>) -> Self {
        let titles = titles.into_iter();
        Self {
            titles: titles
                .map(|(title, alignment)| (Cell::from(title).styled(FAINT), alignment))
                .collect(),
            ..Self::default()
        }
    }

    /// Creates an empty table of texts without titles.
    pub(crate) fn untitled(columns: usize) -> Self {
        Self::new(std::iter::repeat_n(("", Alignment::Left), columns))
    }

    /// Indents every line by a number of columns of the terminal.
    pub(crate) fn indented(self, indent: usize) -> Self {
        Self { indent, ..self }
    }

    /// Adds a row; a short one leaves its last columns empty.
    pub(crate) fn add_row(&mut self, cells: impl IntoIterator<Item = Cell>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// Whether the table has no rows.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Cuts the texts of the last column to the columns of the terminal that `room` returns for the width of
    /// all other columns.
    pub(crate) fn cut_last(&mut self, room: impl FnOnce(usize) -> usize) {
        let last = self.titles.len() - 1;
        let others: usize = self.widths()[..last]
            .iter()
            .flatten()
            .map(|width| width + COLUMN_GAP)
            .sum();
        let room = room(self.indent + others);
        for cell in self.rows.iter_mut().filter_map(|row| row.get_mut(last)) {
            cell.text = cut(&cell.text, room);
        }
    }

    /// The width of each column; `None` for a column that is omitted. A table without rows shows all titles.
    fn widths(&self) -> Vec<Option<usize>> {
        (0..self.titles.len())
            .map(|column| {
                let cells = self.rows.iter().filter_map(|row| row.get(column));
                let widest = cells.map(|cell| columns(&cell.text)).max()?;
                (widest > 0).then(|| widest.max(columns(&self.titles[column].0.text)))
            })
            .collect()
    }

    /// Writes the table, without the columns that are empty in every row.
    ///
    /// # Errors
    /// The output cannot be written.
    pub(crate) fn write(&self, output: &mut dyn Write) -> io::Result<()> {
        let widths = self.widths();
        let titles: Vec<Cell> = self.titles.iter().map(|(title, _)| title.clone()).collect();
        let has_titles = titles.iter().any(|title| !title.text.is_empty());
        for row in has_titles.then_some(&titles).into_iter().chain(&self.rows) {
            let mut gap = self.indent;
            for ((cell, width), (_, alignment)) in row.iter().zip(&widths).zip(&self.titles) {
                let Some(width) = width.or_else(|| self.rows.is_empty().then(|| columns(&cell.text))) else {
                    continue;
                };
                let Cell { text, style } = cell;
                let room = width - columns(text);
                let (before, after) = match alignment {
                    Alignment::Left => (0, room),
                    Alignment::Right => (room, 0),
                };
                if !text.is_empty() {
                    // Write spaces only before text, so that no line ends in spaces.
                    write!(output, "{}{style}{text}{style:#}", " ".repeat(gap + before))?;
                    gap = after + COLUMN_GAP;
                } else {
                    gap += width + COLUMN_GAP;
                }
            }
            writeln!(output)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(table: &Table) -> String {
        let mut text = Vec::new();
        table.write(&mut text).unwrap();
        jde_terminal::escape::without_styles(&String::from_utf8(text).unwrap())
    }

    #[test]
    fn columns_that_are_empty_in_every_row_are_omitted() {
        let mut table = Table::new([
            ("name", Alignment::Left),
            ("note", Alignment::Left),
            ("rate", Alignment::Right),
        ]);
        assert_eq!(text(&table), "name  note  rate\n");
        table.add_row(["laser".into(), "".into(), 20.into()]);
        assert_eq!(text(&table), "name   rate\nlaser    20\n");
    }

    #[test]
    fn numbers_are_aligned_right_words_left_and_no_line_ends_in_spaces() {
        let mut table = Table::new([
            ("name", Alignment::Left),
            ("rate", Alignment::Right),
            ("note", Alignment::Left),
        ]);
        table.add_row(["pioneer.laser".into(), 20.into(), "fresh".into()]);
        table.add_row(["走行".into(), Cell::from("0.5").styled(FAINT)]);
        let expected = "\
name           rate  note
pioneer.laser    20  fresh
走行            0.5
";
        assert_eq!(text(&table), expected);
        table.cut_last(|others| 24 - others);
        let expected = expected.replace("fresh", "fr…");
        assert_eq!(text(&table), expected);
    }
}
