//! The variables and panels of a recording, as shared variables and panels with the interface of a running
//! application's.

use std::collections::BTreeMap;
use std::sync::Arc;

use jde_board::{Access, Board, Declaration, LASTING, Nanos, Variable, Writer};
use jde_ros::cdr;

use super::index::{Index, RecordedValue};
use super::panel_store::PanelStore;

/// Readers that borrow large values at the same time: the link, and one more.
const MAX_READERS: usize = 2;

/// The variables with their writers, and the panels.
pub(super) struct Publisher {
    writers: BTreeMap<String, VariableWriter>,
    /// Schemas by the topics of their panels.
    panels: BTreeMap<String, String>,
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
    /// Declares the variables of a recording. Omits a variable whose name has no schema or is already in use.
    pub(super) fn new(board: &Board, index: &Index, panel_store: Arc<PanelStore>) -> Self {
        let mut writers = BTreeMap::new();
        for (topic, recorded) in &index.variables {
            let Some((owner, name)) = recorded.name.rsplit_once('.') else {
                continue;
            };
            let access = match recorded.access.as_str() {
                "modulation" => Access::Modulation,
                "command" => Access::Command { validity: Nanos::MAX },
                // Where a value ended, the recording says so.
                _ => Access::Export { validity: LASTING },
            };
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
            let Ok(variable) = declared else { continue };
            let writer_entry = match access {
                Access::Export { .. } => match variable.writer(WRITER_ID, "recording") {
                    Ok(writer) => VariableWriter::Export(variable, writer),
                    Err(_) => continue,
                },
                Access::Modulation | Access::Command { .. } => VariableWriter::Other(variable),
            };
            writers.insert(topic.clone(), writer_entry);
        }
        Self {
            writers,
            panels: index.panels.clone(),
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
        let Some(writer_entry) = self.writers.get_mut(&value.topic) else {
            return;
        };
        let (VariableWriter::Export(variable, _) | VariableWriter::Other(variable)) = &*writer_entry;
        let Ok(bytes) = cdr::decode(&variable.describe().value_type, &value.message) else {
            return;
        };
        // A value that was not finite is refused now as it was in the recorded run.
        match writer_entry {
            VariableWriter::Export(_, writer) => {
                writer.loan().copy_from_slice(&bytes);
                let _ = writer.publish(value.measured, value.published);
            }
            VariableWriter::Other(variable) => {
                let _ = variable.put(WRITER_ID, &bytes, value.measured, Nanos::MAX);
            }
        }
    }

    /// Retracts every export and clears every panel: the next values belong to another time, `time`.
    pub(super) fn clear(&self, time: Nanos) {
        self.panel_store.clear(time);
        for writer_entry in self.writers.values() {
            if let VariableWriter::Export(variable, _) = writer_entry {
                variable.retract();
            }
        }
    }
}
