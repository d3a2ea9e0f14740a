//! The version of a release: in the manifests and lock files of all workspaces, in the changelog, and in the names of files
//! that docs/installing.md shows.

use std::fmt;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::str::FromStr;

use anyhow::{Context as _, Result, anyhow, ensure};

use crate::paint::Paint;
use crate::shell;
use crate::steps::WORKSPACES;

/// A version: three numbers. A package of Python and one of Debian write other versions in other ways.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Version([u64; 3]);

impl FromStr for Version {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let numbers: Option<Vec<u64>> = text.split('.').map(|number| number.parse().ok()).collect();
        let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
        let version = Self(numbers.ok_or_else(|| anyhow!("a version has three numbers, such as 0.2.0"))?);
        ensure!(version.to_string() == text, "write it as {version}");
        Ok(version)
    }
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self([major, minor, patch]) = self;
        write!(f, "{major}.{minor}.{patch}")
    }
}

/// Sets the version, and dates its section of the changelog. A version that is set already stays.
pub(super) fn set(root: &Path, version: Version, date: &str, paint: Paint) -> Result<()> {
    let read = |file: &str| fs::read_to_string(root.join(file)).with_context(|| file.to_owned());
    let changes = dated(&read("CHANGELOG.md")?, version, date)?;
    let present = present(&read("Cargo.toml")?)?;
    ensure!(
        present <= version,
        "the version is {present} already, which is newer"
    );
    fs::write(root.join("CHANGELOG.md"), changes)?;
    if present == version {
        return Ok(());
    }
    let mut files = Command::new("git");
    let files = files.args([
        "ls-files",
        "Cargo.toml",
        "benches/**Cargo.toml",
        "fuzz/Cargo.toml",
    ]);
    for file in shell::read(files.current_dir(root))?.lines() {
        fs::write(root.join(file), renewed(&read(file)?, present, version))?;
    }
    let page = "docs/installing.md";
    fs::write(
        root.join(page),
        read(page)?.replace(&present.to_string(), &version.to_string()),
    )?;
    for workspace in WORKSPACES {
        let mut cargo = shell::cargo();
        cargo.args(["update", "--quiet", "--workspace", "--manifest-path", workspace]);
        shell::run(cargo.current_dir(root), paint)?;
    }
    Ok(())
}

/// Returns the changelog with the date of the version's section, which must say something.
fn dated(changes: &str, version: Version, date: &str) -> Result<String> {
    let unreleased = format!("## Unreleased: {version}\n");
    let title = format!("## {version} - ");
    let changes = changes.replacen(&unreleased, &format!("{title}{date}\n"), 1);
    let section = changes
        .split_once(&title)
        .map(|(_, rest)| rest.split("\n## ").next().unwrap_or(rest));
    let section = section.with_context(|| {
        format!(
            "CHANGELOG.md has no section of {version}: name it `{}`",
            unreleased.trim()
        )
    })?;
    ensure!(
        section.contains("\n- "),
        "the section of {version} in CHANGELOG.md lists no change"
    );
    Ok(changes)
}

/// Returns the version in the manifest of a workspace.
fn present(manifest: &str) -> Result<Version> {
    let line = manifest
        .lines()
        .find_map(|line| line.strip_prefix("version = \""));
    line.context("Cargo.toml states no version")?
        .trim_end_matches('"')
        .parse()
}

/// Returns a manifest with the new version of its package, and of the crates of jde on which it depends.
fn renewed(manifest: &str, present: Version, version: Version) -> String {
    let (old, new) = (format!("{present}\""), format!("{version}\""));
    let is_ours = |line: &str| line.starts_with("version = ") || line.starts_with("jde-");
    let lines = manifest.split_inclusive('\n');
    lines
        .map(|line| {
            if is_ours(line) {
                line.replace(&old, &new)
            } else {
                line.to_owned()
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn version(text: &str) -> Version {
        text.parse().unwrap()
    }

    #[test]
    fn a_version_has_three_numbers() {
        assert!(version("0.9.0") < version("0.10.0"));
        for text in ["1.2", "1.2.3.4", "1.2.x", "1.02.3", "1.2.3-rc1"] {
            assert!(text.parse::<Version>().is_err(), "{text}");
        }
    }

    #[test]
    fn the_section_of_the_version_is_dated_once() {
        let before = "# Changelog\n\n## Unreleased: 0.2.0\n\n- a\n\n## 0.1.0 - 2026-01-01\n\n- b\n";
        let after = dated(before, version("0.2.0"), "2026-12-01").unwrap();
        assert_eq!(after, before.replace("Unreleased: 0.2.0", "0.2.0 - 2026-12-01"));
        assert_eq!(dated(&after, version("0.2.0"), "2026-12-02").unwrap(), after);
    }

    #[test]
    fn a_version_without_changes_is_refused() {
        let why = |changes: &str| {
            dated(changes, version("0.2.0"), "2026-12-01")
                .unwrap_err()
                .to_string()
        };
        assert_eq!(
            why("## 0.1.0 - 2026-01-01\n\n- b\n"),
            "CHANGELOG.md has no section of 0.2.0: name it `## Unreleased: 0.2.0`"
        );
        let empty = "## Unreleased: 0.2.0\n\n## 0.1.0 - 2026-01-01\n\n- b\n";
        assert_eq!(why(empty), "the section of 0.2.0 in CHANGELOG.md lists no change");
    }

    #[test]
    fn a_manifest_keeps_the_versions_of_others() {
        let manifest =
            "version = \"0.1.0\"\njde-abi = { version = \"=0.1.0\", path = \"a\" }\nother = \"0.1.0\"\n";
        assert_eq!(present(manifest).unwrap(), version("0.1.0"));
        assert_eq!(
            renewed(manifest, version("0.1.0"), version("0.2.0")),
            "version = \"0.2.0\"\njde-abi = { version = \"=0.2.0\", path = \"a\" }\nother = \"0.1.0\"\n"
        );
    }
}
