//! Steps: what happens to the application during a drive, at a time or on a condition, each once.

use jde_board::value::Value;
use jde_core::Nanos;
use jde_host::Handle;

/// A step.
#[derive(Clone, Debug)]
pub struct Step {
    /// When it happens.
    pub when: StepTime,
    /// What happens.
    pub action: StepAction,
    /// Its place in the file, for messages: `file:line`.
    pub place: String,
}

/// When a step happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepTime {
    /// At this time, ns.
    At(Nanos),
    /// At the first instant at which the expression in this place is true.
    When(usize),
}

/// What a step does, as an operator (R14). Schemas are places in the application.
#[derive(Clone, Debug, PartialEq)]
pub enum StepAction {
    /// Wakes a schema.
    Play(usize),
    /// Puts a schema to sleep.
    Stop(usize),
    /// Makes a schema the winner of its group.
    Force(usize),
    /// Undoes all actions on a schema.
    Release(usize),
    /// Writes modulations and periods.
    Write(Vec<StepWrite>),
}

/// What a step writes.
#[derive(Clone, Debug, PartialEq)]
pub enum StepWrite {
    /// A modulation: schema, name, value.
    Value(usize, String, Value),
    /// The period of a schema, ns.
    Period(usize, Nanos),
}

/// The name of the operator in recordings.
const OPERATOR: &str = "experiment";

impl Step {
    /// Carries the step out.
    ///
    /// # Errors
    /// Why the application refuses it.
    pub fn perform(&self, handle: &Handle) -> Result<(), String> {
        let operator = handle.operator(OPERATOR);
        let done = match &self.action {
            StepAction::Play(schema) => operator.play(*schema),
            StepAction::Stop(schema) => operator.hold_asleep(*schema),
            StepAction::Force(schema) => operator.force(*schema),
            StepAction::Release(schema) => operator.release(*schema),
            StepAction::Write(writes) => writes.iter().try_for_each(|write| match write {
                StepWrite::Value(schema, name, value) => operator.modulate(*schema, name, value),
                StepWrite::Period(schema, period) => operator.set_period(*schema, *period),
            }),
        };
        done.map_err(|reason| format!("the step at {} was refused: {reason}", self.place))
    }
}
