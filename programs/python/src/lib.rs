//! Schemas in Python, and runs of applications from Python: the extension module `jde._jde`, on which the
//! package `jde` in `python/` builds.
//!
//! Built for Python's stable ABI from 3.10 on, so that one file serves all later versions.

mod applications;
mod bench;
mod clients;
mod context;
mod describe;
mod described;
mod functions;
mod layout;
mod numbers;
mod panel;
mod pictures;
mod policies;
mod recordings;
mod runs;
mod serve;
mod values;
mod views;
mod worlds;

use jde_core::Nanos;
use jde_records::RunRecord;
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use serde::Serialize;

pyo3::create_exception!(
    jde,
    Error,
    pyo3::exceptions::PyException,
    "What an application refuses."
);

/// Returns the exception for an error.
fn error(error: impl std::fmt::Display) -> PyErr {
    Error::new_err(error.to_string())
}

/// Returns the exception for an error of an application or a run.
fn run_error(error: jde_embed::Error) -> PyErr {
    match error {
        jde_embed::Error::Unknown(reason) => PyKeyError::new_err(reason),
        other => self::error(other),
    }
}

/// Converts seconds.
fn nanoseconds(seconds: f64) -> PyResult<Nanos> {
    let nanoseconds = (seconds * 1e9).round();
    if (0.0..9e18).contains(&nanoseconds) {
        Ok(nanoseconds as Nanos)
    } else {
        Err(PyValueError::new_err(format!(
            "{seconds} s is not a time of a run"
        )))
    }
}

/// Returns data as dictionaries, lists, numbers and texts.
fn json<'py>(py: Python<'py>, data: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(data).map_err(error)?;
    py.import("json")?.call_method1("loads", (text,))
}

/// Returns a record as a dictionary.
fn record_to_python<'py>(py: Python<'py>, record: &RunRecord) -> PyResult<Bound<'py, PyAny>> {
    match record {
        RunRecord::Decision(decision) => json(py, decision),
        RunRecord::State(state) => json(py, state),
        RunRecord::Other(event) => json(py, event),
    }
}

/// What the package needs of Rust.
#[pymodule]
mod _jde {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::Error;
    #[pymodule_export]
    use crate::applications::LoadedApplication;
    #[pymodule_export]
    use crate::bench::Bench;
    #[pymodule_export]
    use crate::clients::{Lease, RemoteApplication, Watch};
    #[pymodule_export]
    use crate::context::Context;
    #[pymodule_export]
    use crate::described::DescribedPolicy;
    #[pymodule_export]
    use crate::layout::Layout;
    #[pymodule_export]
    use crate::panel::Pen;
    #[pymodule_export]
    use crate::pictures::{draw_numbers, draw_paths};
    #[pymodule_export]
    use crate::policies::Policy;
    #[pymodule_export]
    use crate::recordings::OpenRecording;
    #[pymodule_export]
    use crate::runs::PythonRun;
    #[pymodule_export]
    use crate::serve::{inspect, serve};
    #[pymodule_export]
    use crate::worlds::{OtherWorld, robot_model};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
