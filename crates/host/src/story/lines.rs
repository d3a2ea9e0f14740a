//! The messages of a story: what programs write, send, keep and read back. Data only.

use jde_panel::Gesture;
use serde::{Deserialize, Serialize};

/// A selection with its why-record (R15).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Decision {
    /// Counts the selections of the run, from 1.
    pub number: u64,
    /// When, s since the application's start.
    pub time_s: f64,
    /// The group: `roots`, `example/base`.
    pub group: String,
    /// `alone`, `collision`, `absence`, `forced`.
    pub case: String,
    /// Who was awake, in the father's order, as they were before.
    pub candidates: Vec<Candidate>,
    /// Who was chosen before.
    pub before: Option<String>,
    /// Who is chosen now.
    pub choice: Option<String>,
    /// `nobody`, `father`, `arbitration-failed`, `absence-policy`, `operator`, or a policy.
    pub decider: String,
    /// Why, in words.
    pub reason: String,
    /// What led to it, in words.
    pub cause: String,
    /// Whether the choice differs from the one before.
    pub changed: bool,
    /// Time from the cause to the winner's first iteration, us; none if it was not carried out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub takeover_us: Option<f64>,
}

/// One who was awake at a selection.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Who.
    pub name: String,
    /// `checking`, `ready`, `winner`.
    pub state: String,
    /// Whether its precondition held at its last check.
    pub ready: bool,
    /// The urgency it offered; none if that was no finite number.
    pub urgency: Option<f64>,
}

/// A schema changed its state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// When, s since the application's start.
    pub time_s: f64,
    /// Which.
    pub schema: String,
    /// Its state before.
    pub from: String,
    /// Its state since.
    pub to: String,
}

/// Whatever else happened.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Happening {
    /// When, s since the application's start.
    pub time_s: f64,
    /// `ok`, `overrun`, `arbitration-failed`, `faulted`, `hung`, `left-behind`, `came-back`, `late`, `chatters`, `calmed`,
    /// `refused`, `operator`, `drag`, `retracted`, `trigger`, `reloaded`, `reload-undone`, `ended`.
    pub kind: String,
    /// Whom it is about, if anybody.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub schema: Option<String>,
    /// The operator who did it, if one did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by: Option<String>,
    /// What happened, in words.
    pub text: String,
    /// What was done to the panel of a schema, if that is what happened.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub touched: Option<Touched>,
}

/// What somebody did to a panel, exactly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Touched {
    /// Counts the gestures of the run that were handed in, from 1.
    pub number: u64,
    /// What.
    #[serde(flatten)]
    pub gesture: Gesture,
}
