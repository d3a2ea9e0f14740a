//! `jde describe`: prints a plugin's description of itself, or a type of value.

use std::path::Path;

use clap::Args;
use clap_complete::ArgValueCompleter;
use jde_loader::{PluginError, Plugins, SearchPath};
use jde_session::cli::print_value;
use jde_session::load;

use crate::complete;
use crate::failure::Failure;
use crate::inspect::{self, ValueTypeData};

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
            return Ok(print_value(self.json, &value_type, ValueTypeData::write)?);
        }
        let plugin = if is_a_file {
            plugins.describe_file(path)?
        } else {
            // Accept the full name of a type as well: its plugin is the part before the slash.
            let (name, schema) = self.name.split_once('/').unwrap_or((&self.name, ""));
            let plugin = plugins
                .describe(name, &[])
                .map_err(|error| suggest(error, &plugins))?;
            let types = plugin
                .description
                .schemas
                .iter()
                .map(|schema| schema.name.as_str());
            if !schema.is_empty() && types.clone().all(|known| known != schema) {
                return Err(Failure::unknown(
                    &format!("type of schema in `{name}`"),
                    schema,
                    types,
                ));
            }
            plugin
        };
        let (description, path) = (&plugin.description, plugin.path.as_deref());
        let data = inspect::PluginData::new(description, path);
        Ok(print_value(self.json, &data, |_, out| {
            inspect::plugin(description, path, out)
        })?)
    }
}

/// Returns the failure of a look-up. A name that is near one of a plugin is wrong use.
fn suggest(error: PluginError, plugins: &Plugins) -> Failure {
    if let PluginError::Missing { name, .. } = &error {
        let (files, linked_in) = plugins.list(&[]);
        let names = files.iter().map(|file| file.name.as_str());
        let names = names.chain(linked_in.iter().map(String::as_str));
        if jde_nearest::nearest(name, names.clone()).is_some() {
            return Failure::unknown("plugin", name, names);
        }
    }
    error.into()
}
