//! Mocks: data in place of the functions of a schema. The schema keeps its name, ports, children, father and
//! period; its plugin describes it and is not called. `instance::mocked` carries a mock out.

use std::path::PathBuf;
use std::sync::Arc;

use jde_abi::describe::{Plugin, Role};
use jde_abi::inspect::Problem;
use jde_app::{Application, Catalogue, Inspection, InstanceConfig};
use jde_board::value::{self, Value};
use jde_core::Nanos;

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
    readiness: Vec<(Nanos, (bool, f64))>,
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
    readiness: Vec<(Nanos, (bool, f64))>,
}

impl<'c> MockCatalogue<'c> {
    /// Returns the catalogue for an application in which these schemas are replaced by mocks.
    pub fn new(catalogue: &'c dyn Catalogue, mocked: impl IntoIterator<Item = String>) -> Self {
        let mocked = mocked.into_iter().collect();
        Self { catalogue, mocked }
    }
}

impl Catalogue for MockCatalogue<'_> {
    fn plugin(&self, name: &str, extra_dirs: &[PathBuf]) -> Result<Arc<Plugin>, String> {
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
    ) -> Result<(usize, ResolvedMock), StartError> {
        let refused = |reason: String| StartError::Mock {
            schema: schema.to_owned(),
            reason,
        };
        let number = application
            .instance(schema)
            .ok_or_else(|| refused(String::from("the application has no such schema")))?;
        let instance = &application.instances[number];
        let tracks = self.tracks.into_iter().map(|track| track.resolve(instance));
        let tracks = tracks.collect::<Result<_, _>>().map_err(refused)?;
        self.readiness.sort_by_key(|(from, _)| *from);
        let readiness = self.readiness;
        Ok((number, ResolvedMock { tracks, readiness }))
    }
}

impl Track<MockValue> {
    fn resolve(self, instance: &InstanceConfig) -> Result<Track<Vec<u8>, u32>, String> {
        let ports = &instance.schema.ports;
        let is_written =
            |role: &Role| matches!(role, Role::Export | Role::Actuator | Role::ChildModulation { .. });
        let found = ports
            .iter()
            .position(|port| port.name == self.port && is_written(&port.role));
        let Some(number) = found else {
            let known = ports.iter().filter(|port| is_written(&port.role));
            let known: Vec<_> = known.map(|port| port.name.as_str()).collect();
            return Err(format!(
                "it writes no port `{}`, but {}",
                self.port,
                known.join(", ")
            ));
        };
        let port = &ports[number];
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
            port: number as u32,
            repeats: self.repeats,
            values,
        })
    }
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
