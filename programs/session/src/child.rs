//! This program as a child process without a verb: it runs one isolated schema for a running application, or
//! inspects plugin files before another process loads them, or does what the program adds.

use std::ffi::OsStr;
use std::process::ExitCode;

use jde_isolation::{Program, load, serve, serve_inspections};
use jde_loader::{LoadedPlugin, Plugins};
use jde_terminal as terminal;

/// The command that runs a schema in a process of its own.
#[must_use]
pub fn program() -> Program {
    own_program(Program::SCHEMA)
}

/// The command that inspects plugins.
#[must_use]
pub fn inspector() -> Program {
    own_program(Program::INSPECTIONS)
}

/// This executable, even if its file has been replaced or deleted since the start.
#[must_use]
pub fn own_program(argument: &str) -> Program {
    Program::new("/proc/self/exe".into(), argument)
}

/// Whether the first argument requests a child process of every program.
#[must_use]
pub fn is_child(argument: &OsStr) -> bool {
    argument == terminal::GUARD || argument == Program::SCHEMA || argument == Program::INSPECTIONS
}

/// Runs the child process if the first argument requests one, of every program or what `more` serves. Returns `None`
/// for a verb.
pub fn main(more: impl FnOnce(&OsStr) -> Option<Result<(), String>>) -> Option<ExitCode> {
    let argument = std::env::args_os().nth(1)?;
    let result = if argument == terminal::GUARD {
        terminal::serve_guard().map_err(|error| error.to_string())
    } else if argument == Program::SCHEMA {
        serve(|plugin| load(&Plugins::default(), plugin)).map_err(|error| error.to_string())
    } else if argument == Program::INSPECTIONS {
        serve_inspections(LoadedPlugin::open_copy, Vec::new).map_err(|error| error.to_string())
    } else {
        more(&argument)?
    };
    Some(match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            terminal::write_raw(format_args!("jde: {error}\n"));
            ExitCode::from(2)
        }
    })
}
