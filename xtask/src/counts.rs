//! The gate of the hot paths: counts the instructions of each path with valgrind and compares them with the
//! counts in the repository. The number of instructions does not depend on the load of the machine, so the
//! tolerance can be narrow. The benches measure times.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result, bail};
use serde::{Deserialize, Serialize};

use crate::metadata::Metadata;
use crate::paint::Paint;
use crate::prerequisites::INSTALL_VALGRIND;
use crate::step::StepOutcome;
use crate::test::Context;
use crate::{shell, valgrind};

/// The folder and the package of the paths.
const FOLDER: &str = "benches";
const PACKAGE: &str = "jde-paths";
/// The file with the expected counts.
const BASELINE_FILE: &str = "benches/counts.json";
/// A path runs this many times, and then twice as many times. The difference excludes the start and the end
/// of the process.
const PATH_REPETITIONS: u64 = 1000;
/// The share by which a count may differ. One allocation or one lock exceeds it on every path.
const COUNT_TOLERANCE: f64 = 0.03;

/// The content of the file.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Counts {
    /// The version of the compiler. Counts of another compiler differ.
    compiler: String,
    /// Instructions of each path.
    instructions: BTreeMap<String, u64>,
}

/// The step `counts`.
pub(crate) fn step(context: &Context) -> Result<StepOutcome> {
    if !valgrind::is_installed() {
        return context.missing_tool("valgrind", INSTALL_VALGRIND);
    }
    check(&context.root, context.paint)?;
    Ok(StepOutcome::Passed)
}

/// Counts, and compares with the expected counts. Returns an error if they differ. Does not compare counts of
/// another compiler.
pub(crate) fn check(root: &Path, paint: Paint) -> Result<()> {
    let file = root.join(BASELINE_FILE);
    let kept = fs::read_to_string(&file).with_context(|| format!("cannot read {}", file.display()))?;
    let kept: Counts =
        serde_json::from_str(&kept).with_context(|| format!("{BASELINE_FILE} has an unknown form"))?;
    let compiler = compiler()?;
    if compiler != kept.compiler {
        println!(
            "instructions are not compared: {BASELINE_FILE} is of {}, and this is {compiler}",
            kept.compiler
        );
        return Ok(());
    }
    let counted = count(root, paint)?;
    for (path, now) in &counted {
        println!("{path:28} {now:>8}");
    }
    let faults = differences(&kept.instructions, &counted);
    if !faults.is_empty() {
        bail!(
            "{}\nif that is meant, run `cargo xtask counts --renew`",
            faults.join("\n")
        );
    }
    Ok(())
}

/// Counts, and writes the counts as the expected ones.
pub(crate) fn renew(root: &Path, paint: Paint) -> Result<()> {
    let counts = Counts {
        compiler: compiler()?,
        instructions: count(root, paint)?,
    };
    fs::write(
        root.join(BASELINE_FILE),
        serde_json::to_string_pretty(&counts)? + "\n",
    )?;
    println!("{BASELINE_FILE} is renewed");
    Ok(())
}

/// Describes the counts that differ.
fn differences(kept: &BTreeMap<String, u64>, counted: &BTreeMap<String, u64>) -> Vec<String> {
    let mut faults = Vec::new();
    for (path, now) in counted {
        let Some(then) = kept.get(path) else {
            faults.push(format!(
                "`{path}` takes {now} instructions, and {BASELINE_FILE} does not contain it"
            ));
            continue;
        };
        let more = *now as f64 / *then as f64 - 1.0;
        if more.abs() > COUNT_TOLERANCE {
            let percent = 100.0 * more;
            faults.push(format!(
                "`{path}` takes {now} instructions, and took {then}: {percent:+.1} %"
            ));
        }
    }
    let gone = kept.keys().filter(|path| !counted.contains_key(*path));
    faults.extend(gone.map(|path| format!("{BASELINE_FILE} has `{path}`, which is not a path any more")));
    faults
}

/// Counts the instructions of one pass of each path.
fn count(root: &Path, paint: Paint) -> Result<BTreeMap<String, u64>> {
    let program = build(root, paint)?;
    let names = shell::read(&mut Command::new(&program))?;
    let counts = names.lines().map(|name| {
        let once = collected(&program, name, PATH_REPETITIONS)?;
        let twice = collected(&program, name, 2 * PATH_REPETITIONS)?;
        let each = twice
            .checked_sub(once)
            .context("running a path twice takes fewer instructions than once")?
            / PATH_REPETITIONS;
        Ok((name.to_owned(), each))
    });
    counts.collect()
}

/// Builds the paths as users get them. Their package alone: it does not need the programs that the benches
/// compare with.
fn build(root: &Path, paint: Paint) -> Result<PathBuf> {
    let target = Metadata::of_workspace(root)?.target_directory;
    let mut cargo = shell::cargo();
    cargo
        .args(["build", "--release", "--package", PACKAGE, "--target-dir"])
        .arg(&target)
        // An incremental build is split differently and has other counts.
        .env("CARGO_INCREMENTAL", "0")
        .current_dir(root.join(FOLDER));
    shell::run(&mut cargo, paint)?;
    Ok(target.join("release").join(PACKAGE))
}

/// Counts all instructions of a process that runs a path `times` times.
fn collected(program: &Path, path: &str, times: u64) -> Result<u64> {
    let mut valgrind = Command::new("valgrind");
    valgrind.args(["--tool=callgrind", "--callgrind-out-file=/dev/null"]);
    let output = valgrind
        .arg(program)
        .args([path, &times.to_string()])
        .output()
        .context("cannot start valgrind")?;
    let messages = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        bail!("the path `{path}` ended with {}:\n{messages}", output.status);
    }
    sum(&messages).with_context(|| format!("valgrind does not state what it collected:\n{messages}"))
}

/// Returns the total in valgrind's output.
fn sum(output: &str) -> Option<u64> {
    let (_, rest) = output.split_once("Collected : ")?;
    rest.split_whitespace().next()?.parse().ok()
}

fn compiler() -> Result<String> {
    Ok(shell::read(Command::new("rustc").arg("--version"))?
        .trim()
        .to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(counts: &[(&str, u64)]) -> BTreeMap<String, u64> {
        counts
            .iter()
            .map(|(path, count)| ((*path).to_owned(), *count))
            .collect()
    }

    #[test]
    fn the_sum_is_parsed_from_the_output_of_valgrind() {
        let output = "==1== Events    : Ir\n==1== Collected : 7408310\n==1== \n";
        assert_eq!(sum(output), Some(7_408_310));
        assert_eq!(sum("==1== killed\n"), None);
    }

    #[test]
    fn a_small_difference_passes_and_a_larger_one_in_either_direction_is_reported() {
        let kept = counts(&[("read", 100), ("select", 1000)]);
        assert_eq!(
            differences(&kept, &counts(&[("read", 102), ("select", 971)])),
            [""; 0]
        );
        assert_eq!(
            differences(&kept, &counts(&[("read", 104), ("select", 900)])),
            [
                "`read` takes 104 instructions, and took 100: +4.0 %",
                "`select` takes 900 instructions, and took 1000: -10.0 %"
            ]
        );
    }

    #[test]
    fn new_and_removed_paths_are_reported() {
        let found = differences(&counts(&[("gone", 1)]), &counts(&[("new", 2)]));
        assert_eq!(found.len(), 2);
        assert!(found[0].starts_with("`new` takes 2 instructions"), "{found:?}");
        assert!(
            found[1].contains("`gone`, which is not a path any more"),
            "{found:?}"
        );
    }
}
