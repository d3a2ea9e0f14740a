//! What is told of the past, and by whom.

use std::sync::Arc;

use jde_core::Nanos;
use jde_panel::Gesture;

use crate::turn::{Call, Moment, Told};

/// Tells what happened, in the order in which it did.
pub trait Past: Send {
    /// The next step; none at the end.
    fn next(&mut self) -> Option<Step>;

    /// The next value of a source, given by its place among [`super::sources`], if it was published until then.
    fn value_until(&mut self, source: usize, time: Nanos) -> Option<Old>;

    /// The next value of a source whose number is at most that; it may have been published a little later than it was seen.
    fn value_up_to(&mut self, source: usize, number: u32) -> Option<Old>;

    /// The bytes of the value of that number of a variable that a schema or an operator writes.
    fn written(&mut self, variable: &str, number: u32) -> Option<Vec<u8>>;

    /// The gesture of that number, and whose it was.
    fn touched(&mut self, number: u64) -> Option<(String, Gesture)>;
}

/// A value of the past.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Old {
    /// When it was published, or taken back.
    pub published: Nanos,
    /// When it was measured.
    pub measured: Nanos,
    /// Its number.
    pub number: u32,
    /// Its bytes; none if the value before it was taken back then.
    pub bytes: Option<Vec<u8>>,
}

/// One step of a turn.
#[derive(Clone, Debug)]
pub struct Step {
    /// Which.
    pub part: Part,
    /// Whether it is the last of its turn.
    pub last: bool,
    /// The turn; schemas, groups and ports in it are those of the application that takes it again.
    pub turn: Arc<Told>,
    /// The transaction it was, or the last before it.
    pub order: u64,
    /// When it was.
    pub time: Nanos,
}

/// The steps of turns, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// The call of the check, or the only one.
    Looked,
    /// The rules were told of the check, or of whatever there was.
    Checked,
    /// Leave to iterate was asked.
    Begun,
    /// The call of the iteration.
    Acted,
    /// The rules were told that a call failed.
    Failed,
    /// The rules were told of the end of the iteration.
    Ended,
}

impl Step {
    /// The steps of a turn, in their order.
    #[must_use]
    pub fn of(turn: &Arc<Told>) -> Vec<Self> {
        let call = |call: &Call| call.happened().then_some((call.after, call.time));
        let moment = |moment: &Moment| (moment.order > 0).then_some((moment.order, moment.time));
        let parts = [
            (Part::Looked, call(&turn.looked)),
            (Part::Checked, moment(&turn.checked)),
            (Part::Begun, moment(&turn.begun)),
            (Part::Acted, call(&turn.acted)),
            (Part::Failed, moment(&turn.failed)),
            (Part::Ended, moment(&turn.ended)),
        ];
        let steps = parts.into_iter().filter_map(|(part, when)| {
            let (order, time) = when?;
            Some(Self {
                part,
                last: false,
                turn: Arc::clone(turn),
                order,
                time,
            })
        });
        let mut steps: Vec<_> = steps.collect();
        if let Some(last) = steps.last_mut() {
            last.last = true;
        }
        steps
    }

    /// Whether it is a transaction of the rules.
    #[must_use]
    pub fn is_transaction(&self) -> bool {
        match self.part {
            Part::Checked | Part::Begun | Part::Failed | Part::Ended => true,
            Part::Looked | Part::Acted => false,
        }
    }

    /// What the schema was told when it asked for the time, or when the rules were told.
    pub(super) fn clock(&self) -> Nanos {
        match self.part {
            Part::Looked => self.turn.looked.clock,
            Part::Acted => self.turn.acted.clock,
            Part::Checked | Part::Begun | Part::Failed | Part::Ended => self.time,
        }
    }
}
