//! The form of events and changes of state in messages: for people and other programs a kind and a description, for jde the
//! event itself. Data only.

use std::fmt;

use jde_core::{Nanos, State};
use jde_panel::Gesture;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::check::MAX_TIME;
use crate::earlier;
use crate::event::{Occurrence, StateChange, What};
use crate::{nanoseconds, seconds};

/// A change of state in a message.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StateMessage {
    /// When, s since the application's start.
    pub time_s: f64,
    /// The schema.
    pub schema: String,
    /// Its state before, in lower case.
    pub from: String,
    /// Its new state.
    pub to: String,
}

/// Any other event in a message.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EventMessage {
    /// When, s since the application's start.
    pub time_s: f64,
    /// The name of its kind: those of docs/recordings.md.
    pub kind: String,
    /// The schema concerned, if any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub schema: Option<String>,
    /// The operator who acted, if any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by: Option<String>,
    /// The description of the event.
    pub text: String,
    /// The gesture on a panel, if the event is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub touched: Option<GestureMessage>,
    /// The event, a [`What`]. `None` in messages of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub data: Option<serde_json::Value>,
}

/// A gesture on a panel, with its exact data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GestureMessage {
    /// The number of the gesture among those delivered in this run, from 1.
    pub number: u64,
    /// The gesture.
    #[serde(flatten)]
    pub gesture: Gesture,
}

impl From<&Occurrence<String>> for EventMessage {
    fn from(event: &Occurrence<String>) -> Self {
        let what = &event.what;
        Self {
            time_s: event.time_s(),
            kind: what.kind().to_owned(),
            schema: what.schema().cloned(),
            by: what.by().map(str::to_owned),
            text: event.text(),
            touched: what.gesture().map(|(number, gesture)| GestureMessage {
                number,
                gesture: gesture.clone(),
            }),
            data: if let What::Unknown { data, .. } = what {
                data.clone()
            } else {
                serde_json::to_value(what).ok()
            },
        }
    }
}

impl TryFrom<EventMessage> for Occurrence<String> {
    type Error = Nonsense;

    fn try_from(message: EventMessage) -> Result<Self, Nonsense> {
        let time = time(message.time_s)?;
        let own = message
            .data
            .as_ref()
            .and_then(|data| What::deserialize(data).ok());
        let what = own.or_else(|| earlier::what(time, &message));
        let what = what.unwrap_or(What::Unknown {
            kind: message.kind,
            schema: message.schema,
            by: message.by,
            text: message.text,
            data: message.data,
        });
        Ok(what.at(time))
    }
}

impl From<&StateChange<String>> for StateMessage {
    fn from(change: &StateChange<String>) -> Self {
        Self {
            time_s: seconds(change.time),
            schema: change.schema.clone(),
            from: state_name(change.from),
            to: state_name(change.to),
        }
    }
}

impl TryFrom<StateMessage> for StateChange<String> {
    type Error = Nonsense;

    fn try_from(message: StateMessage) -> Result<Self, Nonsense> {
        Ok(Self {
            time: time(message.time_s)?,
            schema: message.schema,
            from: state_named(&message.from)?,
            to: state_named(&message.to)?,
        })
    }
}

/// Why a message is no record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Nonsense {
    /// It names a state that there is not.
    State,
    /// Its time, s, is before 0, or later than anything can be.
    Time(f64),
}

impl fmt::Display for Nonsense {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::State => f.write_str("it has a record of a state that is none"),
            Self::Time(time_s) => write!(f, "it has a record of the time {time_s} s"),
        }
    }
}

/// Returns the time of a message, ns.
fn time(time_s: f64) -> Result<Nanos, Nonsense> {
    let is_time = (0.0..=MAX_TIME as f64 / 1e9).contains(&time_s);
    is_time.then(|| nanoseconds(time_s)).ok_or(Nonsense::Time(time_s))
}

/// Returns a state's name as it is written in messages: in lower case.
#[must_use]
pub fn state_name(state: State) -> String {
    state.name().to_lowercase()
}

/// Returns the state with that name, in any case.
///
/// # Errors
/// There is none.
pub fn state_named(name: &str) -> Result<State, Nonsense> {
    let mut states = State::ALL.into_iter();
    let known = states.find(|state| state.name().eq_ignore_ascii_case(name));
    known.ok_or(Nonsense::State)
}

impl Serialize for StateChange<String> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        StateMessage::from(self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for StateChange<String> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        StateMessage::deserialize(deserializer)?
            .try_into()
            .map_err(serde::de::Error::custom)
    }
}

impl Serialize for Occurrence<String> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        EventMessage::from(self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Occurrence<String> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        EventMessage::deserialize(deserializer)?
            .try_into()
            .map_err(serde::de::Error::custom)
    }
}
