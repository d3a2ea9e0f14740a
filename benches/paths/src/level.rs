//! A selection with its record, after an iteration of the winner or after a change of readiness.

use std::hint::black_box;

use anyhow::{Result, anyhow};
use jde_core::{Check, Effect, GroupSpec, Hierarchy, Kind, SchemaId, SchemaSpec, Spec};

const MS: u64 = 1_000_000;

/// A group of candidates. The first candidate that is ready wins.
pub struct Level {
    hierarchy: Hierarchy,
    effects: Vec<Effect>,
    time: u64,
    winner: SchemaId,
    /// The last candidate, whose readiness changes.
    last: SchemaId,
    ready: bool,
}

impl Level {
    /// Makes a group in which all candidates are ready: the first wins.
    ///
    /// # Errors
    /// If the rules refuse the group. A retry fails too.
    pub fn new(candidates: u32) -> Result<Self> {
        Self::of(candidates, 0)
    }

    /// Makes a group in which only the last candidate is ready.
    ///
    /// # Errors
    /// If the rules refuse the group. A retry fails too.
    pub fn of_the_last(candidates: u32) -> Result<Self> {
        Self::of(candidates, candidates - 1)
    }

    /// Makes a group in which all candidates from `winner` on are ready.
    fn of(candidates: u32, winner: u32) -> Result<Self> {
        let schemas =
            (0..candidates).map(|number| SchemaSpec::new(format!("s{number}"), Kind::Motor, 100 * MS));
        let spec = Spec {
            schemas: schemas.collect(),
            groups: vec![GroupSpec::new(
                "roots",
                None,
                (0..candidates).map(SchemaId).collect(),
            )]
            .into(),
        };
        let hierarchy = Hierarchy::new(spec).map_err(|faults| anyhow!("{faults:?}"))?;
        let mut level = Self {
            hierarchy,
            effects: Vec::new(),
            time: 0,
            winner: SchemaId(winner),
            last: SchemaId(candidates - 1),
            ready: true,
        };
        level.hierarchy.at(0, &mut level.effects).start();
        for number in 0..candidates {
            level.check(SchemaId(number), number >= winner);
        }
        level.effects.clear();
        Ok(level)
    }

    /// The winner iterates once and competes again.
    ///
    /// # Panics
    /// If the rules do not permit the iteration, or leave no record.
    pub fn iterate(&mut self) {
        self.time += MS;
        let permitted = self.hierarchy.at(self.time, &mut self.effects).begin(self.winner);
        assert!(permitted, "the winner must be permitted to iterate");
        self.hierarchy.at(self.time, &mut self.effects).end(self.winner);
        self.check_record();
    }

    /// The last candidate becomes ready, or stops being ready.
    ///
    /// # Panics
    /// If the rules leave no record.
    pub fn change(&mut self) {
        self.time += MS;
        self.ready = !self.ready;
        self.check(self.last, self.ready);
        self.check_record();
    }

    fn check(&mut self, id: SchemaId, ready: bool) {
        let check = Check {
            ready,
            urgency: 0.0,
            cause: self.time,
        };
        self.hierarchy.at(self.time, &mut self.effects).checked(id, check);
    }

    /// Checks that the selection left a record, and discards all effects.
    fn check_record(&mut self) {
        let recorded = black_box(&self.effects)
            .iter()
            .any(|effect| matches!(effect, Effect::Decided(_)));
        assert!(recorded, "each selection leaves a record");
        self.effects.clear();
    }
}
