//! `jde check`: finds all that is wrong with an application without starting it, or says what will run.

use std::io::Write;
use std::path::PathBuf;

use clap::{Args, ValueHint};
use jde_host::app::Override;

use crate::failure::Failure;
use crate::{inspect, load, terminal};

/// Check an application without starting it: all that is wrong with it, or what will run.
///
/// Drivers look at what they name: whether a robot is in its world, a recording is one, a device is there.
///
/// Prints the schemas by father and group with what they are bound to, and for every group the longest time that a takeover
/// may need (its contract), with the sum it comes from.
#[derive(Args)]
#[command(after_help = "Example:
  jde check apps/safe-navigation.toml")]
pub(super) struct Check {
    /// The application's file, or the name of one in apps.
    #[arg(value_name = "APP", value_hint = ValueHint::FilePath)]
    application: PathBuf,
    /// Check it with another value of a modulation (repeatable).
    #[arg(long, value_name = "SCHEMA.VARIABLE=VALUE")]
    set: Vec<Override>,
}

impl Check {
    /// Checks it.
    pub(super) fn run(self) -> Result<(), Failure> {
        let application = load::check(&self.application, &self.set)?;
        let mut out = terminal::out();
        inspect::application(&application, &mut out)?;
        out.flush()?;
        application
            .concerns
            .map_or(Ok(()), |faults| Err(Failure::missing(faults)))
    }
}
