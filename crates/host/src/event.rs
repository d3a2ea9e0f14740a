//! What a running application tells whoever listens: one enum, in the order in which things happened.

use jde_core::{Health, Nanos, Operator, Record, State};

/// Something that happened. Schemas and groups are named by their place in the `Application`.
#[derive(Clone, Debug)]
pub enum Event {
    /// A schema changed its state.
    Changed {
        /// When.
        time: Nanos,
        /// Which.
        schema: usize,
        /// Before.
        from: State,
        /// Since.
        to: State,
    },
    /// A schema's health changed.
    Health {
        /// When.
        time: Nanos,
        /// Which.
        schema: usize,
        /// Since.
        health: Health,
    },
    /// A selection (R15). The time to the winner's first iteration follows as [`Event::Took`].
    Decided(Record),
    /// A new winner began its first iteration.
    Took {
        /// When.
        time: Nanos,
        /// In which group.
        group: usize,
        /// Number of the selection's record.
        record: u64,
        /// The winner.
        schema: usize,
        /// Time from the cause of the selection.
        latency: Nanos,
        /// The longest it may take by the contract of its group (R17).
        allowed: Nanos,
    },
    /// A schema missed a deadline, or took longer than its budget; counted for each, told when it begins.
    Overrun {
        /// When.
        time: Nanos,
        /// Which.
        schema: usize,
        /// How long the iteration took.
        took: Nanos,
        /// What it may take.
        budget: Nanos,
    },
    /// A call into a schema has not returned for many times its budget.
    Hung {
        /// When it was noticed.
        time: Nanos,
        /// Which.
        schema: usize,
        /// Since when the call runs.
        since: Nanos,
    },
    /// A command or a wake was refused (R7), or a command was not finite; counted for each, told for the first of a row.
    Refused {
        /// When.
        time: Nanos,
        /// Who tried.
        schema: usize,
        /// What, and why.
        what: String,
    },
    /// An operator did something (R14).
    Operator {
        /// When.
        time: Nanos,
        /// What.
        action: OperatorAction,
    },
    /// The application ended.
    Ended {
        /// When.
        time: Nanos,
        /// How.
        outcome: Outcome,
    },
}

/// What an operator can do.
#[derive(Clone, Debug, PartialEq)]
pub enum OperatorAction {
    /// Plays, stops, forces or releases a schema.
    Hierarchy(Operator),
    /// Changes a period, ns.
    Period {
        /// Of which schema.
        schema: usize,
        /// The new one.
        period: Nanos,
    },
    /// Writes a modulation.
    Modulate {
        /// Of which schema.
        schema: usize,
        /// Its name.
        variable: String,
        /// The value, in words.
        value: String,
    },
}

/// How an application ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Its mission is done.
    Done,
    /// Its mission failed.
    Failed,
    /// The time given to it is over.
    TimeUp,
    /// It was asked to stop.
    Stopped,
    /// It could not go on; the reason in words.
    Broken(String),
}

/// Hears events, under the application's lock: it must return at once and must not call the application.
pub trait Observer: Send {
    /// Hears one.
    fn hear(&mut self, event: &Event);
}

impl<F: FnMut(&Event) + Send> Observer for F {
    fn hear(&mut self, event: &Event) {
        self(event);
    }
}
