//! The columns of the table right of the names: their titles, and which of them fit.

use super::cells;

/// A column right of the name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Column {
    State,
    Health,
    Period,
    Measured,
    Load,
    Overruns,
    Buttons,
}

/// The columns by importance: a narrow table has only the first ones.
const IMPORTANCE: [Column; 7] = [
    Column::Buttons,
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
            Self::Buttons => 5.0 * cells::BUTTON + 4.0,
        }
    }

    pub(super) fn title(self) -> (&'static str, &'static str) {
        match self {
            Self::State => (
                "state",
                "SLEPT costs nothing; CHECKING: its precondition is false; READY: it could act, another was chosen; WINNER: it \
                 iterates. A diamond: what it commands counts (R7).",
            ),
            Self::Health => ("health", "Whether it keeps its deadlines, or why it cannot run."),
            Self::Period => (
                "period",
                "The cycle time asked for. Click one to type another: 50ms or 20Hz.",
            ),
            Self::Measured => ("measured", "The cycle time as it is."),
            Self::Load => ("load", "Share of one processor core."),
            Self::Overruns => ("late", "Deadlines missed and budgets passed."),
            Self::Buttons => (
                "operate",
                "Play, stop, force to win, let go of it, open its panel.",
            ),
        }
    }
}

/// The most important columns that fit into `room`, from left to right, each with its left edge. The last
/// ends at `end`.
pub(super) fn fitting(mut room: f32, mut end: f32) -> Vec<(Column, f32)> {
    let mut fitting: Vec<_> = IMPORTANCE
        .into_iter()
        .filter(|column| {
            let fits = column.width() <= room;
            room -= if fits { column.width() } else { 0.0 };
            fits
        })
        .collect();
    fitting.sort_unstable();
    let places = fitting.into_iter().rev().map(|column| {
        end -= column.width();
        (column, end)
    });
    let mut columns: Vec<_> = places.collect();
    columns.reverse();
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_there_is_little_room_the_most_important_columns_stay_in_their_order() {
        let all = fitting(1000.0, 500.0);
        assert_eq!(all.len(), IMPORTANCE.len());
        assert!(all.is_sorted_by(|one, next| one.0 < next.0 && one.1 + one.0.width() == next.1));
        let few = IMPORTANCE[0].width() + IMPORTANCE[1].width();
        let kept: Vec<_> = fitting(few, few).into_iter().map(|(column, _)| column).collect();
        assert_eq!(kept, [Column::State, Column::Buttons]);
        let kept: Vec<_> = fitting(90.0, 90.0)
            .into_iter()
            .map(|(column, _)| column)
            .collect();
        assert_eq!(kept, [Column::State], "it fits where the buttons do not");
        assert!(fitting(10.0, 10.0).is_empty());
    }
}
