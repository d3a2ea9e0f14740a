//! `jde completions`: what a shell needs to complete command lines.

use clap::{Args, Command};
use clap_complete::Shell;

use crate::failure::Failure;

/// Print what a shell needs to complete verbs, options and files.
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
    pub(super) fn run(self, command: &mut Command) -> Result<(), Failure> {
        // Made whole first: the generator panics when a pipe is closed.
        let mut script = Vec::new();
        clap_complete::generate(self.shell, command, "jde", &mut script);
        std::io::Write::write_all(&mut std::io::stdout(), &script)?;
        Ok(())
    }
}
