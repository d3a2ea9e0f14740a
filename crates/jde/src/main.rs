//! The one executable. Connects the other crates, owns the command line and prints errors. Each verb's work
//! has a module of its own. This file contains no control code.

mod attached;
mod child;
mod cli;
mod complete;
mod failure;
mod inspect;
mod interrupt;
mod load;
mod log;
mod new;
mod places;
mod playback;
mod queue;
mod recorded;
mod replay;
mod session;
mod strip;
mod summary;
mod terminal;
mod top;
mod visible;
mod why;

fn main() -> std::process::ExitCode {
    terminal::tell_panics();
    child::main().unwrap_or_else(cli::main)
}
