//! `cargo xtask release`: a release, made and checked on this machine. It uploads nothing and pushes nothing: it prints what
//! the maintainer types (docs/releases.md).

mod crates;
mod sbom;
mod versions;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result, ensure};
use clap::Args;

use crate::metadata::Metadata;
use crate::package::{self, sdk};
use crate::paint::Paint;
use crate::shell;
use versions::Version;

/// The options of the verb.
#[derive(Args)]
#[command(after_help = "Examples:
  cargo xtask release 0.2.0                         sets versions, makes and checks everything, prints what to type
  cargo xtask release 0.2.0 --tag                   commits the versions first, and makes the tag in this repository last
  cargo xtask release 0.2.0 --dev --only tarball    a trial in minutes: `git restore .` takes the versions back")]
pub(crate) struct Release {
    /// The version: three numbers.
    #[arg(value_name = "VERSION")]
    version: Version,
    /// Commit the versions, and make the tag in this repository.
    #[arg(long)]
    tag: bool,
    #[command(flatten)]
    packages: package::Choice,
}

pub(crate) fn run(root: &Path, choice: &Release, paint: Paint) -> Result<()> {
    let changed = shell::read(git(root).args(["status", "--porcelain"]))?;
    ensure!(
        changed.is_empty(),
        "these files are not committed: commit them, or take them back\n{changed}"
    );
    let version = choice.version;
    let date = shell::read(Command::new("date").args(["--utc", "+%F"]))?;
    versions::set(root, version, date.trim(), paint)?;
    make(root, choice, paint).with_context(|| {
        format!("the versions are {version} now; `git restore .` takes back what is not committed")
    })
}

/// Makes and checks everything, and prints what to type.
fn make(root: &Path, choice: &Release, paint: Paint) -> Result<()> {
    let version = choice.version;
    let has_changed = !shell::read(git(root).args(["status", "--porcelain"]))?.is_empty();
    let commit = format!("git commit --all --message 'release: {version}'");
    let tag = format!("git tag --annotate v{version} --message 'jde {version}'");
    let commit = has_changed.then_some(commit);
    let run = |command: &str| shell::run(Command::new("sh").args(["-c", command]).current_dir(root), paint);
    // The packages have the time of the commit. The tag comes last: no check may fail after it.
    if let Some(commit) = commit.as_deref().filter(|_| choice.tag) {
        run(commit)?;
    }
    let metadata = Metadata::with_dependencies(root)?;
    let crates = sdk::crates(&metadata)?;
    crates::check(root, &crates)?;
    crates::try_publication(root, &metadata, &crates, paint)?;
    let mut files = package::make_chosen(root, &choice.packages, paint)?;
    files.push(write_sbom(root, &metadata, version)?);
    let folder = metadata.target_directory.join("package");
    let names: Vec<_> = files.iter().filter_map(|file| file.file_name()).collect();
    let sums = shell::read(Command::new("sha256sum").args(names).current_dir(&folder))?;
    fs::write(folder.join("SHA256SUMS"), &sums)?;
    if choice.tag {
        run(&tag)?;
    }
    println!(
        "{sums}{}\n\nNothing was uploaded. What is left to type:\n",
        folder.join("SHA256SUMS").display()
    );
    if !choice.tag {
        let commands = commit.iter().chain([&tag]);
        commands.for_each(|command| println!("  {command}"));
    }
    println!("  git push origin HEAD v{version}");
    println!("  {}", crates::publication(&crates));
    println!("  and give the files above to the page of the release");
    Ok(())
}

/// Writes the list of what the packages contain.
fn write_sbom(root: &Path, metadata: &Metadata, version: Version) -> Result<PathBuf> {
    let mut log = git(root);
    let time = log
        .args(["log", "-1", "--date=format-local:%FT%TZ", "--format=%cd"])
        .env("TZ", "UTC");
    let list = sbom::list(metadata, &version.to_string(), shell::read(time)?.trim());
    let file = metadata
        .target_directory
        .join(format!("package/jde-{version}.cdx.json"));
    fs::write(&file, serde_json::to_string_pretty(&list)? + "\n")?;
    Ok(file)
}

fn git(root: &Path) -> Command {
    let mut git = Command::new("git");
    git.current_dir(root);
    git
}
