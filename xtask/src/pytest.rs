//! The tests of the package for Python.

use std::path::PathBuf;
use std::process::Command;

use anyhow::Result;

use crate::lints;
use crate::package::python::{self, CRATE};
use crate::programs;
use crate::python::Environment;
use crate::shell;
use crate::step::StepOutcome;
use crate::test::Context;

/// The Python environment of the tests.
const ENVIRONMENT: Environment = Environment {
    folder: "pytest",
    packages: &[
        "gymnasium==1.4.0",
        "mypy==2.4.1",
        "numpy==2.4.6",
        "pandas==3.1.1",
        "pandas-stubs==3.1.0.261029",
        "pytest==9.2.0",
        "ruff==0.17.6",
    ],
    imports: &["gymnasium", "mypy", "numpy", "pandas", "pytest", "ruff"],
};

/// The package for Python, and an interpreter with what its tests need.
pub(crate) struct Python {
    /// The folder of the package, for `PYTHONPATH`.
    pub(crate) packages: PathBuf,
    pub(crate) interpreter: PathBuf,
}

impl Python {
    /// Makes both, unless this machine lacks what makes environments.
    pub(crate) fn new(context: &Context) -> Result<Option<Self>> {
        if !shell::succeeds(Command::new("python3").args(["-c", "import ensurepip"])) {
            return Ok(None);
        }
        let cargo = lints::build_all(context);
        Ok(Some(Self {
            packages: python::make(&context.root, &context.target, cargo, context.paint)?,
            interpreter: ENVIRONMENT.interpreter(&context.target, context.paint)?,
        }))
    }

    /// Says what is missing.
    pub(crate) fn missing(context: &Context) -> Result<StepOutcome> {
        context.missing_tool("Python with venv", "sudo apt-get install python3-venv")
    }
}

/// The schemas in Python of the tests of conformance, from the folder of the package.
const SCHEMAS: &str = "../../runtime/host/tests/python";

pub(crate) fn run(context: &Context) -> Result<StepOutcome> {
    let Some(python) = Python::new(context)? else {
        return Python::missing(context);
    };
    let tests = context.root.join(CRATE);
    let checks: [&[&str]; 4] = [
        &["ruff", "check", ".", SCHEMAS, "--config", "pyproject.toml"],
        &[
            "ruff",
            "format",
            "--check",
            ".",
            SCHEMAS,
            "--config",
            "pyproject.toml",
        ],
        &["mypy", "python", "tests", "benches", SCHEMAS],
        &["pytest", "-q", "-p", "no:cacheprovider"],
    ];
    for check in checks {
        let mut command = Command::new(&python.interpreter);
        command
            .arg("-m")
            .args(check)
            .current_dir(&tests)
            .env("PYTHONPATH", &python.packages)
            .env("PYTHONDONTWRITEBYTECODE", "1")
            .env("RUFF_NO_CACHE", "true")
            .env("MYPY_CACHE_DIR", context.target.join("mypy"))
            .env("JDE_PYTHON", &python.interpreter)
            .env("JDE_TEST_BIN", context.target.join("debug"));
        shell::run(&mut command, context.paint)?;
    }
    if context.options.package.is_none() {
        // The tests of conformance with schemas in Python, which the step `tests` ignores.
        let programs = programs::build(context, &context.selection())?;
        let mut job = programs::find(&programs, "runtime/host", "conformance")?.job(&context.root);
        job.command
            .arg("--ignored")
            .env("PYTHONPATH", &python.packages)
            .env("JDE_PYTHON", &python.interpreter);
        shell::run(&mut job.command, context.paint)?;
    }
    Ok(StepOutcome::Passed)
}
