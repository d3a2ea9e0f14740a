//! The values that schemas read in a replay: those of drivers and other applications come from the recording,
//! all others from the schemas that produce them now. It takes no step.

use std::collections::BTreeMap;
use std::sync::{Arc, Weak};

use jde_abi::describe::{Kind, Role};
use jde_app::{Application, Binding, ImportSource as Origin, InstanceConfig, InstancePort, RemoteVariable};
use jde_board::{Reader, Stamp, Variable, Watch, Writer};
use jde_core::Nanos;
use jde_records::turn::{RecordedTurn, Turn};

use super::recorded_run::{RecordedRun, RecordedValue};
use super::slot::ReplaySlot;
use crate::engine::Engine;
use crate::history::History;

/// The values that schemas can read.
pub(super) struct RecordedInputs {
    sources: Vec<RecordedExport>,
    histories: BTreeMap<String, Arc<History>>,
    /// Held so that the histories keep growing.
    watches: Vec<Watch>,
}

/// An export of a driver or of another application.
struct RecordedExport {
    origin: Origin,
    writer: Writer,
    history: Arc<History>,
}

/// Returns the importable variables that no schema of the replay produces: those of drivers and of other
/// applications.
pub(super) fn recorded_origins(application: &Application) -> Vec<Origin> {
    let instances = application.instances.entries();
    let drivers = instances.filter(|(_, instance)| is_driver(instance));
    let exports = drivers.flat_map(|(number, instance)| {
        let ports = instance.schema.ports.iter().enumerate();
        let exports = ports.filter(|(_, port)| matches!(port.role, Role::Export { .. }));
        exports.map(move |(port, _)| Origin::Local(InstancePort::new(number, port)))
    });
    let remotes = (0..application.remotes.len()).map(Origin::Remote);
    exports.chain(remotes).collect()
}

pub(super) fn is_driver(instance: &InstanceConfig) -> bool {
    instance.schema.kind == Kind::Driver
}

/// Whether a schema other than a driver imports it.
pub(super) fn is_imported(application: &Application, origin: Origin) -> bool {
    let schemas = application
        .instances
        .iter()
        .filter(|instance| !is_driver(instance));
    let mut bindings = schemas.flat_map(|schema| &schema.bindings);
    bindings
        .any(|binding| matches!(binding, Binding::Import { source: Some(source), .. } if *source == origin))
}

impl RecordedInputs {
    /// Makes every input of the schemas read from a history.
    pub(super) fn new<'s>(
        engine: &Engine,
        slots: impl Iterator<Item = &'s mut ReplaySlot>,
    ) -> Result<Self, String> {
        let mut inputs = Self {
            sources: Vec::new(),
            histories: BTreeMap::new(),
            watches: Vec::new(),
        };
        for origin in recorded_origins(&engine.application) {
            let variable = engine.variables.source(origin);
            let (writer, name) = match origin {
                Origin::Local(port) => (port.instance.0, engine.name(port.instance)),
                Origin::Remote(_) => (RemoteVariable::WRITER, "elsewhere"),
            };
            let writer = variable.writer(writer, name).map_err(|error| error.to_string())?;
            let history = History::of(variable);
            let name = variable.describe().full_name();
            inputs.histories.insert(name, Arc::clone(&history));
            inputs.sources.push(RecordedExport {
                origin,
                writer,
                history,
            });
        }
        for slot in slots {
            slot.runner.read_from_history(|reader| inputs.history(reader));
        }
        Ok(inputs)
    }

    /// Publishes the recorded values of the sources up to `time`.
    pub(super) fn publish(&mut self, recorded_run: &mut dyn RecordedRun, time: Nanos) {
        for (place, export) in self.sources.iter_mut().enumerate() {
            while let Some(value) = recorded_run.value_until(place, time) {
                export.publish_value(&value);
            }
        }
    }

    /// Publishes the values that an instance read in a turn; they may have been published slightly later than
    /// they were read.
    pub(super) fn publish_inputs(
        &mut self,
        recorded_run: &mut dyn RecordedRun,
        instance: &InstanceConfig,
        turn: &RecordedTurn,
    ) {
        for (port, binding) in instance.bindings.iter().enumerate() {
            let Binding::Import {
                source: Some(source), ..
            } = binding
            else {
                continue;
            };
            let mut sources = self.sources.iter_mut().enumerate();
            let Some((place, export)) = sources.find(|(_, export)| export.origin == *source) else {
                continue;
            };
            let number = turn.port(port);
            if matches!(number, Turn::UNUSED | Turn::NO_VALUE) || export.history.has_reached(number) {
                continue;
            }
            while let Some(value) = recorded_run.value_up_to(place, number) {
                export.publish_value(&value);
            }
        }
    }

    /// Returns how often requested values were missing, by variable.
    pub(super) fn missed_values(&self) -> Vec<(String, u64)> {
        let histories = self.histories.iter();
        let missed = histories.map(|(name, history)| (name.clone(), history.missed()));
        missed.filter(|(_, missed)| *missed > 0).collect()
    }

    /// Returns the history of the variable that an input reads.
    fn history(&mut self, reader: &Reader) -> Arc<History> {
        let variable = reader.variable();
        let name = variable.describe().full_name();
        let history = self.histories.entry(name).or_insert_with(|| {
            let history = History::of(variable);
            self.watches.push(record_into(variable, &history));
            history
        });
        Arc::clone(history)
    }
}

impl RecordedExport {
    fn publish_value(&mut self, value: &RecordedValue) {
        let Some(bytes) = &value.bytes else {
            self.history.retract();
            return self.writer.retract();
        };
        let value_type = Arc::clone(&self.writer.variable().describe().value_type);
        if value_type.bytes != bytes.len() {
            return;
        }
        value_type.copy_into(bytes, self.writer.loan());
        if self.writer.publish(value.measured, value.published).is_ok() {
            // Turns refer to the recorded number; the board counts from 1 again.
            let stamp = Stamp {
                time: value.measured,
                sequence: u64::from(value.number),
                writer: self.writer.id(),
                valid_until: Nanos::MAX,
            };
            self.history.push(stamp, bytes);
        }
    }
}

/// Adds every value of a variable to a history.
fn record_into(variable: &Arc<Variable>, history: &Arc<History>) -> Watch {
    let history = Arc::clone(history);
    // A strong reference in the variable's own watch would keep the variable forever.
    let weak: Weak<Variable> = Arc::downgrade(variable);
    variable.watch(move || {
        if let Some(variable) = weak.upgrade() {
            history.record_newest(&variable);
        }
    })
}
