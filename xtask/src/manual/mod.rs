//! `cargo xtask manual`: the pages of docs, and a reference that the executable and its plugins describe, as
//! one book of HTML that is searched and read without a network. It checks every link of the book.

mod links;
mod reference;
mod summary;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, bail};

use crate::metadata::Metadata;
use crate::paint::Paint;
use crate::step::StepOutcome;
use crate::test::Context;
use crate::tidy::links::{resolve, targets};
use crate::{package, project_files, shell};

/// How to install the program that makes the book.
const INSTALL: &str = "cargo install mdbook --locked --no-default-features --features search";

/// The settings of the book; docs/README.md lists its pages.
const BOOK: &str = r#"[book]
title    = "jde"
language = "en"

# Links name pages as the project does: README.html, not index.html.
[build]
use-default-preprocessors = false
create-missing            = false

[output.html.print]
enable = false
"#;

/// A page of the book.
struct Chapter {
    title: String,
    /// Its file, relative to the root of the project.
    path: String,
    /// The pages below it.
    pages: Vec<Chapter>,
}

/// Builds the executable and its plugins, and then the manual. Prints the path of its first page.
pub(crate) fn run(root: &Path, paint: Paint) -> Result<()> {
    if !is_installed() {
        bail!("mdbook is not installed: {INSTALL}");
    }
    let mut cargo = shell::cargo();
    cargo.args(["build", "--workspace"]).current_dir(root);
    shell::run(&mut cargo, paint)?;
    let book = make(root, paint)?;
    println!("{}", book.join("index.html").display());
    Ok(())
}

/// The step `manual`. Skipped without `mdbook`, in CI too: building it takes minutes.
pub(crate) fn step(context: &Context) -> Result<StepOutcome> {
    if !is_installed() {
        return Ok(StepOutcome::Skipped(format!(
            "mdbook is not installed: {INSTALL}"
        )));
    }
    make(&context.root, context.paint)?;
    Ok(StepOutcome::Passed)
}

fn is_installed() -> bool {
    shell::succeeds(Command::new("mdbook").arg("--version"))
}

/// Makes the book with the development build. Returns its folder.
fn make(root: &Path, paint: Paint) -> Result<PathBuf> {
    let metadata = Metadata::of_workspace(root)?;
    let folder = metadata.target_directory.join("manual");
    let source = folder.join("src");
    project_files::empty(&source)?;
    project_files::copy(
        root,
        &[
            "README.md",
            "CHANGELOG.md",
            "CONTRIBUTING.md",
            "docs",
            "scenarios/README.md",
        ],
        &source,
    )?;
    let linked = linked_files(&source)?;
    let linked: Vec<&str> = linked.iter().map(String::as_str).collect();
    project_files::copy(root, &linked, &source)?;
    let mut parts = summary::parts(&source)?;
    let programs = metadata.target_directory.join("debug");
    parts.push((
        "Reference".to_owned(),
        reference::write(&programs, &package::plugins(root, &metadata), &source)?,
    ));
    fs::write(source.join("SUMMARY.md"), summary::text(&parts))?;
    fs::write(folder.join("book.toml"), BOOK)?;
    shell::run(Command::new("mdbook").arg("build").arg(&folder), paint)?;
    let book = folder.join("book");
    links::check(&book)?;
    Ok(book)
}

/// Returns the files and folders beside the pages to which the pages link.
fn linked_files(source: &Path) -> Result<BTreeSet<String>> {
    let mut linked = BTreeSet::new();
    for page in pages_below(source)? {
        let name = page.strip_prefix(source)?.to_string_lossy().into_owned();
        let text = fs::read_to_string(&page)?;
        let all = text.lines().flat_map(targets);
        let inside = all.filter(|target| !target.contains(':') && !target.starts_with('#'));
        let paths = inside.map(|target| resolve(&name, target.split('#').next().unwrap_or(target)));
        linked.extend(paths.filter(|path| !path.ends_with(".md")));
    }
    Ok(linked)
}

/// Returns the pages in a folder and below it.
fn pages_below(folder: &Path) -> Result<Vec<PathBuf>> {
    files_below(folder, "md")
}

/// Returns the files of one kind in a folder and below it, in the order of their paths.
fn files_below(folder: &Path, extension: &str) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            files.extend(files_below(&path, extension)?);
        } else if path.extension().is_some_and(|found| found == extension) {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}
