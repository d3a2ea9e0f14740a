//! Measures the drivers of ROS 2 beside programs of ROS 2, and prints one table.
//! `cargo xtask bench --ros2` builds everything and starts this program. `docs/figures/ros2.md` describes each row.

mod arrivals;
mod programs;
mod rows;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use clap::builder::PossibleValuesParser;
use jde_measure::page;
use jde_measure::table::{Paint, table};

use crate::programs::Programs;
use crate::rows::{ROWS, Row};

/// Measures the drivers of ROS 2 beside programs of ROS 2.
#[derive(Parser)]
#[command(name = "cargo xtask bench --ros2", disable_version_flag = true)]
struct Cli {
    /// Measure only this row (may be repeated).
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(ROWS.iter().map(|row| row.name)))]
    row: Vec<String>,
    /// Only print the names of the rows.
    #[arg(long)]
    list: bool,
    /// Take a tenth of the time, for less reliable figures.
    #[arg(long)]
    quick: bool,
    /// Replace the table in this page.
    #[arg(long, value_name = "FILE", hide = true)]
    page: Option<PathBuf>,
    /// The root of the product's source.
    #[arg(long, hide = true)]
    root: PathBuf,
    /// The folder with the built product.
    #[arg(long, hide = true)]
    built: PathBuf,
    /// The folder with the built programs of ROS 2.
    #[arg(long, hide = true)]
    peers: PathBuf,
}

fn main() -> Result<ExitCode> {
    let cli = Cli::parse();
    if cli.list {
        for Row { name, title, .. } in ROWS {
            println!("{name:10}  {title}");
        }
        return Ok(ExitCode::SUCCESS);
    }
    let programs = Programs::new(cli.root, cli.built, cli.peers, cli.quick)?;
    let is_chosen = |row: &&Row| cli.row.is_empty() || cli.row.iter().any(|name| name == row.name);
    let mut measured = Vec::new();
    let mut complete = true;
    for row in ROWS.iter().filter(is_chosen) {
        eprintln!("{} ...", row.title);
        match (row.run)(&programs) {
            Ok(lines) => measured.push((row.name.to_owned(), lines)),
            Err(error) => {
                eprintln!("not measured: {error:#}");
                complete = false;
            }
        }
    }
    println!("\n{}", table(&measured, Paint(false)));
    if let Some(file) = cli.page {
        if complete {
            page::save(&file, &measured)?;
        } else {
            eprintln!("nothing is saved: a row could not be measured");
        }
    }
    Ok(if complete {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}
