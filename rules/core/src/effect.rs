//! The effects of a transaction. The executor applies them in order, before the next transaction.
//!
//! Data only; it refuses to act.

use std::sync::Arc;

use crate::record::{Candidate, Case, Record};
use crate::spec::{GroupId, Nanos, SchemaId};
use crate::state::{Health, State};

/// One consequence of a call. Effects are applied in the given order, inside the transaction that returned
/// them.
#[derive(Clone, PartialEq, Debug)]
pub enum Effect {
    /// A schema woke: a motor schema checks its precondition at once, a perceptive one iterates.
    Woken(SchemaId),
    /// A schema went to SLEPT.
    Slept {
        /// The schema.
        id: SchemaId,
        /// Its iteration still runs. Its thread sleeps once the iteration has returned, and reports the end
        /// then.
        abandoned: bool,
    },
    /// A schema is about to gain authority (R7). It takes over every command that was given before from its
    /// group or below. A command that neither it nor a schema below it is bound to becomes neutral. Every
    /// other one stays in force for at most its driver's validity.
    TakesOver {
        /// Its group.
        group: GroupId,
        /// The schema.
        id: SchemaId,
    },
    /// A schema gained authority over commands and children (R7); fathers before children. It follows its
    /// `TakesOver` directly.
    Granted(SchemaId),
    /// A schema ended its first iteration with authority. A command that it took over becomes neutral if the
    /// schema is bound to it and has not written it, or if no schema below that is bound to it could act
    /// (R7).
    Lapsed(SchemaId),
    /// A guard refused a command of a schema, which is not READY for its group's retry (R18). What it took over
    /// stays in force, at most for its driver's validity.
    Refused(SchemaId),
    /// The retry of a refused schema ended (R18).
    Retries(SchemaId),
    /// A schema lost its authority; children before fathers.
    Withdrawn(SchemaId),
    /// A motor schema became WINNER and should iterate at once.
    Promoted(SchemaId),
    /// A motor schema is no longer WINNER and stays awake.
    Demoted(SchemaId),
    /// The father's own arbitration is requested. The reply carries the ticket.
    Arbitrate {
        /// The group.
        group: GroupId,
        /// Identifies this request.
        ticket: u64,
        /// The snapshot that the father evaluates.
        level: Level,
    },
    /// The neutral value must be sent to every actuator that was last commanded from this group or below it,
    /// and to those taken over that a schema there is bound to (R9).
    Brake {
        /// The group.
        group: GroupId,
    },
    /// The last commands from this group or below it stay in force although no member wins (R9).
    Hold {
        /// The group.
        group: GroupId,
        /// The end of the hold. A `Brake` follows if no member has won by then.
        until: Nanos,
    },
    /// A schema changed its state. Emitted for every change, for observers.
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
    /// A selection was made (R15). The effects that carry it out follow.
    Decided(Record),
    /// A winner began its first iteration (R15).
    TookOver {
        /// The group.
        group: GroupId,
        /// The number of the record that chose the winner.
        record: u64,
        /// The winner.
        id: SchemaId,
        /// Time from the cause of that selection to now.
        latency: Nanos,
    },
}

/// A snapshot of a group, for the father that arbitrates it (R4).
#[derive(Clone, PartialEq, Debug)]
pub struct Level {
    /// The group.
    pub group: GroupId,
    /// Collision or absence.
    pub case: Case,
    /// The awake members in the father's order. On a collision the father may choose a READY member or none.
    /// On an absence it may choose any member or none.
    pub candidates: Arc<[Candidate]>,
    /// The current winner, which stays until the father has decided.
    pub winner: Option<SchemaId>,
}
