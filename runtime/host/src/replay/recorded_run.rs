//! The interface of a recorded run. It reads no recording itself.

use std::sync::Arc;

use jde_core::Nanos;
use jde_panel::Gesture;

use jde_records::turn::{Call, Moment, RecordedTurn};

/// Supplies the recorded steps in their order, and the recorded values.
pub trait RecordedRun: Send {
    /// Returns the next step; `None` at the end.
    fn next(&mut self) -> Option<ReplayStep>;

    /// Returns the next value of a source, given by its place among [`super::sources`], if it was published
    /// at `time` or before.
    fn value_until(&mut self, source: usize, time: Nanos) -> Option<RecordedValue>;

    /// Returns the next value of a source whose number is at most `number`. It may have been published
    /// slightly later than it was read.
    fn value_up_to(&mut self, source: usize, number: u32) -> Option<RecordedValue>;

    /// Returns the bytes of the value of that number of a variable that a schema or an operator writes.
    fn written_value(&mut self, variable: &str, number: u32) -> Option<Vec<u8>>;

    /// Returns the gesture of that number and the name of its operator.
    fn gesture(&mut self, number: u64) -> Option<(String, Gesture)>;
}

/// A recorded value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordedValue {
    /// When it was published or retracted.
    pub published: Nanos,
    /// When it was measured.
    pub measured: Nanos,
    /// Its sequence number.
    pub number: u32,
    /// Its bytes; `None` if the value before it was retracted.
    pub bytes: Option<Vec<u8>>,
}

/// One step of a turn.
#[derive(Clone, Debug)]
pub struct ReplayStep {
    /// The kind of step.
    pub kind: StepKind,
    /// Whether it is the last step of its turn.
    pub is_last: bool,
    /// The turn; its schemas, groups and ports are numbered as in the application that takes it again.
    pub turn: Arc<RecordedTurn>,
    /// The number of its transaction, or for a call, of the last transaction before it.
    pub order: u64,
    /// When it was taken, ns.
    pub time: Nanos,
}

/// The steps of a turn, in their usual order. If the iteration began early, its beginning is the
/// first and the result of the check follows the iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum StepKind {
    /// The call of the check, or the only call.
    CheckCall,
    /// The rules received the result of the check, or another report of the turn.
    Checked,
    /// The schema requested permission to iterate.
    Begun,
    /// The call of the iteration.
    IterationCall,
    /// The rules received the failure of a call.
    Failed,
    /// The rules received the end of the iteration.
    Ended,
}

impl ReplayStep {
    /// Returns the steps of a turn, in their order.
    #[must_use]
    pub fn of(turn: &Arc<RecordedTurn>) -> Vec<Self> {
        let call = |call: &Call| call.has_occurred().then_some((call.after, call.time));
        let moment = |moment: &Moment| (moment.order > 0).then_some((moment.order, moment.time));
        let mut candidates = [
            (StepKind::CheckCall, call(&turn.looked)),
            (StepKind::Checked, moment(&turn.checked)),
            (StepKind::Begun, moment(&turn.begun)),
            (StepKind::IterationCall, call(&turn.acted)),
            (StepKind::Failed, moment(&turn.failed)),
            (StepKind::Ended, moment(&turn.ended)),
        ];
        if turn.began_early() {
            // Begun, the call of the check, the call of the iteration, checked.
            candidates[..3].rotate_right(1);
            candidates.swap(2, 3);
        }
        let steps = candidates.into_iter().filter_map(|(kind, occurrence)| {
            let (order, time) = occurrence?;
            Some(Self {
                kind,
                is_last: false,
                turn: Arc::clone(turn),
                order,
                time,
            })
        });
        let mut steps: Vec<_> = steps.collect();
        if let Some(last) = steps.last_mut() {
            last.is_last = true;
        }
        steps
    }

    /// Whether it is a transaction of the rules.
    #[must_use]
    pub fn is_transaction(&self) -> bool {
        match self.kind {
            StepKind::Checked | StepKind::Begun | StepKind::Failed | StepKind::Ended => true,
            StepKind::CheckCall | StepKind::IterationCall => false,
        }
    }

    /// Returns the time that the schema obtained from the clock in a call, or the time of a transaction.
    pub(super) fn clock(&self) -> Nanos {
        match self.kind {
            StepKind::CheckCall => self.turn.looked.clock,
            StepKind::IterationCall => self.turn.acted.clock,
            StepKind::Checked | StepKind::Begun | StepKind::Failed | StepKind::Ended => self.time,
        }
    }
}
