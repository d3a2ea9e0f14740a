//! `jde describe`: prints a plugin's description of itself, or a type of value.

use std::io::Write;
use std::path::Path;

use clap::Args;
use clap_complete::ArgValueCompleter;
use jde_loader::SearchPath;

use crate::cli::print_json;
use crate::failure::Failure;
use crate::inspect::{self, ValueTypeData};
use crate::{complete, load, terminal};

/// Describe a plugin: its types of schemas with their inputs, outputs, modulations and children. Or a type of
/// value: its fields, and the schemas that have it.
///
/// Starts no schema.
#[derive(Args)]
#[command(after_help = "Examples:
  jde describe vff
  jde describe target/debug/libfollow.so --json
  jde describe sensor_msgs/msg/LaserScan")]
pub(crate) struct Describe {
    /// The plugin's name or file, or the name of a type of value, with its package or without.
    #[arg(value_name = "PLUGIN|TYPE", add = ArgValueCompleter::new(complete::plugins_and_value_types))]
    name: String,
    /// Print one line of JSON.
    #[arg(long)]
    json: bool,
}

impl Describe {
    /// Prints the description.
    pub(super) fn run(self) -> Result<(), Failure> {
        let plugins = load::plugins(SearchPath::usual(None));
        let path = Path::new(&self.name);
        let is_a_file = path.is_file() || self.name.ends_with(".so") || self.name.starts_with(['.', '/']);
        let last = self.name.rsplit('/').next().unwrap_or_default();
        // The names of plugins and of their types of schemas have no capitals.
        if !is_a_file && last.starts_with(char::is_uppercase) {
            let value_type = ValueTypeData::find(&self.name, &load::describe_all(&plugins, &[]))?;
            if self.json {
                return print_json(&value_type);
            }
            let mut out = terminal::out();
            value_type.write(&mut out)?;
            return Ok(out.flush()?);
        }
        let plugin = if is_a_file {
            plugins.describe_file(path)?
        } else {
            // Accept the full name of a type as well: its plugin is the part before the slash.
            plugins.describe(self.name.split('/').next().unwrap_or_default(), &[])?
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
