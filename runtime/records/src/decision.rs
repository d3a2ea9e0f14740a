//! The selections of a run, as programs write, send, store and read them. Data only.

use std::fmt;

use jde_core::{Case, Decider, PolicyKind, State};
use serde::{Deserialize, Serialize};

use crate::snapshot::{CaseName, StateName};

/// A selection with its why-record (R15).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Decision {
    /// Counts the selections of the run, from 1.
    pub number: u64,
    /// When, s since the application's start.
    pub time_s: f64,
    /// The group: `roots`, `example/base`.
    pub group: String,
    /// How many were ready.
    #[serde(with = "CaseName")]
    pub case: Case,
    /// The candidates that were awake, in the father's order, as they were before the selection.
    pub candidates: Vec<CandidateRecord>,
    /// The choice before.
    pub before: Option<String>,
    /// The choice.
    pub choice: Option<String>,
    /// Who decided.
    pub decider: DecidedBy,
    /// The reason, as text.
    pub reason: String,
    /// The cause, as text.
    pub cause: String,
    /// Whether the choice differs from the one before.
    pub changed: bool,
    /// Time from the cause to the winner's first iteration, us; `None` if the choice was not carried out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub takeover_us: Option<f64>,
    /// The candidates that were not ready because a guard had refused a command of theirs (R18).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub refused: Vec<RefusedCandidate>,
}

impl Decision {
    /// The name of a choice, or of none.
    const NOBODY: &str = "nobody";

    /// What the case means.
    #[must_use]
    pub fn case_text(&self) -> &'static str {
        match self.case {
            Case::Alone => "exactly one was ready, so there is no choice",
            Case::Collision => "two or more were ready",
            Case::Absence => "none was ready",
            Case::Forced => "an operator forced one",
        }
    }

    /// Who decided, in words.
    #[must_use]
    pub fn decider_text(&self) -> String {
        match &self.decider {
            DecidedBy::Nobody => String::from("nobody: there was no choice"),
            DecidedBy::Father => String::from("the father's own arbitration"),
            DecidedBy::ArbitrationFailed => {
                String::from("the priority order, because the father's arbitration failed")
            }
            DecidedBy::AbsencePolicy => String::from("the absence policy of the group"),
            DecidedBy::Operator => String::from("an operator"),
            DecidedBy::Policy(policy) => format!("the policy of the group, {policy}"),
        }
    }

    /// Whether another schema took over, or none acts any more. A choice that was not carried out is neither.
    #[must_use]
    pub fn is_takeover(&self) -> bool {
        self.changed && (self.takeover_us.is_some() || self.choice.is_none())
    }

    /// Returns why a candidate was not ready that a guard had refused, in words, and how long that lasts.
    #[must_use]
    pub fn refusal_of(&self, candidate: &str) -> Option<String> {
        let refused = self.refused.iter().find(|refused| refused.name == candidate)?;
        Some(format!(
            "{}; not ready for {:.2} s more",
            refused.reason, refused.left_s
        ))
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
    /// Its state before the selection.
    #[serde(with = "StateName")]
    pub state: State,
    /// Whether its precondition held at its last check.
    pub ready: bool,
    /// The urgency that it offered; `None` if that was not finite.
    pub urgency: Option<f64>,
}

/// A candidate that was not ready because a guard had refused a command of it (R18).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RefusedCandidate {
    /// Its name.
    pub name: String,
    /// The guard and its reason, in words.
    pub reason: String,
    /// How long the refusal lasts from this selection on, s.
    pub left_s: f64,
}

/// Who decided a selection. Its form in messages is its name.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(from = "String", into = "String")]
pub enum DecidedBy {
    /// There was nothing to decide.
    #[default]
    Nobody,
    /// The father's own arbitration.
    Father,
    /// The priority order or the absence policy, because the father's arbitration failed.
    ArbitrationFailed,
    /// The absence policy of the group.
    AbsencePolicy,
    /// An operator.
    Operator,
    /// The policy of the group with this name, also one that only another version of jde has.
    Policy(String),
}

impl DecidedBy {
    /// Returns the name that messages use.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Nobody => Decider::Nobody.name(),
            Self::Father => Decider::Father.name(),
            Self::ArbitrationFailed => Decider::ArbitrationFailed.name(),
            Self::AbsencePolicy => Decider::AbsencePolicy.name(),
            Self::Operator => Decider::Operator.name(),
            Self::Policy(name) => name,
        }
    }
}

impl DecidedBy {
    /// Whether it switches by intention, so that many switches are no chattering: by turns, or by an operator.
    #[must_use]
    pub fn switches_by_intention(&self) -> bool {
        match self {
            Self::Operator => true,
            Self::Policy(name) => PolicyKind::named(name).is_some_and(|kind| kind.rotates),
            Self::Nobody | Self::Father | Self::ArbitrationFailed | Self::AbsencePolicy => false,
        }
    }
}

impl fmt::Display for DecidedBy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl From<Decider> for DecidedBy {
    fn from(decider: Decider) -> Self {
        match decider {
            Decider::Nobody => Self::Nobody,
            Decider::Father => Self::Father,
            Decider::ArbitrationFailed => Self::ArbitrationFailed,
            Decider::AbsencePolicy => Self::AbsencePolicy,
            Decider::Operator => Self::Operator,
            Decider::Policy(policy) => Self::Policy(policy.name().to_owned()),
        }
    }
}

impl From<String> for DecidedBy {
    fn from(name: String) -> Self {
        let fixed = [
            Self::Nobody,
            Self::Father,
            Self::ArbitrationFailed,
            Self::AbsencePolicy,
            Self::Operator,
        ];
        let fixed = fixed.into_iter().find(|decider| decider.name() == name);
        fixed.unwrap_or(Self::Policy(name))
    }
}

impl From<DecidedBy> for String {
    fn from(decider: DecidedBy) -> Self {
        decider.name().to_owned()
    }
}
