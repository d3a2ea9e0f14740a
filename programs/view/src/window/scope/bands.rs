//! States over time as columns of the screen. A lasting state is a bar whose height is its activity. A column
//! with changes extends from the least to the most active state in it, so that no change is lost at any zoom.

use eframe::egui::{Color32, Mesh, Rangef, Rect, pos2};
use jde_core::State;
use jde_timeline::Track;

use super::axis::Scale;
use crate::style::{self, Style};

/// Number of intervals examined at the beginning and at the end of a column.
const EXAMINED_INTERVALS: usize = 12;

/// Consecutive columns of the same appearance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ColumnRun {
    /// The first column.
    pub(super) from: usize,
    /// The column after the last.
    pub(super) to: usize,
    /// The least active state in each column.
    pub(super) low: State,
    /// The most active state in each column.
    pub(super) high: State,
    /// Whether each column has more than one change.
    pub(super) many: bool,
}

/// The intervals of a schema as runs of columns. Times before the first interval and after `now` are omitted.
///
/// The cost is the number of columns times the logarithm of the intervals in each, not the number of
/// intervals.
pub(super) fn runs(bands: &Track<State>, scale: &Scale, columns: usize, now: f64, runs: &mut Vec<ColumnRun>) {
    runs.clear();
    let Some(first) = bands.get(0) else { return };
    if columns == 0 {
        return;
    }
    let width = (scale.to - scale.from) / columns as f64;
    let column_of = |time: f64| ((time - scale.from) / width).floor().clamp(0.0, columns as f64) as usize;
    let end = if now >= scale.to { columns } else { column_of(now) };
    let mut column = column_of(first.from_s());
    let mut band = bands.partition_point(|band| band.from_s() <= scale.from + column as f64 * width);
    band = band.saturating_sub(1);
    while column < end {
        // The next interval begins with this column.
        if bands
            .get(band + 1)
            .is_some_and(|next| next.from_s() <= scale.from + column as f64 * width)
        {
            band += 1;
        }
        let column_end = scale.from + (column + 1) as f64 * width;
        let next = bands.get(band + 1).map_or(f64::INFINITY, |next| next.from_s());
        let Some(state) = bands.get(band).map(|band| band.value) else {
            return;
        };
        if next >= column_end {
            let to = column_of(next).clamp(column + 1, end);
            push(
                runs,
                ColumnRun {
                    from: column,
                    to,
                    low: state,
                    high: state,
                    many: false,
                },
            );
            column = to;
            continue;
        }
        let last = last_before(bands, band, column_end);
        let near = (band + EXAMINED_INTERVALS).min(last);
        let far = last.saturating_sub(EXAMINED_INTERVALS).max(near);
        let (mut low, mut high) = (state, state);
        for state in (band..=near)
            .chain(far..=last)
            .filter_map(|place| Some(bands.get(place)?.value))
        {
            if level(state) < level(low) {
                low = state;
            }
            if level(state) > level(high) {
                high = state;
            }
            // The range is already complete.
            if (low, high) == (State::Slept, State::Winner) {
                break;
            }
        }
        push(
            runs,
            ColumnRun {
                from: column,
                to: column + 1,
                low,
                high,
                many: last > band + 1,
            },
        );
        (column, band) = (column + 1, last);
    }
}

/// The last interval that begins before a time, starting at one that does: by doubling, then halving steps.
fn last_before(bands: &Track<State>, from: usize, end: f64) -> usize {
    let begins = |place: usize| bands.get(place).is_some_and(|band| band.from_s() < end);
    let (mut low, mut step) = (from, 1);
    while begins(low + step) {
        low += step;
        step *= 2;
    }
    while step > 0 {
        if begins(low + step) {
            low += step;
        }
        step /= 2;
    }
    low
}

fn push(runs: &mut Vec<ColumnRun>, run: ColumnRun) {
    match runs.last_mut() {
        Some(last)
            if last.to == run.from
                && (last.low, last.high, last.many) == (run.low, run.high, run.many)
                && (run.many || run.low == run.high) =>
        {
            last.to = run.to;
        }
        _ => runs.push(run),
    }
}

/// The activity of a state.
pub(super) fn level(state: State) -> u8 {
    match state {
        State::Slept => 0,
        State::Checking => 1,
        State::Ready => 2,
        State::Winner => 3,
    }
}

/// Height of a state's bar, as a fraction of the row.
fn height(state: State) -> f32 {
    match state {
        State::Slept => 0.1,
        State::Checking => 0.34,
        State::Ready => 0.64,
        State::Winner => 1.0,
    }
}

/// Draws runs into a row: columns of `step` points from its left edge.
pub(super) fn draw(mesh: &mut Mesh, runs: &[ColumnRun], row: Rect, step: f32, style: &Style) {
    let bar = |mesh: &mut Mesh, x: Rangef, state: State, color: Color32| {
        let top = row.bottom() - row.height() * height(state);
        let rect = Rect::from_min_max(pos2(x.min, top), pos2(x.max, row.bottom()));
        mesh.add_colored_rect(rect, color);
    };
    for run in runs {
        let x = Rangef::new(
            row.left() + run.from as f32 * step,
            row.left() + run.to as f32 * step,
        );
        let high = style::state(run.high, style);
        if run.many {
            // The changes are denser than visible: the most active state is drawn translucent.
            bar(mesh, x, run.high, high.gamma_multiply(0.7));
        } else {
            bar(mesh, x, run.high, high);
        }
        if run.low != run.high {
            bar(mesh, x, run.low, style::state(run.low, style));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bands(list: &[(f64, State)]) -> Track<State> {
        list.iter()
            .map(|&(from, state)| ((from * 1e9).round() as u64, state))
            .collect()
    }

    fn runs_of(list: &[(f64, State)], from: f64, to: f64, columns: usize, now: f64) -> Vec<ColumnRun> {
        let x = Rangef::new(0.0, columns as f32);
        let mut found = Vec::new();
        runs(&bands(list), &Scale { from, to, x }, columns, now, &mut found);
        found
    }

    fn run(from: usize, to: usize, low: State, high: State, many: bool) -> ColumnRun {
        ColumnRun {
            from,
            to,
            low,
            high,
            many,
        }
    }

    #[test]
    fn a_lasting_state_is_one_run_from_its_beginning_to_its_end() {
        use State::{Checking, Slept, Winner};
        let list = [(0.0, Slept), (2.0, Checking), (5.0, Winner)];
        assert_eq!(
            runs_of(&list, 0.0, 10.0, 10, 8.0),
            [
                run(0, 2, Slept, Slept, false),
                run(2, 5, Checking, Checking, false),
                run(5, 8, Winner, Winner, false)
            ]
        );
        assert_eq!(
            runs_of(&list, 6.0, 7.0, 10, 8.0),
            [run(0, 10, Winner, Winner, false)]
        );
        assert_eq!(
            runs_of(&list[1..], -10.0, 10.0, 20, 8.0)[0],
            run(12, 15, Checking, Checking, false)
        );
    }

    #[test]
    fn a_column_with_changes_extends_over_its_states_and_marks_several_changes() {
        use State::{Checking, Ready, Winner};
        let list = [
            (0.0, Checking),
            (2.5, Ready),
            (5.1, Winner),
            (5.2, Checking),
            (5.3, Ready),
        ];
        assert_eq!(
            runs_of(&list, 0.0, 10.0, 10, 10.0),
            [
                run(0, 2, Checking, Checking, false),
                run(2, 3, Checking, Ready, false),
                run(3, 5, Ready, Ready, false),
                run(5, 6, Checking, Winner, true),
                run(6, 10, Ready, Ready, false)
            ]
        );
    }

    #[test]
    fn a_column_with_many_changes_extends_over_all_of_its_states() {
        let list: Vec<_> = (0..1000)
            .map(|place| {
                let state = if place % 2 == 0 {
                    State::Checking
                } else {
                    State::Ready
                };
                (f64::from(place) * 0.01, state)
            })
            .collect();
        let all = runs_of(&list, 0.0, 10.0, 5, 10.0);
        assert_eq!(all, [run(0, 5, State::Checking, State::Ready, true)]);
    }
}
