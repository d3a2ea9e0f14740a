//! Checks whether the disk has room for the builds of the steps. Frees nothing: only the owner of the disk
//! can decide what to delete.

use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, Result};

use crate::shell;

/// The size of the target folder after all steps, starting without one, bytes.
const FULL_BUILD_BYTES: u64 = 16_000_000_000;

/// Returns a warning to print before anything is built, or `None` if there is room.
///
/// # Errors
/// If `df` or `du` fails.
pub(crate) fn warning(target: &Path) -> Result<Option<String>> {
    let existing = target.ancestors().find(|path| path.exists());
    let existing = existing.context("no folder above that of builds exists")?;
    let mut df = Command::new("df");
    let free = number(shell::read(
        df.args(["--block-size=1", "--output=avail"]).arg(existing),
    )?)?;
    if free >= FULL_BUILD_BYTES {
        return Ok(None);
    }
    let mut du = Command::new("du");
    let built = match target.exists() {
        true => number(shell::read(
            du.args(["--summarize", "--block-size=1"]).arg(target),
        )?)?,
        false => 0,
    };
    Ok(is_short(free, built).then(|| {
        format!(
            "{:.1} GB are free for {}, and all steps need about {:.0} GB there, of which it has {:.1}: make room, or name a \
             folder of another disk in CARGO_TARGET_DIR",
            gigabytes(free),
            target.display(),
            gigabytes(FULL_BUILD_BYTES),
            gigabytes(built)
        )
    }))
}

/// Returns whether the free space and the existing builds together are less than all steps need.
fn is_short(free: u64, built: u64) -> bool {
    free.saturating_add(built) < FULL_BUILD_BYTES
}

/// Returns the first number of an output, which may have a heading.
fn number(output: String) -> Result<u64> {
    let mut fields = output.split_whitespace();
    fields
        .find_map(|field| field.parse().ok())
        .with_context(|| format!("there is no number in `{}`", output.trim()))
}

fn gigabytes(bytes: u64) -> f64 {
    bytes as f64 / 1e9
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn existing_builds_count_as_available_space() {
        assert!(is_short(FULL_BUILD_BYTES - 1, 0));
        assert!(!is_short(FULL_BUILD_BYTES, 0));
        assert!(is_short(FULL_BUILD_BYTES / 2, FULL_BUILD_BYTES / 4));
        assert!(!is_short(FULL_BUILD_BYTES / 2, FULL_BUILD_BYTES / 2));
    }

    #[test]
    fn the_number_is_parsed_below_a_heading_and_before_a_path() {
        assert_eq!(
            number("      Avail\n5400000000\n".to_owned()).unwrap(),
            5_400_000_000
        );
        assert_eq!(number("123\t/some/where\n".to_owned()).unwrap(), 123);
        number("Avail\n".to_owned()).unwrap_err();
    }

    #[test]
    fn a_folder_that_does_not_exist_is_on_the_disk_of_its_parent() {
        let folder = tempfile::tempdir().unwrap();
        warning(&folder.path().join("not/there/yet")).unwrap();
    }
}
