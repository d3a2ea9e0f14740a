//! Columns of text, as wide as what is in them; right for numbers, left for words. Knows no colours of its own.

use std::io::{self, Write};

use anstyle::Style;

use crate::terminal::FAINT;
use crate::visible::visible;

/// Where a column's text stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// Words.
    Left,
    /// Numbers.
    Right,
}

/// A text in a table, and how it looks.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cell {
    text: String,
    style: Style,
}

/// Rows below titles.
pub(crate) struct Table {
    titles: Vec<(&'static str, Side)>,
    rows: Vec<Vec<Cell>>,
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
            // As wide as it is shown.
            text: visible(&text.to_string()),
            style: Style::new(),
        }
    }
}

impl Table {
    /// An empty one.
    pub(crate) fn new(titles: impl IntoIterator<Item = (&'static str, Side)>) -> Self {
        Self {
            titles: titles.into_iter().collect(),
            rows: Vec::new(),
        }
    }

    /// Adds a row; a short one leaves its last columns empty.
    pub(crate) fn row(&mut self, cells: impl IntoIterator<Item = Cell>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// Writes it, without the columns in which no row has anything.
    ///
    /// # Errors
    /// It cannot be written.
    pub(crate) fn tell(&self, words: &mut dyn Write) -> io::Result<()> {
        // Nothing for a column that is left out; titles alone say what there could be.
        let widths: Vec<Option<usize>> = (0..self.titles.len())
            .map(|column| {
                let cells = self.rows.iter().filter_map(|row| row.get(column));
                let widest = cells.map(|cell| columns(&cell.text)).max()?;
                (widest > 0).then(|| widest.max(columns(self.titles[column].0)))
            })
            .collect();
        let titles: Vec<Cell> = self
            .titles
            .iter()
            .map(|(title, _)| Cell::from(title).styled(FAINT))
            .collect();
        for row in std::iter::once(&titles).chain(&self.rows) {
            let mut gap = 0;
            for ((cell, width), (_, side)) in row.iter().zip(&widths).zip(&self.titles) {
                let Some(width) = width.or_else(|| self.rows.is_empty().then(|| columns(&cell.text))) else {
                    continue;
                };
                let Cell { text, style } = cell;
                let room = width - columns(text);
                let (before, after) = match side {
                    Side::Left => (0, room),
                    Side::Right => (room, 0),
                };
                if !text.is_empty() {
                    // Spaces are written only before something, so that no line ends in them.
                    write!(words, "{}{style}{text}{style:#}", " ".repeat(gap + before))?;
                    gap = after + 2;
                } else {
                    gap += width + 2;
                }
            }
            writeln!(words)?;
        }
        Ok(())
    }
}

/// Columns of a terminal that a text takes.
fn columns(text: &str) -> usize {
    ratatui::text::Span::raw(text).width()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(table: &Table) -> String {
        let mut text = Vec::new();
        table.tell(&mut text).unwrap();
        anstream::adapter::strip_str(&String::from_utf8(text).unwrap()).to_string()
    }

    #[test]
    fn columns_that_no_row_fills_are_left_out() {
        let mut table = Table::new([("name", Side::Left), ("note", Side::Left), ("rate", Side::Right)]);
        assert_eq!(text(&table), "name  note  rate\n");
        table.row(["laser".into(), "".into(), 20.into()]);
        assert_eq!(text(&table), "name   rate\nlaser    20\n");
    }

    #[test]
    fn numbers_stand_right_words_left_and_no_line_ends_in_spaces() {
        let mut table = Table::new([("name", Side::Left), ("rate", Side::Right), ("note", Side::Left)]);
        table.row(["pioneer.laser".into(), 20.into(), "fresh".into()]);
        table.row(["走行".into(), Cell::from("0.5").styled(FAINT)]);
        let expected = "\
name           rate  note
pioneer.laser    20  fresh
走行            0.5
";
        assert_eq!(text(&table), expected);
    }
}
