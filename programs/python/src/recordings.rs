//! Recordings as arrays. Their format and their damage are the concern of `jde-log`.

use std::collections::{BTreeMap, TryReserveError};
use std::ffi::CString;
use std::io::ErrorKind;
use std::path::PathBuf;

use jde_abi::describe::Type;
use jde_board::value::get_path;
use jde_embed::split_name;
use jde_log::{LeftOut, ReadError, RecordedVariable, RecordedVariables, Recording, record};
use jde_report::{Analysis, Series, Wanted, draw_recording};
use jde_ros::cdr;
use pyo3::exceptions::{PyKeyError, PyMemoryError, PyUserWarning};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error;
use crate::pictures::{png, valid_size};
use crate::values::{dtype, part_of, to_python};

/// An array of up to so many bytes is made, however short most of its values are.
const MOST_UNASKED: usize = 1 << 30;
/// How many times as large as its values a larger array may be.
const MOST_TIMES: usize = 8;

/// A recording, open for reading.
#[pyclass(frozen, module = "jde", name = "Recording")]
pub(crate) struct OpenRecording {
    recording: Recording,
    /// The variables, by their full names.
    variables: BTreeMap<String, RecordedVariable>,
    /// The variables by their channels, and what is none.
    all: RecordedVariables,
}

#[pymethods]
impl OpenRecording {
    /// Opens a file, or the folder of a recording in parts.
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        py.detach(|| {
            let recording = Recording::open(&path).map_err(read_error)?;
            let all = RecordedVariables::of(&recording);
            let variables = all
                .iter()
                .map(|variable| (variable.name.clone(), variable.clone()));
            Ok(Self {
                variables: variables.collect(),
                all,
                recording,
            })
        })
    }

    /// What the recording says of its run: `application`, `seed`, `start_ns` and others.
    #[getter]
    fn metadata(&self) -> BTreeMap<String, String> {
        self.recording.metadata("jde").cloned().unwrap_or_default()
    }

    /// Why the recording ends too early; `None` if it is complete.
    #[getter]
    fn damage(&self) -> Option<&str> {
        self.recording.damage().map(|damage| damage.reason.as_str())
    }

    /// The files and topics that cannot be read, each with the reason.
    #[getter]
    fn left_out(&self) -> Vec<String> {
        self.all.left_out().lines().collect()
    }

    /// The names of the variables, and of their types.
    #[getter]
    fn variables(&self) -> BTreeMap<&str, &str> {
        let variables = self.variables.iter();
        variables
            .map(|(name, variable)| (name.as_str(), variable.value_type.name.as_str()))
            .collect()
    }

    /// Returns the times, ns since the start, the values and the `dtype` of a variable. Warns of messages that are none.
    fn series<'py>(
        &self,
        py: Python<'py>,
        name: &str,
    ) -> PyResult<(Vec<u64>, Bound<'py, PyBytes>, Bound<'py, PyAny>)> {
        let (_, variable, _) = self.find(name)?;
        let start = self.start();
        let held = py.detach(|| self.messages(variable))?;
        for line in held.left_out.lines() {
            // A topic may have any name.
            let line = CString::new(line.replace('\0', "?"))?;
            PyErr::warn(py, &py.get_type::<PyUserWarning>(), &line, 1)?;
        }
        let (value_type, messages) = (held.value_type, held.messages);
        let bytes = messages.iter().map(|(_, data)| data.len()).sum::<usize>();
        let size = value_type.bytes.saturating_mul(messages.len());
        if size > MOST_UNASKED && size / bytes.max(1) > MOST_TIMES {
            return Err(PyMemoryError::new_err(format!(
                "the values of `{name}` have {} MiB, and an array of them needs {} MiB, because a few are much longer than the \
                 others",
                bytes >> 20,
                size >> 20
            )));
        }
        let times = messages
            .iter()
            .map(|(time, _)| time.saturating_sub(start))
            .collect();
        let array = PyBytes::new_with(py, size, |array| {
            py.detach(|| {
                let values = array.chunks_exact_mut(value_type.bytes.max(1));
                let mut values = messages.into_iter().zip(values);
                values.try_for_each(|((_, data), value)| cdr::decode_into(&value_type, &data, value))
            })
            .map_err(error)
        })?;
        Ok((times, array, dtype(py, &value_type)?.into_any()))
    }

    /// Returns the newest value that had been published at a time, s since the start, or a part of it, as a schema reads it;
    /// without a time the last one. `None` if there was none, or if it had ended.
    #[pyo3(signature = (name, at=None))]
    fn value<'py>(
        &self,
        py: Python<'py>,
        name: &str,
        at: Option<f64>,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        let (_, variable, path) = self.find(name)?;
        let since = at.map(|at| (at.max(0.0) * 1e9).round() as u64);
        let until = since.map_or(u64::MAX, |since| self.start().saturating_add(since));
        let Some(bytes) = py.detach(|| self.newest(variable, until))? else {
            return Ok(None);
        };
        part_of(to_python(py, &variable.value_type, &bytes)?, path).map(Some)
    }

    /// Returns the records of a kind: `decisions`, `states` or `events`.
    fn records<'py>(&self, py: Python<'py>, kind: &str) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let topic = format!("/jde/{kind}");
        let loads = py.import("json")?.getattr("loads")?;
        let messages = py.detach(|| {
            let messages = self.recording.messages().map_err(read_error)?;
            let of_kind = messages.filter(|message| {
                message
                    .as_ref()
                    .map_or(true, |message| message.channel.topic == topic)
            });
            of_kind.collect::<Result<Vec<_>, _>>().map_err(read_error)
        })?;
        let records = messages.iter().filter_map(record::read);
        records
            .map(|record| loads.call1((PyBytes::new(py, &record.to_json()),)))
            .collect()
    }

    /// Returns a picture as PNG: the path of the robots or the named numbers over time, and the states.
    fn picture<'py>(
        &self,
        py: Python<'py>,
        numbers: Vec<String>,
        size: (u32, u32),
    ) -> PyResult<Bound<'py, PyBytes>> {
        let size = valid_size(size)?;
        let series = numbers.iter().map(|name| self.number(name));
        let wanted = Wanted {
            columns: size.columns(),
            series: series.collect::<PyResult<_>>()?,
            ..Wanted::default()
        };
        png(py, || {
            let analysis = Analysis::read(&self.recording, wanted, &mut |_| {}).map_err(read_error)?;
            Ok(draw_recording(&analysis, size))
        })
    }
}

/// Returns the exception for what cannot be read.
fn read_error(error: ReadError) -> PyErr {
    match &error {
        ReadError::File { error: cause, .. } if cause.kind() == ErrorKind::OutOfMemory => {
            PyMemoryError::new_err(error.to_string())
        }
        _ => crate::error(error),
    }
}

fn no_memory(error: TryReserveError) -> PyErr {
    PyMemoryError::new_err(error.to_string())
}

/// The messages of a variable, as those of its type, and what of them is left out.
struct Held {
    /// Each with its time, ns.
    messages: Vec<(u64, Vec<u8>)>,
    /// Its type, with just the room that they need.
    value_type: Type,
    left_out: LeftOut,
}

impl OpenRecording {
    /// Reads the messages of a variable. They take the memory of what is in them.
    fn messages(&self, variable: &RecordedVariable) -> PyResult<Held> {
        let (mut messages, mut left_out) = (Vec::new(), LeftOut::default());
        let mut extent = cdr::Extent::new(&variable.value_type);
        // Messages of other programs become values first, which may be merged, cut or converted.
        let mut value = Vec::new();
        if variable.is_foreign() {
            value
                .try_reserve_exact(variable.value_type.bytes)
                .map_err(no_memory)?;
            value.resize(variable.value_type.bytes, 0);
        }
        for message in self.recording.messages().map_err(read_error)? {
            let message = message.map_err(read_error)?;
            let of = self.all.get(&message.channel);
            if of.is_none_or(|of| of.name != variable.name) {
                continue;
            }
            let mut data = Vec::new();
            if variable.is_foreign() {
                if let Err(reason) = variable.decode_into(&message.data, &mut value, &mut left_out) {
                    left_out.add_again(format_args!("a message of {}", variable.topic), reason);
                    continue;
                }
                cdr::encode(&variable.value_type, &value, &mut data);
            } else {
                data.try_reserve_exact(message.data.len()).map_err(no_memory)?;
                data.extend_from_slice(&message.data);
            }
            extent.include(&data).map_err(error)?;
            messages.try_reserve(1).map_err(no_memory)?;
            messages.push((message.publish_time, data));
        }
        Ok(Held {
            messages,
            value_type: extent.into_type(),
            left_out,
        })
    }

    /// Returns the value of the last message of a variable until a time, ns since 1970, if it had not ended by then.
    fn newest(&self, variable: &RecordedVariable, until: u64) -> PyResult<Option<Vec<u8>>> {
        let mut newest = None;
        for message in self.recording.messages().map_err(read_error)? {
            let message = message.map_err(read_error)?;
            if message.log_time > until {
                break;
            }
            let of = self.all.get(&message.channel);
            if of.is_some_and(|of| of.name == variable.name) {
                newest = Some(message.data);
            } else if newest.is_some()
                && record::kind(&message.channel).is_some()
                && let Some(line) = record::read(&message)
                && line.retracted_variable() == Some(variable.name.as_str())
            {
                newest = None;
            }
        }
        newest
            .map(|data| variable.decode(&data, &mut LeftOut::default()).map_err(error))
            .transpose()
    }

    /// The start of the application, ns since 1970.
    fn start(&self) -> u64 {
        let stated = self.recording.metadata("jde").and_then(|jde| jde.get("start_ns"));
        let stated = stated.and_then(|start| start.parse().ok());
        stated
            .or_else(|| Some(self.recording.times()?.0))
            .unwrap_or_default()
    }

    /// Returns the variable at the front of a name, with its name, and the path after it.
    fn find<'n>(&self, name: &'n str) -> PyResult<(&'n str, &RecordedVariable, &'n str)> {
        let found = split_name(name, |variable| Some((variable, self.variables.get(variable)?)));
        match found {
            Some(((variable, recorded), path)) => Ok((variable, recorded, path)),
            None => {
                let known = self.variables.keys().map(String::as_str);
                let help = jde_nearest::nearest(name, known).map_or_else(
                    || String::from("`variables` has their names"),
                    |near| format!("did you mean `{near}`?"),
                );
                Err(PyKeyError::new_err(format!(
                    "the recording has no `{name}`; {help}"
                )))
            }
        }
    }

    fn number(&self, name: &str) -> PyResult<Series> {
        let (variable, recorded, path) = self.find(name)?;
        let (recorded, path) = (recorded.clone(), path.to_owned());
        Ok(Series {
            topic: recorded.topic.clone(),
            variable: variable.to_owned(),
            name: name.to_owned(),
            unit: String::new(),
            number: Box::new(move |message| {
                let bytes = recorded.decode(message, &mut LeftOut::default())?;
                let value = get_path(&recorded.value_type, &bytes, &path).ok();
                Ok(value.and_then(|value| value.into_only_field().as_number()))
            }),
        })
    }
}
