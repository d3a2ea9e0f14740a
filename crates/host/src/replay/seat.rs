//! One schema that takes its turns again: which of its steps are done, and what awaits it that the past has yet to tell of.

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
    /// Its turns are those of the past; otherwise by its own period.
    pub(super) told: bool,
    /// It was awake in the past.
    pub(super) was_awake: bool,
    /// It is to wake up or to fall asleep since then, as soon as the past tells of it.
    pub(super) life: VecDeque<(bool, Nanos)>,
    /// It is asked since then.
    pub(super) asked: Vec<Asked>,
    /// When its next turn is due by its own period.
    pub(super) due: Option<Nanos>,
    /// What the check of its present turn found.
    pub(super) checked: Option<Result<instance::Answer, String>>,
    /// The turn whose iteration it has leave for.
    pub(super) leave: Option<Arc<Told>>,
    /// A turn of the past has begun, and its last step is to come.
    pub(super) in_turn: bool,
    /// What it asked for its children in that, and was not done yet.
    pub(super) leads: Vec<Led>,
    /// How that ended.
    pub(super) acted: Option<Result<(), String>>,
    /// What it answered, and the rules have yet to be told.
    pub(super) answer: Option<(GroupId, u64, Answer)>,
    /// Why it failed when it was touched, and the rules have yet to be told.
    pub(super) touched: Option<String>,
    /// What it saw at its last check.
    pub(super) saw: Vec<Shown>,
}

/// A question to a father.
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

    /// Since when something awaits it that the past has not told of.
    pub(super) fn waits_since(&self) -> Option<Nanos> {
        let life = self.life.front().map(|(_, since)| *since);
        let asked = self.asked.iter().map(|asked| asked.since);
        life.into_iter().chain(asked).min()
    }

    /// Takes the next step of its life.
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

    /// Has it take its turns by its own period, if the past tells none of them.
    pub(super) fn go_on(&mut self, now: Nanos) {
        self.due = None;
        if !self.told && self.runner.is_awake() {
            self.runner.go_on(now);
            self.due = Some(now);
        }
    }

    /// The question that a turn of then answered; it may have been asked anew before that turn began. Older ones of its group are
    /// void.
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

    /// Answers every question at once.
    pub(super) fn answer_all(&mut self) {
        for Asked {
            group, ticket, level, ..
        } in std::mem::take(&mut self.asked)
        {
            self.runner.arbitrate_now(group, ticket, &level);
        }
    }

    /// Tells the rules that it failed when it was touched, if it did.
    pub(super) fn fail(&mut self) {
        if let Some(reason) = self.touched.take() {
            self.runner.fault_now(reason);
        }
    }

    /// Its present turn is over.
    pub(super) fn rest(&mut self) {
        (self.checked, self.acted, self.leave) = (None, None, None);
        self.runner.rest_again();
    }

    /// One step of a period.
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
                    // It had no leave then: there is no step of the past for this iteration.
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

    /// The iteration that it has leave for. What it asks for its children meanwhile is done when it was done first.
    pub(super) fn act(&mut self, engine: &Engine) {
        if let Some(turn) = self.leave.take() {
            self.runner.recall(Some(&turn));
            engine.put_off();
            self.acted = Some(self.runner.act_again());
            self.leads = engine.taken_on();
        }
    }

    /// Does what it asked for and the past has no step for.
    pub(super) fn lead_all(&mut self, engine: &Engine) {
        for led in std::mem::take(&mut self.leads) {
            engine.carry_on(led);
        }
    }
}
