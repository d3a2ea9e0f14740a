//! What a policy observes and commands, as vectors of numbers: the fast way for learning. A run is read and
//! written without an object of Python for each value.

use jde_abi::describe::{Form, Scalar};
use jde_board::Reader;
use jde_embed::LivePort;
use jde_policy::{Numbers, collect};
use parking_lot::Mutex;
use pyo3::prelude::*;
use pyo3::types::PyByteArray;

use crate::error;
use crate::runs::PythonRun;

/// The numbers that a policy observes and commands in one run.
#[pyclass(frozen, module = "jde", name = "Policy")]
pub(crate) struct Policy {
    run: Py<PythonRun>,
    state: Mutex<State>,
}

struct State {
    observed: Vec<Observed>,
    /// The newest observation.
    numbers: Vec<f32>,
    commands: Vec<Command>,
}

/// A variable, and the numbers of it that are observed.
struct Observed {
    name: String,
    reader: Reader,
    parts: Vec<Numbers>,
    /// How many numbers it has. A sequence has as many as at its first value.
    count: Option<usize>,
}

/// A command, and where each number of the action belongs.
struct Command {
    port: LivePort,
    bytes: Vec<u8>,
    /// The places in the action and in the bytes.
    numbers: Vec<(usize, Numbers)>,
}

#[pymethods]
impl Policy {
    /// Prepares the numbers named by `observe`, such as `pioneer.laser.ranges`, and those that mocks command, named
    /// by `act`, such as `policy.base.linear.x`.
    #[new]
    fn new(run: Py<PythonRun>, observe: Vec<String>, act: Vec<String>) -> PyResult<Self> {
        let running = run.get();
        let observed = observe.iter().map(|name| Observed::new(running, name));
        let observed = observed.collect::<PyResult<_>>()?;
        let mut commands: Vec<(String, Command)> = Vec::new();
        for (place, name) in act.iter().enumerate() {
            let (port, path, live) = running.0.find_live(name).map_err(crate::run_error)?;
            let parts = collect(&live.value_type, path).map_err(|wrong| refused(name, &wrong))?;
            let [part @ Numbers { form: Form::One, .. }] = parts.as_slice() else {
                return Err(refused(name, "it is not one number; name a field"));
            };
            let known = commands.iter().position(|(known, _)| known == port);
            let index = known.unwrap_or_else(|| {
                let command = Command {
                    port: live.clone(),
                    bytes: vec![0; live.value_type.bytes],
                    numbers: Vec::new(),
                };
                commands.push((port.to_owned(), command));
                commands.len() - 1
            });
            commands[index].1.numbers.push((place, *part));
        }
        let state = State {
            observed,
            numbers: Vec::new(),
            commands: commands.into_iter().map(|(_, command)| command).collect(),
        };
        Ok(Self {
            run,
            state: Mutex::new(state),
        })
    }

    /// Returns the newest numbers as 32-bit floats; `None` while a variable has had no value. A variable whose
    /// value was retracted keeps its last numbers.
    fn observe<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyByteArray>> {
        let mut state = self.state.lock();
        state.observe().then(|| {
            let bytes: Vec<u8> = state
                .numbers
                .iter()
                .flat_map(|number| number.to_ne_bytes())
                .collect();
            PyByteArray::new(py, &bytes)
        })
    }

    /// Returns the names of the variables without a value.
    fn missing(&self) -> Vec<String> {
        let state = self.state.lock();
        let missing = state.observed.iter().filter(|observed| observed.count.is_none());
        missing.map(|observed| observed.name.clone()).collect()
    }

    /// Returns how many numbers each name stands for; 0 while it has had no value.
    fn counts(&self) -> Vec<usize> {
        let state = self.state.lock();
        let observed = state.observed.iter();
        observed
            .map(|observed| observed.count.unwrap_or_default())
            .collect()
    }

    /// Commands the numbers of an action, and runs until a time, s. Returns whether the application goes on.
    fn act(&self, py: Python<'_>, action: Vec<f64>, until: f64) -> PyResult<bool> {
        let mut state = self.state.lock();
        for command in &mut state.commands {
            for (place, part) in &command.numbers {
                let number = action
                    .get(*place)
                    .ok_or_else(|| error("the action has too few numbers"))?;
                write(part, *number, &mut command.bytes);
            }
            command.port.value.set(&command.bytes).map_err(error)?;
        }
        drop(state);
        self.run.get().until_time(py, until)
    }
}

impl State {
    /// Takes the newest numbers. Returns whether there are all.
    fn observe(&mut self) -> bool {
        let mut start = 0;
        for observed in &mut self.observed {
            let Some(latched) = observed.reader.latch_newest(0) else {
                match observed.count {
                    Some(count) => start += count,
                    None => return false,
                }
                continue;
            };
            let of = |part: &Numbers| part.count(latched.bytes);
            let count = *observed
                .count
                .get_or_insert_with(|| observed.parts.iter().map(of).sum());
            if self.numbers.len() < start + count {
                self.numbers.resize(start + count, 0.0);
            }
            let numbers = &mut self.numbers[start..start + count];
            let read = observed.parts.iter().flat_map(|part| part.read(latched.bytes));
            let mut written = 0;
            for (place, number) in numbers.iter_mut().zip(read) {
                *place = seen(number);
                written += 1;
            }
            numbers[written..].fill(0.0);
            start += count;
        }
        true
    }
}

impl Observed {
    fn new(run: &PythonRun, name: &str) -> PyResult<Self> {
        let (variable, path) = run.0.find(name).map_err(crate::run_error)?;
        let parts = collect(&variable.describe().value_type, path).map_err(|wrong| refused(name, &wrong))?;
        Ok(Self {
            name: name.to_owned(),
            reader: variable.reader("policy"),
            parts,
            count: None,
        })
    }
}

/// As a policy sees it: NaN is 0.
fn seen(number: f64) -> f32 {
    if number.is_nan() { 0.0 } else { number as f32 }
}

/// Writes a number, rounded and limited to what the scalar can hold.
fn write(part: &Numbers, number: f64, bytes: &mut [u8]) {
    let place = &mut bytes[part.offset..][..part.scalar.bytes()];
    match part.scalar {
        Scalar::Bool => place.copy_from_slice(&[u8::from(number >= 0.5)]),
        Scalar::U8 => place.copy_from_slice(&(number.round() as u8).to_ne_bytes()),
        Scalar::U16 => place.copy_from_slice(&(number.round() as u16).to_ne_bytes()),
        Scalar::U32 => place.copy_from_slice(&(number.round() as u32).to_ne_bytes()),
        Scalar::U64 => place.copy_from_slice(&(number.round() as u64).to_ne_bytes()),
        Scalar::I8 => place.copy_from_slice(&(number.round() as i8).to_ne_bytes()),
        Scalar::I16 => place.copy_from_slice(&(number.round() as i16).to_ne_bytes()),
        Scalar::I32 => place.copy_from_slice(&(number.round() as i32).to_ne_bytes()),
        Scalar::I64 => place.copy_from_slice(&(number.round() as i64).to_ne_bytes()),
        Scalar::F32 => place.copy_from_slice(&(number as f32).to_ne_bytes()),
        Scalar::F64 => place.copy_from_slice(&number.to_ne_bytes()),
    }
}

fn refused(name: &str, wrong: &str) -> PyErr {
    error(format!("`{name}`: {wrong}"))
}
