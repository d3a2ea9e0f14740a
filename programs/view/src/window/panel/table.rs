//! Tables of a panel. Only the visible rows are laid out. A click on a heading sorts by its column; numbers
//! are sorted by value.

use std::cmp::Ordering;

use eframe::egui::{Label, RichText, Sense, Shape, Stroke, TextWrapMode, Ui, pos2, vec2};
use egui_extras::{Column, TableBuilder};

/// How a table is sorted.
#[derive(Default)]
pub(super) struct Sorted {
    by: Option<(usize, SortOrder)>,
    /// The indices of the rows in the order shown. `of` has the list's serial number and the sort that it is
    /// for.
    order: Vec<usize>,
    of: Option<(u64, Option<(usize, SortOrder)>)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SortOrder {
    Up,
    Down,
}

impl SortOrder {
    /// Draws a triangle that points towards the greater values.
    fn paint(self, ui: &mut Ui) {
        let (rect, _) = ui.allocate_exact_size(vec2(8.0, 8.0), Sense::hover());
        let (top, bottom) = match self {
            Self::Up => (rect.bottom(), rect.top()),
            Self::Down => (rect.top(), rect.bottom()),
        };
        let corners = vec![
            pos2(rect.left(), top),
            pos2(rect.right(), top),
            pos2(rect.center().x, bottom),
        ];
        let color = ui.visuals().text_color();
        ui.painter()
            .add(Shape::convex_polygon(corners, color, Stroke::NONE));
    }
}

impl Sorted {
    /// Computes the order of the rows of a list, unless it is up to date.
    pub(super) fn sort(&mut self, serial: u64, rows: &[Vec<String>]) {
        if self.of == Some((serial, self.by)) {
            return;
        }
        self.of = Some((serial, self.by));
        self.order = (0..rows.len()).collect();
        if let Some((column, order)) = self.by {
            let text = |row: &usize| rows[*row].get(column).map_or("", String::as_str);
            self.order.sort_by(|one, other| {
                let ascending = natural(text(one), text(other));
                match order {
                    SortOrder::Up => ascending,
                    SortOrder::Down => ascending.reverse(),
                }
            });
        }
    }

    /// Cycles a column: ascending, descending, unsorted.
    fn next(&mut self, column: usize) {
        self.by = match self.by {
            Some((by, SortOrder::Up)) if by == column => Some((column, SortOrder::Down)),
            Some((by, SortOrder::Down)) if by == column => None,
            _ => Some((column, SortOrder::Up)),
        };
    }
}

/// Shows the table.
pub(super) fn show(
    ui: &mut Ui,
    height: f32,
    id: &str,
    columns: &[String],
    rows: &[Vec<String>],
    sorted: &mut Sorted,
) {
    let line = ui.text_style_height(&eframe::egui::TextStyle::Body) + 2.0;
    let size = vec2(ui.available_width(), height);
    ui.allocate_ui(size, |ui| {
        ui.set_min_size(size);
        ui.style_mut().wrap_mode = Some(TextWrapMode::Truncate);
        TableBuilder::new(ui)
            .id_salt(id)
            .striped(true)
            .resizable(true)
            .auto_shrink(false)
            .max_scroll_height(height - 2.0 * line)
            .columns(Column::remainder().at_least(30.0).clip(true), columns.len())
            .header(line, |mut header| {
                for (column, name) in columns.iter().enumerate() {
                    header.col(|ui| {
                        let title = RichText::new(name).strong();
                        let title = ui.add(Label::new(title).sense(Sense::click()).selectable(false));
                        if let Some((by, order)) = sorted.by
                            && by == column
                        {
                            order.paint(ui);
                        }
                        if title.on_hover_text("Sort by this").clicked() {
                            sorted.next(column);
                        }
                    });
                }
            })
            .body(|body| {
                body.rows(line, sorted.order.len(), |mut row| {
                    let texts = sorted.order.get(row.index()).and_then(|number| rows.get(*number));
                    for text in texts.into_iter().flatten() {
                        row.col(|ui| drop(ui.label(text)));
                    }
                });
            });
    });
}

/// Orders numbers by value and before texts, and texts alphabetically.
fn natural(one: &str, other: &str) -> Ordering {
    // "0.40 m" counts as a number.
    let number = |text: &str| {
        let head = text.split_whitespace().next().unwrap_or_default();
        head.parse::<f64>().ok().filter(|number| !number.is_nan())
    };
    match (number(one), number(other)) {
        (Some(a), Some(b)) => a.total_cmp(&b).then_with(|| one.cmp(other)),
        (Some(_), None) => Ordering::Less,
        (None, Some(_)) => Ordering::Greater,
        (None, None) => one.cmp(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_sorted_by_value_and_before_texts() {
        let rows: Vec<_> = ["10 m", "goon", "9 m", "-3", "avoid"]
            .map(|text| vec![text.to_owned()])
            .into();
        let mut sorted = Sorted::default();
        let shown = |sorted: &mut Sorted| {
            sorted.sort(1, &rows);
            sorted
                .order
                .iter()
                .map(|row| rows[*row][0].clone())
                .collect::<Vec<_>>()
        };
        assert_eq!(shown(&mut sorted), ["10 m", "goon", "9 m", "-3", "avoid"]);
        sorted.next(0);
        assert_eq!(shown(&mut sorted), ["-3", "9 m", "10 m", "avoid", "goon"]);
        sorted.next(0);
        assert_eq!(shown(&mut sorted), ["goon", "avoid", "10 m", "9 m", "-3"]);
        sorted.next(0);
        assert_eq!(shown(&mut sorted), ["10 m", "goon", "9 m", "-3", "avoid"]);
    }
}
