//! `jde man`: writes the manual pages of all verbs.

use std::path::PathBuf;

use clap::{Args, CommandFactory, ValueHint};

use crate::cli::Cli;
use crate::failure::Failure;

/// Write a manual page for each verb, from its help.
#[derive(Args)]
#[command(after_help = "Example:
  jde man ~/.local/share/man/man1")]
pub(crate) struct Man {
    /// The folder, which is made if it does not exist.
    #[arg(value_name = "DIR", value_hint = ValueHint::DirPath)]
    folder: PathBuf,
}

impl Man {
    /// Writes the pages.
    pub(super) fn run(self) -> Result<(), Failure> {
        jde_files::create_folder(&self.folder)
            .and_then(|()| clap_mangen::generate_to(Cli::command(), &self.folder))
            .map_err(Failure::file(&self.folder))
    }
}
