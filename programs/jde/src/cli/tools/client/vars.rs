//! `jde vars`: lists the shared variables of a running application.

use clap::Args;
use clap_complete::ArgValueCompleter;
use jde_board::value::Value;
use jde_link::Remote;
use jde_link::message::VariableInfo;
use jde_link::value::to_json;
use jde_log::Selection;
use jde_session::cli::print_json;
use jde_terminal::{self as terminal, FAINT, TITLE, WARN};
use serde_json::json;

use super::{Context, Past, Target};
use crate::complete;
use crate::failure::Failure;
use crate::inspect::first_paragraph;
use crate::remote::field::VariableField;
use crate::remote::table::{Alignment, Cell, Table};
use crate::replay::Asked;

/// The size above which a value is not printed, bytes: that of an image or a map.
const MAX_BYTES: usize = 1 << 20;
/// The fewest columns of the terminal for values.
const MIN_VALUE: usize = 16;
/// The most columns for values where the output is no terminal.
const MAX_VALUE: usize = 40;

/// List the shared variables: type, age, writer and newest value. Long values are cut; `jde get` and --json
/// print them in full.
#[derive(Args)]
#[command(after_help = "Examples:
  jde vars
  jde vars 'pioneer.*' '*.speed' --docs
  jde vars robot2:pioneer.laser --json
  jde vars --in drive.mcap --at 12.4s")]
pub(crate) struct Vars {
    /// List only the variables that match: full names with * for any text.
    #[arg(value_name = "PATTERN", add = ArgValueCompleter::new(complete::variables))]
    patterns: Vec<String>,
    #[command(flatten)]
    past: Past,
    #[command(flatten)]
    target: Target,
    /// Print the unit, the range and the meaning of each variable instead of its value.
    #[arg(long)]
    docs: bool,
    /// Print one line of JSON, with the definition of every type and the whole values.
    #[arg(long)]
    json: bool,
}

impl Vars {
    pub(crate) fn run(mut self, context: &Context) -> Result<(), Failure> {
        let _moment = self.past.serve(&mut self.target, &Asked::Values(Vec::new()))?;
        let (remote, patterns) = context.resolve_all(&self.target, &self.patterns)?;
        let variables = select(&remote, patterns)?;
        if self.json {
            let variables = variables.iter().map(|variable| with_value(&remote, variable));
            return Ok(print_json(&variables.collect::<Result<Vec<_>, _>>()?)?);
        }
        let mut table = Table::new(columns(self.docs));
        for variable in &variables {
            let mut row = status_cells(variable);
            if self.docs {
                row.extend(doc_cells(variable));
            } else {
                row.push(short_value(&remote, variable)?.into());
            }
            table.add_row(row);
        }
        if !self.docs {
            table.cut_last(|others| match terminal::width() {
                Some(width) => width.saturating_sub(others).max(MIN_VALUE),
                None => MAX_VALUE,
            });
        }
        let mut out = terminal::out();
        table.write(&mut out)?;
        out.flush()?;
        Ok(())
    }
}

/// Returns the variables that match a pattern, with their status; without patterns, all.
///
/// # Errors
/// A pattern matches nothing, or the application gives no answer.
pub(crate) fn select(remote: &Remote, patterns: Vec<String>) -> Result<Vec<VariableInfo>, Failure> {
    let mut variables = remote.variables(true)?;
    let names: Vec<String> = variables.iter().map(|variable| variable.name.clone()).collect();
    let selection = Selection::new(patterns, &names).map_err(|unknown| {
        Failure::usage(
            unknown.to_string(),
            "a pattern is a variable's full name, with `*` for any text: `pioneer.*`",
        )
    })?;
    variables.retain(|variable| selection.contains(&variable.name));
    Ok(variables)
}

/// Returns a variable as JSON, with its newest value.
///
/// # Errors
/// The application gives no answer, or its type cannot be read.
pub(crate) fn with_value(remote: &Remote, variable: &VariableInfo) -> Result<serde_json::Value, Failure> {
    let mut json = json!(variable);
    let bytes = remote.get(&variable.name)?.bytes;
    let field = VariableField::resolve(variable, "")?;
    let value = bytes.map(|bytes| field.decode(&bytes)).transpose()?;
    json["value"] = json!(value.as_ref().map(to_json));
    Ok(json)
}

/// Returns the newest value of a variable as text, without the header, whose time the age shows. Empty if it
/// has no value.
///
/// # Errors
/// The application gives no answer, or its type cannot be read.
pub(crate) fn short_value(remote: &Remote, variable: &VariableInfo) -> Result<String, Failure> {
    let field = VariableField::resolve(variable, "")?;
    if field.bytes() > MAX_BYTES {
        return Ok(format!("up to {:.1} MB", field.bytes() as f64 / 1e6));
    }
    let Some(bytes) = remote.get(&variable.name)?.bytes else {
        return Ok(String::new());
    };
    let mut value = field.decode(&bytes)?;
    if let Value::Map(fields) = &mut value {
        fields.retain(|(name, _)| name != "header");
    }
    Ok(field.format_value(value))
}

/// Returns the columns of the table.
fn columns(docs: bool) -> impl Iterator<Item = (&'static str, Alignment)> {
    let extra: &[_] = if docs {
        &["unit", "range", "doc"]
    } else {
        &["value"]
    };
    let status = [
        ("variable", Alignment::Left),
        ("type", Alignment::Left),
        ("access", Alignment::Left),
        ("rate", Alignment::Right),
        ("age", Alignment::Right),
        ("written by", Alignment::Left),
    ];
    status
        .into_iter()
        .chain(extra.iter().map(|title| (*title, Alignment::Left)))
}

/// Returns the cells that describe a variable and its newest write.
fn status_cells(variable: &VariableInfo) -> Vec<Cell> {
    let status = variable.status.as_ref();
    let rate = status.map(|status| status.rate_hz).filter(|rate| *rate > 0.0);
    let age = match status {
        Some(status) if status.retracted => Cell::from("ended").styled(WARN),
        Some(status) => match status.age_s {
            Some(age) => age_of(age).into(),
            None => Cell::from("-").styled(FAINT),
        },
        None => Cell::default(),
    };
    vec![
        Cell::from(&variable.name).styled(TITLE),
        Cell::from(variable.type_name.replace("/msg/", "/")).styled(FAINT),
        Cell::from(&variable.access).styled(FAINT),
        rate.map_or(Cell::from("-").styled(FAINT), |rate| {
            format!("{rate:.1} Hz").into()
        }),
        age,
        status
            .and_then(|status| status.last_writer.as_deref())
            .unwrap_or_default()
            .into(),
    ]
}

/// Returns unit, range and meaning of a variable.
fn doc_cells(variable: &VariableInfo) -> [Cell; 3] {
    let has_range = variable.access == "modulation" && variable.range != Default::default();
    let range = has_range.then(|| Cell::from(&variable.range));
    let doc = first_paragraph(&variable.doc);
    [
        variable.unit.as_str().into(),
        range.unwrap_or_default(),
        Cell::from(doc).styled(FAINT),
    ]
}

fn age_of(seconds: f64) -> String {
    match seconds {
        age if age < 1.0 => format!("{:.0} ms", age * 1e3),
        age if age < 100.0 => format!("{age:.1} s"),
        age => format!("{age:.0} s"),
    }
}
