//! Builds the Python package by cargo, and runs its tests: `target/python/jde` is the package as a wheel would
//! install it, so that `PYTHONPATH=target/python` is enough to use it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result};

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
/// The crate with the package and its tests.
const CRATE: &str = "crates/python";

pub(crate) fn run(context: &Context) -> Result<StepOutcome> {
    if !shell::succeeds(Command::new("python3").args(["-c", "import ensurepip"])) {
        return context.missing_tool("Python with venv", "sudo apt-get install python3-venv");
    }
    let packages = package(context)?;
    let python = ENVIRONMENT.interpreter(context)?;
    let tests = context.root.join(CRATE);
    let checks: [&[&str]; 4] = [
        &["ruff", "check", "."],
        &["ruff", "format", "--check", "."],
        &["mypy", "python", "tests"],
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

/// Builds the package, and returns the folder that contains it.
fn package(context: &Context) -> Result<PathBuf> {
    let mut cargo = context.cargo(&["build", "--package", "jde-python"]);
    shell::run(&mut cargo, context.paint)?;
    let folder = context.target.join("python");
    let package = folder.join("jde");
    if package.exists() {
        fs::remove_dir_all(&package).context("the old package cannot be removed")?;
    }
    copy(&context.root.join(CRATE).join("python/jde"), &package)?;
    let library = context.target.join("debug/lib_jde.so");
    fs::copy(library, package.join("_jde.abi3.so")).context("the extension module cannot be copied")?;
    Ok(folder)
}

/// Copies a folder with all that is in it, except what Python has compiled.
fn copy(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let target = to.join(entry.file_name());
        if entry.file_name() == "__pycache__" {
            continue;
        }
        if entry.file_type()?.is_dir() {
            copy(&entry.path(), &target)?;
        } else {
            fs::copy(entry.path(), target)?;
        }
    }
    Ok(())
}
