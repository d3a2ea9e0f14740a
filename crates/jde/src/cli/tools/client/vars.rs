//! `jde vars`: lists the shared variables of a running application.

use clap::Args;
use clap_complete::ArgValueCompleter;
use jde_link::message::VariableInfo;
use jde_log::Selection;

use super::{Context, Target};
use crate::cli::print_json;
use crate::complete;
use crate::failure::Failure;
use crate::remote::table::{Alignment, Cell, Table};
use crate::terminal::{self, FAINT, TITLE, WARN};

/// List the shared variables: type, age and writer.
#[derive(Args)]
#[command(after_help = "Examples:
  jde vars
  jde vars 'pioneer.*' '*.speed' --docs
  jde vars robot2:pioneer.laser --json")]
pub(crate) struct Vars {
    /// List only the variables that match: full names with * for any letters.
    #[arg(value_name = "PATTERN", add = ArgValueCompleter::new(complete::variables))]
    patterns: Vec<String>,
    #[command(flatten)]
    target: Target,
    /// Also print the meaning of each variable, and the range of modulations.
    #[arg(long)]
    docs: bool,
    /// Print one line of JSON, with the definition of every type.
    #[arg(long)]
    json: bool,
}

impl Vars {
    pub(crate) fn run(self, context: &Context) -> Result<(), Failure> {
        let (remote, patterns) = context.resolve_all(&self.target, &self.patterns)?;
        let mut variables = remote.variables(true)?;
        let names: Vec<String> = variables.iter().map(|variable| variable.name.clone()).collect();
        let selection = Selection::new(patterns, &names).map_err(|unknown| {
            Failure::usage(
                unknown.to_string(),
                "a pattern is a variable's full name, with `*` for any letters: `pioneer.*`",
            )
        })?;
        variables.retain(|variable| selection.contains(&variable.name));
        if self.json {
            return print_json(&variables);
        }
        let mut out = terminal::out();
        table(&variables, self.docs).write(&mut out)?;
        out.flush()?;
        Ok(())
    }
}

fn table(variables: &[VariableInfo], docs: bool) -> Table {
    let titles = [
        ("variable", Alignment::Left),
        ("type", Alignment::Left),
        ("unit", Alignment::Left),
        ("access", Alignment::Left),
        ("rate", Alignment::Right),
        ("age", Alignment::Right),
        ("written by", Alignment::Left),
    ];
    let more = [("range", Alignment::Left), ("doc", Alignment::Left)];
    let mut table = Table::new(titles.into_iter().chain(more.into_iter().filter(|_| docs)));
    for variable in variables {
        let status = variable.status.as_ref();
        let rate = status.map(|status| status.rate_hz).filter(|rate| *rate > 0.0);
        let age = match status {
            Some(status) if status.retracted => Cell::from("taken back").styled(WARN),
            Some(status) => match status.age_s {
                Some(age) => age_of(age).into(),
                None => Cell::from("-").styled(FAINT),
            },
            None => Cell::default(),
        };
        let mut row = vec![
            Cell::from(&variable.name).styled(TITLE),
            Cell::from(variable.type_name.replace("/msg/", "/")).styled(FAINT),
            variable.unit.as_str().into(),
            Cell::from(&variable.access).styled(FAINT),
            rate.map_or(Cell::from("-").styled(FAINT), |rate| {
                format!("{rate:.1} Hz").into()
            }),
            age,
            status
                .and_then(|status| status.last_writer.as_deref())
                .unwrap_or_default()
                .into(),
        ];
        if docs {
            row.push(
                if variable.access == "modulation" && variable.range != Default::default() {
                    (&variable.range).into()
                } else {
                    Cell::default()
                },
            );
            row.push(Cell::from(variable.doc.lines().next().unwrap_or_default()).styled(FAINT));
        }
        table.add_row(row);
    }
    table
}

fn age_of(seconds: f64) -> String {
    match seconds {
        age if age < 1.0 => format!("{:.0} ms", age * 1e3),
        age if age < 100.0 => format!("{age:.1} s"),
        age => format!("{age:.0} s"),
    }
}
