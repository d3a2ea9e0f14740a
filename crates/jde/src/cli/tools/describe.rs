//! `jde describe`: prints a plugin's description of itself.

use std::io::Write;
use std::path::Path;

use clap::{Args, ValueHint};
use jde_loader::SearchPath;

use crate::cli::print_json;
use crate::failure::Failure;
use crate::{inspect, load, terminal};

/// Describe a plugin: its types of schemas with their inputs, outputs, modulations and children.
///
/// Starts no schema of it.
#[derive(Args)]
#[command(after_help = "Examples:
  jde describe vff
  jde describe target/debug/libfollow.so --json")]
pub(crate) struct Describe {
    /// The plugin's name or file.
    #[arg(value_hint = ValueHint::FilePath)]
    plugin: String,
    /// Print one line of JSON.
    #[arg(long)]
    json: bool,
}

impl Describe {
    /// Prints the description.
    pub(super) fn run(self) -> Result<(), Failure> {
        let plugins = load::plugins(SearchPath::usual(None));
        let path = Path::new(&self.plugin);
        let is_a_file = path.is_file() || self.plugin.ends_with(".so") || self.plugin.starts_with(['.', '/']);
        let plugin = if is_a_file {
            plugins.describe_file(path)?
        } else {
            // Accept the full name of a type as well: its plugin is the part before the slash.
            plugins.describe(self.plugin.split('/').next().unwrap_or_default(), &[])?
        };
        if self.json {
            return print_json(&inspect::PluginData::new(
                &plugin.description,
                plugin.path.as_deref(),
            ));
        }
        let mut out = terminal::out();
        inspect::plugin(&plugin.description, plugin.path.as_deref(), &mut out)?;
        out.flush()?;
        Ok(())
    }
}
