//! The messages of a run, as programs write, send, store and read them. Data only.

use std::fmt;

use jde_panel::Gesture;
use serde::{Deserialize, Serialize};

/// A selection with its why-record (R15).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Decision {
    /// Counts the selections of the run, from 1.
    pub number: u64,
    /// When, s since the application's start.
    pub time_s: f64,
    /// The group: `roots`, `example/base`.
    pub group: String,
    /// `alone`, `collision`, `absence`, `forced`.
    pub case: String,
    /// The candidates that were awake, in the father's order, as they were before the selection.
    pub candidates: Vec<CandidateRecord>,
    /// The choice before.
    pub before: Option<String>,
    /// The choice.
    pub choice: Option<String>,
    /// `nobody`, `father`, `arbitration-failed`, `absence-policy`, `operator`, or a policy.
    pub decider: String,
    /// The reason, as text.
    pub reason: String,
    /// The cause, as text.
    pub cause: String,
    /// Whether the choice differs from the one before.
    pub changed: bool,
    /// Time from the cause to the winner's first iteration, us; `None` if the choice was not carried out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub takeover_us: Option<f64>,
}

impl Decision {
    /// The name of a choice, or of none.
    const NOBODY: &str = "nobody";

    /// What the case means.
    #[must_use]
    pub fn case_text(&self) -> &'static str {
        match self.case.as_str() {
            "alone" => "exactly one was ready, so there is no choice",
            "collision" => "two or more were ready",
            "absence" => "none was ready",
            "forced" => "an operator forced one",
            _ => "",
        }
    }

    /// Who decided, in words.
    #[must_use]
    pub fn decider_text(&self) -> String {
        match self.decider.as_str() {
            "nobody" => String::from("nobody: there was no choice"),
            "father" => String::from("the father's own arbitration"),
            "arbitration-failed" => {
                String::from("the priority order, because the father's arbitration failed")
            }
            "absence-policy" => String::from("the absence policy of the group"),
            "operator" => String::from("an operator"),
            policy => format!("the policy of the group, {policy}"),
        }
    }

    /// Whether another schema took over, or none acts any more. A choice that was not carried out is neither.
    #[must_use]
    pub fn is_takeover(&self) -> bool {
        self.changed && (self.takeover_us.is_some() || self.choice.is_none())
    }

    /// Returns the name of the choice before, or "nobody".
    #[must_use]
    pub fn before_name(&self) -> &str {
        self.before.as_deref().unwrap_or(Self::NOBODY)
    }

    /// Returns the name of the choice, or "nobody".
    #[must_use]
    pub fn choice_name(&self) -> &str {
        self.choice.as_deref().unwrap_or(Self::NOBODY)
    }
}

/// A candidate that was awake at a selection.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CandidateRecord {
    /// Its name.
    pub name: String,
    /// `checking`, `ready`, `winner`.
    pub state: String,
    /// Whether its precondition held at its last check.
    pub ready: bool,
    /// The urgency that it offered; `None` if that was not finite.
    pub urgency: Option<f64>,
}

/// A schema changed its state.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StateRecord {
    /// When, s since the application's start.
    pub time_s: f64,
    /// The schema.
    pub schema: String,
    /// Its state before.
    pub from: String,
    /// Its new state.
    pub to: String,
}

/// Any other event.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EventRecord {
    /// When, s since the application's start.
    pub time_s: f64,
    /// `ok`, `overrun`, `arbitration-failed`, `faulted`, `hung`, `left-behind`, `came-back`, `late`,
    /// `chatters`, `calmed`, `stalled`, `stands-still`, `refused`, `operator`, `drag`, `retracted`, `trigger`,
    /// `reloaded`, `reload-undone`, `ended`.
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
    pub touched: Option<GestureRecord>,
}

/// The schema if there is one, the kind and the description: `goon faulted: it panicked`.
impl fmt::Display for EventRecord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(schema) = &self.schema {
            write!(f, "{schema} ")?;
        }
        write!(f, "{}: {}", self.kind, self.text)
    }
}

/// A gesture on a panel, with its exact data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GestureRecord {
    /// The number of the gesture among those delivered in this run, from 1.
    pub number: u64,
    /// The gesture.
    #[serde(flatten)]
    pub gesture: Gesture,
}
