//! The executable as a library. Connects the other crates, owns the command line and prints errors. Each
//! verb's work has a module of its own. This file contains no control code.

// Modules that both builds share have parts that only the tools use.
#![cfg_attr(
    not(feature = "tools"),
    allow(dead_code, unused_imports, reason = "only the tools use it")
)]

#[cfg(feature = "tools")]
mod analysis;
mod child;
mod cli;
#[cfg(feature = "tools")]
mod complete;
#[cfg(feature = "tools")]
mod decide;
mod descriptors;
mod escape;
mod failure;
#[cfg(feature = "tools")]
mod inspect;
mod interrupt;
mod load;
mod lock;
mod log;
#[cfg(feature = "tools")]
mod new;
mod paths;
#[cfg(feature = "tools")]
mod quantity;
mod queue;
mod record_text;
#[cfg(feature = "tools")]
mod remote;
#[cfg(feature = "tools")]
mod replay;
mod session;
#[cfg(feature = "tools")]
mod strip_chart;
mod summary;
mod terminal;
mod top;
#[cfg(feature = "tools")]
mod why;

/// Whether the first argument makes this process serve another `jde` as its child.
#[must_use]
pub fn is_child(argument: &std::ffi::OsStr) -> bool {
    child::is_child(argument)
}

/// Runs the verb of the command line, or serves as a child process of another `jde`. Returns the exit status.
#[must_use]
pub fn main() -> std::process::ExitCode {
    terminal::install_panic_hook();
    child::main().unwrap_or_else(|| match terminal::open() {
        Ok(()) => {
            descriptors::raise_limit();
            cli::main()
        }
        Err(error) => {
            terminal::write_raw(format_args!(
                "jde: there is no descriptor or thread for the output: {error}\n"
            ));
            std::process::ExitCode::FAILURE
        }
    })
}
