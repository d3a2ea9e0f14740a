//! `jde check`: reports every fault of an application without starting it, or prints what would run.

use std::io::Write;
use std::path::PathBuf;

use clap::{Args, ValueHint};
use jde_app::Override;
use jde_session::load;
use jde_terminal as terminal;

use crate::failure::Failure;
use crate::inspect;

/// Check an application without starting it: print every fault, or what would run.
///
/// Drivers check what their settings name: that a robot exists in its world, a file is a recording, a device
/// is present.
///
/// Prints the schemas by father and group with their bindings. Prints for each group its contract: the
/// longest time that a takeover may take, and how it is computed. Prints warnings of what may not be intended on
/// standard error.
#[derive(Args)]
#[command(after_help = "Examples:
  jde check apps/safe-navigation.toml
  jde check safe-navigation --defaults")]
pub(crate) struct Check {
    /// The application's file, or the name of one in the folder apps.
    #[arg(value_name = "APP", value_hint = ValueHint::FilePath)]
    application: PathBuf,
    /// Check it with another value of a modulation (repeatable).
    #[arg(long, value_name = "SCHEMA.VARIABLE=VALUE")]
    set: Vec<Override>,
    /// Also print the modulations that have the default of their type.
    #[arg(long)]
    defaults: bool,
}

impl Check {
    /// Checks the application and prints the result.
    pub(super) fn run(self) -> Result<(), Failure> {
        let application = load::check(&self.application, &self.set)?;
        let mut out = terminal::out();
        inspect::application(&application, &mut out)?;
        if self.defaults {
            inspect::defaults(&application, &mut out)?;
        }
        out.flush()?;
        if let Some(warnings) = inspect::warnings(&application) {
            jde_session::failure::warn(&warnings);
        }
        application
            .concerns
            .map_or(Ok(()), |faults| Err(Failure::faults(faults)))
    }
}
