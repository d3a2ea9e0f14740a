//! Applications that Python runs: loaded and checked once, started many times.

use std::collections::BTreeMap;
use std::path::PathBuf;

use jde_app::Override;
use jde_embed::StartOptions;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::runs::PythonRun;
use crate::values::{as_text, from_python};
use crate::{error, nanoseconds, run_error};

/// The name of the operator in records.
const OPERATOR: &str = "python";

/// An application that was loaded and checked.
#[pyclass(frozen, module = "jde", name = "Application")]
pub(crate) struct LoadedApplication(jde_embed::LoadedApplication);

#[pymethods]
impl LoadedApplication {
    /// Loads the application of a file, with values in place of those in the file. The schemas in `mocks` are not
    /// called: the run writes what they export and command.
    #[new]
    #[pyo3(signature = (file, set=None, mocks=Vec::new(), executable=None))]
    fn new(
        py: Python<'_>,
        file: PathBuf,
        set: Option<&Bound<'_, PyDict>>,
        mocks: Vec<String>,
        executable: Option<PathBuf>,
    ) -> PyResult<Self> {
        let overrides = set.map_or(Ok(Vec::new()), overrides)?;
        let loaded = py.detach(|| jde_embed::LoadedApplication::load(file, overrides, mocks, executable));
        loaded.map(Self).map_err(run_error)
    }

    /// The name of the application.
    #[getter]
    fn name(&self) -> PyResult<String> {
        Ok(self.0.application().map_err(run_error)?.name)
    }

    /// The names of the schemas, in the order of the file.
    #[getter]
    fn schemas(&self) -> PyResult<Vec<String>> {
        let instances = self.0.application().map_err(run_error)?.instances.into_iter();
        Ok(instances.map(|instance| instance.name).collect())
    }

    /// The full names of the variables, and the names of their types.
    #[getter]
    fn variables(&self) -> PyResult<BTreeMap<String, String>> {
        self.0.variables().map_err(run_error)
    }

    /// Starts the application in lockstep, at time 0. Without `records`, decisions, events and traces are not
    /// kept, and conditions are not available.
    #[pyo3(signature = (seed=None, limit=None, records=true))]
    fn run(
        &self,
        py: Python<'_>,
        seed: Option<u64>,
        limit: Option<f64>,
        records: bool,
    ) -> PyResult<PythonRun> {
        let options = StartOptions {
            lockstep: true,
            seed,
            limit: limit.map(nanoseconds).transpose()?,
            records,
            operator: String::from(OPERATOR),
            ..StartOptions::default()
        };
        py.detach(|| self.0.start(&options))
            .map(PythonRun)
            .map_err(run_error)
    }
}

/// Reads values by the full names of their variables.
fn overrides(set: &Bound<'_, PyDict>) -> PyResult<Vec<Override>> {
    let read = set.iter().map(|(name, value)| {
        let text = format!("{}={}", name.extract::<String>()?, as_text(&from_python(&value)?));
        text.parse().map_err(error)
    });
    read.collect()
}
