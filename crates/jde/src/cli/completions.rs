//! `jde completions`: what a shell needs to complete command lines.

use std::io::Write;

use clap::Args;
use clap_complete::Shell;
use clap_complete::env::Shells;

use crate::failure::Failure;
use crate::terminal;

/// The variable by which a shell asks for completions.
const ASKED_BY: &str = "COMPLETE";

/// Print what a shell needs to complete verbs, options, files, and the names in applications that run.
#[derive(Args)]
#[command(after_help = "Examples:
  jde completions bash > ~/.local/share/bash-completion/completions/jde
  jde completions fish > ~/.config/fish/completions/jde.fish")]
pub(super) struct Completions {
    /// Which shell.
    shell: Shell,
}

impl Completions {
    /// Prints it.
    pub(super) fn run(self) -> Result<(), Failure> {
        let name = self.shell.to_string();
        let shells = Shells::builtins();
        let shell = shells.completer(&name).ok_or_else(|| {
            let known: Vec<_> = shells.names().collect();
            Failure::usage(
                format!("there are no completions for {name}"),
                format!("there are for {}", known.join(", ")),
            )
        })?;
        // Made whole first: a pipe may be closed.
        let mut script = Vec::new();
        shell.write_registration(ASKED_BY, "jde", "jde", "jde", &mut script)?;
        terminal::raw_out().write_all(&script)?;
        Ok(())
    }
}
