//! What the programs of jde share that run an application and say on a terminal what it does: loading it, its run with
//! what accompanies it, the oscilloscope, the summary, failures and their exit status. And the demonstration.
//!
//! It has neither link nor recordings; a program adds them as extensions of a run ([`run::Extension`]).

pub mod child;
pub mod cli;
pub mod clock;
pub mod demo;
mod descriptors;
pub mod failure;
pub mod load;
pub mod log;
pub mod paths;
pub mod record_text;
pub mod run;
pub mod summary;
pub mod top;

use std::ffi::OsStr;
use std::process::ExitCode;

use jde_terminal as terminal;

/// Runs a program: what its command line requests, or a child process of every program or of its own, which `serve`
/// serves. Returns the exit status.
pub fn main(
    serve: impl FnOnce(&OsStr) -> Option<Result<(), String>>,
    command_line: impl FnOnce() -> ExitCode,
) -> ExitCode {
    terminal::install_panic_hook();
    child::main(serve).unwrap_or_else(|| match terminal::open() {
        Ok(()) => {
            descriptors::raise_limit();
            command_line()
        }
        Err(error) => {
            terminal::write_raw(format_args!(
                "jde: there is no descriptor or thread for the output: {error}\n"
            ));
            ExitCode::FAILURE
        }
    })
}
