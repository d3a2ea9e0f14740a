//! `cargo xtask package`: packages for machines without Rust and without this project.
//!
//! All packages hold one tree, the [`prefix`], which the executable finds from its own place.

mod deb;
mod prefix;
pub(crate) mod python;
pub(crate) mod sdk;
mod symbols;
mod third_party;
pub(crate) mod trial;
mod wheel;

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result};
use clap::{Args, ValueEnum};

use crate::metadata::{Metadata, Package};
use crate::paint::Paint;
use crate::shell;

/// The options of the verb.
#[derive(Args)]
pub(crate) struct Choice {
    /// Make only this form of package (may be repeated).
    #[arg(long, value_enum, value_name = "FORM")]
    only: Vec<Form>,
    /// Package the development build instead of the optimised one.
    #[arg(long)]
    dev: bool,
}

/// A form of package.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Form {
    /// An archive that runs from any folder.
    Tarball,
    /// Packages of Debian and Ubuntu.
    Deb,
    /// A package of `pip`, with everything.
    Wheel,
    /// The package for Python of the development build, as a folder for `PYTHONPATH`.
    Python,
}

/// What all packages of one build share.
struct Release<'r> {
    root: &'r Path,
    metadata: &'r Metadata,
    /// The folder of the packages.
    folder: PathBuf,
    version: String,
    /// The time of the last commit, in seconds since 1970: the same commit gives the same packages.
    time: String,
    /// How hard `xz` compresses: little what is only tried.
    level: &'static str,
    paint: Paint,
}

impl Release<'_> {
    /// Returns the tree of the symbols of all programs, from the root of a system.
    fn symbols(&self) -> PathBuf {
        self.folder.join("symbols")
    }
}

/// Makes the packages, and prints the path and the size of each.
pub(crate) fn run(root: &Path, choice: &Choice, paint: Paint) -> Result<()> {
    if choice.only.contains(&Form::Python) {
        let target = Metadata::of_workspace(root)?.target_directory;
        println!(
            "{}",
            python::make(root, &target, cargo_build(root, true), paint)?.display()
        );
    }
    for package in make_chosen(root, choice, paint)? {
        let megabytes = package.metadata()?.len() as f64 / 1e6;
        println!("{megabytes:6.1} MB  {}", package.display());
    }
    Ok(())
}

/// Makes the packages of a choice, and returns their files.
pub(crate) fn make_chosen(root: &Path, choice: &Choice, paint: Paint) -> Result<Vec<PathBuf>> {
    let forms = if choice.only.is_empty() {
        &[Form::Tarball, Form::Deb, Form::Wheel]
    } else {
        choice.only.as_slice()
    };
    if forms.iter().all(|form| *form == Form::Python) {
        return Ok(Vec::new());
    }
    make(root, cargo_build(root, choice.dev), choice.dev, forms, paint)
}

/// Returns a call of `cargo build`, for the whole workspace or for what the caller adds.
fn cargo_build(root: &Path, all: bool) -> Command {
    let mut cargo = shell::cargo();
    cargo.arg("build").current_dir(root);
    if all {
        cargo.arg("--workspace");
    }
    cargo
}

/// Builds with a call of `cargo build`, and returns the packages that it makes of the build.
fn make(root: &Path, cargo: Command, dev: bool, forms: &[Form], paint: Paint) -> Result<Vec<PathBuf>> {
    let metadata = Metadata::with_dependencies(root)?;
    let plugins = plugins(root, &metadata);
    let executable = metadata.members().find(|package| package.name == "jde");
    let mut time = Command::new("git");
    time.args(["log", "-1", "--format=%ct"]).current_dir(root);
    let release = Release {
        root,
        metadata: &metadata,
        folder: metadata.target_directory.join("package"),
        version: executable.context("there is no package jde")?.version.clone(),
        time: shell::read(&mut time)?.trim().to_owned(),
        level: if dev { "1" } else { "6" },
        paint,
    };
    build(cargo, &plugins, dev, paint)?;
    let built = metadata
        .target_directory
        .join(if dev { "debug" } else { "release" });
    let prefix = prefix::write(&release, &built, &plugins)?;
    let mut packages = Vec::new();
    if forms.contains(&Form::Tarball) {
        packages.push(tarball(&release, &prefix)?);
    }
    if forms.contains(&Form::Deb) {
        packages.extend(deb::make(&release, &prefix)?);
    }
    if forms.contains(&Form::Wheel) {
        packages.push(wheel::make(&release, &prefix)?);
    }
    Ok(packages)
}

/// Returns the plugins of the workspace. Not every library with a C ABI is one: that of Python is not.
pub(crate) fn plugins<'m>(root: &Path, metadata: &'m Metadata) -> Vec<&'m Package> {
    let is_plugin = |folder: &str| folder.starts_with("schemas/") || folder.starts_with("drivers/");
    metadata
        .members()
        .filter(|package| is_plugin(&package.folder(root)))
        .collect()
}

/// Builds the executable, the plugins, the library for programs and the extension module of Python with a call of `cargo
/// build`; for a development build the call says itself what it builds, so that nothing is built a second time with other
/// features.
fn build(mut cargo: Command, plugins: &[&Package], dev: bool, paint: Paint) -> Result<()> {
    if !dev {
        cargo.arg("--release");
        for package in ["jde", "jde-c", "jde-python"] {
            cargo.args(["--package", package]);
        }
        for plugin in plugins {
            cargo.args(["--package", &plugin.name]);
        }
    }
    shell::run(&mut cargo, paint)
}

/// Packs the prefix, with its own name as the only folder.
fn tarball(release: &Release<'_>, prefix: &Path) -> Result<PathBuf> {
    let name = prefix.file_name().context("the prefix has a name")?;
    let file = release.folder.join(name).with_added_extension("tar.xz");
    let mut tar = Command::new("tar");
    tar.args(["--create", "--xz", "--sort=name", "--numeric-owner"])
        .args(["--owner=0", "--group=0", &format!("--mtime=@{}", release.time)])
        .arg("--file")
        .arg(&file)
        .arg("--directory")
        .arg(&release.folder)
        .arg(name)
        .env("XZ_OPT", format!("-{}", release.level));
    shell::run(&mut tar, release.paint)?;
    Ok(file)
}
