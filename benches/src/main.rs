//! Measures jde against the best alternatives in the same run, and prints one table. `cargo xtask bench`
//! builds everything and starts this program. `docs/figures/performance.md` describes each row. A row that cannot be
//! measured is a failure; a missed goal is not, since people evaluate the figures.

mod bare;
mod live;
mod loaded;
mod machine;
mod product;
mod rows;
mod schemas;
mod scope;

use std::io::{IsTerminal as _, Write as _};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Context as _, Result};
use clap::Parser;
use clap::builder::PossibleValuesParser;
use jde_measure::figure::{Line, Verdict};
use jde_measure::page;
use jde_measure::table::{Paint, table};
use serde::Serialize;

use crate::machine::Machine;
use crate::rows::{ROWS, Row};
use crate::scope::Scope;

/// Measures jde against the best alternatives.
#[derive(Parser)]
#[command(name = "cargo xtask bench", disable_version_flag = true)]
struct Cli {
    /// Measure only this row (may be repeated).
    #[arg(long, value_name = "NAME", value_parser = names())]
    row: Vec<String>,
    /// Only print the names of the rows.
    #[arg(long)]
    list: bool,
    /// Take a tenth of the time, for less reliable figures.
    #[arg(long)]
    quick: bool,
    /// Save the table and the description of the machine as JSON.
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
    /// Replace the table in this page.
    #[arg(long, value_name = "FILE", hide = true)]
    page: Option<PathBuf>,
    /// The root of the product's source.
    #[arg(long, hide = true)]
    root: PathBuf,
    /// The folder with the built product.
    #[arg(long, hide = true)]
    built: PathBuf,
    /// A Python interpreter with the package that one row compares with.
    #[arg(long, hide = true)]
    python: Option<PathBuf>,
}

/// The content of the file of `--save`.
#[derive(Serialize)]
struct SavedTable<'a> {
    machine: &'a Machine,
    quick: bool,
    lines: Vec<SavedLine<'a>>,
}

#[derive(Serialize)]
struct SavedLine<'a> {
    row: &'a str,
    #[serde(flatten)]
    line: &'a Line,
    by: Option<f64>,
    verdict: Verdict,
}

fn main() -> Result<ExitCode> {
    let arguments: Vec<_> = std::env::args_os().skip(1).collect();
    if let [role, folder] = arguments.as_slice()
        && role == rows::LISTEN
    {
        return rows::listen(folder.as_ref()).map(|()| ExitCode::SUCCESS);
    }
    let cli = Cli::parse();
    if cli.list {
        let width = ROWS.iter().map(|row| row.name.len()).max().unwrap_or_default();
        for Row {
            name, title, long, ..
        } in ROWS
        {
            let long = if *long {
                " (takes many minutes, only when it is named)"
            } else {
                ""
            };
            println!("{name:width$}  {title}{long}");
        }
        return Ok(ExitCode::SUCCESS);
    }
    let scope = Scope {
        quick: cli.quick,
        root: cli.root,
        built: cli.built,
        python: cli.python,
    };
    let machine = Machine::current();
    let chosen = |row: &&Row| {
        if cli.row.is_empty() {
            !row.long
        } else {
            cli.row.iter().any(|name| name == row.name)
        }
    };
    let rows: Vec<&Row> = ROWS.iter().filter(chosen).collect();
    let mut measured = Vec::new();
    let mut complete = true;
    for (number, row) in rows.iter().enumerate() {
        let start = Instant::now();
        eprint!("[{}/{}] {} ... ", number + 1, rows.len(), row.title);
        std::io::stderr().flush()?;
        match (row.run)(&scope) {
            Ok(lines) => {
                eprintln!("{:.1} s", start.elapsed().as_secs_f64());
                measured.push((row.name.to_owned(), lines));
            }
            Err(error) => {
                eprintln!("not measured: {error:#}");
                complete = false;
            }
        }
    }
    println!("\n{}\n", machine.summary());
    println!("{}", table(&measured, Paint(uses_color())));
    // An incomplete table does not replace the project's table.
    if cli.page.is_some() && !complete {
        eprintln!("nothing is saved: a row could not be measured");
        return Ok(ExitCode::FAILURE);
    }
    if let Some(file) = cli.save {
        let lines = measured
            .iter()
            .flat_map(|(row, lines)| lines.iter().map(move |line| (row, line)));
        let saved = SavedTable {
            machine: &machine,
            quick: scope.quick,
            lines: lines
                .map(|(row, line)| SavedLine {
                    row,
                    line,
                    by: line.ratio(),
                    verdict: line.verdict(),
                })
                .collect(),
        };
        let text = serde_json::to_string_pretty(&saved)? + "\n";
        std::fs::write(&file, text).with_context(|| format!("cannot write {}", file.display()))?;
    }
    if let Some(file) = cli.page {
        page::save(&file, &measured)?;
    }
    Ok(if complete {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

fn names() -> PossibleValuesParser {
    PossibleValuesParser::new(ROWS.iter().map(|row| row.name))
}

fn uses_color() -> bool {
    std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn row_names_are_unique() {
        let mut names: Vec<&str> = ROWS.iter().map(|row| row.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), ROWS.len());
    }
}
