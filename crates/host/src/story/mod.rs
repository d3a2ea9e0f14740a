//! The decisions and events of a run, as JSON messages with one JSON schema per kind. JSON, because names and
//! reasons have any length, and variables have types of fixed size. `--decisions`, recordings and the link
//! all carry the same messages.

mod decided;
mod happenings;
mod lines;

use jde_core::Nanos;

use crate::app::Application;
use crate::event::Event;
pub use decided::{Decided, state_name};
pub use lines::{Candidate, Change, Decision, Happening, Touched};

/// One message of a story.
#[derive(Clone, Debug, PartialEq)]
pub enum Line {
    /// A selection.
    Decision(Decision),
    /// A change of state.
    Change(Change),
    /// Any other event.
    Happening(Happening),
}

/// The kinds of messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// [`Line::Decision`].
    Decision,
    /// [`Line::Change`].
    Change,
    /// [`Line::Happening`].
    Happening,
}

/// Turns events into messages.
pub struct Story {
    schemas: Vec<String>,
    groups: Vec<String>,
    decided: Decided,
    /// Includes every position of a drag.
    whole: bool,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Decision, Self::Change, Self::Happening];

    /// The topic of messages of this kind: `/jde/decisions`.
    #[must_use]
    pub fn topic(self) -> &'static str {
        match self {
            Self::Decision => "/jde/decisions",
            Self::Change => "/jde/states",
            Self::Happening => "/jde/events",
        }
    }

    /// The name of their JSON schema, and the schema.
    #[must_use]
    pub fn schema(self) -> (&'static str, &'static str) {
        match self {
            Self::Decision => ("jde/Decision", include_str!("decision.json")),
            Self::Change => ("jde/State", include_str!("state.json")),
            Self::Happening => ("jde/Event", include_str!("event.json")),
        }
    }
}

impl Story {
    /// Returns the story of an application.
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
            decided: Decided::new(application),
            whole: false,
        }
    }

    /// Returns the story of an application, with every position of every drag, as a replay of all turns needs
    /// it.
    #[must_use]
    pub fn whole(application: &Application) -> Self {
        Self {
            whole: true,
            ..Self::new(application)
        }
    }

    /// Returns the messages of an event. The message of a selection follows once the time of its takeover is
    /// known.
    pub fn hear(&mut self, event: &Event) -> Vec<Line> {
        let decided = self.decided.hear(event);
        let mut lines: Vec<_> = decided.into_iter().map(Line::Decision).collect();
        lines.extend(self.event(event));
        lines
    }

    /// Returns the selections whose takeover did not occur.
    #[must_use]
    pub fn finish(mut self) -> Vec<Line> {
        self.decided.rest().into_iter().map(Line::Decision).collect()
    }
}

fn happening(time: Nanos, kind: &str, schema: Option<String>, text: String) -> Line {
    Line::Happening(Happening {
        time_s: seconds(time),
        kind: kind.to_owned(),
        schema,
        text,
        ..Happening::default()
    })
}

/// Converts to seconds, exact to the nanosecond for the first hundred days.
pub(crate) fn seconds(time: Nanos) -> f64 {
    time as f64 / 1e9
}

impl Line {
    /// Returns the message that the value of a variable was retracted.
    #[must_use]
    pub fn retracted(time: Nanos, variable: &str) -> Self {
        happening(
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
            Self::Happening(happening) if happening.kind == "retracted" => happening
                .text
                .strip_prefix("the value of ")?
                .strip_suffix(" was taken back"),
            Self::Happening(_) | Self::Decision(_) | Self::Change(_) => None,
        }
    }

    /// Its kind.
    #[must_use]
    pub fn kind(&self) -> Kind {
        match self {
            Self::Decision(_) => Kind::Decision,
            Self::Change(_) => Kind::Change,
            Self::Happening(_) => Kind::Happening,
        }
    }

    /// Its time, ns since the application's start.
    #[must_use]
    pub fn time(&self) -> Nanos {
        let time_s = match self {
            Self::Decision(decision) => decision.time_s,
            Self::Change(change) => change.time_s,
            Self::Happening(happening) => happening.time_s,
        };
        (time_s * 1e9).round() as Nanos
    }

    /// The message as JSON.
    #[must_use]
    pub fn json(&self) -> Vec<u8> {
        let json = match self {
            Self::Decision(decision) => serde_json::to_vec(decision),
            Self::Change(change) => serde_json::to_vec(change),
            Self::Happening(happening) => serde_json::to_vec(happening),
        };
        // Serialization of numbers and texts cannot fail.
        json.unwrap_or_default()
    }

    /// Parses a message of a kind.
    ///
    /// # Errors
    /// It is no such message.
    pub fn read(kind: Kind, json: &[u8]) -> serde_json::Result<Self> {
        Ok(match kind {
            Kind::Decision => Self::Decision(serde_json::from_slice(json)?),
            Kind::Change => Self::Change(serde_json::from_slice(json)?),
            Kind::Happening => Self::Happening(serde_json::from_slice(json)?),
        })
    }
}
