//! Decision replay: the schemas of an application take the turns again that were taken once, on one thread and in the order
//! of then, each seeing the values that it saw then. What its drivers exported comes from elsewhere; no driver is made, and
//! commands reach nobody. So what is decided depends on the schemas alone, and what is decided otherwise is their doing.
//!
//! A schema that is awake now and was not then takes its turns by its own period. Judges nothing: see `jde-log`.

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

/// What of a recorded run has to be there.
#[derive(Clone, Debug)]
pub struct Source {
    /// The full name of an export of a driver, or of another application.
    pub name: String,
    /// Its type.
    pub value_type: Arc<Type>,
    /// Whether a schema that is no driver imports it.
    pub imported: bool,
}

/// What a schema has seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Sight {
    /// The name of the port.
    pub port: String,
    /// The number of the value, the time when it was measured, and the value in words if it is short; none if there was none.
    pub value: Option<(u64, Nanos, Option<String>)>,
}

/// An application that takes the turns of the past again. Dropping it brings it to rest.
pub struct Replay {
    player: Player,
}

/// What the drivers of an application export, in its order, and what it imports from others.
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

/// A value as a person reads it: of a type with one field that field alone.
#[must_use]
pub fn words(value_type: &Type, bytes: &[u8]) -> String {
    match value::decode(value_type, bytes) {
        Value::Map(fields) if fields.len() == 1 => fields[0].1.to_string(),
        value => value.to_string(),
    }
}

impl Replay {
    /// Makes all schemas but the drivers ready to take the turns that `past` tells of. The times of what was done by several
    /// threads are told apart up to `slack`, ns: 0 for a past in virtual time.
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

    /// What tools need.
    #[must_use]
    pub fn handle(&self) -> Handle {
        Handle::new(self.player.engine())
    }

    /// Takes one step, of the past or of what happens by itself; answers false once it is over.
    pub fn step(&mut self) -> bool {
        self.player.step()
    }

    /// What a schema saw at its last check.
    #[must_use]
    pub fn saw(&self, schema: usize) -> Vec<Sight> {
        self.player.saw(schema)
    }

    /// What schemas did since this was asked last, beside what they did then, in the order of their turns.
    pub fn deeds(&mut self) -> Vec<Deed> {
        self.player.deeds()
    }

    /// Values that were seen then and are not there now, by variable: the newest were shown instead. None of those that the
    /// drivers exported are unless they were lost; of others there may be once something has been decided otherwise.
    #[must_use]
    pub fn missed(&self) -> Vec<(String, u64)> {
        self.player.missed()
    }

    /// Operators wrote these variables, and the values they wrote are not known.
    #[must_use]
    pub fn unknown(&self) -> Vec<String> {
        self.player.unknown()
    }
}
