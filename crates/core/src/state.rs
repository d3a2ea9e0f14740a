//! The facts about a schema and a group as they are shown: state, health, who keeps awake, who commands.
//!
//! Values only; the transitions live in the hierarchy.

use crate::spec::SchemaId;

/// The activation of a schema.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub enum State {
    /// Costs no processor time; keeps its memory.
    Slept,
    /// Awake; its precondition is false as far as known.
    Checking,
    /// Awake; its precondition is true; not chosen.
    Ready,
    /// Iterates; a motor schema may command and wake children if all its fathers are WINNER too.
    Winner,
}

/// How well a schema does; a fact apart from its state.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum Health {
    /// Nothing to report.
    Ok,
    /// Missed its deadline.
    Overrun,
    /// Its own arbitration failed (panicked, erred, named a stranger or passed its budget), with the reason. It
    /// stays awake; its next good answer clears the note.
    ArbitrationFailed(String),
    /// Panicked, returned an error, hung, or its process died, with the reason. It is SLEPT until its restart.
    Faulted(String),
}

/// Who wants a schema awake; each counts once (R6).
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Requester {
    /// The application, for its roots.
    Application,
    /// A father that woke it.
    Father(SchemaId),
    /// An awake schema that imports from it or commands it.
    Need(SchemaId),
    /// An operator who plays it.
    Operator,
}

/// What the actuators do on behalf of a group.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub enum Standing {
    /// Nobody has won since the father woke the first member.
    Fresh,
    /// Somebody wins.
    Commanding,
    /// Nobody wins; the last commands stand.
    Holding,
    /// Nobody wins; the group has braked.
    Braked,
}
