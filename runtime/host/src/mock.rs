//! Mocks: data in place of the functions of a schema. The schema keeps its name, ports, children, father and
//! period; its plugin describes it and is not called. `instance::mocked` carries a mock out.

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use arc_swap::ArcSwapOption;
use jde_abi::describe::{Plugin, Port, Role};
use jde_abi::inspect::Problem;
use jde_app::{Application, Catalogue, Inspection, InstanceConfig, Unusable};
use jde_board::value::{self, Value};
use jde_core::{Nanos, SchemaId};

use crate::running::StartError;

/// What a schema does in place of its plugin's functions, as values and readiness over the application's time.
///
/// A value is published in every iteration from its time until the next value of its port; a recorded value,
/// set by [`Mock::recorded`], only once. Values are those of exports, and for a motor schema also those of its
/// commands and of the modulations of its children. A father wakes all its children in every iteration. Without
/// a statement on it, a motor schema is always ready, with urgency 0. A mock draws no panel, and settles what
/// its type would arbitrate by priority.
///
/// ```
/// use jde_board::value::Value;
/// use jde_host::Mock;
///
/// let mut gate = Mock::default();
/// gate.set("ahead", 0, Some(Value::Float(1.2)));
/// gate.set("ahead", 2_000_000_000, None);
/// gate.set_ready(0, false, 0.0);
/// gate.set_ready(2_000_000_000, true, 0.0);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Mock {
    tracks: Vec<Track<MockValue>>,
    live: Vec<(String, LiveValue)>,
    readiness: Vec<(Nanos, (bool, f64))>,
}

/// The value of a mock's port that a program changes while the application runs. Usable from any thread; a clone
/// is the same value.
#[derive(Clone, Debug, Default)]
pub struct LiveValue(Arc<LiveState>);

#[derive(Debug, Default)]
struct LiveState {
    /// The size of a value in bytes; none before the application starts.
    size: OnceLock<usize>,
    /// The schema's thread reads it without a lock, which a thread that sets it could hold.
    bytes: ArcSwapOption<Vec<u8>>,
}

#[derive(Clone, Debug)]
enum MockValue {
    Given(Value),
    Recorded(Vec<u8>),
}

/// The catalogue of an application with mocks: a schema that is replaced by a mock inspects nothing, because what
/// it needs may be missing.
pub struct MockCatalogue<'c> {
    catalogue: &'c dyn Catalogue,
    mocked: Vec<String>,
}

/// The values of a port, by the time from which they are in force.
#[derive(Clone, Debug)]
pub(crate) struct Track<V, P = String> {
    pub(crate) port: P,
    /// Whether a value is published in every iteration.
    pub(crate) repeats: bool,
    /// `None` from the time at which there is no value any more.
    pub(crate) values: Vec<(Nanos, Option<V>)>,
}

/// A mock of an instance, whose ports are numbers and whose values are bytes.
pub(crate) struct ResolvedMock {
    pub(crate) tracks: Vec<Track<Vec<u8>, u32>>,
    pub(crate) live: Vec<(u32, LiveValue)>,
    readiness: Vec<(Nanos, (bool, f64))>,
}

impl LiveValue {
    /// Sets the value, in the bytes of its type. The mock publishes it in every iteration from the next one on.
    ///
    /// # Errors
    /// The application has not started, or the type has another size.
    pub fn set(&self, bytes: &[u8]) -> Result<(), String> {
        match self.0.size.get() {
            Some(size) if *size == bytes.len() => {
                self.0.bytes.store(Some(Arc::new(bytes.to_vec())));
                Ok(())
            }
            Some(size) => Err(format!(
                "a value of the port has {size} bytes, not {}",
                bytes.len()
            )),
            None => Err(String::from("the application of the mock has not started")),
        }
    }

    /// Calls `use_bytes` with the value, if there is one.
    pub(crate) fn with(&self, use_bytes: impl FnOnce(&[u8])) {
        if let Some(bytes) = &*self.0.bytes.load() {
            use_bytes(bytes);
        }
    }
}

impl<'c> MockCatalogue<'c> {
    /// Returns the catalogue for an application in which these schemas are replaced by mocks.
    pub fn new(catalogue: &'c dyn Catalogue, mocked: impl IntoIterator<Item = String>) -> Self {
        let mocked = mocked.into_iter().collect();
        Self { catalogue, mocked }
    }
}

impl Catalogue for MockCatalogue<'_> {
    fn plugin(&self, name: &str, extra_dirs: &[PathBuf]) -> Result<Arc<Plugin>, Unusable> {
        self.catalogue.plugin(name, extra_dirs)
    }

    fn inspect(&self, plugin: &Arc<Plugin>, inspection: &Inspection<'_>) -> Result<Vec<Problem>, String> {
        if self.mocked.iter().any(|schema| schema == inspection.name) {
            return Ok(Vec::new());
        }
        self.catalogue.inspect(plugin, inspection)
    }

    fn type_names(&self) -> Vec<String> {
        self.catalogue.type_names()
    }
}

impl Mock {
    /// Sets the value of a port from a time on, ns since the start; `None` retracts the export. Fields that the
    /// value does not name are zero.
    pub fn set(&mut self, port: &str, from: Nanos, value: Option<Value>) {
        self.track(port, true)
            .values
            .push((from, value.map(MockValue::Given)));
    }

    /// Sets a value of a port, in the bytes of its type, that is published once, at the first iteration from
    /// that time on, or `None` that retracts it. Only the last of several values since the iteration before
    /// counts.
    pub fn recorded(&mut self, port: &str, at: Nanos, value: Option<Vec<u8>>) {
        let value = value.map(MockValue::Recorded);
        self.track(port, false).values.push((at, value));
    }

    /// Returns the value of a port that is set while the application runs. It has none until then.
    pub fn live(&mut self, port: &str) -> LiveValue {
        let value = LiveValue::default();
        self.live.push((port.to_owned(), value.clone()));
        value
    }

    /// Sets the result of the precondition from a time on, ns since the start.
    pub fn set_ready(&mut self, from: Nanos, ready: bool, urgency: f64) {
        self.readiness.push((from, (ready, urgency)));
    }

    fn track(&mut self, port: &str, repeats: bool) -> &mut Track<MockValue> {
        let known = self.tracks.iter().position(|track| track.port == port);
        let place = known.unwrap_or_else(|| {
            self.tracks.push(Track {
                port: port.to_owned(),
                repeats,
                values: Vec::new(),
            });
            self.tracks.len() - 1
        });
        &mut self.tracks[place]
    }

    /// Finds the instance and its ports, and encodes the values.
    pub(crate) fn resolve(
        mut self,
        application: &Application,
        schema: &str,
    ) -> Result<(SchemaId, ResolvedMock), StartError> {
        let refused = |reason: String| StartError::Mock {
            schema: schema.to_owned(),
            reason,
        };
        let id = application
            .instance(schema)
            .ok_or_else(|| refused(String::from("the application has no such schema")))?;
        let instance = &application.instances[id];
        let tracks = self.tracks.into_iter().map(|track| track.resolve(instance));
        let tracks = tracks.collect::<Result<_, _>>().map_err(refused)?;
        let mut live = Vec::with_capacity(self.live.len());
        for (name, value) in self.live {
            let (number, port) = written_port(instance, &name).map_err(refused)?;
            value.0.size.get_or_init(|| port.value_type.bytes);
            live.push((number, value));
        }
        self.readiness.sort_by_key(|(from, _)| *from);
        let readiness = self.readiness;
        Ok((
            id,
            ResolvedMock {
                tracks,
                live,
                readiness,
            },
        ))
    }
}

impl Track<MockValue> {
    fn resolve(self, instance: &InstanceConfig) -> Result<Track<Vec<u8>, u32>, String> {
        let (number, port) = written_port(instance, &self.port)?;
        let mut values = Vec::with_capacity(self.values.len());
        for (from, value) in self.values {
            let bytes = match value {
                None => None,
                Some(MockValue::Recorded(bytes)) if bytes.len() == port.value_type.bytes => Some(bytes),
                Some(MockValue::Recorded(_)) => {
                    return Err(format!(
                        "a value of `{}` is no {}",
                        self.port, port.value_type.name
                    ));
                }
                Some(MockValue::Given(given)) => {
                    let mut bytes = vec![0; port.value_type.bytes];
                    value::encode(&port.value_type, &given, &mut bytes)
                        .map_err(|error| format!("`{}`: {error}", self.port))?;
                    Some(bytes)
                }
            };
            values.push((from, bytes));
        }
        values.sort_by_key(|(from, _)| *from);
        Ok(Track {
            port: number,
            repeats: self.repeats,
            values,
        })
    }
}

/// Returns the number of a port that a mock writes, and the port.
fn written_port<'i>(instance: &'i InstanceConfig, name: &str) -> Result<(u32, &'i Port), String> {
    let is_written = |port: &&Port| {
        matches!(
            port.role,
            Role::Export { .. } | Role::Actuator | Role::ChildModulation { .. }
        )
    };
    let ports = &instance.schema.ports;
    let found = ports
        .iter()
        .position(|port| port.name == name && is_written(&port));
    found
        .map(|number| (number as u32, &ports[number]))
        .ok_or_else(|| {
            let known = ports.iter().filter(is_written);
            let known: Vec<_> = known.map(|port| port.name.as_str()).collect();
            format!("it writes no port `{name}`, but {}", known.join(", "))
        })
}

impl<V, P> Track<V, P> {
    /// Returns how many values are in force or were so at a time.
    pub(crate) fn reached(&self, now: Nanos) -> usize {
        self.values.partition_point(|(from, _)| *from <= now)
    }
}

impl ResolvedMock {
    /// Returns the result of the precondition at a time, and the urgency.
    pub(crate) fn precondition(&self, now: Nanos) -> (bool, f64) {
        let reached = self.readiness.partition_point(|(from, _)| *from <= now);
        match reached.checked_sub(1) {
            Some(last) => self.readiness[last].1,
            // Before the first statement of a script the schema waits for it.
            None => (self.readiness.is_empty(), 0.0),
        }
    }
}
