//! The events of a running application. One enum serves those who watch a run while it goes on, where schemas and groups are
//! those of the application, and those who read its records, where they are names.
//!
//! A new event is a variant of [`What`]. The compiler then lists everything that reads events: no `match` on one has an arm
//! for all others.

mod action;
mod named;
mod outcome;
mod words;

use std::fmt;

use jde_core::{GroupId, Health, Nanos, Record, SchemaId, State};
use jde_panel::Gesture;
use serde::{Deserialize, Serialize};

use crate::reload::{BuildName, Replacement};
use crate::resource_usage::ResourceUsage;
use crate::snapshot::HealthName;
pub use action::OperatorAction;
pub use named::Names;
pub use outcome::Outcome;

/// How events name schemas, and groups accordingly.
pub trait Naming {
    /// The name of a group.
    type Group: Clone + fmt::Debug + PartialEq;
}

impl Naming for SchemaId {
    type Group = GroupId;
}

impl Naming for String {
    type Group = Self;
}

/// An event. `N` names schemas: by default by their place in the `Application`. `D` is a selection.
#[derive(Clone, Debug, PartialEq)]
pub enum Event<N: Naming = SchemaId, D = Record> {
    /// A selection (R15). [`What::TookOver`] later reports the time to the winner's first iteration.
    Decision(D),
    /// A schema changed its state.
    State(StateChange<N>),
    /// Any other event.
    Other(Occurrence<N>),
}

/// A schema changed its state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StateChange<N = SchemaId> {
    /// When, ns since the application's start.
    pub time: Nanos,
    /// The schema.
    pub schema: N,
    /// The state before.
    pub from: State,
    /// The new state.
    pub to: State,
}

/// An event other than a selection or a change of state.
#[derive(Clone, Debug, PartialEq)]
pub struct Occurrence<N: Naming = SchemaId> {
    /// When, ns since the application's start.
    pub time: Nanos,
    /// What happened.
    pub what: What<N>,
}

/// What happened. Times are ns since the application's start, durations ns.
///
/// Its form in JSON is a part of records: a field that is added later has a default, and what gets another meaning gets
/// another name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    rename_all = "kebab-case",
    bound(
        serialize = "N: Serialize, N::Group: Serialize",
        deserialize = "N: Deserialize<'de>, N::Group: Deserialize<'de>"
    )
)]
pub enum What<N: Naming = SchemaId> {
    /// A schema's health changed.
    HealthChanged {
        /// The schema.
        schema: N,
        /// The new health.
        #[serde(with = "HealthName")]
        health: Health,
    },
    /// A new winner began its first iteration. Whether that was late: [`What::is_late`].
    TookOver {
        /// The group.
        group: N::Group,
        /// Number of the selection's record.
        record: u64,
        /// The winner.
        schema: N,
        /// Time since the cause of the selection.
        latency: Nanos,
        /// The longest time that the contract of the group permits (R17).
        allowed: Nanos,
        /// Of a takeover that took longer: how much of that was due to the machine.
        machine: Nanos,
    },
    /// A group began to chatter: see [`crate::chattering`].
    ChatteringStarted {
        /// The group.
        group: N::Group,
        /// The two schemas that alternate most; `None` stands for no winner.
        between: [Option<N>; 2],
        /// Switches within the last second.
        switches: usize,
    },
    /// A group stopped chattering.
    ChatteringEnded {
        /// The group.
        group: N::Group,
        /// When it began to chatter.
        since: Nanos,
        /// Switches since then.
        switches: u64,
    },
    /// Time stands still from now on.
    StoodStill {
        /// Why: the condition that became true.
        reason: String,
    },
    /// An operator let time pass that stood still (R14).
    WentOn {
        /// The operator.
        by: String,
        /// Whether only one step, after which time stands still again.
        one_step: bool,
    },
    /// The distance to the mission's target has not decreased for the time that the application states.
    /// Reported once, until it decreases.
    Stalled {
        /// The schema that exports the mission.
        schema: N,
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
        /// The schema.
        schema: N,
        /// How long the iteration or drawing took.
        took: Nanos,
        /// The budget.
        budget: Nanos,
    },
    /// A call into a schema has not returned for many times its budget.
    Hung {
        /// The schema.
        schema: N,
        /// When the call began.
        since: Nanos,
    },
    /// A hung call was given up. Its thread is abandoned, its further effects are ignored, and the next wake
    /// creates a fresh instance.
    CallAbandoned {
        /// The schema.
        schema: N,
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
        /// The schema.
        schema: N,
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
        /// The schema that tried.
        schema: N,
        /// What was refused, and why.
        description: String,
        /// How long the schema is not READY from then on: the retry of its group, if a guard refused its command (R18).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        retry: Option<Nanos>,
    },
    /// A guard limits the commands of a schema: lesser ones take effect (R18). Reported once for as long as it goes
    /// on.
    Limited {
        /// The schema that commands.
        schema: N,
        /// The guard, and why.
        description: String,
    },
    /// An operator acted (R14).
    Operator {
        /// The operator's name: "ana@laptop".
        by: String,
        /// The action.
        action: OperatorAction<N>,
        /// What awake schemas can no longer read since.
        losses: Vec<Loss<N>>,
    },
    /// Another build of a schema took over from the build before, between two iterations (R10).
    Reloaded {
        /// The schema.
        schema: N,
        /// How it took over.
        takeover: Replacement,
    },
    /// A schema continues with the build before: the new build could not take over, or failed while on trial.
    ReloadRolledBack {
        /// The schema.
        schema: N,
        /// The build that was given up.
        build: BuildName,
        /// The reason.
        reason: String,
    },
    /// The value of a variable was retracted. Recorders report this.
    Retracted {
        /// The variable: "eye.laser".
        variable: String,
    },
    /// A condition of a recorder became true.
    Triggered {
        /// What became true: "collision in example/base".
        condition: String,
    },
    /// The application ended.
    Ended {
        /// How it ended.
        outcome: Outcome,
    },
    /// Only in records: an event of another version of jde, of which this one knows no more than the words.
    Unknown {
        /// The name of its kind.
        kind: String,
        /// The schema concerned, if any.
        schema: Option<N>,
        /// The operator who acted, if any.
        by: Option<String>,
        /// Its description.
        text: String,
        /// Its data, if it has any, which is passed on as it is.
        data: Option<serde_json::Value>,
    },
}

/// An import of an awake schema whose source sleeps, because an operator stopped or unloaded it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Loss<N = SchemaId> {
    /// The schema that imports.
    pub reader: N,
    /// The name of its import.
    pub import: String,
}

impl<N: Naming> What<N> {
    /// Whether it is a takeover that took longer than its contract permits, and not because of the machine (R17).
    #[must_use]
    pub fn is_late(&self) -> bool {
        matches!(self, Self::TookOver { latency, allowed, machine, .. } if *latency > allowed.saturating_add(*machine))
    }

    /// Returns the number of a gesture on a panel among those of the run, and the gesture.
    #[must_use]
    pub fn gesture(&self) -> Option<(u64, &Gesture)> {
        let Self::Operator {
            action: OperatorAction::Touch { number, gesture, .. },
            ..
        } = self
        else {
            return None;
        };
        Some((*number, gesture))
    }

    /// Returns the event with its time.
    #[must_use]
    pub fn at(self, time: Nanos) -> Occurrence<N> {
        Occurrence { time, what: self }
    }
}

impl<N: Naming, D> From<Occurrence<N>> for Event<N, D> {
    fn from(occurrence: Occurrence<N>) -> Self {
        Self::Other(occurrence)
    }
}

impl<N: Naming, D> Event<N, D> {
    /// Returns what happened, if it is neither a selection nor a change of state.
    #[must_use]
    pub fn what(&self) -> Option<&What<N>> {
        match self {
            Self::Other(occurrence) => Some(&occurrence.what),
            Self::Decision(_) | Self::State(_) => None,
        }
    }
}

impl Event {
    /// When it happened, ns since the application's start.
    #[must_use]
    pub fn time(&self) -> Nanos {
        match self {
            Self::Decision(record) => record.time,
            Self::State(change) => change.time,
            Self::Other(occurrence) => occurrence.time,
        }
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
