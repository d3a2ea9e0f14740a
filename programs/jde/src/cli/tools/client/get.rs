//! `jde get`: prints the newest value of a variable.

use clap::Args;
use clap_complete::ArgValueCompleter;
use jde_board::value::Value;
use jde_link::message::VariableInfo;
use jde_link::value::to_json;
use jde_link::{Remote, Sample};
use jde_session::cli::print_json;
use jde_terminal::{self as terminal, FAINT};
use serde_json::json;

use super::{Context, Past, Target};
use crate::complete;
use crate::failure::Failure;
use crate::remote::field::VariableField;
use crate::remote::name;
use crate::replay::Asked;

/// Show the newest value of a variable, or of a field of it.
#[derive(Args)]
#[command(after_help = "Examples:
  jde get pioneer.odometry
  jde get pioneer.odometry.pose.pose.position.x
  jde get robot2:pioneer.laser.ranges[90] --json
  jde get pioneer.truth --in drive.mcap --at 12.4s")]
pub(crate) struct Get {
    /// The variables: SCHEMA.VARIABLE, with .FIELD after it and APP: before it if needed.
    #[arg(value_name = "VARIABLE", required = true, add = ArgValueCompleter::new(complete::variables))]
    variables: Vec<String>,
    #[command(flatten)]
    past: Past,
    #[command(flatten)]
    target: Target,
    /// Print each value as one line of JSON, with its time of measurement and its writer.
    #[arg(long)]
    json: bool,
}

impl Get {
    pub(crate) fn run(mut self, context: &Context) -> Result<(), Failure> {
        let asked = Asked::Values(self.variables.clone());
        let _moment = self.past.serve(&mut self.target, &asked)?;
        let mut out = terminal::out();
        for requested in &self.variables {
            let (remote, requested) = context.resolve(&self.target, requested)?;
            let reading = Reading::request(&remote, requested)?;
            if self.json {
                out.flush()?;
                print_json(&reading.to_json(&remote))?;
                continue;
            }
            if self.variables.len() > 1 {
                write!(out, "{FAINT}{requested}{FAINT:#}  ")?;
            }
            match reading.value {
                Some(value) => writeln!(out, "{}", reading.field.format_value(value))?,
                None => writeln!(out, "{}", without_value(&reading.info, &reading.sample))?,
            }
        }
        out.flush()?;
        Ok(())
    }
}

/// The newest value of a variable, or of a field of it.
pub(crate) struct Reading {
    /// The variable.
    info: VariableInfo,
    /// The path of the field; empty for the whole variable.
    path: String,
    field: VariableField,
    sample: Sample,
    /// `None` if there is no value now.
    value: Option<Value>,
}

impl Reading {
    /// Requests the value of `SCHEMA.VARIABLE[.FIELD]`.
    ///
    /// # Errors
    /// There is no such variable, field or element, or the application gives no answer.
    pub(crate) fn request(remote: &Remote, requested: &str) -> Result<Self, Failure> {
        let known = remote.variables(false)?;
        let (variable, path) =
            name::split_variable(requested, known.iter().map(|known| known.name.as_str()))?;
        let info = remote.variable(variable)?;
        let field = VariableField::resolve(&info, path)?;
        let sample = remote.get(variable)?;
        let value = sample.bytes.as_deref().map(|bytes| field.decode(bytes));
        Ok(Self {
            value: value.transpose()?,
            path: path.to_owned(),
            info,
            field,
            sample,
        })
    }

    /// Returns it as the object that `--json` prints.
    pub(crate) fn to_json(&self, remote: &Remote) -> serde_json::Value {
        json!({
            "application": remote.about().name,
            "variable": self.info.name,
            "field": self.path,
            "unit": self.field.unit,
            "time_s": self.sample.time as f64 / 1e9,
            "age_s": self.sample.age as f64 / 1e9,
            "sequence": self.sample.sequence,
            "writer": self.sample.writer,
            "value": self.value.as_ref().map(to_json),
        })
    }
}

/// Says why there is no value.
fn without_value(info: &VariableInfo, sample: &Sample) -> &'static str {
    match (sample.sequence, info.access.as_str()) {
        (0, _) => "no value yet",
        (_, "command") => "not in force: its driver has the neutral value",
        (_, _) => "no value: it has ended, or was retracted",
    }
}
