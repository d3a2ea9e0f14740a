//! What a running application tells whoever listens: one enum, in the order in which things happened.

mod action;

use jde_core::{Health, Nanos, Record, State};

use crate::build::BuildName;
use crate::footprint::Footprint;
use crate::reload::Takeover;
pub use action::OperatorAction;

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
    /// A takeover took longer than the contract of its group allows (R17); the [`Event::Took`] of it came just before.
    Late {
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
        /// The longest it may take.
        allowed: Nanos,
    },
    /// A group began to chatter: see [`crate::chatter`].
    Chatters {
        /// When.
        time: Nanos,
        /// Which.
        group: usize,
        /// The two that alternate most; one may be nobody.
        between: [Option<usize>; 2],
        /// Switches within the last second.
        switches: usize,
    },
    /// A group that chattered has calmed down.
    Calmed {
        /// When.
        time: Nanos,
        /// Which.
        group: usize,
        /// Since when it chattered.
        since: Nanos,
        /// Switches from then on.
        switches: u64,
    },
    /// The mission has not come nearer to its target for the time that the application states; told once, until it does.
    Stalled {
        /// When.
        time: Nanos,
        /// Who exports the mission.
        schema: usize,
        /// Since when.
        since: Nanos,
        /// How far its target is, m.
        distance: f64,
        /// Targets reached.
        reached: u32,
    },
    /// A schema missed a deadline, or it or the drawing of its panel took longer than its budget; counted for each, told when it
    /// begins.
    Overrun {
        /// When.
        time: Nanos,
        /// Which.
        schema: usize,
        /// How long the iteration or drawing took.
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
    /// A call that hangs was given up: its thread is left behind, nothing it does counts any more, and the next awakening makes a
    /// fresh instance.
    LeftBehind {
        /// When.
        time: Nanos,
        /// Whose.
        schema: usize,
        /// Since when the call runs.
        since: Nanos,
        /// Calls of this schema that were given up and have not returned, this one included.
        left: u64,
        /// Bytes of shared values that this one may still look at or write to, and that are kept for it.
        kept: u64,
        /// What the whole process holds now.
        process: Footprint,
    },
    /// A call that was given up returned after all: its instance was ended.
    CameBack {
        /// When.
        time: Nanos,
        /// Whose.
        schema: usize,
        /// Since when the call ran.
        since: Nanos,
        /// Calls of this schema that were given up and have not returned.
        left: u64,
        /// What the whole process holds now.
        process: Footprint,
    },
    /// A command or a wake was refused (R7), or a command was not finite; counted for each, told for the first of a row. So are
    /// gestures that were accepted and that their schema, which was gone too soon, did not take up.
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
        /// Who: "ana@laptop".
        by: String,
        /// What.
        action: OperatorAction,
    },
    /// Another build of a schema took over from the one before, between two iterations (R10).
    Reloaded {
        /// When.
        time: Nanos,
        /// Of which.
        schema: usize,
        /// How.
        takeover: Takeover,
    },
    /// A schema goes on with the build before: the new one could not take over, or failed while it was on trial.
    ReloadUndone {
        /// When.
        time: Nanos,
        /// Which.
        schema: usize,
        /// The build that was given up.
        build: BuildName,
        /// Why.
        reason: String,
    },
    /// The application ended.
    Ended {
        /// When.
        time: Nanos,
        /// How.
        outcome: Outcome,
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

impl Outcome {
    /// All but those that have words of their own.
    const PLAIN: [(Self, &str); 4] = [
        (Self::Done, "the mission is done"),
        (Self::Failed, "the mission failed"),
        (Self::TimeUp, "the time was up"),
        (Self::Stopped, "it was asked to stop"),
    ];

    /// It in words, as stories tell it.
    #[must_use]
    pub fn words(&self) -> &str {
        let plain = Self::PLAIN.iter().find(|(outcome, _)| outcome == self);
        match (plain, self) {
            (Some((_, words)), _) => words,
            (None, Self::Broken(reason)) => reason,
            (None, Self::Done | Self::Failed | Self::TimeUp | Self::Stopped) => "it ended",
        }
    }

    /// Out of the words of a story.
    #[must_use]
    pub fn read(words: &str) -> Self {
        let plain = Self::PLAIN.into_iter().find(|(_, known)| *known == words);
        plain.map_or_else(|| Self::Broken(words.to_owned()), |(outcome, _)| outcome)
    }
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
