//! The state of every schema and group at one instant, as the oscilloscope shows it. Data only. The JSON form
//! has the names of the fields, and enumerations as names, such as `"winner"`, `"motor"`, `"ok"` or
//! `{"faulted": "why"}`. Times are in ns.

mod names;

use std::fmt;

use jde_abi::describe::Kind;
use jde_core::{Health, Nanos, State};
use serde::{Deserialize, Serialize};

use crate::DecidedBy;
use crate::reload::BuildName;
use names::KindName;
pub(crate) use names::{CaseName, HealthName, StateName};

/// The whole application at one instant.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// ns since the application's start.
    pub time: Nanos,
    /// Every schema, in the application's order.
    pub schemas: Vec<SchemaView>,
    /// Every group, in the application's order.
    pub groups: Vec<GroupView>,
    /// Why time stands still; `None` while it passes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standstill: Option<String>,
}

impl Snapshot {
    /// Returns the name of a group's winner, or "nobody".
    #[must_use]
    pub fn winner_name(&self, group: &GroupView) -> &str {
        group.winner.map_or("nobody", |winner| &self.schemas[winner].name)
    }
}

/// A schema at one instant.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SchemaView {
    /// Its name in the application.
    pub name: String,
    /// Full name of its type, "plugin/schema".
    pub type_name: String,
    /// Its kind.
    #[serde(with = "KindName")]
    pub kind: Kind,
    /// Its father's place; `None` if it has no father.
    pub father: Option<usize>,
    /// The place of the group in which it competes; `None` if it does not compete.
    pub group: Option<usize>,
    /// Its state.
    #[serde(with = "StateName")]
    pub state: State,
    /// Its health.
    #[serde(with = "HealthName")]
    pub health: Health,
    /// Whether it and all its fathers are WINNER, so that its commands take effect.
    pub authority: bool,
    /// Its configured period, ns.
    pub period: Nanos,
    /// Mean time between its last cycles, ns; `None` before the second cycle, and while one is late by more than it.
    pub measured: Option<Nanos>,
    /// Longest iteration so far, ns.
    pub longest: Nanos,
    /// In lockstep, where no turn overruns: those that took longer than the budget by the machine's clock.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub slow_turns: u64,
    /// The longest of them, ns.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub slowest_turn: Nanos,
    /// Recent share of time spent in calls, 0 to 1.
    pub load: f64,
    /// Iterations so far.
    pub iterations: u64,
    /// Missed deadlines and exceeded budgets so far.
    pub overruns: u64,
    /// Refused commands and wakes, and commands that were not finite.
    pub refused: u64,
    /// Faults so far.
    pub faults: u64,
    /// Triggers that were dropped or had to rest, because they followed each other too fast (R12).
    #[serde(default)]
    pub triggers_dropped: u64,
    /// Restarts that its restart policy still permits; `None` if it is never restarted.
    #[serde(default)]
    pub restarts_left: Option<u32>,
    /// Calls of it that were given up and have not returned.
    #[serde(default)]
    pub left: u64,
    /// What an operator holds it to: of several holds, the first in the order of [`HoldKind`].
    pub operator: Option<Hold>,
    /// The other holds on it, in the same order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub more_holds: Vec<Hold>,
    /// Whether it has a panel.
    #[serde(default)]
    pub panel: bool,
    /// The id of its own process; `None` while it has none.
    #[serde(default)]
    pub process: Option<u32>,
    /// The result of its reloads; `None` before one took over or failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reload: Option<ReloadView>,
}

impl SchemaView {
    /// Returns all holds of operators on it.
    pub fn holds(&self) -> impl Iterator<Item = &Hold> {
        self.operator.iter().chain(&self.more_holds)
    }

    /// Returns whether an operator holds it to this.
    #[must_use]
    pub fn is_held_to(&self, kind: HoldKind) -> bool {
        self.holds().any(|hold| hold.kind == kind)
    }

    /// Returns the first hold that keeps it asleep.
    #[must_use]
    pub fn stop(&self) -> Option<&Hold> {
        self.holds()
            .find(|hold| matches!(hold.kind, HoldKind::Unloaded | HoldKind::Stopped))
    }

    /// Returns whether it was stopped together with everything else.
    #[must_use]
    pub fn is_stopped_with_everything(&self) -> bool {
        self.holds().any(|hold| hold.with_everything)
    }

    /// Returns all holds in words: "stopped by ana@laptop, forced by ben@base"; `None` without holds.
    #[must_use]
    pub fn held_by(&self) -> Option<String> {
        let words: Vec<_> = self.holds().map(ToString::to_string).collect();
        (!words.is_empty()).then(|| words.join(", "))
    }
}

/// The result of the reloads of a schema.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReloadView {
    /// How many builds have taken over.
    pub reloads: u32,
    /// The build that it runs.
    pub build: BuildName,
    /// Whether the build is on trial: after a fault, the build before takes over again.
    pub on_trial: bool,
    /// Why the last new build was given up, if it was.
    pub undone: Option<String>,
}

/// One action of an operator that is in force on a schema (R14). Each ends alone.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hold {
    /// What the schema is held to.
    pub kind: HoldKind,
    /// Whether it was stopped together with everything else; of an unload, whether the schema also was.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub with_everything: bool,
    /// Whether it ends with a lease.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub leased: bool,
    /// The operator's name: "ana@laptop".
    pub by: String,
}

impl fmt::Display for Hold {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let with = match self.kind {
            HoldKind::Stopped if self.with_everything => " with everything",
            _ => "",
        };
        write!(f, "{}{with} by {}", self.kind.word(), self.by)
    }
}

/// The kinds of an operator's action on a schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HoldKind {
    /// Asleep and without an instance.
    Unloaded,
    /// Asleep.
    Stopped,
    /// The winner of its group while it is awake.
    Forced,
    /// Awake.
    Played,
    /// Exports that fail.
    Failing,
    /// A period.
    Retimed,
    /// Modulations.
    Modulated,
}

impl HoldKind {
    /// Returns its name: "stopped", "forced".
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Unloaded => "unloaded",
            Self::Stopped => "stopped",
            Self::Forced => "forced",
            Self::Played => "played",
            Self::Failing => "failing",
            Self::Retimed => "re-timed",
            Self::Modulated => "modulated",
        }
    }
}

/// A group at one instant.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GroupView {
    /// Its name: "example/base", "roots".
    pub name: String,
    /// The father's place; `None` for the roots.
    pub father: Option<usize>,
    /// Its members' places, in the father's order.
    pub members: Vec<usize>,
    /// The winner's place.
    pub winner: Option<usize>,
    /// The name of its policy.
    pub policy: String,
    /// Changes of winner so far.
    pub switches: u64,
    /// The last change of winner.
    pub last: Option<Switch>,
    /// The longest time from a cause to the winner's first iteration so far, ns.
    pub worst: Nanos,
    /// The longest time that its contract permits (R17), ns.
    pub allowed: Nanos,
    /// Takeovers so far that took longer.
    #[serde(default)]
    pub late: u64,
    /// How it chatters; `None` if it does not.
    #[serde(default)]
    pub chatter: Option<Chattering>,
}

/// A group whose winner changes repeatedly.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Chattering {
    /// When it began to chatter, ns.
    pub since: Nanos,
    /// The two schemas that alternate most, by place; `None` stands for no winner.
    pub between: [Option<usize>; 2],
    /// Switches within the last second.
    pub switches: usize,
}

/// A change of winner.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Switch {
    /// When, ns.
    pub time: Nanos,
    /// The winner before.
    pub from: Option<usize>,
    /// The new winner.
    pub to: Option<usize>,
    /// Who decided.
    pub decider: DecidedBy,
    /// The reason, as text.
    pub reason: String,
    /// Time from the cause to the winner's first iteration, ns.
    pub latency: Option<Nanos>,
}

fn is_zero(count: &u64) -> bool {
    *count == 0
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn view(health: Health, operator: Option<Hold>) -> SchemaView {
        SchemaView {
            name: "vff".to_owned(),
            type_name: "vff/vff".to_owned(),
            kind: Kind::Motor,
            father: Some(2),
            group: Some(1),
            state: State::Winner,
            health,
            authority: true,
            period: 75_000_000,
            longest: u64::MAX,
            load: 0.25,
            iterations: 7,
            faults: 1,
            restarts_left: Some(4),
            operator,
            panel: true,
            process: Some(4711),
            ..SchemaView::default()
        }
    }

    fn snapshot() -> Snapshot {
        let hold = Hold {
            kind: HoldKind::Forced,
            with_everything: false,
            leased: false,
            by: "ana@laptop".to_owned(),
        };
        Snapshot {
            time: 1,
            schemas: vec![
                view(Health::Ok, Some(hold)),
                view(Health::Overrun, None),
                view(Health::ArbitrationFailed("late".to_owned()), None),
                view(Health::Faulted("panicked".to_owned()), None),
            ],
            groups: vec![GroupView {
                name: "roots".to_owned(),
                father: None,
                members: vec![0, 1],
                winner: Some(0),
                policy: "priority".to_owned(),
                switches: 1,
                last: Some(Switch {
                    time: 1,
                    from: None,
                    to: Some(0),
                    decider: DecidedBy::Nobody,
                    reason: "alone".to_owned(),
                    latency: Some(3),
                }),
                worst: 3,
                allowed: 4,
                late: 1,
                chatter: Some(Chattering {
                    since: 1,
                    between: [None, Some(0)],
                    switches: 6,
                }),
            }],
            ..Snapshot::default()
        }
    }

    #[test]
    fn a_snapshot_survives_json() {
        let sent = serde_json::to_string(&snapshot()).expect("it can be written as JSON");
        let read: Snapshot = serde_json::from_str(&sent).expect("the JSON is a snapshot");
        assert_eq!(read, snapshot());
    }

    #[test]
    fn json_has_states_health_kinds_and_holds_as_names() {
        let sent = serde_json::to_value(snapshot()).expect("it can be written as JSON");
        let schemas = &sent["schemas"];
        assert_eq!(schemas[0]["state"], "winner");
        assert_eq!(schemas[0]["kind"], "motor");
        assert_eq!(schemas[0]["health"], "ok");
        assert_eq!(
            schemas[0]["operator"],
            json!({ "kind": "forced", "by": "ana@laptop" })
        );
        assert_eq!(schemas[1]["operator"], json!(null));
        assert_eq!(schemas[2]["health"], json!({ "arbitration-failed": "late" }));
        assert_eq!(schemas[3]["health"], json!({ "faulted": "panicked" }));
        assert_eq!(sent["groups"][0]["last"]["reason"], "alone");
    }
}
