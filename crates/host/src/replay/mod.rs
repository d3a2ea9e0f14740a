//! Decision replay: the schemas of an application take recorded turns again, on one thread and in the
//! recorded order, each with the values that it read then. The values of drivers and of other applications
//! come from the recording; no driver is created, and commands have no effect. So decisions depend on the
//! schemas alone, and every different decision is caused by them.
//!
//! A schema that is awake now and was not awake then takes turns by its own period. Judges nothing: see
//! `jde-log`.

mod deeds;
mod past;
mod player;
mod scenery;
mod seat;

use std::sync::Arc;

use jde_abi::describe::Type;
use jde_board::value::{self, Value};
use jde_core::Nanos;

use crate::app::{Application, Source as Origin};
use crate::clock::Clock;
use crate::engine::Engine;
use crate::event::Observer;
use crate::plugin::Plugins;
use crate::runner::Runner;
use crate::running::{Handle, StartError, original};
pub use deeds::{Deed, Done};
pub use past::{Old, Part, Past, Step};
use player::Player;

/// A variable whose values a recording must contain.
#[derive(Clone, Debug)]
pub struct Source {
    /// The full name of an export of a driver, or of another application.
    pub name: String,
    /// Its type.
    pub value_type: Arc<Type>,
    /// Whether a schema other than a driver imports it.
    pub imported: bool,
}

/// What a schema read from a port.
#[derive(Clone, Debug, PartialEq)]
pub struct Sight {
    /// The name of the port.
    pub port: String,
    /// The number of the value, the time when it was measured, and the value in words if it is short; `None`
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
pub fn sources(application: &Application) -> Vec<Source> {
    let sources = scenery::origins(application).into_iter().map(|origin| {
        let (name, value_type) = match origin {
            Origin::Here(instance, port) => {
                let owner = &application.instances[instance];
                let export = &owner.schema.ports[port];
                (format!("{}.{}", owner.name, export.name), &export.value_type)
            }
            Origin::Elsewhere(remote) => {
                let remote = &application.remotes[remote];
                (remote.local.clone(), &remote.value_type)
            }
        };
        Source {
            name,
            value_type: Arc::clone(value_type),
            imported: scenery::is_imported(application, origin),
        }
    });
    sources.collect()
}

/// Formats a value for people; a value of a type with one field as that field alone.
#[must_use]
pub fn words(value_type: &Type, bytes: &[u8]) -> String {
    match value::decode(value_type, bytes) {
        Value::Map(fields) if fields.len() == 1 => fields[0].1.to_string(),
        value => value.to_string(),
    }
}

impl Replay {
    /// Prepares all schemas except the drivers to take the turns of `past`. `slack` is the time, ns, within
    /// which the order of actions of different threads is uncertain: 0 for a past in virtual time.
    ///
    /// # Errors
    /// [`StartError`].
    pub fn start(
        application: Application,
        plugins: &Plugins,
        observers: Vec<Box<dyn Observer>>,
        past: Box<dyn Past>,
        slack: Nanos,
    ) -> Result<Self, StartError> {
        let (engine, ports) = Engine::new(application, Clock::again(slack > 0), observers, None, None, None)
            .map_err(StartError::Wiring)?;
        let mut runners = Vec::new();
        for (number, ports) in ports.into_iter().enumerate() {
            let instance = &engine.application.instances[number];
            if scenery::is_driver(instance) {
                runners.push(None);
                continue;
            }
            let build = original(&engine.application, plugins, instance)?;
            let mut runner = Runner::new(&engine, number, build, ports);
            runner.make()?;
            runners.push(Some(runner));
        }
        let player = Player::new(engine, runners, past, slack).map_err(StartError::Wiring)?;
        Ok(Self { player })
    }

    /// Returns a handle for tools.
    #[must_use]
    pub fn handle(&self) -> Handle {
        Handle::new(self.player.engine())
    }

    /// Takes one step: the next of the past, or an earlier one that the past does not contain. Returns false
    /// at the end.
    pub fn step(&mut self) -> bool {
        self.player.step()
    }

    /// Returns what a schema read at its last check.
    #[must_use]
    pub fn saw(&self, schema: usize) -> Vec<Sight> {
        self.player.saw(schema)
    }

    /// Returns the schemas' writes since the last call, paired with the recorded writes, in the order of
    /// turns.
    pub fn deeds(&mut self) -> Vec<Deed> {
        self.player.deeds()
    }

    /// Returns, by variable, how many values were read then and are missing now; the newest values replaced
    /// them. Values of drivers are missing only if they were lost; others may be missing after a decision
    /// differed.
    #[must_use]
    pub fn missed(&self) -> Vec<(String, u64)> {
        self.player.missed()
    }

    /// Returns the variables that operators wrote with values that are not known.
    #[must_use]
    pub fn unknown(&self) -> Vec<String> {
        self.player.unknown()
    }
}
