//! One selection with its record, in groups of several sizes: after the winner's iteration, and after another
//! candidate became ready or stopped being ready.

use anyhow::Result;
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::interleave;
use jde_paths::Level;

use crate::scope::Scope;

/// The numbers of options, and the time of `arbitration_graphs` 0.6 for each, ns.
const OPTIONS: [(u32, f64); 3] = [(3, 85.0), (100, 420.0), (1000, 3500.0)];
/// The time that BehaviorTree.CPP 4 takes for each leaf that is ticked, ns.
const LEAF: f64 = 135.0;

pub(crate) fn run(scope: &Scope) -> Result<Vec<Line>> {
    let mut lines = Vec::new();
    for (count, options) in OPTIONS {
        let mut iterated = Level::new(count)?;
        let mut last = Level::of_the_last(count)?;
        let mut changed = Level::new(count)?;
        let [first_acts, last_acts, last_changes] = interleave(
            scope.effort(),
            [
                &mut |times| (0..times).for_each(|_| iterated.iterate()),
                &mut |times| (0..times).for_each(|_| last.iterate()),
                &mut |times| (0..times).for_each(|_| changed.change()),
            ],
        );
        // A tree is ticked up to the first leaf that can act, hence the number of leaves.
        for (what, ours, leaves) in [
            ("all ready, the winner iterated", &first_acts, 1),
            ("only the last ready, it iterated", &last_acts, count),
            ("all ready, the last changes", &last_changes, 1),
        ] {
            for (name, theirs) in [
                (String::from("arbitration_graphs"), options),
                (
                    format!("BehaviorTree.CPP, {LEAF} ns for each of {leaves}"),
                    f64::from(leaves) * LEAF,
                ),
            ] {
                lines.push(Line::compared_with_given(
                    format!("selection among {count}, {what}"),
                    Figure::Time(ours.median()),
                    name,
                    Figure::Time(theirs),
                    Goal::TimesFaster(1.0),
                ));
            }
        }
    }
    Ok(lines)
}
