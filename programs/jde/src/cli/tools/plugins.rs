//! `jde plugins`: lists the plugins, their files, and the searched folders with the reason for each.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use jde_session::cli::print_value;

use crate::failure::Failure;
use crate::inspect;

/// List the plugins, the searched folders in their order, and the files that cannot be used with the reason.
#[derive(Args)]
#[command(after_help = "Examples:
  jde plugins
  jde plugins apps/safe-navigation.toml --json")]
pub(crate) struct Plugins {
    /// List what this application can use. It may name folders of its own.
    #[arg(value_name = "APP", value_hint = ValueHint::FilePath)]
    application: Option<PathBuf>,
    /// Print one line of JSON.
    #[arg(long)]
    json: bool,
}

impl Plugins {
    /// Prints the list.
    pub(super) fn run(self) -> Result<(), Failure> {
        let listing = inspect::PluginListing::scan(self.application.as_deref())?;
        Ok(print_value(self.json, &listing, inspect::PluginListing::write)?)
    }
}
