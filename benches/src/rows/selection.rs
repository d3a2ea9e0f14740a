//! One selection with its record, in a group of so many candidates: what a winner's iteration leads to, and what it takes when
//! another candidate has become ready or is no longer.

use std::hint::black_box;

use anyhow::{Result, anyhow};
use jde_core::{Check, Effect, GroupSpec, Hierarchy, Kind, SchemaId, SchemaSpec, Spec};

use crate::figure::{Figure, Goal, Line};
use crate::pairs::interleave;
use crate::scope::Scope;

const MS: u64 = 1_000_000;

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

/// A group of candidates, all ready; the first wins.
pub(crate) struct Level {
    hierarchy: Hierarchy,
    effects: Vec<Effect>,
    time: u64,
    /// Whose readiness changes: the last.
    last: SchemaId,
    ready: bool,
}

impl Level {
    pub(crate) fn new(candidates: u32) -> Result<Self> {
        let schemas = (0..candidates).map(|number| SchemaSpec::new(format!("s{number}"), Kind::Motor, 100 * MS));
        let spec = Spec {
            schemas: schemas.collect(),
            groups: vec![GroupSpec::new("roots", None, (0..candidates).map(SchemaId).collect())],
        };
        let hierarchy = Hierarchy::new(spec).map_err(|faults| anyhow!("{faults:?}"))?;
        let mut level = Self {
            hierarchy,
            effects: Vec::new(),
            time: 0,
            last: SchemaId(candidates - 1),
            ready: true,
        };
        level.hierarchy.start(0, &mut level.effects);
        for number in 0..candidates {
            level.check(SchemaId(number), true);
        }
        level.effects.clear();
        Ok(level)
    }

    /// The winner iterates once, and competes again.
    pub(crate) fn iterate(&mut self) {
        self.time += MS;
        let may = self.hierarchy.begin(self.time, SchemaId(0), &mut self.effects);
        assert!(may, "the winner may iterate");
        self.hierarchy.end(self.time, SchemaId(0), &mut self.effects);
        self.told();
    }

    /// The last candidate is ready, or is no longer.
    pub(crate) fn change(&mut self) {
        self.time += MS;
        self.ready = !self.ready;
        self.check(self.last, self.ready);
        self.told();
    }

    fn check(&mut self, id: SchemaId, ready: bool) {
        let check = Check {
            ready,
            urgency: 0.0,
            cause: self.time,
        };
        self.hierarchy.checked(self.time, id, check, &mut self.effects);
    }

    /// There was a record, which whoever wanted it has seen.
    fn told(&mut self) {
        let told = black_box(&self.effects).iter().any(|it| matches!(it, Effect::Decided(_)));
        assert!(told, "each selection leaves a record");
        self.effects.clear();
    }
}
