//! The decisions and events of a run. `--decisions` and the link carry them as JSON, recordings as messages of
//! ROS 2.

pub mod chattering;
pub mod check;
mod decision;
mod decision_tracker;
pub mod decision_writer;
mod earlier;
pub mod event;
pub mod reload;
mod resource_usage;
pub mod snapshot;
pub mod turn;
mod turn_kind;
pub mod wire;

use jde_app::Application;
use jde_core::Nanos;

use crate::event::{Event, Names, What};
pub use decision::{CandidateRecord, DecidedBy, Decision, RefusedCandidate};
pub use decision_tracker::{DecisionTracker, MAX_QUEUED, MAX_WAIT};
pub use resource_usage::ResourceUsage;

/// One message of a run: an event with the names of schemas and groups. [`wire`] has its form.
pub type RunRecord = Event<String, Decision>;

/// The kinds of messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordKind {
    /// A selection.
    Decision,
    /// A change of state.
    State,
    /// Any other event.
    Event,
}

/// Turns events into messages.
pub struct RecordBuilder {
    names: Names,
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
        let instances = application.instances.iter();
        let groups = application.groups.iter();
        Self {
            names: Names {
                schemas: instances.map(|instance| instance.name.clone()).collect(),
                groups: groups.map(|group| group.name.clone()).collect(),
            },
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
        let mut records: Vec<_> = decisions.into_iter().map(RunRecord::Decision).collect();
        match event {
            Event::Decision(_) => {}
            Event::State(change) => records.push(RunRecord::State(self.names.state(change))),
            Event::Other(occurrence) if self.has_message(&occurrence.what) => {
                records.push(RunRecord::Other(self.names.occurrence(occurrence)));
            }
            Event::Other(_) => {}
        }
        records
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

    /// Whether there is a message of an event. A takeover in time is a part of the message of its selection.
    fn has_message(&self, what: &What) -> bool {
        let is_in_time = matches!(what, What::TookOver { latency, allowed, .. } if latency <= allowed);
        let is_part_of_drag = matches!(what, What::Operator { action, .. } if action.goes_on());
        !is_in_time && (self.all_drags || !is_part_of_drag)
    }
}

/// Converts to seconds, exact to the nanosecond for the first hundred days.
pub(crate) fn seconds(time: Nanos) -> f64 {
    time as f64 / 1e9
}

/// Converts from seconds. No time is before 0.
pub(crate) fn nanoseconds(time_s: f64) -> Nanos {
    (time_s * 1e9).round() as Nanos
}

impl RunRecord {
    /// Returns the message that the value of a variable was retracted.
    #[must_use]
    pub fn retracted(time: Nanos, variable: &str) -> Self {
        let variable = variable.to_owned();
        Self::Other(What::Retracted { variable }.at(time))
    }

    /// Returns the variable whose value was retracted, if the message is of that kind.
    #[must_use]
    pub fn retracted_variable(&self) -> Option<&str> {
        let Some(What::Retracted { variable }) = self.what() else {
            return None;
        };
        Some(variable)
    }

    /// Its kind.
    #[must_use]
    pub fn kind(&self) -> RecordKind {
        match self {
            Self::Decision(_) => RecordKind::Decision,
            Self::State(_) => RecordKind::State,
            Self::Other(_) => RecordKind::Event,
        }
    }

    /// Its time, ns since the application's start.
    #[must_use]
    pub fn time(&self) -> Nanos {
        match self {
            Self::Decision(decision) => nanoseconds(decision.time_s),
            Self::State(change) => change.time,
            Self::Other(occurrence) => occurrence.time,
        }
    }

    /// The message as JSON.
    #[must_use]
    pub fn to_json(&self) -> Vec<u8> {
        let json = match self {
            Self::Decision(decision) => serde_json::to_vec(decision),
            Self::State(change) => serde_json::to_vec(change),
            Self::Other(occurrence) => serde_json::to_vec(occurrence),
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
            RecordKind::Event => Self::Other(serde_json::from_slice(json)?),
        })
    }
}
