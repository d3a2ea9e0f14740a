//! `jde completions`: prints the script that enables completion in a shell.

use std::io::Write;

use clap::Args;
use clap_complete::Shell;
use clap_complete::env::Shells;
use jde_terminal as terminal;

use crate::failure::Failure;

/// The environment variable through which a shell requests completions.
const COMPLETE_VARIABLE: &str = "COMPLETE";

/// Print the shell script that completes verbs, options, files, and the names in running applications.
#[derive(Args)]
#[command(after_help = "Examples:
  jde completions bash > ~/.local/share/bash-completion/completions/jde
  jde completions fish > ~/.config/fish/completions/jde.fish")]
pub(crate) struct Completions {
    /// The shell.
    shell: Shell,
}

impl Completions {
    /// Prints the script.
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
        // Build the whole script before writing it: standard output may be a closed pipe.
        let mut script = Vec::new();
        shell.write_registration(COMPLETE_VARIABLE, "jde", "jde", "jde", &mut script)?;
        terminal::raw_out().write_all(&script)?;
        Ok(())
    }
}
