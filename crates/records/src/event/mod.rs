//! The events of a running application: one enum, delivered to observers in the order in which the events
//! occurred.

mod action;

use jde_core::{Health, Nanos, Record, State};

use crate::reload::BuildName;
use crate::reload::Replacement;
use crate::resource_usage::ResourceUsage;
pub use action::OperatorAction;

/// An event. Schemas and groups are numbered by their place in the `Application`.
#[derive(Clone, Debug)]
pub enum Event {
    /// A schema changed its state.
    StateChanged {
        /// When.
        time: Nanos,
        /// The schema.
        schema: usize,
        /// The state before.
        from: State,
        /// The new state.
        to: State,
    },
    /// A schema's health changed.
    HealthChanged {
        /// When.
        time: Nanos,
        /// The schema.
        schema: usize,
        /// The new health.
        health: Health,
    },
    /// A selection (R15). [`Event::TookOver`] later reports the time to the winner's first iteration.
    Decided(Record),
    /// A new winner began its first iteration. Whether that was late: [`Event::is_late`].
    TookOver {
        /// When.
        time: Nanos,
        /// The group.
        group: usize,
        /// Number of the selection's record.
        record: u64,
        /// The winner.
        schema: usize,
        /// Time since the cause of the selection.
        latency: Nanos,
        /// The longest time that the contract of the group permits (R17).
        allowed: Nanos,
        /// Of a takeover that took longer: how much of that was due to the machine.
        machine: Nanos,
    },
    /// A group began to chatter: see [`crate::chattering`].
    ChatteringStarted {
        /// When.
        time: Nanos,
        /// The group.
        group: usize,
        /// The two schemas that alternate most; `None` stands for no winner.
        between: [Option<usize>; 2],
        /// Switches within the last second.
        switches: usize,
    },
    /// Time stands still from now on.
    StoodStill {
        /// When.
        time: Nanos,
        /// Why: the condition that became true.
        reason: String,
    },
    /// An operator let time pass that stood still (R14).
    WentOn {
        /// When.
        time: Nanos,
        /// The operator.
        by: String,
        /// Whether only one step, after which time stands still again.
        one_step: bool,
    },
    /// A group stopped chattering.
    ChatteringEnded {
        /// When.
        time: Nanos,
        /// The group.
        group: usize,
        /// When it began to chatter.
        since: Nanos,
        /// Switches since then.
        switches: u64,
    },
    /// The distance to the mission's target has not decreased for the time that the application states.
    /// Reported once, until it decreases.
    Stalled {
        /// When.
        time: Nanos,
        /// The schema that exports the mission.
        schema: usize,
        /// Since when there has been no progress.
        since: Nanos,
        /// The distance to the target, m.
        distance: f64,
        /// Targets reached.
        reached: u32,
    },
    /// A schema missed a deadline, or its iteration or the drawing of its panel exceeded its budget. Every
    /// case is counted; the first of a series is reported.
    Overrun {
        /// When.
        time: Nanos,
        /// The schema.
        schema: usize,
        /// How long the iteration or drawing took.
        took: Nanos,
        /// The budget.
        budget: Nanos,
    },
    /// A call into a schema has not returned for many times its budget.
    Hung {
        /// When this was detected.
        time: Nanos,
        /// The schema.
        schema: usize,
        /// When the call began.
        since: Nanos,
    },
    /// A hung call was given up. Its thread is abandoned, its further effects are ignored, and the next wake
    /// creates a fresh instance.
    CallAbandoned {
        /// When.
        time: Nanos,
        /// The schema.
        schema: usize,
        /// When the call began.
        since: Nanos,
        /// Calls of this schema that were given up and have not returned, including this one.
        abandoned: u64,
        /// Bytes of shared values that are kept because this call may still read or write them.
        retained_bytes: u64,
        /// What the whole process holds now.
        process: ResourceUsage,
    },
    /// A call that had been given up returned. Its instance was ended.
    AbandonedCallReturned {
        /// When.
        time: Nanos,
        /// The schema.
        schema: usize,
        /// When the call began.
        since: Nanos,
        /// Calls of this schema that were given up and have not returned.
        abandoned: u64,
        /// What the whole process holds now.
        process: ResourceUsage,
    },
    /// A command or a wake was refused (R7), or a command was not finite. Every case is counted; the first of
    /// a series is reported. Also reports gestures that were accepted but not delivered, because the schema's
    /// instance ended first.
    Refused {
        /// When.
        time: Nanos,
        /// The schema that tried.
        schema: usize,
        /// What was refused, and why.
        description: String,
    },
    /// A guard limits the commands of a schema: lesser ones take effect (R18). Reported once for as long as it goes
    /// on.
    Limited {
        /// When.
        time: Nanos,
        /// The schema that commands.
        schema: usize,
        /// The guard, and why.
        description: String,
    },
    /// An operator acted (R14).
    Operator {
        /// When.
        time: Nanos,
        /// The operator's name: "ana@laptop".
        by: String,
        /// The action.
        action: OperatorAction,
        /// What awake schemas can no longer read since.
        losses: Vec<Loss>,
    },
    /// Another build of a schema took over from the build before, between two iterations (R10).
    Reloaded {
        /// When.
        time: Nanos,
        /// The schema.
        schema: usize,
        /// How it took over.
        takeover: Replacement,
    },
    /// A schema continues with the build before: the new build could not take over, or failed while on trial.
    ReloadRolledBack {
        /// When.
        time: Nanos,
        /// The schema.
        schema: usize,
        /// The build that was given up.
        build: BuildName,
        /// The reason.
        reason: String,
    },
    /// The application ended.
    Ended {
        /// When.
        time: Nanos,
        /// How it ended.
        outcome: Outcome,
    },
}

/// An import of an awake schema whose source sleeps, because an operator stopped or unloaded it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loss {
    /// The schema that imports.
    pub reader: usize,
    /// The name of its import.
    pub import: String,
}

impl Event {
    /// Whether it is a takeover that took longer than its contract permits, and not because of the machine (R17).
    #[must_use]
    pub fn is_late(&self) -> bool {
        matches!(self, Self::TookOver { latency, allowed, machine, .. } if *latency > allowed.saturating_add(*machine))
    }

    /// When it happened, ns since the application's start.
    #[must_use]
    pub fn time(&self) -> Nanos {
        match self {
            Self::Decided(record) => record.time,
            Self::StateChanged { time, .. }
            | Self::HealthChanged { time, .. }
            | Self::TookOver { time, .. }
            | Self::ChatteringStarted { time, .. }
            | Self::ChatteringEnded { time, .. }
            | Self::StoodStill { time, .. }
            | Self::WentOn { time, .. }
            | Self::Stalled { time, .. }
            | Self::Overrun { time, .. }
            | Self::Hung { time, .. }
            | Self::CallAbandoned { time, .. }
            | Self::AbandonedCallReturned { time, .. }
            | Self::Refused { time, .. }
            | Self::Limited { time, .. }
            | Self::Operator { time, .. }
            | Self::Reloaded { time, .. }
            | Self::ReloadRolledBack { time, .. }
            | Self::Ended { time, .. } => *time,
        }
    }
}

/// How an application ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Its mission is done.
    Done,
    /// Its mission failed.
    Failed,
    /// Its time limit was reached.
    TimeUp,
    /// It was asked to stop.
    Stopped,
    /// It could not continue, for this reason.
    Broken(String),
}

impl Outcome {
    /// The outcomes with fixed texts.
    const FIXED_MESSAGES: [(Self, &str); 4] = [
        (Self::Done, "the mission is done"),
        (Self::Failed, "the mission failed"),
        (Self::TimeUp, "the time was up"),
        (Self::Stopped, "it was asked to stop"),
    ];

    /// Returns the outcome as text, as records contain it.
    #[must_use]
    pub fn message(&self) -> &str {
        let fixed = Self::FIXED_MESSAGES.iter().find(|(outcome, _)| outcome == self);
        match (fixed, self) {
            (Some((_, text)), _) => text,
            (None, Self::Broken(reason)) => reason,
            (None, Self::Done | Self::Failed | Self::TimeUp | Self::Stopped) => "it ended",
        }
    }

    /// Parses the text of an outcome in a record.
    #[must_use]
    pub fn parse(text: &str) -> Self {
        let fixed = Self::FIXED_MESSAGES.into_iter().find(|(_, known)| *known == text);
        fixed.map_or_else(|| Self::Broken(text.to_owned()), |(outcome, _)| outcome)
    }
}

/// Receives events under the application's lock. It must return at once and must not call the application.
pub trait Observer: Send {
    /// Receives one event.
    fn on_event(&mut self, event: &Event);
}

impl<F: FnMut(&Event) + Send> Observer for F {
    fn on_event(&mut self, event: &Event) {
        self(event);
    }
}
