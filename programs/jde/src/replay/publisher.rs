//! The variables and panels of a recording, as shared variables and panels with the interface of a running
//! application's.

use std::collections::BTreeMap;
use std::sync::Arc;

use jde_board::{Access, Board, Declaration, LASTING, Nanos, Variable, Writer};
use jde_files::Budget;
use jde_log::{LeftOut, RecordedVariable};

use super::index::{Index, RecordedValue};
use super::panel_store::PanelStore;

/// Readers that borrow large values at the same time: the link, and one more.
const MAX_READERS: usize = 2;

/// The memory that the values of all variables may need, in bytes.
const MAX_BYTES: u64 = 384 << 20;
/// The most topics of another program that are played: each is announced to tools, which takes milliseconds.
const MAX_TOPICS: u64 = 4096;
/// What a variable takes besides its values: its description, and what the link keeps of it, in bytes.
const VARIABLE_BYTES: usize = 16 << 10;
/// How often the memory of a variable has room for a value: its readers, its writer, and what the board adds.
const VALUE_SLOTS: usize = MAX_READERS + 3;

/// The variables with their writers, and the panels.
pub(super) struct Publisher {
    writers: BTreeMap<String, (RecordedVariable, VariableWriter)>,
    /// Schemas by the topics of their panels.
    panels: Arc<BTreeMap<String, String>>,
    panel_store: Arc<PanelStore>,
}

enum VariableWriter {
    Export(Arc<Variable>, Writer),
    /// Written by a writer that needs no authority.
    Other(Arc<Variable>),
}

/// The writer of all played values.
const WRITER_ID: u32 = 0;

impl Publisher {
    /// Declares the variables of a recording. Those that cannot be declared are added to what is left out of it.
    pub(super) fn new(board: &Board, index: &mut Index, panel_store: Arc<PanelStore>) -> Self {
        let mut writers = BTreeMap::new();
        let mut budget = Budget::new(MAX_BYTES, MAX_TOPICS, 0);
        for recorded in index.variables.iter() {
            // The topic of another program may have a name of one part.
            let (owner, name) = recorded.name.rsplit_once('.').unwrap_or(("", &recorded.name));
            let access = match recorded.access.as_str() {
                "modulation" => Access::Modulation,
                "command" => Access::Command { validity: Nanos::MAX },
                // Where a value ended, the recording says so.
                _ => Access::Export { validity: LASTING },
            };
            if recorded.is_foreign() && budget.work(1).is_err() {
                let why = format_args!("at most {MAX_TOPICS} topics are played");
                index.left_out.add(&recorded.topic, None, why);
                continue;
            }
            if budget
                .hold(
                    recorded
                        .value_type
                        .bytes
                        .saturating_mul(VALUE_SLOTS)
                        .saturating_add(VARIABLE_BYTES),
                )
                .is_err()
            {
                let why = format_args!(
                    "with its values, the recording would need more than {} MB of memory",
                    MAX_BYTES >> 20
                );
                index.left_out.add(&recorded.topic, None, why);
                continue;
            }
            let declared = board.declare(Declaration {
                owner: owner.to_owned(),
                name: name.to_owned(),
                doc: recorded.doc.clone(),
                unit: recorded.unit.clone(),
                value_type: Arc::clone(&recorded.value_type),
                access,
                limits: jde_abi::describe::Limits::default(),
                initial: None,
                writers: 1,
                readers: MAX_READERS,
            });
            let writer = declared.and_then(|variable| match access {
                Access::Export { .. } => {
                    let writer = variable.writer(WRITER_ID, "recording")?;
                    Ok(VariableWriter::Export(variable, writer))
                }
                Access::Modulation | Access::Command { .. } => Ok(VariableWriter::Other(variable)),
            });
            match writer {
                Ok(writer) => drop(writers.insert(recorded.topic.clone(), (recorded.clone(), writer))),
                Err(reason) => index.left_out.add(&recorded.topic, None, reason),
            }
        }
        Self {
            writers,
            panels: Arc::clone(&index.panels),
            panel_store,
        }
    }

    /// Publishes a value, or shows a panel. Ignores a value that does not fit its type, which the index has counted.
    pub(super) fn publish(&mut self, value: &RecordedValue) {
        if let Some(schema) = self.panels.get(&value.topic) {
            let list = jde_log::panel::read(&value.message);
            let list = list.unwrap_or_else(|broken| Err(format!("it cannot be shown: {broken}")));
            return self.panel_store.set_drawing(schema, value.measured, list);
        }
        let Some((recorded, writer_entry)) = self.writers.get_mut(&value.topic) else {
            return;
        };
        // The index has counted what is cut.
        let mut left_out = LeftOut::default();
        // A value that was not finite is refused now as it was in the recorded run.
        match writer_entry {
            // Only the elements that are there take memory.
            VariableWriter::Export(_, writer) => {
                if recorded
                    .decode_into(&value.message, writer.loan(), &mut left_out)
                    .is_ok()
                {
                    let _ = writer.publish(value.measured, value.published);
                }
            }
            VariableWriter::Other(variable) => {
                if let Ok(bytes) = recorded.decode(&value.message, &mut left_out) {
                    let _ = variable.put(WRITER_ID, &bytes, value.measured, Nanos::MAX);
                }
            }
        }
    }

    /// Ends the value of a topic at a time, as the recording says (R19).
    pub(super) fn end(&self, topic: &str, time: Nanos) {
        match self.writers.get(topic) {
            Some((_, VariableWriter::Export(variable, _))) => variable.retract(),
            Some((_, VariableWriter::Other(variable))) => {
                // A command ends by its validity: the same value is published again with another one.
                let mut reader = variable.reader("recording");
                let newest = reader.latch(0);
                let newest = newest.map(|newest| (newest.bytes.to_vec(), newest.stamp.time));
                drop(reader);
                if let Some((bytes, measured)) = newest {
                    let _ = variable.put(WRITER_ID, &bytes, measured, time.saturating_sub(1));
                }
            }
            None => {}
        }
    }

    /// Retracts every export and clears every panel: the next values belong to another time, `time`.
    pub(super) fn clear(&self, time: Nanos) {
        self.panel_store.clear(time);
        for (_, writer_entry) in self.writers.values() {
            if let VariableWriter::Export(variable, _) = writer_entry {
                variable.retract();
            }
        }
    }
}
