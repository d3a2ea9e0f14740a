//! The columns of the list: which of them fit a width, and what each shows of a schema.
//!
//! The name and the strip are always shown. This module chooses the columns in between.

use jde_core::State;
use jde_records::snapshot::{Hold, SchemaView};
use jde_timeline::{health_word, state_word};
use ratatui::style::Style;

use crate::top::text;
use crate::top::theme::Theme;

/// A column between the name and the strip, in the order on the screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Column {
    Held,
    State,
    Health,
    Period,
    Measured,
    Load,
    Iterations,
    Overruns,
    Refused,
    Longest,
    Faults,
}

/// The order in which columns get room, each only if the strip keeps at least so many cells.
const PRIORITIES: [(Column, usize); 11] = [
    (Column::State, 4),
    (Column::Held, 4),
    (Column::Health, 12),
    (Column::Period, 12),
    (Column::Measured, 12),
    (Column::Load, 12),
    (Column::Overruns, 24),
    (Column::Iterations, 24),
    (Column::Refused, 30),
    (Column::Longest, 30),
    (Column::Faults, 30),
];

/// Returns the columns that fit beside a name of a width, in their order, and the cells left for the strip.
pub(super) fn plan(width: usize, name: usize) -> (Vec<Column>, usize) {
    let mut strip = width.saturating_sub(name + 1);
    let mut columns = Vec::new();
    for (column, least) in PRIORITIES {
        let Some(left) = strip
            .checked_sub(column.width() + 1)
            .filter(|left| *left >= least)
        else {
            break;
        };
        strip = left;
        columns.push(column);
    }
    columns.sort_unstable();
    (columns, strip)
}

impl Column {
    pub(super) fn width(self) -> usize {
        match self {
            Self::Held => 1,
            Self::Load => 4,
            Self::Faults => 6,
            Self::Health | Self::Period | Self::Refused => 7,
            Self::State | Self::Measured | Self::Overruns | Self::Longest => 8,
            Self::Iterations => 10,
        }
    }

    pub(super) fn title(self) -> &'static str {
        match self {
            Self::Held => "",
            Self::State => "state",
            Self::Health => "health",
            Self::Period => "period",
            Self::Measured => "measured",
            Self::Load => "load",
            Self::Iterations => "iterations",
            Self::Overruns => "overruns",
            Self::Refused => "refused",
            Self::Longest => "longest",
            Self::Faults => "faults",
        }
    }

    /// Whether the column contains words, which are aligned left. Numbers are aligned right.
    pub(super) fn is_text(self) -> bool {
        matches!(self, Self::Held | Self::State | Self::Health)
    }

    /// Returns the text of the column for a schema, and its style.
    pub(super) fn cell(self, schema: &SchemaView, paint: Theme) -> (String, Style) {
        let plain = if schema.state == State::Slept {
            paint.faint()
        } else {
            Style::new()
        };
        let counted = |count: u64| (count.to_string(), if count == 0 { paint.faint() } else { plain });
        match self {
            Self::Held => (
                schema.operator.as_ref().map_or_else(String::new, mark),
                paint.operator(),
            ),
            Self::State => (state_word(schema).to_owned(), paint.state(schema.state)),
            Self::Health => (
                health_word(&schema.health).to_owned(),
                paint.health(&schema.health),
            ),
            Self::Period => (text::format_setting(schema.period), plain),
            Self::Measured => (
                schema
                    .measured
                    .map_or_else(|| "-".to_owned(), text::format_duration),
                plain,
            ),
            Self::Load => (load(schema.load), plain),
            Self::Iterations => (schema.iterations.to_string(), plain),
            Self::Overruns => counted(schema.overruns),
            Self::Refused => counted(schema.refused),
            Self::Longest => (text::format_duration(schema.longest), plain),
            Self::Faults => counted(schema.faults),
        }
    }
}

/// Returns a share of time as a whole percentage. A share above 0 and below 1 % is `<1%`.
pub(super) fn load(share: f64) -> String {
    if share > 0.0 && share < 0.01 {
        "<1%".to_owned()
    } else {
        format!("{:.0}%", share * 100.0)
    }
}

/// The first letter of the first hold on a schema: Played, Stopped, Forced.
fn mark(held: &Hold) -> String {
    let word = held.kind.word().chars();
    word.take(1).flat_map(char::to_uppercase).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wider_list_has_more_columns_and_a_long_enough_strip() {
        let mut before = 0;
        for width in 20..300 {
            let (columns, strip) = plan(width, 14);
            let used: usize = columns.iter().map(|column| column.width() + 1).sum();
            assert_eq!(14 + 1 + used + strip, width);
            assert!(columns.len() >= before, "{width}");
            before = columns.len();
        }
        assert_eq!(before, PRIORITIES.len());
    }

    #[test]
    fn the_classic_terminal_shows_state_health_and_both_cycle_times() {
        let (columns, strip) = plan(80, 16);
        assert_eq!(columns.first(), Some(&Column::Held));
        assert_eq!(columns.last(), Some(&Column::Load));
        assert!(strip >= 16);
    }

    #[test]
    fn a_list_narrower_than_a_name_shows_only_names() {
        assert_eq!(plan(10, 14), (vec![], 0));
    }
}
