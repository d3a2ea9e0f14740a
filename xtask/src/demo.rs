//! The demonstration in lockstep: the same seed gives the same decisions, also on another processor, and another seed
//! gives other decisions (R16).
//!
//! It runs the development build that the other steps use, since an optimised build would take as long as all
//! other steps.

use std::process::Command;

use anyhow::{Context as _, Result, ensure};

use crate::shell;
use crate::step::StepOutcome;
use crate::test::Context;

/// The name under which the demonstration prints the digest of its decisions.
const DIGEST: &str = "decisions_sha256";
/// The number of hexadecimal digits of the digest.
const DIGEST_DIGITS: usize = 64;
/// What makes the C library compute as on a processor without fused multiplication and addition. Another C library
/// ignores it.
const OTHER_PROCESSOR: (&str, &str) = ("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX");

pub(crate) fn run(context: &Context) -> Result<StepOutcome> {
    let first = decisions(context, "1", None)?;
    let again = decisions(context, "1", Some(OTHER_PROCESSOR))?;
    let other = decisions(context, "2", None)?;
    ensure!(
        first == again,
        "seed 1 decided {first}, and {again} as on another processor"
    );
    ensure!(
        first != other,
        "seeds 1 and 2 both decided {first}: the seed has no effect"
    );
    Ok(StepOutcome::Passed)
}

/// Runs the demonstration and returns the digest of its decisions.
fn decisions(context: &Context, seed: &str, processor: Option<(&str, &str)>) -> Result<String> {
    // The program of `cargo run` as the first step has built it: alone, cargo would build its libraries again.
    let mut launcher = Command::new(context.target.join("debug/jde-launcher"));
    launcher
        .args(["demo", "--headless", "--lockstep", "--seed", seed])
        .envs(processor)
        .current_dir(&context.root);
    shell::show(&launcher, context.paint);
    let output = shell::read(&mut launcher)?;
    print!("{output}");
    digest(&output).with_context(|| format!("the demonstration printed no {DIGEST}"))
}

pub(crate) fn digest(output: &str) -> Option<String> {
    let (_, after) = output.split_once(DIGEST)?;
    let line = after.lines().next()?;
    let mut numbers = line.split(|c: char| !c.is_ascii_hexdigit());
    numbers
        .find(|number| number.len() == DIGEST_DIGITS)
        .map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_is_found_in_text_and_in_json() {
        let digits = "0123456789abcdef".repeat(4);
        for output in [
            format!("time 3 s\n{DIGEST}: {digits}\n"),
            format!("{{\"{DIGEST}\":\"{digits}\",\"a\":1}}"),
        ] {
            assert_eq!(digest(&output).as_ref(), Some(&digits), "{output}");
        }
    }

    #[test]
    fn other_text_is_not_taken_for_a_digest() {
        let digits = "0".repeat(DIGEST_DIGITS);
        for output in [
            "".to_owned(),
            format!("{DIGEST}: abc\n{digits}"),
            format!("other: {digits}"),
        ] {
            assert_eq!(digest(&output), None, "{output}");
        }
    }
}
