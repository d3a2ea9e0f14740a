//! The program of `cargo run` in a checkout. It runs `demo` and child processes itself, with the few
//! libraries that they need. For every other verb it builds all of jde, which takes minutes the first time,
//! and runs it.

use std::ffi::OsString;
use std::io::{self, Write};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, ExitCode};

use clap::{Parser, Subcommand};
use jde_session::child::is_child;
use jde_session::cli::{Common, exit_status, report_usage_error};
use jde_session::demo::Demo;
use jde_session::failure::Failure;

/// Packages of the workspace that no user of jde runs.
const NOT_BUILT: [&str; 3] = ["jde-launcher", "jde-faults", "xtask"];

/// The one verb of this program.
#[derive(Parser)]
#[command(name = "jde", bin_name = "jde", version)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
    #[command(flatten)]
    common: Common,
}

#[derive(Subcommand)]
enum Verb {
    Demo(Demo),
}

fn main() -> ExitCode {
    let verb = std::env::args_os().nth(1).unwrap_or_default();
    if verb == "demo" || is_child(&verb) {
        return jde_session::main(|_| None, demonstrate);
    }
    let error = match build_and_run() {
        Ok(code) => return code,
        Err(error) => error,
    };
    // If standard error is closed, the error cannot be reported.
    let _ = writeln!(
        io::stderr(),
        "error: jde cannot be built and started: {error}\n  help: run `cargo build --workspace`, then target/debug/jde"
    );
    ExitCode::FAILURE
}

fn demonstrate() -> ExitCode {
    let Cli { verb, common } = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return report_usage_error(&error),
    };
    jde_terminal::set_color(common.color);
    let Verb::Demo(demo) = verb;
    exit_status(demo.run(common.log, Vec::new()), Failure::report)
}

/// Builds `jde` and all plugins beside this program, and replaces this process by `jde`. Returns only if that
/// is not possible, or with the exit status of a build that failed.
fn build_and_run() -> io::Result<ExitCode> {
    let launcher = std::env::current_exe()?;
    let profile = launcher.parent().unwrap_or(Path::new(""));
    let target = profile.parent().unwrap_or(Path::new(""));
    let jde = profile.join("jde");
    if !jde.exists() {
        let message =
            "jde: this verb requires the rest of jde, which is built now; the first build takes some minutes";
        writeln!(io::stderr(), "{message}")?;
    }
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo"));
    let mut build = Command::new(cargo);
    build
        .args(["build", "--workspace", "--manifest-path"])
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/../../Cargo.toml"))
        .arg("--target-dir")
        .arg(target);
    for package in NOT_BUILT {
        build.args(["--exclude", package]);
    }
    if profile.ends_with("release") {
        build.arg("--release");
    }
    if jde.exists() {
        // Usually there is nothing to build.
        build.arg("--quiet");
    }
    let built = build.status()?;
    if !built.success() {
        return Ok(ExitCode::from(
            u8::try_from(built.code().unwrap_or(1)).unwrap_or(1),
        ));
    }
    Err(Command::new(jde).args(std::env::args_os().skip(1)).exec())
}
