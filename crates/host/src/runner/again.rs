//! Repeats a turn in a replay, a step at a time: each step at its original time, with the values that were
//! seen then.

use std::sync::Arc;

use jde_board::{Reader, Variable};
use jde_core::{Answer, GroupId, Level, Nanos};
use jde_panel::Gesture;

use super::{Life, Runner};
use crate::history::History;
use crate::instance::{self, Ports, Shown, Wrote};
use crate::turn::{Told, Turn};

impl Runner {
    /// Makes its inputs show values of the past.
    pub(crate) fn look_back(&mut self, history: impl FnMut(&Reader) -> Arc<History>) {
        self.desk.ports(|ports| ports.look_back(history));
    }

    /// Makes its inputs show what they showed in that turn; the newest values without a turn.
    pub(crate) fn recall(&mut self, turn: Option<&Told>) {
        self.desk.ports(|ports| ports.recall(turn));
    }

    pub(crate) fn is_awake(&self) -> bool {
        matches!(self.life, Life::Awake { .. })
    }

    /// Repeats the check. `None` if the instance is not awake.
    pub(crate) fn look_again(&mut self) -> Option<Result<instance::Answer, String>> {
        match &mut self.life {
            Life::Awake { instance, .. } => {
                let checked = instance.check();
                instance.called(&mut self.told, &mut self.beyond);
                Some(checked)
            }
            Life::Absent | Life::Slept(_) | Life::Changing => None,
        }
    }

    /// What its inputs show.
    pub(crate) fn shown(&mut self) -> Vec<Shown> {
        self.desk.ports(|ports| ports.shown()).unwrap_or_default()
    }

    /// What it has written since the last call of this function, in calls that turns record.
    pub(crate) fn wrote(&mut self) -> Vec<Wrote> {
        std::mem::take(&mut self.beyond.wrote)
    }

    /// The variable that a port writes; `None` if it is not bound to one.
    pub(crate) fn written_by(&mut self, port: usize) -> Option<Arc<Variable>> {
        let variable = |ports: &mut Ports| {
            let written = ports.variable(port).filter(|(_, writes)| *writes);
            written.map(|(variable, _)| Arc::clone(variable))
        };
        self.desk.ports(variable).flatten()
    }

    /// Reports the result of that check to the rules.
    pub(crate) fn checked_again(&mut self, result: Result<instance::Answer, String>) {
        if let Some(check) = self.found(self.engine.clock.now(), result) {
            self.told.checked = self.engine.checked(self.number, check);
        }
    }

    /// Asks permission to iterate, in the way of that turn.
    pub(crate) fn begin_again(&mut self, turn: &Turn) -> bool {
        self.is_awake()
            && match turn.way {
                Turn::FIRST => self.engine.begin_first(self.number).0,
                _ => self.engine.begin(self.number).0,
            }
    }

    /// Repeats the iteration.
    pub(crate) fn act_again(&mut self) -> Result<(), String> {
        self.iterate()
    }

    /// Reports the end of that iteration to the rules.
    pub(crate) fn acted_again(&mut self, result: Result<(), String>) {
        self.iterated(result);
    }

    /// Repeats a gesture on its panel.
    pub(crate) fn touch_again(&mut self, by: &str, gesture: &Gesture) -> Result<(), String> {
        match &mut self.life {
            Life::Slept(instance) | Life::Awake { instance, .. } => {
                let touched = instance.touch(by, gesture);
                instance.called(&mut self.told, &mut self.beyond);
                touched
            }
            Life::Absent | Life::Changing => Ok(()),
        }
    }

    /// Handles a failed call.
    pub(crate) fn fault_now(&mut self, reason: String) {
        self.fault(reason);
    }

    /// Calls the father's own arbitration.
    pub(crate) fn answer_again(&mut self, level: &Level) -> Answer {
        self.answer(level)
    }

    /// Calls the father's own arbitration, and reports the answer to the rules at once.
    pub(crate) fn arbitrate_now(&mut self, group: GroupId, ticket: u64, level: &Level) {
        self.arbitrate(group, ticket, level);
    }

    /// Ends the instance as soon as it sleeps.
    pub(crate) fn unload_now(&mut self) {
        self.unload();
    }

    /// Releases the values read, and shows the newest values again.
    pub(crate) fn rest_again(&mut self) {
        self.recall(None);
        self.rest();
    }

    pub(crate) fn awake_now(&mut self) {
        self.wake_up(self.engine.clock.now());
    }

    pub(crate) fn sleep_now(&mut self) {
        self.fall_asleep();
    }

    pub(crate) fn retime_now(&mut self) {
        self.retime();
    }

    pub(crate) fn give_up_now(&mut self) {
        self.give_up();
    }

    /// From now on it takes its turns by its own period.
    pub(crate) fn go_on(&mut self, now: Nanos) {
        self.be_due(now);
    }
}
