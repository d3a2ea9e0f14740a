//! The one classification of events: what kind of thing happened, how bad it is, and the health of a schema in words.

use jde_abi::describe::Kind;
use jde_core::{Health, Nanos, State};
use jde_records::event::{Naming, What};
use jde_records::snapshot::SchemaView;

/// An event of a schema that is marked in time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mark {
    /// When, ns since the application's start.
    pub time: Nanos,
    /// What kind of event it is.
    pub kind: MarkKind,
    /// The event in words.
    pub text: String,
}

impl Mark {
    /// When, s since the application's start.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.time as f64 / 1e9
    }
}

/// The kinds of events, the least important first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MarkKind {
    /// A gesture of which more will follow, a retracted value, or an event of another version.
    Other,
    /// A takeover in time, or late because of the machine.
    Delayed,
    /// The application ended.
    Ended,
    /// A schema is well again.
    Recovered,
    /// An operator acted.
    Operator,
    /// A build of a schema replaced another one, or did not.
    Reloaded,
    /// Time stands still, or goes on.
    Standstill,
    /// A recorder began because of a condition.
    Triggered,
    /// A guard limits the commands of a schema.
    Limited,
    /// A command or a wake was refused.
    Refused,
    /// A schema missed a deadline.
    Overrun,
    /// The arbitration of a father failed.
    ArbitrationFailed,
    /// A group stopped chattering, or a call that had been given up returned.
    Calmed,
    /// A group chatters.
    Chattering,
    /// The mission stalled.
    Stalled,
    /// A takeover took longer than its contract permits (R17).
    Late,
    /// A schema faulted or did not return.
    Fault,
}

/// How bad a kind of event is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// As it should be.
    Good,
    /// Worth a look.
    Warning,
    /// Something is wrong.
    Bad,
}

impl MarkKind {
    /// Returns the kind of an event.
    #[must_use]
    pub fn of<N: Naming>(what: &What<N>) -> Self {
        match what {
            What::HealthChanged { health, .. } => match health {
                Health::Ok => Self::Recovered,
                Health::Overrun => Self::Overrun,
                Health::ArbitrationFailed(_) => Self::ArbitrationFailed,
                Health::Faulted(_) => Self::Fault,
            },
            What::Overrun { .. } => Self::Overrun,
            What::Hung { .. } | What::CallAbandoned { .. } => Self::Fault,
            What::Refused { .. } => Self::Refused,
            What::Limited { .. } => Self::Limited,
            What::Operator { action, .. } if action.goes_on() => Self::Other,
            What::Operator { .. } => Self::Operator,
            What::TookOver { .. } if what.is_late() => Self::Late,
            What::TookOver { .. } => Self::Delayed,
            What::Retracted { .. } | What::Unknown { .. } => Self::Other,
            What::ChatteringStarted { .. } => Self::Chattering,
            What::ChatteringEnded { .. } | What::AbandonedCallReturned { .. } => Self::Calmed,
            What::StoodStill { .. } | What::WentOn { .. } => Self::Standstill,
            What::Stalled { .. } => Self::Stalled,
            What::Reloaded { .. } | What::ReloadRolledBack { .. } => Self::Reloaded,
            What::Triggered { .. } => Self::Triggered,
            What::Ended { .. } => Self::Ended,
        }
    }

    /// Returns how bad it is.
    #[must_use]
    pub fn severity(self) -> Severity {
        match self {
            Self::Recovered | Self::Ended => Severity::Good,
            Self::Other
            | Self::Delayed
            | Self::Operator
            | Self::Reloaded
            | Self::Standstill
            | Self::Triggered
            | Self::Limited
            | Self::Refused
            | Self::Overrun
            | Self::ArbitrationFailed
            | Self::Calmed => Severity::Warning,
            Self::Chattering | Self::Stalled | Self::Late | Self::Fault => Severity::Bad,
        }
    }
}

/// Returns the state of a schema in a word. A perceptive schema or a driver competes with none: it runs instead of winning.
#[must_use]
pub fn state_word(view: &SchemaView) -> &'static str {
    match (view.state, view.kind) {
        (State::Winner, Kind::Perceptive | Kind::Driver) => "running",
        (State::Winner, Kind::Motor) | (State::Slept | State::Checking | State::Ready, _) => {
            view.state.name()
        }
    }
}

/// Returns the health of a schema in a word or two: "ok", "overrun", "arbitration failed", "faulted".
#[must_use]
pub fn health_word(health: &Health) -> &'static str {
    match health {
        Health::Ok => "ok",
        Health::Overrun => "overrun",
        Health::ArbitrationFailed(_) => "arbitration failed",
        Health::Faulted(_) => "faulted",
    }
}

/// Returns what is wrong with a schema; `None` if nothing is.
#[must_use]
pub fn health_reason(health: &Health) -> Option<&str> {
    match health {
        Health::Ok => None,
        Health::Overrun => Some("it missed its deadline or exceeded its budget"),
        Health::ArbitrationFailed(reason) | Health::Faulted(reason) => Some(reason),
    }
}

/// Returns the health of a schema in a word or two, and what is wrong: "faulted: it panicked".
#[must_use]
pub fn health_text(health: &Health) -> String {
    let word = health_word(health);
    health_reason(health).map_or_else(|| word.to_owned(), |reason| format!("{word}: {reason}"))
}

/// Returns how bad the health of a schema is.
#[must_use]
pub fn health_severity(health: &Health) -> Severity {
    match health {
        Health::Ok => Severity::Good,
        Health::Overrun | Health::ArbitrationFailed(_) => Severity::Warning,
        Health::Faulted(_) => Severity::Bad,
    }
}
