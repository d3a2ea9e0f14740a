//! What this process does for a host: it runs one schema, or describes files. The functions return when the host
//! ends the connection.

use std::path::{Path, PathBuf};

use jde_isolation::{serve as serve_schema, serve_inspections};
use jde_loader::{LoadError, LoadedPlugin, PluginLocation};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyType;

use crate::functions::{self, reason};

/// Runs one schema for the host at standard input.
#[pyfunction]
pub(crate) fn serve(py: Python<'_>) -> PyResult<()> {
    py.detach(|| {
        serve_schema(|plugin| match plugin {
            PluginLocation::Python { copy, path } => load(copy, path).map_err(|error| error.to_string()),
            PluginLocation::File(path) => Err(format!("{} is not a file of Python", path.display())),
            PluginLocation::LinkedIn(name) => Err(format!("`{name}` is not a file of Python")),
        })
    })
    .map_err(|error| PyRuntimeError::new_err(error.to_string()))
}

/// Describes files, and lets their schemas inspect what their modulations name, for the host at standard input.
#[pyfunction]
pub(crate) fn inspect(py: Python<'_>) -> PyResult<()> {
    py.detach(|| serve_inspections(load, entry_points))
        .map_err(|error| PyRuntimeError::new_err(error.to_string()))
}

/// Returns the names and files of the plugins that distributions state as entry points.
fn entry_points() -> Vec<(String, PathBuf)> {
    Python::attach(|py| {
        let find = || {
            py.import("jde._load")?
                .getattr("entry_points")?
                .call0()?
                .extract()
        };
        find().unwrap_or_else(|error: PyErr| {
            error.print(py);
            Vec::new()
        })
    })
}

/// Runs a file and writes the tables of its schemas. `copy` has its contents.
fn load(copy: &Path, path: &Path) -> Result<LoadedPlugin, LoadError> {
    Python::attach(|py| {
        let table = || {
            let load = py.import("jde._load")?.getattr("load")?;
            let (name, version, doc, classes): (String, String, String, Vec<Py<PyType>>) =
                load.call1((copy, path))?.extract()?;
            functions::table(py, (name, version, doc), &classes)
        };
        match table() {
            Ok(table) => LoadedPlugin::linked_in(table),
            Err(error) => Err(LoadError::Python(reason(py, &error))),
        }
    })
}
