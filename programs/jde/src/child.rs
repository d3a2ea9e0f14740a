//! What this program does as a child process of itself, beside what every program does: one drive of an experiment, or
//! one check of a plugin.

use std::ffi::OsStr;

use jde_experiment::worker::{WorkerArguments, serve};
use jde_isolation::Program;
use jde_session::child::{inspector, own_program, program};
use jde_terminal::interrupt::SignalListener;

/// The argument that runs a check of a plugin.
const CHECK: &str = "--serve-check";
/// The argument that runs the drives of an experiment.
const DRIVES: &str = "--serve-drives";

/// The command that runs drives of an experiment.
pub(crate) fn drives(arguments: &WorkerArguments) -> Program {
    let mut program = own_program(DRIVES);
    program
        .arguments
        .extend(arguments.to_vec().into_iter().map(Into::into));
    program
}

/// The command that runs a check of a plugin.
pub(crate) fn validator() -> Program {
    own_program(CHECK)
}

/// Serves as the child process that the first argument requests. Returns `None` for a verb.
pub(crate) fn serve_child(argument: &OsStr) -> Option<Result<(), String>> {
    if argument == DRIVES {
        return Some(serve_drives());
    }
    let arguments = || std::env::args().skip(2).collect::<Vec<_>>();
    (argument == CHECK).then(|| jde_validate::serve(&arguments()).map_err(|error| error.to_string()))
}

fn serve_drives() -> Result<(), String> {
    let arguments = std::env::args().skip(2);
    let arguments = WorkerArguments::read(arguments).ok_or("wrong arguments")?;
    // The end of the input ends this process. A signal to all processes of a job, as Slurm sends, must not: the
    // drive would have crashed.
    let _listener = SignalListener::on_each(|_, _| {}).map_err(|error| error.to_string())?;
    serve(&arguments, &program(), &inspector())
}
