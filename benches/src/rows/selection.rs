//! One selection with its record, in a group of so many candidates: what a winner's iteration leads to, and what it takes when
//! another candidate has become ready or is no longer.

use anyhow::Result;
use jde_measure::figure::{Figure, Goal, Line};
use jde_measure::pairs::interleave;
use jde_paths::Level;

use crate::scope::Scope;

/// What others take for so many options and leaves, ns.
struct Others {
    candidates: u32,
    arbitration_graphs: f64,
    behavior_tree: f64,
}

/// `arbitration_graphs` 0.6 and BehaviorTree.CPP 4, each leaf 135 ns.
const OTHERS: [Others; 3] = [
    Others {
        candidates: 3,
        arbitration_graphs: 85.0,
        behavior_tree: 3.0 * 135.0,
    },
    Others {
        candidates: 100,
        arbitration_graphs: 420.0,
        behavior_tree: 100.0 * 135.0,
    },
    Others {
        candidates: 1000,
        arbitration_graphs: 3500.0,
        behavior_tree: 1000.0 * 135.0,
    },
];

pub(crate) fn run(scope: &Scope) -> Result<Vec<Line>> {
    let mut lines = Vec::new();
    for others in OTHERS {
        let count = others.candidates;
        let mut iterated = Level::new(count)?;
        let mut changed = Level::new(count)?;
        let [after_iteration, after_change] = interleave(
            scope.effort(),
            [
                &mut |times| (0..times).for_each(|_| iterated.iterate()),
                &mut |times| (0..times).for_each(|_| changed.change()),
            ],
        );
        for (what, ours) in [
            ("the winner iterated", &after_iteration),
            ("one changed", &after_change),
        ] {
            for (name, theirs) in [
                ("arbitration_graphs", others.arbitration_graphs),
                ("BehaviorTree.CPP", others.behavior_tree),
            ] {
                lines.push(Line::given(
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
