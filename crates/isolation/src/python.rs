//! The program that runs schemas in Python and inspects their files: an interpreter with the package `jde`.

use std::ffi::OsString;
use std::io;

use super::Program;

/// The variable that names the interpreter. Without it `python3` on the `PATH` is used, which in an active virtual
/// environment is the environment's own.
const VARIABLE: &str = "JDE_PYTHON";
/// The interpreter without the variable.
const USUAL: &str = "python3";
/// Starts the package, or says in words why it cannot. The folder in which the host was started is no place of
/// modules.
const BEGIN: &str = r#"
import sys
sys.path[:] = [folder for folder in sys.path if folder]
if sys.version_info < (3, 10):
    sys.exit("%s is Python %d.%d, and jde needs 3.10 or newer; name another interpreter in JDE_PYTHON" % ((sys.executable,) + sys.version_info[:2]))
try:
    from jde import _serve
except ModuleNotFoundError as error:
    if error.name != "jde":
        raise
    sys.exit("%s has no package jde: run %s -m pip install jde" % (sys.executable, sys.executable))
_serve.main(*sys.argv[1:])
"#;

/// The name of the interpreter.
fn interpreter() -> OsString {
    std::env::var_os(VARIABLE)
        .filter(|name| !name.is_empty())
        .unwrap_or_else(|| USUAL.into())
}

/// Returns the command that runs a schema.
#[must_use]
pub fn program() -> Program {
    command("schema")
}

/// Returns the command that inspects files.
pub(crate) fn inspector() -> Program {
    command("inspections")
}

fn command(what: &str) -> Program {
    Program {
        path: interpreter().into(),
        arguments: ["-c", BEGIN, what, env!("CARGO_PKG_VERSION")]
            .map(OsString::from)
            .to_vec(),
    }
}

/// Why the interpreter cannot be started, in words.
pub(crate) fn describe_start_error(error: &io::Error) -> String {
    format!(
        "{} cannot be started: {error}; install Python 3.10 or newer, or name its interpreter in {VARIABLE}",
        interpreter().display()
    )
}
