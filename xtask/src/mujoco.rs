//! The example for MuJoCo: its tests, with robots that MuJoCo moves. Nothing else of the project needs MuJoCo.

use std::process::Command;

use anyhow::Result;

use crate::lints;
use crate::package::python as package;
use crate::python::Environment;
use crate::shell;
use crate::step::StepOutcome;
use crate::test::Context;

const ENVIRONMENT: Environment = Environment {
    folder: "mujoco",
    packages: &[
        "flit-core==4.2.0",
        "mujoco==4.0.0",
        "numpy==2.4.6",
        "pytest==9.2.0",
        "ruff==0.17.6",
    ],
    imports: &["flit_core", "mujoco", "numpy", "pytest", "ruff"],
};
const EXAMPLE: &str = "examples/mujoco";

pub(crate) fn run(context: &Context) -> Result<StepOutcome> {
    if !shell::succeeds(Command::new("python3").args(["-c", "import ensurepip"])) {
        return context.missing_tool("Python with venv", "sudo apt-get install python3-venv");
    }
    let cargo = lints::build_all(context);
    let packages = package::make(&context.root, &context.target, cargo, context.paint)?;
    let python = ENVIRONMENT.interpreter(&context.target, context.paint)?;
    let example = context.root.join(EXAMPLE);
    let checks: [&[&str]; 4] = [
        &[
            "pip",
            "install",
            "--quiet",
            "--no-deps",
            "--no-build-isolation",
            "--force-reinstall",
            ".",
        ],
        &["ruff", "check", "."],
        &["ruff", "format", "--check", "."],
        &["pytest", "-q", "-p", "no:cacheprovider"],
    ];
    for check in checks {
        let mut command = Command::new(&python);
        command
            .arg("-m")
            .args(check)
            .current_dir(&example)
            .env("PYTHONPATH", &packages)
            .env("PYTHONDONTWRITEBYTECODE", "1")
            .env("RUFF_NO_CACHE", "true")
            .env("JDE_PYTHON", &python)
            .env("JDE_TEST_BIN", context.target.join("debug"));
        shell::run(&mut command, context.paint)?;
    }
    Ok(StepOutcome::Passed)
}
