//! Clippy as a part of the build. Its driver is the compiler of the workspace's own crates, so nothing is
//! compiled a second time to be linted.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Result, bail};
use serde::Deserialize;

use crate::shell;
use crate::step::StepOutcome;
use crate::steps::BENCHES;
use crate::test::Context;

/// A message of cargo that holds one of the compiler.
#[derive(Deserialize)]
struct Message {
    message: Diagnostic,
}

#[derive(Deserialize)]
struct Diagnostic {
    level: String,
    rendered: Option<String>,
}

/// Returns the compiler that also lints, if the toolchain has it.
pub(crate) fn compiler() -> Result<Option<PathBuf>> {
    let sysroot = shell::read(Command::new("rustc").args(["--print", "sysroot"]))?;
    let driver = PathBuf::from(sysroot.trim()).join("bin/clippy-driver");
    Ok(driver.exists().then_some(driver))
}

/// Returns the command that builds everything that the other steps use. With fewer targets or packages the libraries
/// would have other features, and be built a second time.
pub(crate) fn build_all(context: &Context) -> Command {
    let mut cargo = context.cargo(&["build", "--all-targets"]);
    cargo.args(context.selection());
    cargo
}

/// Reads the warnings of the build, which cargo repeats.
pub(crate) fn run(context: &Context) -> Result<StepOutcome> {
    if !context.has_lints() {
        return context.missing_tool("clippy", "rustup component add clippy");
    }
    let mut cargo = build_all(context);
    cargo.args(["--quiet", "--message-format", "json-diagnostic-rendered-ansi"]);
    let warnings = warnings(&shell::read(&mut cargo)?);
    if !warnings.is_empty() {
        println!("{}", warnings.concat());
        bail!("{} warnings", warnings.len());
    }
    Ok(StepOutcome::Passed)
}

/// Lints the benches, without a build.
pub(crate) fn run_benches(context: &Context) -> Result<StepOutcome> {
    if !context.has_lints() {
        return context.missing_tool("clippy", "rustup component add clippy");
    }
    let mut cargo = context.cargo(&["clippy", "--workspace", "--all-targets"]);
    cargo.args(["--manifest-path", BENCHES, "--target-dir"]);
    cargo.arg(&context.target);
    shell::run(cargo.args(["--", "-D", "warnings"]), context.paint)?;
    Ok(StepOutcome::Passed)
}

/// Returns the text of each warning. A crate that is also built as a test repeats its warnings.
fn warnings(messages: &str) -> Vec<String> {
    let messages = messages
        .lines()
        .filter_map(|line| serde_json::from_str::<Message>(line).ok());
    let mut warnings: Vec<String> = messages
        .filter(|message| message.message.level == "warning")
        .filter_map(|message| message.message.rendered)
        .collect();
    warnings.sort();
    warnings.dedup();
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_warning_is_read_once() {
        let message = |level, text| {
            format!(r#"{{"reason":"compiler-message","message":{{"level":"{level}","rendered":"{text}"}}}}"#)
        };
        let messages = [
            message("warning", "b"),
            r#"{"reason":"compiler-artifact","target":{"name":"x"}}"#.to_owned(),
            message("warning", "a"),
            message("note", "c"),
            message("warning", "b"),
        ];
        assert_eq!(warnings(&messages.join("\n")), ["a", "b"]);
    }
}
