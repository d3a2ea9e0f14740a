//! The executable as a library. Connects the other crates and owns the command line. Each
//! verb's work has a module of its own. This file contains no control code.

mod analysis;
mod child;
mod cli;
mod complete;
mod decide;
mod extensions;
mod failure;
mod inspect;
mod mcp;
mod new;
mod page_file;
mod quantity;
mod remote;
mod replay;
#[cfg(test)]
#[path = "../../session/src/top/tests/snapshots.rs"]
mod snapshots;
mod strip_chart;
mod why;
#[cfg(not(feature = "view"))]
#[path = "no_windows.rs"]
mod windows;
#[cfg(feature = "view")]
mod windows;

/// Runs the verb of the command line, or serves as a child process of another `jde`. Returns the exit status.
#[must_use]
pub fn main() -> std::process::ExitCode {
    jde_session::main(child::serve_child, cli::main)
}
