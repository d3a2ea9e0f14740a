//! `cargo xtask faults`: runs a campaign of faults and prints what was injected and survived. Exit status 0
//! if every fault was survived, 1 if not, 2 if the campaign could not run.

mod page;
mod progress;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context as _, Result};
use clap::{Parser, ValueEnum};
use jde_faults::application::{Root, TestApplication};
use jde_faults::campaign::Campaign;
use jde_faults::case::{Case, RunMode, name};
use jde_faults::observer::Tamper;
use jde_faults::plan::Kind;
use jde_faults::run::SERVE;
use jde_isolation::{load, serve};
use jde_loader::Plugins;
use progress::ProgressDisplay;
use signal_hook::consts::{SIGINT, SIGTERM};

/// Inject hundreds of faults of every kind into running applications, and check that the rules still hold.
///
/// Two applications run repeatedly: the demonstration with additional schemas that misbehave on command, and
/// one of a hundred schemas. They run in lockstep, in real time, and in processes of their own. An observer
/// checks R1, R5, R7, R9 and R10, that nothing moves without a command, that every other schema keeps its
/// period, and that nothing leaks. The same seed gives the same campaign.
#[derive(Parser)]
#[command(
    name = "cargo xtask faults",
    bin_name = "cargo xtask faults",
    disable_version_flag = true,
    after_help = "Examples:
  cargo xtask faults
  cargo xtask faults --seed 7 --count 1000 --only lockstep
  cargo xtask faults --kind hang --kind crash
  cargo xtask faults --seed 7 --case real-time/hundred/12    one case again, and print its faults
  cargo xtask faults --save docs/figures/faults.md"
)]
struct Arguments {
    /// Seed of all random choices.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Number of faults.
    #[arg(long, value_name = "N", default_value_t = 600, value_parser = clap::value_parser!(u64).range(1..))]
    count: u64,
    /// Inject only this kind (may be repeated).
    #[arg(long, value_name = "KIND", hide_possible_values = true, help = kinds())]
    kind: Vec<Kind>,
    /// Run only cases under this clock (may be repeated).
    #[arg(long, value_name = "WHERE")]
    only: Vec<RunMode>,
    /// Run only this case, named as in a failure.
    #[arg(long, value_name = "CASE", conflicts_with_all = ["count", "only", "save"])]
    case: Option<Case>,
    /// Print the application of --case instead of running it.
    #[arg(long, requires = "case")]
    application: bool,
    /// Write the table into this file, between its two marks.
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
    /// Another folder with plugins (may be repeated).
    #[arg(long, value_name = "DIR")]
    plugins: Vec<PathBuf>,
    /// The executable for the cases in processes of their own [default: the one beside this program].
    #[arg(long, value_name = "FILE")]
    jde: Option<PathBuf>,
    /// Do not judge periods in real time, for a machine under other load.
    #[arg(long)]
    no_rhythm: bool,
    /// Give the observer false data, to test that it finds them.
    #[arg(long, value_name = "LIE", hide = true)]
    tamper: Option<Tamper>,
}

fn kinds() -> String {
    let names: Vec<_> = Kind::value_variants().iter().map(name).collect();
    let names = names.join(", ");
    format!("Inject only this kind (may be repeated): {names}")
}

/// Returns all values if none is given.
fn or_all<T: ValueEnum>(given: Vec<T>) -> Vec<T> {
    if given.is_empty() {
        T::value_variants().to_vec()
    } else {
        given
    }
}

fn main() -> ExitCode {
    if std::env::args_os().nth(1).is_some_and(|first| first == SERVE) {
        return serve_schema();
    }
    match run(Arguments::parse()) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}

/// Runs this program as the process of one schema.
fn serve_schema() -> ExitCode {
    // The messages of schemas that crash on purpose are not useful.
    let quiet = std::fs::File::options().write(true).open("/dev/null");
    if let Ok(quiet) = quiet
        && rustix::stdio::dup2_stderr(&quiet).is_err()
    {
        return ExitCode::from(2);
    }
    match serve(|plugin| load(&Plugins::default(), plugin)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("jde-faults: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: Arguments) -> Result<ExitCode> {
    let campaign = Campaign {
        seed: arguments.seed,
        count: arguments.count,
        kinds: or_all(arguments.kind),
        clocks: or_all(arguments.only),
        case: arguments.case,
        plugins: arguments.plugins,
        jde: arguments.jde,
        root: Root::usual(),
        rhythm: !arguments.no_rhythm,
        tamper: arguments.tamper,
    };
    if let Some(case) = campaign.case.filter(|_| arguments.application) {
        print!(
            "{}",
            TestApplication::of(&campaign.root, campaign.seed, case)?.text()
        );
        return Ok(ExitCode::SUCCESS);
    }
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // A second signal ends the process at once.
        signal_hook::flag::register_conditional_shutdown(signal, 130, Arc::clone(&stop))?;
        signal_hook::flag::register(signal, Arc::clone(&stop)).context("cannot handle signals")?;
    }
    let mut display = ProgressDisplay::new(&campaign);
    let result = campaign.run(&stop, &mut display)?;
    display.clear();
    let table = result.table.markdown();
    println!("{table}");
    println!("{}", result.summary(&campaign));
    for (case, violation) in result.table.violations() {
        println!("broken: {violation}\n  again: {}", campaign.repeat_command(*case));
    }
    if let Some(leak) = &result.leak {
        println!("broken: {leak}");
    }
    let interrupted = stop.load(Ordering::Relaxed);
    if interrupted {
        println!("interrupted: the results above are incomplete");
    }
    if let Some(file) = &arguments.save
        && !interrupted
    {
        page::save(file, &table, &result.summary(&campaign))?;
    }
    let survived = result.table.violations().is_empty() && result.leak.is_none();
    Ok(if survived && !interrupted {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::Arguments;

    #[test]
    fn the_command_line_is_consistent() {
        Arguments::command().debug_assert();
    }
}
