//! Running applications, over the link: their values, their records, and the actions of an operator. What arrives
//! waits in a queue until Python takes it.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::time::{Duration, Instant};

use jde_app::literal::parse_value;
use jde_board::value::Value;
use jde_link::message::{Action, Request, VariableInfo};
use jde_link::{
    Client, Folders, Hold, Login, PanelSample, Rate, Reach, Remote, Sample, Subscription, Tls, operator,
    value,
};
use jde_records::RunRecord;
use parking_lot::Mutex;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::runs::record_kind;
use crate::values::{from_python, to_python};
use crate::{error, json, record_to_python};

/// The most values, records or drawings that wait; newer ones are dropped and counted.
const MAX_QUEUED: usize = 1000;
/// How often a wait looks for signals, and for the end of the application.
const LOOK_INTERVAL: Duration = Duration::from_millis(50);

/// A running application.
#[pyclass(frozen, module = "jde", name = "Remote")]
pub(crate) struct RemoteApplication {
    remote: Remote,
}

/// What arrives from an application until it is dropped.
#[pyclass(frozen, module = "jde", name = "Watch")]
pub(crate) struct Watch {
    remote: Remote,
    receiver: Mutex<Receiver<Arrival>>,
    missed: Arc<AtomicU64>,
    subscription: Mutex<Option<Subscription>>,
}

/// An action of an operator that ends with this object, with its process, or with the network.
#[pyclass(frozen, module = "jde", name = "Lease")]
pub(crate) struct Lease(Mutex<Option<Hold>>);

enum Arrival {
    Value(Sample),
    Record(RunRecord),
    Panel(PanelSample),
}

#[pymethods]
impl RemoteApplication {
    /// Connects to the application of a name, or to the only one: of this user on this machine, or at endpoints.
    #[new]
    #[pyo3(signature = (name=None, at=Vec::new(), user=None, authority=None, identity=None))]
    fn new(
        py: Python<'_>,
        name: Option<&str>,
        at: Vec<String>,
        user: Option<(String, PathBuf)>,
        authority: Option<String>,
        identity: Option<(String, String)>,
    ) -> PyResult<Self> {
        py.detach(|| {
            let reach = if at.is_empty() {
                Reach::Local(Folders::of_user())
            } else {
                let login = user.map(|(user, file)| Login::read(&user, &file));
                let tls = authority.is_some() || identity.is_some();
                Reach::Network {
                    endpoints: at,
                    login: login.transpose().map_err(error)?,
                    tls: tls.then_some(Tls {
                        identity,
                        authority,
                        clients: false,
                    }),
                }
            };
            let client = Client::connect(&reach).map_err(error)?;
            let remote = client.application(name).map_err(error)?;
            Ok(Self { remote })
        })
    }

    /// The name of the application.
    #[getter]
    fn name(&self) -> &str {
        &self.remote.about().name
    }

    /// The name with the id of this run, by which the executable finds it among others of the name.
    #[getter]
    fn address(&self) -> String {
        let about = self.remote.about();
        format!("{}@{}", about.name, about.id)
    }

    /// Whether the application can be reached.
    #[getter]
    fn is_alive(&self) -> bool {
        self.remote.is_alive()
    }

    /// The full names of the variables, and the names of their types.
    fn variables(&self, py: Python<'_>) -> PyResult<BTreeMap<String, String>> {
        let variables = py
            .detach(|| self.remote.variables(false))
            .map_err(error)?
            .into_iter();
        Ok(variables
            .map(|variable| (variable.name, variable.type_name))
            .collect())
    }

    /// Returns the newest value of a variable with its time, s, and its number.
    fn get<'py>(&self, py: Python<'py>, name: &str) -> PyResult<(Option<Bound<'py, PyAny>>, f64, u64)> {
        let sample = py.detach(|| self.remote.get(name)).map_err(error)?;
        sample_to_python(py, &sample)
    }

    /// Returns the state of every schema and group.
    fn snapshot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json(py, &py.detach(|| self.remote.hierarchy()).map_err(error)?)
    }

    /// Receives the values of a variable, all or at most so many a second.
    #[pyo3(signature = (name, rate=None))]
    fn watch(&self, py: Python<'_>, name: &str, rate: Option<f64>) -> PyResult<Watch> {
        let rate = rate.map(valid_rate).transpose()?.unwrap_or(Rate::Full);
        self.receive(py, |send| {
            self.remote
                .watch(name, rate, move |sample| send(Arrival::Value(sample)))
        })
    }

    /// Receives the drawings of a panel, at most so many a second.
    fn watch_panel(&self, py: Python<'_>, schema: &str, rate: f64) -> PyResult<Watch> {
        let rate = valid_rate(rate)?;
        self.receive(py, |send| {
            self.remote
                .watch_panel(schema, rate, move |panel| send(Arrival::Panel(panel)))
        })
    }

    /// Receives the last records of these kinds and each new one: `decisions`, `states`, `events`.
    fn watch_records(&self, py: Python<'_>, kinds: Vec<String>, last: usize) -> PyResult<Watch> {
        let kinds = kinds.iter().map(|name| record_kind(name));
        let kinds = kinds.collect::<PyResult<Vec<_>>>()?;
        self.receive(py, |send| {
            self.remote
                .events(&kinds, last, move |event| send(Arrival::Record(event.record)))
        })
    }

    /// Acts as an operator (R14). The action is the JSON of the link's protocol, without the operator's name. With
    /// a lease, s, it ends with the returned object.
    #[pyo3(signature = (action, lease=None))]
    fn operate(&self, py: Python<'_>, action: &str, lease: Option<f64>) -> PyResult<Option<Lease>> {
        self.act(py, serde_json::from_str(action).map_err(error)?, lease)
    }

    /// Writes a modulation or a period. A text may have a unit.
    #[pyo3(signature = (name, value, lease=None))]
    fn write(
        &self,
        py: Python<'_>,
        name: &str,
        value: &Bound<'_, PyAny>,
        lease: Option<f64>,
    ) -> PyResult<Option<Lease>> {
        let value = from_python(value)?;
        let variable = py.detach(|| self.remote.variable(name)).map_err(error)?;
        let value = parse(&variable, value)?;
        let schema = variable.owner.clone();
        let action = if variable.variable == "period" {
            let period = value.into_only_field().as_number();
            let period_s = period.ok_or_else(|| error(format!("`{name}` is a number of seconds")))?;
            Action::Period { schema, period_s }
        } else {
            let value_type = variable.value_type().map_err(error)?;
            let value = value::to_json(&value.into_only_field_of(&value_type));
            let variable = variable.variable;
            Action::Modulate {
                schema,
                variable,
                value,
            }
        };
        self.act(py, action, lease)
    }
}

impl RemoteApplication {
    fn act(&self, py: Python<'_>, action: Action, lease: Option<f64>) -> PyResult<Option<Lease>> {
        let by = operator();
        let request = Request {
            by,
            action,
            lease_ms: None,
        };
        let lease = lease.map(Duration::try_from_secs_f64).transpose();
        let lease = lease.map_err(|wrong| PyValueError::new_err(wrong.to_string()))?;
        py.detach(|| match lease {
            None => self.remote.operate(&request).map(|()| None),
            Some(lease) => self.remote.hold(&request, lease).map(Some),
        })
        .map(|hold| hold.map(|hold| Lease(Mutex::new(Some(hold)))))
        .map_err(error)
    }

    fn receive(
        &self,
        py: Python<'_>,
        subscribe: impl FnOnce(Box<dyn Fn(Arrival) + Send + Sync>) -> Result<Subscription, jde_link::Error> + Send,
    ) -> PyResult<Watch> {
        let (sender, receiver) = sync_channel(MAX_QUEUED);
        let missed = Arc::new(AtomicU64::new(0));
        let send = sending(sender, Arc::clone(&missed));
        let subscription = py.detach(|| subscribe(Box::new(send))).map_err(error)?;
        Ok(Watch {
            remote: self.remote.clone(),
            receiver: Mutex::new(receiver),
            missed,
            subscription: Mutex::new(Some(subscription)),
        })
    }
}

#[pymethods]
impl Watch {
    /// Values, records or drawings that were dropped because Python took too few.
    #[getter]
    fn missed(&self) -> u64 {
        self.missed.load(Ordering::Relaxed)
    }

    /// Whether nothing will arrive any more: the watch was closed, or the application is gone.
    #[getter]
    fn is_over(&self) -> bool {
        self.subscription.lock().is_none() || !self.remote.is_alive()
    }

    /// Waits for the next arrival, at most so many seconds; `None` after that time or at the end.
    #[pyo3(signature = (timeout=None))]
    fn receive<'py>(&self, py: Python<'py>, timeout: Option<f64>) -> PyResult<Option<Bound<'py, PyAny>>> {
        if timeout.is_some_and(f64::is_nan) {
            return Err(PyValueError::new_err("nan s is not a time to wait"));
        }
        let end = timeout.map(|timeout| Instant::now() + Duration::from_secs_f64(timeout.clamp(0.0, 1e9)));
        while self.subscription.lock().is_some() {
            let left = end.map_or(LOOK_INTERVAL, |end| end.saturating_duration_since(Instant::now()));
            let is_gone = !self.remote.is_alive();
            let arrived = py.detach(|| self.receiver.lock().recv_timeout(left.min(LOOK_INTERVAL)));
            if let Ok(arrived) = arrived {
                return arrival_to_python(py, &arrived).map(Some);
            }
            py.check_signals()?;
            if is_gone || end.is_some_and(|end| Instant::now() >= end) {
                break;
            }
        }
        Ok(None)
    }

    /// Ends the subscription. What has arrived by then is not received.
    fn close(&self, py: Python<'_>) {
        py.detach(|| drop(self.subscription.lock().take()));
    }
}

#[pymethods]
impl Lease {
    /// Why the action ended before the lease was closed; `None` while it is in force.
    #[getter]
    fn lost(&self) -> Option<String> {
        self.0.lock().as_ref().and_then(Hold::lost)
    }

    /// Ends the action, and waits until the application has confirmed it.
    fn close(&self, py: Python<'_>) {
        py.detach(|| drop(self.0.lock().take()));
    }
}

/// Returns the rate of so many arrivals a second, or more.
fn valid_rate(rate: f64) -> PyResult<Rate> {
    if rate > 0.0 && rate.is_finite() {
        return Ok(Rate::at_least(rate));
    }
    let message = format!("{rate} is no rate: give a number above 0, how many a second");
    Err(PyValueError::new_err(message))
}

fn sending(sender: SyncSender<Arrival>, missed: Arc<AtomicU64>) -> impl Fn(Arrival) + Send + Sync {
    move |arrival| {
        if let Err(TrySendError::Full(_)) = sender.try_send(arrival) {
            missed.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// Reads a text as the application file would; other values stay as they are.
fn parse(variable: &VariableInfo, value: Value) -> PyResult<Value> {
    let Value::Text(text) = &value else {
        return Ok(value);
    };
    let is_period = variable.variable == "period";
    let unit = if is_period { "s" } else { &variable.unit };
    let value_type = variable.value_type().map_err(error)?;
    let folder = std::env::current_dir().unwrap_or_default();
    let owner = (variable.owner.as_str(), variable.variable.as_str());
    parse_value(text, owner, &value_type, unit, &folder, &variable.name).map_err(error)
}

fn arrival_to_python<'py>(py: Python<'py>, arrival: &Arrival) -> PyResult<Bound<'py, PyAny>> {
    match arrival {
        Arrival::Value(sample) => Ok(sample_to_python(py, sample)?.into_pyobject(py)?.into_any()),
        Arrival::Record(record) => record_to_python(py, record),
        Arrival::Panel(panel) => match &panel.list {
            Ok(list) => json(py, list),
            Err(reason) => Err(error(reason)),
        },
    }
}

fn sample_to_python<'py>(
    py: Python<'py>,
    sample: &Sample,
) -> PyResult<(Option<Bound<'py, PyAny>>, f64, u64)> {
    let bytes = sample.bytes.as_ref();
    let value = bytes
        .map(|bytes| to_python(py, &sample.value_type, bytes))
        .transpose()?;
    Ok((value, sample.time as f64 / 1e9, sample.sequence))
}
