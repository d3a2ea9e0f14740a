//! `jde set`: writes a modulation of a running application.

use std::path::Path;

use clap::Args;
use clap_complete::ArgValueCompleter;
use jde_app::Faults;
use jde_app::literal;
use jde_app::period::{RANGE, from_seconds};
use jde_link::Remote;
use jde_link::message::Action;
use jde_link::value::to_json;
use jde_session::top;

use super::operate::{ActionMessages, DurationArg, perform_action};
use super::{Context, Target};
use crate::complete;
use crate::failure::Failure;
use crate::remote::name::unknown_variable;

/// Write a modulation of a schema, with its unit; `period` is one of every schema.
///
/// The value stays until the father or another operator writes it, or until it is released. With --for it
/// stays at most for that time.
#[derive(Args)]
#[command(after_help = "Examples:
  jde set goon.fast '0.3 m/s'
  jde set vff.period 50ms
  jde set guide.room kitchen
  jde set robot2:goon.fast=0.2 --for 10s")]
pub(crate) struct Set {
    /// The modulation: SCHEMA.MODULATION, or SCHEMA.MODULATION=VALUE.
    #[arg(value_name = "MODULATION", add = ArgValueCompleter::new(complete::modulations))]
    modulation: String,
    /// The value, in TOML, or a text without quotes.
    #[arg(value_name = "VALUE", allow_hyphen_values = true)]
    value: Option<String>,
    #[command(flatten)]
    lasting: DurationArg,
    #[command(flatten)]
    target: Target,
}

impl Set {
    pub(crate) fn run(self, context: &Context) -> Result<(), Failure> {
        let (name, value) = match (self.modulation.split_once('='), &self.value) {
            (Some((name, value)), None) => (name.trim(), value.trim()),
            (None, Some(value)) => (self.modulation.as_str(), value.trim()),
            (Some(_), Some(_)) => {
                return Err(Failure::usage(
                    "there are two values",
                    "write goon.fast=0.3 or goon.fast 0.3",
                ));
            }
            (None, None) => {
                return Err(Failure::usage(
                    format!("there is no value for `{}`", self.modulation),
                    format!("write {}=VALUE; `jde get` shows what it is now", self.modulation),
                ));
            }
        };
        let (remote, name) = context.resolve(&self.target, name)?;
        let folder = std::env::current_dir().unwrap_or_else(|_| Path::new(".").to_owned());
        let action = read_action(&remote, name, value, &folder)?;
        let mut shown = value.to_owned();
        if let Action::Period { period_s, .. } = &action
            && let Ok(period) = from_seconds(*period_s)
        {
            shown = top::text::format_setting(period);
        }
        let messages = ActionMessages {
            done: format!("{name} is now {shown}"),
            ended: format!("{name} is released"),
        };
        perform_action(&remote, action, &self.lasting, &messages)
    }
}

/// Returns the action that writes a value, in TOML or as a text without quotes, to a modulation. Files that the value
/// names are relative to `folder`.
///
/// # Errors
/// There is no such modulation, or it cannot have the value.
pub(crate) fn read_action(
    remote: &Remote,
    name: &str,
    value: &str,
    folder: &Path,
) -> Result<Action, Failure> {
    let variables = remote.variables(false)?;
    let settable = variables
        .iter()
        .filter(|variable| variable.access == "modulation");
    let Some(info) = variables.iter().find(|variable| variable.name == name) else {
        if let Some(present) = present_name(remote, name)? {
            return Err(Failure::usage(
                format!("`{name}` is called `{present}` now"),
                format!("write `jde set {present} {value}`"),
            ));
        }
        let names = settable.map(|variable| variable.name.as_str());
        return Err(unknown_variable("modulation", name, names));
    };
    if info.access != "modulation" {
        return Err(Failure::usage(
            format!(
                "`{name}` is not a modulation but {} {}",
                article(&info.access),
                info.access
            ),
            "only modulations can be set; `jde vars` lists the variables",
        ));
    }
    let schema = info.owner.clone();
    if info.variable == "period" {
        let period = top::text::period(value)
            .map_err(|error| Failure::usage(error, format!("a period is a time {RANGE}, or a frequency")))?;
        return Ok(Action::Period {
            schema,
            period_s: period as f64 / 1e9,
        });
    }
    let value_type = info
        .value_type()
        .map_err(|error| Failure::broken(format!("the type of `{name}` cannot be read: {error}")))?;
    let read = literal::parse_value(
        value,
        (&schema, &info.variable),
        &value_type,
        &info.unit,
        folder,
        name,
    )
    .map_err(|faults| refused(faults, name))?;
    Ok(Action::Modulate {
        schema,
        variable: info.variable.clone(),
        value: to_json(&read.into_only_field_of(&value_type)),
    })
}

/// Returns why a modulation cannot have a value. A single reason names the modulation itself.
fn refused(faults: Faults, name: &str) -> Failure {
    if let [fault] = faults.list() {
        let help = fault.help.clone();
        let help = help.unwrap_or_else(|| format!("`jde vars {name} --docs` shows its unit and range"));
        return Failure::usage(fault.message.clone(), help);
    }
    Failure::faults(faults)
}

/// Returns the present name of a modulation that was renamed.
fn present_name(remote: &Remote, name: &str) -> Result<Option<String>, Failure> {
    let Some((owner, former)) = name.rsplit_once('.') else {
        return Ok(None);
    };
    let schemas = remote.schemas()?.schemas;
    let ports = schemas.iter().filter(|schema| schema.name == owner);
    let mut ports = ports.flat_map(|schema| &schema.ports);
    let renamed = ports.find(|port| port.former_name.as_deref() == Some(former));
    Ok(renamed.map(|port| format!("{owner}.{}", port.name)))
}

fn article(word: &str) -> &'static str {
    if word.starts_with(['a', 'e', 'i', 'o', 'u']) {
        "an"
    } else {
        "a"
    }
}
