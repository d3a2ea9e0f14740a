//! `jde mcp`: serves the Model Context Protocol, so that an agent inspects and operates robots.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueHint};
use jde_core::Nanos;
use jde_session::log::{Filter, Log};

use super::client::Target;
use crate::failure::Failure;
use crate::mcp::{self, Options};
use crate::quantity;

/// Serve the Model Context Protocol on standard input and output: an agent inspects robots, and operates them only
/// with --operate.
///
/// A client of the protocol starts it, and it ends with its client. What the agent does to a schema is a hold of the
/// operator agent@HOST, which ends with this server and which anybody may release. An agent may always stop everything.
#[derive(Args)]
#[command(after_help = "Examples:
  jde mcp                                    inspect the applications of this machine
  jde mcp --folder ~/robot --app robot2      files of that folder, and one application alone
  jde mcp --operate --at tls/robot2:7447 --key me.toml

Configuration of a client, such as claude_desktop_config.json:
  { \"mcpServers\": { \"jde\": { \"command\": \"jde\", \"args\": [\"mcp\", \"--folder\", \"/srv/robot\"] } } }
Other clients take the same command and arguments, with the transport `stdio`.")]
pub(crate) struct Mcp {
    #[command(flatten)]
    target: Target,
    /// Let the agent play, stop, force and release schemas, and set modulations and periods.
    #[arg(long)]
    operate: bool,
    /// The folder of all files that the agent may name; the present one if left out.
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    folder: Option<PathBuf>,
    /// Processes at a time of a test or an experiment.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..), default_value = "1")]
    jobs: u16,
    /// The longest time of a test or an experiment.
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time,
          default_value = "10min")]
    limit: Nanos,
}

impl Mcp {
    pub(super) fn run(self, filter: Option<Filter>) -> Result<(), Failure> {
        let _log = Log::start(filter.unwrap_or_default());
        mcp::serve(Options {
            target: self.target,
            operate: self.operate,
            folder: self.folder.unwrap_or_else(|| PathBuf::from(".")),
            jobs: self.jobs.into(),
            limit: Duration::from_nanos(self.limit),
        })
    }
}
