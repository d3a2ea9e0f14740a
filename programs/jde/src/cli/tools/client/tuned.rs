//! `jde tuned`: the modulations that differ from the application's file; writes them to it, or sets them back.

use clap::Args;
use clap_complete::ArgValueCompleter;
use jde_board::value::Value;
use jde_link::message::Request;
use jde_link::tuned::{self, NotSaved, Tuned};
use jde_link::value::to_json;
use jde_link::{Remote, operator};
use jde_session::cli::print_json;
use jde_terminal::{self as terminal, FAINT, GOOD, TITLE};
use serde_json::json;

use super::vars::select;
use super::{Context, Target};
use crate::complete;
use crate::failure::Failure;
use crate::remote::field::VariableField;
use crate::remote::table::{Alignment, Cell, Table};

/// List the modulations that differ from the application's file, write them to it, or set them back.
///
/// They are compared with the file as it was when the run began. What a father modulates is not listed. Written values
/// take the place of the old ones, in their units; comments stay.
#[derive(Args)]
#[command(after_help = "Examples:
  jde tuned
  jde tuned --save
  jde tuned 'goon.*' --back")]
pub(crate) struct TunedArgs {
    /// Only the modulations that match: full names with * for any text.
    #[arg(value_name = "PATTERN", add = ArgValueCompleter::new(complete::modulations))]
    patterns: Vec<String>,
    #[command(flatten)]
    target: Target,
    /// Write the values to the application's file.
    #[arg(long)]
    save: bool,
    /// Write them also over what was changed in the file since the run began.
    #[arg(long, requires = "save")]
    overwrite: bool,
    /// Set the values back to those of the application's file when the run began.
    #[arg(long, conflicts_with = "save")]
    back: bool,
    /// Print one line of JSON.
    #[arg(long, conflicts_with_all = ["save", "back"])]
    json: bool,
}

impl TunedArgs {
    pub(crate) fn run(self, context: &Context) -> Result<(), Failure> {
        let (remote, patterns) = context.resolve_all(&self.target, &self.patterns)?;
        let (about, tuned) = (remote.about(), differing(&remote, patterns, self.save)?);
        let mut out = terminal::out();
        if self.json {
            let one = |tuned: &Tuned| {
                json!({
                    "variable": tuned.info.name,
                    "unit": tuned.info.unit,
                    "file": to_json(&tuned.file),
                    "now": to_json(&tuned.now),
                })
            };
            return Ok(print_json(&tuned.iter().map(one).collect::<Vec<_>>())?);
        }
        if tuned.is_empty() {
            let stated = format!("what {} stated when the run began", about.file);
            writeln!(out, "no modulation differs from {stated}")?;
        } else if self.save {
            let written =
                tuned::save(&remote, &remote.schemas()?, &tuned, self.overwrite).map_err(failure)?;
            match written.as_slice() {
                [] => writeln!(out, "{} has these values already", about.file)?,
                _ => writeln!(out, "{GOOD}saved in {}{GOOD:#}", about.file)?,
            }
            for line in written {
                writeln!(out, "  {line}")?;
            }
        } else if self.back {
            for tuned in &tuned {
                remote.operate(&Request {
                    by: operator(),
                    action: tuned.back(),
                    lease_ms: None,
                })?;
                writeln!(out, "{} is {} again", tuned.info.name, shown(tuned, &tuned.file)?)?;
            }
        } else {
            let titles = ["modulation", "at the start", "now"].map(|title| (title, Alignment::Left));
            let mut table = Table::new(titles);
            for tuned in &tuned {
                table.add_row([
                    Cell::from(&tuned.info.name).styled(TITLE),
                    Cell::from(shown(tuned, &tuned.file)?).styled(FAINT),
                    shown(tuned, &tuned.now)?.into(),
                ]);
            }
            table.write(&mut out)?;
            let advice = "`jde tuned --save` writes this to the file, `--back` sets it back";
            writeln!(out, "{FAINT}{}: {advice}{FAINT:#}", about.file)?;
        }
        out.flush()?;
        Ok(())
    }
}

/// Asks for the values of all modulations that match, and compares them with the file as it was when the run began.
/// With `with_back`, also returns what was set back, for a comparison with the file of now.
fn differing(remote: &Remote, patterns: Vec<String>, with_back: bool) -> Result<Vec<Tuned>, Failure> {
    let compare = match with_back {
        true => Tuned::with_back,
        false => Tuned::of,
    };
    let mut tuned = Vec::new();
    let mut are_stated = false;
    for variable in select(remote, patterns)? {
        if variable.stated.is_some() {
            are_stated = true;
            tuned.extend(compare(&variable, &remote.get(&variable.name)?));
        }
    }
    match are_stated {
        true => Ok(tuned),
        false => Err(Failure::usage(
            format!("nothing of `{}` can be tuned", remote.about().name),
            "this works for modulations of a running application, not for recordings",
        )),
    }
}

fn failure(reason: NotSaved) -> Failure {
    match reason {
        NotSaved::File(faults) => Failure::faults(faults),
        NotSaved::Elsewhere { .. } | NotSaved::Folder { .. } | NotSaved::Type(_) => {
            Failure::broken(reason.to_string())
        }
    }
}

fn shown(tuned: &Tuned, value: &Value) -> Result<String, Failure> {
    Ok(VariableField::resolve(&tuned.info, "")?.format_value(value.clone()))
}
