//! This program as a child process without a verb: it runs one isolated schema for a running application, or
//! inspects plugin files before another process loads them, or runs one drive or one check for a verb.

use std::ffi::OsStr;
use std::process::ExitCode;

use jde_isolation::{Program, load, serve, serve_inspections};
use jde_loader::{LoadedPlugin, Plugins};

#[cfg(feature = "tools")]
use crate::interrupt::SignalListener;
use crate::terminal;

/// The argument that runs a check of a plugin.
#[cfg(feature = "tools")]
const CHECK: &str = "--serve-check";
/// The argument that runs the drives of an experiment.
#[cfg(feature = "tools")]
const DRIVES: &str = "--serve-drives";

/// The command that runs drives of an experiment.
#[cfg(feature = "tools")]
pub(crate) fn drives(arguments: &jde_experiment::worker::WorkerArguments) -> Program {
    let mut program = own_program(DRIVES);
    program
        .arguments
        .extend(arguments.to_vec().into_iter().map(Into::into));
    program
}

/// The command that runs a check of a plugin.
#[cfg(feature = "tools")]
pub(crate) fn validator() -> Program {
    own_program(CHECK)
}

/// The command that runs a schema in a process of its own.
pub(crate) fn program() -> Program {
    own_program(Program::SCHEMA)
}

/// The command that inspects plugins.
pub(crate) fn inspector() -> Program {
    own_program(Program::INSPECTIONS)
}

/// This executable, even if its file has been replaced or deleted since the start.
fn own_program(argument: &str) -> Program {
    Program::new("/proc/self/exe".into(), argument)
}

/// Whether the first argument requests a child process.
pub(crate) fn is_child(argument: &OsStr) -> bool {
    #[cfg(feature = "tools")]
    if argument == DRIVES || argument == CHECK {
        return true;
    }
    argument == terminal::GUARD || argument == Program::SCHEMA || argument == Program::INSPECTIONS
}

/// Runs the child process if the first argument requests one. Returns `None` for a verb.
pub(crate) fn main() -> Option<ExitCode> {
    let argument = std::env::args_os().nth(1)?;
    if argument == terminal::GUARD {
        return Some(report(terminal::serve_guard()));
    }
    let result = if argument == Program::SCHEMA {
        serve(|plugin| load(&Plugins::default(), plugin))
    } else if argument == Program::INSPECTIONS {
        serve_inspections(LoadedPlugin::open_copy, Vec::new)
    } else {
        #[cfg(feature = "tools")]
        if argument == DRIVES {
            return Some(report(serve_drives()));
        }
        #[cfg(feature = "tools")]
        if argument == CHECK {
            let arguments: Vec<String> = std::env::args().skip(2).collect();
            return Some(report(jde_validate::serve(&arguments)));
        }
        return None;
    };
    Some(report(result))
}

#[cfg(feature = "tools")]
fn serve_drives() -> Result<(), String> {
    use jde_experiment::worker::{WorkerArguments, serve};
    let arguments = std::env::args().skip(2);
    let arguments = WorkerArguments::read(arguments).ok_or("wrong arguments")?;
    // The end of the input ends this process. A signal to all processes of a job, as Slurm sends, must not: the
    // drive would have crashed.
    let _listener = SignalListener::on_each(|_, _| {}).map_err(|error| error.to_string())?;
    serve(&arguments, &program(), &inspector())
}

fn report<E: std::fmt::Display>(result: Result<(), E>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            terminal::write_raw(format_args!("jde: {error}\n"));
            ExitCode::from(2)
        }
    }
}
