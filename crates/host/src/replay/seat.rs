//! The state of one schema that takes its turns again: its completed steps, and the pending actions for which
//! the past has not supplied a step yet.

use std::collections::VecDeque;
use std::sync::Arc;

use jde_core::{Answer, GroupId, Level, Nanos};

use super::past::Part;
use crate::engine::{Engine, Led};
use crate::instance::{self, Shown};
use crate::runner::Runner;
use crate::turn::{Told, Turn};

/// A schema that takes its turns again.
pub(super) struct Seat {
    pub(super) runner: Runner,
    /// Its turns come from the past; otherwise it takes turns by its own period.
    pub(super) told: bool,
    /// It was awake in the past.
    pub(super) was_awake: bool,
    /// Pending transitions, each to awake (true) or asleep, and since when; they wait for their step of the
    /// past.
    pub(super) life: VecDeque<(bool, Nanos)>,
    /// Pending arbitrations.
    pub(super) asked: Vec<Asked>,
    /// When its next turn is due by its own period.
    pub(super) due: Option<Nanos>,
    /// The result of the check of its present turn.
    pub(super) checked: Option<Result<instance::Answer, String>>,
    /// The turn whose iteration is permitted and not taken yet.
    pub(super) leave: Option<Arc<Told>>,
    /// A turn of the past has begun, and its last step is still to be taken.
    pub(super) in_turn: bool,
    /// Actions on its children that the iteration requested and that are not carried out yet.
    pub(super) leads: Vec<Led>,
    /// The result of the iteration.
    pub(super) acted: Option<Result<(), String>>,
    /// The result of an arbitration that the rules have not received yet.
    pub(super) answer: Option<(GroupId, u64, Answer)>,
    /// The error of a gesture that the rules have not received yet.
    pub(super) touched: Option<String>,
    /// What it read at its last check.
    pub(super) saw: Vec<Shown>,
}

/// An arbitration requested of a father.
pub(super) struct Asked {
    pub(super) since: Nanos,
    pub(super) group: GroupId,
    pub(super) ticket: u64,
    pub(super) level: Level,
}

impl Seat {
    pub(super) fn new(runner: Runner) -> Self {
        Self {
            runner,
            told: false,
            was_awake: false,
            life: VecDeque::new(),
            asked: Vec::new(),
            due: None,
            checked: None,
            leave: None,
            in_turn: false,
            leads: Vec::new(),
            acted: None,
            answer: None,
            touched: None,
            saw: Vec::new(),
        }
    }

    /// Returns since when the oldest pending action waits for the past.
    pub(super) fn waits_since(&self) -> Option<Nanos> {
        let life = self.life.front().map(|(_, since)| *since);
        let asked = self.asked.iter().map(|asked| asked.since);
        life.into_iter().chain(asked).min()
    }

    /// Carries out a transition.
    pub(super) fn live(&mut self, awake: bool, now: Nanos) {
        if awake {
            self.runner.awake_now();
            self.told = self.was_awake;
            self.go_on(now);
        } else {
            self.runner.sleep_now();
            self.due = None;
        }
    }

    /// Lets it take turns by its own period, if the past contains none of them.
    pub(super) fn go_on(&mut self, now: Nanos) {
        self.due = None;
        if !self.told && self.runner.is_awake() {
            self.runner.go_on(now);
            self.due = Some(now);
        }
    }

    /// Takes the pending arbitration that a recorded turn answered, or a newer one of the same group, since
    /// the request may have been repeated before that turn. Older ones of the group are void.
    pub(super) fn question(&mut self, turn: &Turn) -> Option<Asked> {
        let group = |asked: &Asked| u64::from(asked.group.0) == turn.detail;
        let same = |asked: &Asked| group(asked) && asked.ticket == turn.ticket;
        let place = self
            .asked
            .iter()
            .position(same)
            .or_else(|| self.asked.iter().rposition(group))?;
        let question = self.asked.remove(place);
        self.asked
            .retain(|asked| !group(asked) || asked.ticket > question.ticket);
        Some(question)
    }

    /// Answers every pending arbitration at once.
    pub(super) fn answer_all(&mut self) {
        for Asked {
            group, ticket, level, ..
        } in std::mem::take(&mut self.asked)
        {
            self.runner.arbitrate_now(group, ticket, &level);
        }
    }

    /// Reports the error of a gesture to the rules, if there is one.
    pub(super) fn fail(&mut self) {
        if let Some(reason) = self.touched.take() {
            self.runner.fault_now(reason);
        }
    }

    /// Ends the present turn.
    pub(super) fn rest(&mut self) {
        (self.checked, self.acted, self.leave) = (None, None, None);
        self.runner.rest_again();
    }

    /// Takes one step of a period.
    pub(super) fn cycle(&mut self, engine: &Engine, part: Part, turn: &Arc<Told>) {
        if !self.runner.is_awake() {
            return;
        }
        match part {
            Part::Looked => {
                self.runner.recall(Some(turn));
                self.checked = self.runner.look_again();
                self.saw = self.runner.shown();
            }
            Part::Checked | Part::Failed => {
                if let Some(checked) = self.checked.take() {
                    self.runner.checked_again(checked);
                }
            }
            Part::Begun => {
                let leave = self.runner.begin_again(turn);
                if leave && !turn.acted.happened() {
                    // The iteration was not permitted in the past, so the past has no step for it.
                    let acted = self.runner.act_again();
                    self.runner.acted_again(acted);
                } else if leave {
                    self.leave = Some(Arc::clone(turn));
                }
            }
            Part::Acted => self.act(engine),
            Part::Ended => {
                self.act(engine);
                self.lead_all(engine);
                if let Some(acted) = self.acted.take() {
                    self.runner.acted_again(acted);
                }
            }
        }
    }

    /// Takes the permitted iteration. Its actions on children are put off until their recorded steps.
    pub(super) fn act(&mut self, engine: &Engine) {
        if let Some(turn) = self.leave.take() {
            self.runner.recall(Some(&turn));
            engine.put_off();
            self.acted = Some(self.runner.act_again());
            self.leads = engine.taken_on();
        }
    }

    /// Carries out the requested actions for which the past has no step.
    pub(super) fn lead_all(&mut self, engine: &Engine) {
        for led in std::mem::take(&mut self.leads) {
            engine.carry_on(led);
        }
    }
}
