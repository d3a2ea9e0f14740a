//! The tests of the package for Python.

use std::process::Command;

use anyhow::Result;

use crate::package::python::{self, CRATE};
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

pub(crate) fn run(context: &Context) -> Result<StepOutcome> {
    if !shell::succeeds(Command::new("python3").args(["-c", "import ensurepip"])) {
        return context.missing_tool("Python with venv", "sudo apt-get install python3-venv");
    }
    let mut cargo = context.cargo(&["build"]);
    cargo.args(context.selection());
    let packages = python::make(&context.root, &context.target, cargo, context.paint)?;
    let python = ENVIRONMENT.interpreter(context)?;
    let tests = context.root.join(CRATE);
    let checks: [&[&str]; 4] = [
        &["ruff", "check", "."],
        &["ruff", "format", "--check", "."],
        &["mypy", "python", "tests", "benches"],
        &["pytest", "-q", "-p", "no:cacheprovider"],
    ];
    for check in checks {
        let mut command = Command::new(&python);
        command
            .arg("-m")
            .args(check)
            .current_dir(&tests)
            .env("PYTHONPATH", &packages)
            .env("PYTHONDONTWRITEBYTECODE", "1")
            .env("RUFF_NO_CACHE", "true")
            .env("MYPY_CACHE_DIR", context.target.join("mypy"))
            .env("JDE_PYTHON", &python)
            .env("JDE_TEST_BIN", context.target.join("debug"));
        shell::run(&mut command, context.paint)?;
    }
    Ok(StepOutcome::Passed)
}
