//! The program that runs schemas in Python and inspects their files: an interpreter with the package `jde`.

use std::ffi::OsString;
use std::io;
use std::path::PathBuf;

use super::Program;

/// The variable that names the interpreter.
const VARIABLE: &str = "JDE_PYTHON";
/// The interpreter without the variable, on the `PATH`: in an active virtual environment the environment's own.
const USUAL: &str = "python3";
/// Starts the package, or says in words why it cannot. The folder in which the host was started is no place of
/// modules.
const BEGIN: &str = r#"
import sys
sys.path[:] = [folder for folder in sys.path if folder] + sys.argv[3:]
if sys.version_info < (3, 10):
    sys.exit("%s is Python %d.%d, and jde needs 3.10 or newer; name another interpreter in JDE_PYTHON" % ((sys.executable,) + sys.version_info[:2]))
try:
    from jde import _serve
except ModuleNotFoundError as error:
    if error.name != "jde":
        raise
    sys.exit("%s has no package jde, and there is none in %s: install it for this interpreter, or run `cargo xtask package --only python` in the checkout of jde" % (sys.executable, " or ".join(sys.argv[3:])))
_serve.main(*sys.argv[1:3])
"#;

/// The name of the interpreter.
fn interpreter() -> OsString {
    std::env::var_os(VARIABLE)
        .filter(|name| !name.is_empty())
        .or_else(of_environment)
        .unwrap_or_else(|| USUAL.into())
}

/// The interpreter of the virtual environment in which this executable is installed, active or not.
fn of_environment() -> Option<OsString> {
    let prefix = prefix().filter(|prefix| prefix.join("pyvenv.cfg").is_file())?;
    Some(prefix.join("bin").join(USUAL).into())
}

/// The folder above that of the executable.
fn prefix() -> Option<PathBuf> {
    let executable = std::env::current_exe().ok()?;
    executable.ancestors().nth(2).map(PathBuf::from)
}

/// Returns the command that runs a schema, or one whose debugger may use the terminal.
#[must_use]
pub fn program(debugged: bool) -> Program {
    command(if debugged { "debugged schema" } else { "schema" })
}

/// Returns the command that inspects files.
pub(crate) fn inspector() -> Program {
    command("inspections")
}

fn command(what: &str) -> Program {
    let mut arguments = ["-c", BEGIN, what, env!("CARGO_PKG_VERSION")]
        .map(OsString::from)
        .to_vec();
    arguments.extend(folders().map(PathBuf::into_os_string));
    Program {
        path: interpreter().into(),
        arguments,
    }
}

/// The folders that hold the package of this executable's build, for an interpreter that has none: of an
/// installation, and of a checkout.
pub fn folders() -> impl Iterator<Item = PathBuf> {
    prefix()
        .into_iter()
        .flat_map(|prefix| [prefix.join("lib/jde/python"), prefix.join("python")])
}

/// Why the interpreter cannot be started, in words.
pub(crate) fn describe_start_error(error: &io::Error) -> String {
    format!(
        "{} cannot be started: {error}; install Python 3.10 or newer, or name its interpreter in {VARIABLE}",
        interpreter().display()
    )
}
