//! The decisions and events of a run. `--decisions` and the link carry them as JSON, recordings as messages of
//! ROS 2.

pub mod chattering;
pub mod check;
mod decision_tracker;
pub mod decision_writer;
pub mod event;
mod event_text;
mod messages;
pub mod reload;
mod resource_usage;
pub mod snapshot;
pub mod turn;

use jde_app::Application;
use jde_core::Nanos;

use crate::event::Event;
pub use decision_tracker::{DecisionTracker, MAX_QUEUED, MAX_WAIT, state_name, state_named};
pub use messages::{CandidateRecord, Decision, EventRecord, GestureRecord, StateRecord};
pub use resource_usage::ResourceUsage;

/// One message of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum RunRecord {
    /// A selection.
    Decision(Decision),
    /// A change of state.
    State(StateRecord),
    /// Any other event.
    Event(EventRecord),
}

/// The kinds of messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordKind {
    /// [`RunRecord::Decision`].
    Decision,
    /// [`RunRecord::State`].
    State,
    /// [`RunRecord::Event`].
    Event,
}

/// Turns events into messages.
pub struct RecordBuilder {
    schemas: Vec<String>,
    groups: Vec<String>,
    tracker: DecisionTracker,
    /// Includes every position of a drag.
    all_drags: bool,
}

impl RecordKind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Decision, Self::State, Self::Event];

    /// The topic of messages of this kind: `/jde/decisions`.
    #[must_use]
    pub fn topic(self) -> &'static str {
        match self {
            Self::Decision => "/jde/decisions",
            Self::State => "/jde/states",
            Self::Event => "/jde/events",
        }
    }
}

impl RecordBuilder {
    /// Creates a builder for an application.
    #[must_use]
    pub fn new(application: &Application) -> Self {
        Self {
            schemas: application
                .instances
                .iter()
                .map(|instance| instance.name.clone())
                .collect(),
            groups: application
                .groups
                .iter()
                .map(|group| group.name.clone())
                .collect(),
            tracker: DecisionTracker::new(application),
            all_drags: false,
        }
    }

    /// Creates a builder for an application that includes every position of every drag, as a replay of all
    /// turns needs it.
    #[must_use]
    pub fn with_all_drags(application: &Application) -> Self {
        Self {
            all_drags: true,
            ..Self::new(application)
        }
    }

    /// Returns the messages of an event. The message of a selection follows once the time of its takeover is
    /// known.
    pub fn process(&mut self, event: &Event) -> Vec<RunRecord> {
        let decisions = self.tracker.process(event);
        let mut lines: Vec<_> = decisions.into_iter().map(RunRecord::Decision).collect();
        lines.extend(self.describe_event(event));
        lines
    }

    /// Returns the selections whose takeover did not occur.
    #[must_use]
    pub fn finish(&mut self) -> Vec<RunRecord> {
        self.tracker
            .drain()
            .into_iter()
            .map(RunRecord::Decision)
            .collect()
    }
}

fn event_record(time: Nanos, kind: &str, schema: Option<String>, text: String) -> RunRecord {
    RunRecord::Event(EventRecord {
        time_s: seconds(time),
        kind: kind.to_owned(),
        schema,
        text,
        ..EventRecord::default()
    })
}

/// Converts to seconds, exact to the nanosecond for the first hundred days.
pub(crate) fn seconds(time: Nanos) -> f64 {
    time as f64 / 1e9
}

impl RunRecord {
    /// Returns the message that the value of a variable was retracted.
    #[must_use]
    pub fn retracted(time: Nanos, variable: &str) -> Self {
        event_record(
            time,
            "retracted",
            None,
            format!("the value of {variable} was taken back"),
        )
    }

    /// Returns the variable whose value was retracted, if the message is of that kind.
    #[must_use]
    pub fn retracted_variable(&self) -> Option<&str> {
        match self {
            Self::Event(happening) if happening.kind == "retracted" => happening
                .text
                .strip_prefix("the value of ")?
                .strip_suffix(" was taken back"),
            Self::Event(_) | Self::Decision(_) | Self::State(_) => None,
        }
    }

    /// Its kind.
    #[must_use]
    pub fn kind(&self) -> RecordKind {
        match self {
            Self::Decision(_) => RecordKind::Decision,
            Self::State(_) => RecordKind::State,
            Self::Event(_) => RecordKind::Event,
        }
    }

    /// Its time, ns since the application's start.
    #[must_use]
    pub fn time(&self) -> Nanos {
        let time_s = match self {
            Self::Decision(decision) => decision.time_s,
            Self::State(change) => change.time_s,
            Self::Event(happening) => happening.time_s,
        };
        (time_s * 1e9).round() as Nanos
    }

    /// The message as JSON.
    #[must_use]
    pub fn to_json(&self) -> Vec<u8> {
        let json = match self {
            Self::Decision(decision) => serde_json::to_vec(decision),
            Self::State(change) => serde_json::to_vec(change),
            Self::Event(happening) => serde_json::to_vec(happening),
        };
        // Serialization of numbers and texts cannot fail.
        json.unwrap_or_default()
    }

    /// Parses a message of a kind in JSON.
    ///
    /// # Errors
    /// It is not such a message.
    pub fn parse(kind: RecordKind, json: &[u8]) -> serde_json::Result<Self> {
        Ok(match kind {
            RecordKind::Decision => Self::Decision(serde_json::from_slice(json)?),
            RecordKind::State => Self::State(serde_json::from_slice(json)?),
            RecordKind::Event => Self::Event(serde_json::from_slice(json)?),
        })
    }
}
