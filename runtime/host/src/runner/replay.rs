//! Repeats a turn in a replay, a step at a time: each step at its original time, with the values that it read
//! then.

use std::sync::Arc;

use jde_board::{Reader, Variable};
use jde_core::Nanos;
use jde_panel::Gesture;
use jde_records::turn::{Permission, RecordedTurn, Turn, TurnKind};

use super::Runner;
use super::deadlines::Deadlines;
use super::phase::{Installed, Phase};
use crate::history::History;
use crate::instance::{self, PortWrite, Ports, ShownValue};

impl Runner {
    /// Makes its inputs show recorded values.
    pub(crate) fn read_from_history(&mut self, history: impl FnMut(&Reader) -> Arc<History>) {
        self.port_access
            .with_ports(|ports| ports.read_from_history(history));
    }

    /// Makes its inputs show the values that they showed in that turn; the newest values without a turn.
    pub(crate) fn show_recorded(&mut self, turn: Option<&RecordedTurn>) {
        self.port_access.with_ports(|ports| ports.show_recorded(turn));
    }

    pub(crate) fn is_awake(&self) -> bool {
        self.phase.is_awake()
    }

    /// Repeats the check. `None` if the instance is not awake.
    pub(crate) fn repeat_check(&mut self) -> Option<Result<instance::CheckResult, String>> {
        let Phase::Awake(Installed { instance, .. }, _) = &mut self.phase else {
            return None;
        };
        let result = instance.check();
        self.record.add_look(instance);
        Some(result)
    }

    /// Returns the values that its inputs show.
    pub(crate) fn shown_inputs(&mut self) -> Vec<ShownValue> {
        self.port_access
            .with_ports(|ports| ports.shown_values())
            .unwrap_or_default()
    }

    /// Returns the writes since the last call of this function, in calls that turns record.
    pub(crate) fn take_writes(&mut self) -> Vec<PortWrite> {
        self.record.take_writes()
    }

    /// Returns the variable that a port writes; `None` if it is not bound to one.
    pub(crate) fn written_variable(&mut self, port: usize) -> Option<Arc<Variable>> {
        let variable = |ports: &mut Ports| {
            let written = ports.variable(port).filter(|(_, writes)| *writes);
            written.map(|(variable, _)| Arc::clone(variable))
        };
        self.port_access.with_ports(variable).flatten()
    }

    /// Reports the result of that check to the rules.
    pub(crate) fn report_check(&mut self, result: Result<instance::CheckResult, String>) {
        if let Some(check) = self.handle_check_result(self.engine.clock.now(), result) {
            self.record.turn.checked = self.engine.rules.report_check(self.number, check);
        }
    }

    /// Requests permission to iterate, in the way of that turn.
    pub(crate) fn repeat_begin(&mut self, turn: &Turn) -> bool {
        self.is_awake()
            && match turn.kind() {
                TurnKind::Cycled(Some(Permission::First)) => {
                    self.engine.rules.request_first_iteration(self.number).0
                }
                _ => self.engine.rules.request_iteration(self.number).0,
            }
    }

    /// Repeats that a guard refused a command of it.
    pub(crate) fn repeat_refusal(&self) {
        self.engine.repeat_refusal(self.number, &self.port_access);
    }

    /// Repeats a gesture on its panel.
    pub(crate) fn repeat_gesture(&mut self, by: &str, gesture: &Gesture) -> Result<(), String> {
        let Some(instance) = self.phase.instance() else {
            return Ok(());
        };
        let result = instance.touch(by, gesture);
        self.record.add_look(instance);
        result
    }

    /// Releases the values read, and shows the newest values again.
    pub(crate) fn end_recorded_turn(&mut self) {
        self.show_recorded(None);
        self.release_values();
    }

    pub(crate) fn awake_now(&mut self) {
        self.wake_up(self.engine.clock.now());
    }

    /// From now on it takes its turns by its own period.
    pub(crate) fn start_own_turns(&mut self, now: Nanos) {
        if let Some(awake) = self.phase.awake() {
            awake.deadlines = Deadlines::starting_at(now);
        }
    }
}
