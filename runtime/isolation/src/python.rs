//! The program that runs schemas in Python and inspects their files: an interpreter with the package `jde`.

use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};

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
fn interpreter(executable: Option<&Path>) -> OsString {
    std::env::var_os(VARIABLE)
        .filter(|name| !name.is_empty())
        .or_else(|| of_environment(executable).map(PathBuf::into_os_string))
        .unwrap_or_else(|| USUAL.into())
}

/// The interpreter of the virtual environment in which the executable is installed, active or not.
#[must_use]
pub fn of_environment(executable: Option<&Path>) -> Option<PathBuf> {
    let prefix = prefix(executable).filter(|prefix| prefix.join("pyvenv.cfg").is_file())?;
    Some(prefix.join("bin").join(USUAL))
}

/// The folder above that of the executable, or of this one if there is none.
fn prefix(executable: Option<&Path>) -> Option<PathBuf> {
    let executable = executable
        .and_then(|executable| executable.canonicalize().ok())
        .or_else(|| std::env::current_exe().ok())?;
    executable.ancestors().nth(2).map(PathBuf::from)
}

/// Returns the command that runs a schema, or one whose debugger may use the terminal, with the package that belongs
/// to the executable `jde`, or to this one if there is none.
#[must_use]
pub fn program(executable: Option<&Path>, debugged: bool) -> Program {
    command(executable, if debugged { "debugged schema" } else { "schema" })
}

/// Returns the command that inspects files.
pub(crate) fn inspector(executable: &Path) -> Program {
    command(Some(executable), "inspections")
}

fn command(executable: Option<&Path>, what: &str) -> Program {
    let mut arguments = ["-c", BEGIN, what, env!("CARGO_PKG_VERSION")]
        .map(OsString::from)
        .to_vec();
    arguments.extend(folders(executable).map(PathBuf::into_os_string));
    Program {
        path: interpreter(executable).into(),
        arguments,
    }
}

/// The folders that hold the package of the executable's build, for an interpreter that has none: of an
/// installation, and of a checkout.
pub fn folders(executable: Option<&Path>) -> impl Iterator<Item = PathBuf> + use<> {
    prefix(executable)
        .into_iter()
        .flat_map(|prefix| [prefix.join("lib/jde/python"), prefix.join("python")])
}

/// Why an interpreter cannot be started, in words.
pub(crate) fn describe_start_error(interpreter: &Program, error: &io::Error) -> String {
    format!(
        "{} cannot be started: {error}; install Python 3.10 or newer, or name its interpreter in {VARIABLE}",
        interpreter.path.display()
    )
}
