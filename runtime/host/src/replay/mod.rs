//! Decision replay: the schemas of an application take recorded turns again, on one thread and in the
//! recorded order, each with the values that it read then. The values of drivers and of other applications
//! come from the recording; no driver is created, and commands have no effect. So decisions depend on the
//! schemas alone, and every different decision is caused by them.
//!
//! A schema that is awake now and was not awake then takes turns by its own period. `jde-log` compares the
//! decisions; this module does not.

mod player;
mod recorded_inputs;
mod recorded_run;
mod slot;
mod writes;

use std::collections::BTreeMap;
use std::sync::Arc;

use jde_abi::describe::Type;
use jde_app::{Application, ImportSource as Origin};
use jde_board::value::{self, Value};
use jde_core::{Nanos, SchemaId, Table};
use jde_loader::Plugins;
use jde_records::event::Observer;

use crate::clock::Clock;
use crate::engine::Engine;
use crate::prepare::original_build;
use crate::runner::Runner;
use crate::running::{Handle, StartError};
use player::Player;
pub use recorded_run::{RecordedRun, RecordedValue, ReplayStep, StepKind};
pub use writes::{PairedWrite, WriteOutcome};

/// A variable whose values a recording must contain.
#[derive(Clone, Debug)]
pub struct RecordedSource {
    /// The full name of an export of a driver, or of another application.
    pub name: String,
    /// Its type.
    pub value_type: Arc<Type>,
    /// Whether a schema other than a driver imports it.
    pub imported: bool,
}

/// What a schema read from a port.
#[derive(Clone, Debug, PartialEq)]
pub struct PortReading {
    /// The name of the port.
    pub port: String,
    /// The number of the value, the time when it was measured, and the formatted value if it is short; `None`
    /// if the port had no value.
    pub value: Option<(u64, Nanos, Option<String>)>,
}

/// An application that takes recorded turns again. Dropping it brings it to rest.
pub struct Replay {
    player: Player,
}

/// Returns the exports of an application's drivers, in the application's order, and then its imports from
/// other applications.
#[must_use]
pub fn sources(application: &Application) -> Vec<RecordedSource> {
    let sources = recorded_inputs::recorded_origins(application)
        .into_iter()
        .map(|origin| {
            let (name, value_type) = match origin {
                Origin::Local(port) => {
                    let owner = &application.instances[port.instance].schema;
                    (
                        application.variable_name(port),
                        &owner.ports[port.port].value_type,
                    )
                }
                Origin::Remote(remote) => {
                    let remote = &application.remotes[remote];
                    (remote.local.clone(), &remote.value_type)
                }
            };
            RecordedSource {
                name,
                value_type: Arc::clone(value_type),
                imported: recorded_inputs::is_imported(application, origin),
            }
        });
    sources.collect()
}

/// Formats a value for people; a value of a type with one field as that field alone.
#[must_use]
pub fn format_value(value_type: &Type, bytes: &[u8]) -> String {
    match value::decode(value_type, bytes) {
        Value::Map(fields) if fields.len() == 1 => fields[0].1.to_string(),
        value => value.to_string(),
    }
}

impl Replay {
    /// Prepares all schemas except the drivers to take the turns of `recorded_run`. `slack` is the time, ns,
    /// within which the order of actions of different threads is uncertain: 0 for a recording in virtual
    /// time.
    ///
    /// # Errors
    /// [`StartError`].
    pub fn start(
        application: Application,
        plugins: &Plugins,
        observers: Vec<Box<dyn Observer>>,
        recorded_run: Box<dyn RecordedRun>,
        slack: Nanos,
    ) -> Result<Self, StartError> {
        let (engine, ports) = Engine::new(
            application,
            Clock::replayed(),
            observers,
            None,
            None,
            None,
            BTreeMap::new(),
        )
        .map_err(StartError::Wiring)?;
        let mut runners = Table::default();
        for (id, ports) in engine.application.instances.ids().zip(ports) {
            let instance = &engine.application.instances[id];
            if recorded_inputs::is_driver(instance) {
                runners.push(None);
                continue;
            }
            let build = original_build(&engine.application, plugins, instance)?;
            let mut runner = Runner::new(&engine, id, build, ports);
            runner.create_for_start()?;
            runners.push(Some(runner));
        }
        let player = Player::new(engine, runners, recorded_run, slack).map_err(StartError::Wiring)?;
        Ok(Self { player })
    }

    /// Returns a handle for tools.
    #[must_use]
    pub fn handle(&self) -> Handle {
        Handle::new(self.player.engine())
    }

    /// Takes the next recorded step, or an earlier one that the recording does not contain. Returns false at
    /// the end.
    pub fn step(&mut self) -> bool {
        self.player.step()
    }

    /// Returns what a schema read at its last check.
    #[must_use]
    pub fn last_inputs(&self, schema: SchemaId) -> Vec<PortReading> {
        self.player.last_inputs(schema)
    }

    /// Returns the schemas' writes since the last call, paired with the recorded writes, in the order of
    /// turns.
    pub fn take_writes(&mut self) -> Vec<PairedWrite> {
        self.player.take_writes()
    }

    /// Returns, by variable, how many values were read then and are missing now; the newest values replaced
    /// them. Values of drivers are missing only if they were lost; others may be missing after a decision
    /// differed.
    #[must_use]
    pub fn missed_values(&self) -> Vec<(String, u64)> {
        self.player.missed_values()
    }

    /// Returns the variables that operators wrote with values that are not known.
    #[must_use]
    pub fn unknown_writes(&self) -> Vec<String> {
        self.player.unknown_writes()
    }
}
