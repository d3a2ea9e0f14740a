//! What follows from a transaction: the effects an executor applies, in order, before the next transaction.
//!
//! Data only; nothing here acts.

use std::sync::Arc;

use crate::record::{Candidate, Case, Record};
use crate::spec::{GroupId, Nanos, SchemaId};
use crate::state::{Health, State};

/// One consequence of a call. Effects are applied in the order given, inside the transaction that gave them.
#[derive(Clone, PartialEq, Debug)]
pub enum Effect {
    /// A schema is awake: a motor schema checks its precondition at once, a perceptive one iterates.
    Woken(SchemaId),
    /// A schema sleeps.
    Slept {
        /// The schema.
        id: SchemaId,
        /// Its iteration still runs: its thread goes to sleep when the iteration returns, and reports its end then.
        abandoned: bool,
    },
    /// A schema is about to gain authority (R7): every command given before from its group or below is its now, if it or somebody below
    /// it is bound to that, and stands for its driver's validity at most; every other is neutral.
    TakesOver {
        /// Its group.
        group: GroupId,
        /// The schema.
        id: SchemaId,
    },
    /// A schema gained authority over commands and children (R7); fathers before children. Follows its `TakesOver` at once.
    Granted(SchemaId),
    /// A schema ended its first iteration with authority: what it took over is neutral, where it is bound to it itself and has not
    /// written it, or nobody bound to it below could act (R7).
    Lapsed(SchemaId),
    /// A schema lost that authority; children before fathers.
    Withdrawn(SchemaId),
    /// A motor schema became WINNER and should iterate at once.
    Promoted(SchemaId),
    /// A motor schema is no longer WINNER and stays awake.
    Demoted(SchemaId),
    /// The father's own arbitration is wanted; the answer carries the ticket.
    Ask {
        /// The group.
        group: GroupId,
        /// Names this question.
        ticket: u64,
        /// What the father is to judge.
        level: Level,
    },
    /// The neutral value is due on every actuator last commanded from this group or below it, and on those taken over that somebody
    /// there is bound to (R9).
    Brake {
        /// The group.
        group: GroupId,
    },
    /// The last commands from this group or below it stand although nobody wins (R9).
    Hold {
        /// The group.
        group: GroupId,
        /// Until then; a `Brake` follows if nobody wins by that time.
        until: Nanos,
    },
    /// A schema changed its state; given for every change, for those who watch.
    Changed {
        /// The schema.
        id: SchemaId,
        /// Its state before.
        from: State,
        /// Its state now.
        to: State,
    },
    /// The health of a schema changed.
    Health {
        /// The schema.
        id: SchemaId,
        /// Its health now.
        health: Health,
    },
    /// A selection was made (R15); the effects that carry it out follow.
    Decided(Record),
    /// A winner began its first iteration (R15).
    Took {
        /// The group.
        group: GroupId,
        /// The number of the record that made it the choice.
        record: u64,
        /// The winner.
        id: SchemaId,
        /// From the cause of that selection to now.
        latency: Nanos,
    },
}

/// A snapshot of a group, for the father who arbitrates it (R4).
#[derive(Clone, PartialEq, Debug)]
pub struct Level {
    /// The group.
    pub group: GroupId,
    /// Collision or absence.
    pub case: Case,
    /// The awake members in the father's order. On a collision the father may choose a ready one or nobody; on an
    /// absence any of them or nobody.
    pub candidates: Arc<[Candidate]>,
    /// The present winner, which stays while the father is asked.
    pub winner: Option<SchemaId>,
}
