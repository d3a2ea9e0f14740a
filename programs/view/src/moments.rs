//! The moments of a recording that deserve a look: takeovers, contacts, faults and failures, in words.

use std::collections::BTreeMap;

use jde_abi::describe::Type;
use jde_log::{LeftOut, RecordedVariable, RecordedVariables};
use jde_records::RunRecord;
use jde_timeline::{MarkKind, Severity};
use jde_types::{Mission, Truth, Value as _};

/// The most moments.
const MAX_MOMENTS: usize = 100_000;

/// A moment of a recording that deserves a look.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Moment {
    /// When, s since the application's start.
    pub(crate) time_s: f64,
    pub(crate) kind: MomentKind,
    /// What happened, in words.
    pub(crate) text: String,
}

/// The kinds of moments, the least important first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum MomentKind {
    /// The winner of a group changed.
    Takeover,
    /// A robot touched something.
    Contact,
    /// A schema faulted, was late, chattered or stalled.
    Fault,
    /// A mission failed.
    Failure,
}

/// Finds moments.
pub(crate) struct Moments {
    pub(crate) list: Vec<Moment>,
    /// The variables with the truth about robots, and the contacts of each so far.
    truths: BTreeMap<String, (RecordedVariable, Option<u64>)>,
    /// The variables with the progress of missions, and whether each has failed.
    missions: BTreeMap<String, (RecordedVariable, bool)>,
}

impl Moments {
    pub(crate) fn new(variables: &RecordedVariables) -> Self {
        let (truth, mission) = (Truth::describe(), Mission::describe());
        let of = |known: &Type| {
            let typed = variables
                .iter()
                .filter(|variable| variable.value_type.name == known.name);
            let typed = typed.map(|variable| (variable.name.clone(), variable.with_type(known.clone())));
            typed.collect::<Vec<_>>()
        };
        let truths = of(&truth).into_iter();
        let missions = of(&mission).into_iter();
        Self {
            list: Vec::new(),
            truths: truths.map(|(name, variable)| (name, (variable, None))).collect(),
            missions: missions
                .map(|(name, variable)| (name, (variable, false)))
                .collect(),
        }
    }

    fn add(&mut self, time_s: f64, kind: MomentKind, text: String) {
        if self.list.len() < MAX_MOMENTS {
            self.list.push(Moment { time_s, kind, text });
        }
    }

    pub(crate) fn record(&mut self, record: &RunRecord) {
        match record {
            RunRecord::Decision(decision) if decision.changed => {
                let (from, to) = (decision.before_name(), decision.choice_name());
                let text = format!("{}: {from} › {to}", decision.group);
                self.add(decision.time_s, MomentKind::Takeover, text);
            }
            RunRecord::Other(event) if MarkKind::of(&event.what).severity() == Severity::Bad => {
                self.add(event.time_s(), MomentKind::Fault, event.to_string());
            }
            RunRecord::Decision(_) | RunRecord::Other(_) | RunRecord::State(_) => {}
        }
    }

    pub(crate) fn value(&mut self, time_s: f64, name: &str, message: &[u8]) {
        let mut left_out = LeftOut::default();
        if let Some((variable, contacts)) = self.truths.get_mut(name)
            && let Ok(bytes) = variable.decode(message, &mut left_out)
            && let Some(truth) = Truth::from_bytes(&bytes)
        {
            let before = contacts.replace(truth.collisions);
            if before.is_some_and(|before| before < truth.collisions) {
                let robot = name.split('.').next().unwrap_or_default();
                self.add(time_s, MomentKind::Contact, format!("{robot} touches something"));
            }
        } else if let Some((variable, has_failed)) = self.missions.get_mut(name)
            && let Ok(bytes) = variable.decode(message, &mut left_out)
            && let Some(mission) = Mission::from_bytes(&bytes)
        {
            let fails = mission.state == Mission::FAILED;
            let failed = std::mem::replace(has_failed, fails);
            if fails && !failed {
                let text = format!("{name} failed: {}", mission.note.as_str());
                self.add(time_s, MomentKind::Failure, text);
            }
        }
    }
}
