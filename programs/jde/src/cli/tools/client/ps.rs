//! `jde ps`: prints the hierarchy of a running application.

use clap::Args;
use clap_complete::ArgValueCompleter;
use jde_session::cli::{print_json, print_value};

use super::{Context, Past, Target};
use crate::complete;
use crate::failure::Failure;
use crate::remote;
use crate::replay::Asked;

/// Show the hierarchy: the state, the health and the timing of each schema.
#[derive(Args)]
#[command(after_help = "Examples:
  jde ps
  jde ps robot2 --json
  jde ps --in drive.mcap --at 12.4s")]
pub(crate) struct Ps {
    /// The application, if several run.
    #[arg(value_name = "APP", add = ArgValueCompleter::new(complete::applications))]
    application: Option<String>,
    #[command(flatten)]
    past: Past,
    #[command(flatten)]
    target: Target,
    /// Print one line of JSON.
    #[arg(long)]
    json: bool,
}

impl Ps {
    pub(crate) fn run(mut self, context: &Context) -> Result<(), Failure> {
        let _moment = self.past.serve(&mut self.target, &Asked::Hierarchy)?;
        let remote = context.remote_by_name(&self.target, self.application.as_deref())?;
        let hierarchy = remote.hierarchy()?;
        match (self.past.is_asked(), self.json) {
            (false, json) => print_value(json, &hierarchy, remote::hierarchy::write)?,
            (true, false) => print_value(false, &hierarchy, remote::hierarchy::write_recorded)?,
            (true, true) => print_json(&remote::hierarchy::recorded_json(&hierarchy))?,
        }
        Ok(())
    }
}
