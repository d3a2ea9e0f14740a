//! `jde new`: writes a new schema, driver or application.

use std::path::PathBuf;

use clap::{Args, ValueEnum, ValueHint};

use crate::failure::Failure;
use crate::new::{self, Kind};

/// Write a new schema, driver or application that builds, passes its test and runs at once.
#[derive(Args)]
#[command(after_help = "Examples:
  jde new schema follow
  jde new driver gripper --path ~/robots
  jde new app patrol")]
pub(crate) struct New {
    /// What to write.
    kind: KindArg,
    /// Its name, such as follow-wall. The folder has the same name.
    name: String,
    /// The folder in which to make its folder.
    #[arg(long, value_name = "DIR", default_value = ".", value_hint = ValueHint::DirPath)]
    path: PathBuf,
}

#[derive(Clone, Copy, ValueEnum)]
enum KindArg {
    /// A motor schema, with an application in which it drives a simulated robot.
    Schema,
    /// A driver, with an application that reads it.
    Driver,
    /// An application of the existing schemas.
    App,
}

impl New {
    /// Writes the files.
    pub(super) fn run(self) -> Result<(), Failure> {
        let kind = match self.kind {
            KindArg::Schema => Kind::Schema,
            KindArg::Driver => Kind::Driver,
            KindArg::App => Kind::Application,
        };
        new::write(kind, &self.name, &self.path)
    }
}
