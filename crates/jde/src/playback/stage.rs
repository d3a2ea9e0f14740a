//! The variables of a recording as shared variables, so that whoever reads those of a running application reads these.

use std::collections::BTreeMap;
use std::sync::Arc;

use jde_board::{Access, Board, Declaration, Nanos, Variable, Writer};
use jde_ros::cdr;

use super::index::{Recorded, Value};

/// Readers that borrow large values at once: the link, and one more.
const READERS: usize = 2;

/// The variables, and the right to write them.
pub(super) struct Stage {
    writers: BTreeMap<String, Seat>,
}

enum Seat {
    Export(Arc<Variable>, Writer),
    /// Written as whoever has no authority to lose.
    Other(Arc<Variable>),
}

/// Who writes what is played.
const PLAYER: u32 = 0;

impl Stage {
    /// Declares the variables of a recording. One that has no name of its own, or one that is another's, is left out.
    pub(super) fn new(board: &Board, variables: &BTreeMap<String, Recorded>) -> Self {
        let mut writers = BTreeMap::new();
        for (topic, recorded) in variables {
            let Some((owner, name)) = recorded.name.rsplit_once('.') else {
                continue;
            };
            let access = match recorded.access.as_str() {
                "modulation" => Access::Modulation,
                "command" => Access::Command { validity: Nanos::MAX },
                _ => Access::Export,
            };
            let declared = board.declare(Declaration {
                owner: owner.to_owned(),
                name: name.to_owned(),
                doc: recorded.doc.clone(),
                unit: recorded.unit.clone(),
                value_type: Arc::clone(&recorded.value_type),
                access,
                initial: None,
                writers: 1,
                readers: READERS,
            });
            let Ok(variable) = declared else { continue };
            let seat = match access {
                Access::Export => match variable.writer(PLAYER, "recording") {
                    Ok(writer) => Seat::Export(variable, writer),
                    Err(_) => continue,
                },
                Access::Modulation | Access::Command { .. } => Seat::Other(variable),
            };
            writers.insert(topic.clone(), seat);
        }
        Self { writers }
    }

    /// Publishes a value. One that is of another type than its definition says is left out.
    pub(super) fn publish(&mut self, value: &Value) {
        let Some(seat) = self.writers.get_mut(&value.topic) else {
            return;
        };
        let (Seat::Export(variable, _) | Seat::Other(variable)) = &*seat;
        let Ok(bytes) = cdr::decode(&variable.describe().value_type, &value.message) else {
            return;
        };
        // What was not finite then is refused now as it was then.
        match seat {
            Seat::Export(_, writer) => {
                writer.loan().copy_from_slice(&bytes);
                let _ = writer.publish(value.measured, value.published);
            }
            Seat::Other(variable) => {
                let _ = variable.put(PLAYER, &bytes, value.measured, Nanos::MAX);
            }
        }
    }

    /// Takes back every export: what is shown next is of another time.
    pub(super) fn clear(&self) {
        for seat in self.writers.values() {
            if let Seat::Export(variable, _) = seat {
                variable.retract();
            }
        }
    }
}
