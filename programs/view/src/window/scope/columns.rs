//! The columns of the table right of the names: their titles, and which of them fit.

/// A column right of the name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Column {
    State,
    Health,
    Period,
    Measured,
    Load,
    Overruns,
}

/// The columns by importance: a narrow table has only the first ones.
const IMPORTANCE: [Column; 6] = [
    Column::State,
    Column::Period,
    Column::Measured,
    Column::Load,
    Column::Health,
    Column::Overruns,
];

impl Column {
    pub(super) fn width(self) -> f32 {
        match self {
            Self::State => 86.0,
            Self::Health => 64.0,
            Self::Period | Self::Measured => 62.0,
            Self::Load => 46.0,
            Self::Overruns => 44.0,
        }
    }

    pub(super) fn title(self) -> (&'static str, &'static str) {
        match self {
            Self::State => (
                "state",
                "SLEPT: it does not run; CHECKING: its precondition is false; READY: its precondition is true, but another \
                 was chosen; WINNER, or running where none compete: it iterates. A diamond: it has authority (R7).",
            ),
            Self::Health => ("health", "Whether it meets its deadlines, or why it cannot run."),
            Self::Period => (
                "period",
                "The configured period. Click it to enter another one: 50ms or 20Hz.",
            ),
            Self::Measured => ("measured", "The measured period."),
            Self::Load => ("load", "Share of one processor core."),
            Self::Overruns => ("late", "Deadlines missed and budgets passed."),
        }
    }
}

/// The most important columns that fit into `width`, from left to right, each with its left edge. The last
/// ends at `end`.
pub(super) fn fitting(mut width: f32, mut end: f32) -> Vec<(Column, f32)> {
    let mut fitting: Vec<_> = IMPORTANCE
        .into_iter()
        .filter(|column| {
            let fits = column.width() <= width;
            width -= if fits { column.width() } else { 0.0 };
            fits
        })
        .collect();
    fitting.sort_unstable();
    let positioned = fitting.into_iter().rev().map(|column| {
        end -= column.width();
        (column, end)
    });
    let mut columns: Vec<_> = positioned.collect();
    columns.reverse();
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_narrow_table_keeps_the_most_important_columns_in_order() {
        let all = fitting(1000.0, 500.0);
        assert_eq!(all.len(), IMPORTANCE.len());
        assert!(all.is_sorted_by(|one, next| one.0 < next.0 && one.1 + one.0.width() == next.1));
        let narrow = IMPORTANCE[0].width() + IMPORTANCE[1].width();
        let kept: Vec<_> = fitting(narrow, narrow)
            .into_iter()
            .map(|(column, _)| column)
            .collect();
        assert_eq!(kept, [Column::State, Column::Period]);
        let kept: Vec<_> = fitting(90.0, 90.0)
            .into_iter()
            .map(|(column, _)| column)
            .collect();
        assert_eq!(kept, [Column::State], "the state fits where nothing else does");
        assert!(fitting(10.0, 10.0).is_empty());
    }
}
