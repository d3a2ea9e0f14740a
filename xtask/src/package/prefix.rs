//! The tree of all packages, as docs/installing.md shows it: `bin`, `lib`, `include` and `share` of one prefix.

use std::fs::{self, Permissions};
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Result;

use super::{Release, python, sdk, symbols, third_party};
use crate::metadata::Package;
use crate::{project_files, shell};

/// What users read and run, beside the crates of the SDK.
const DATA: &[&str] = &[
    "README.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "LICENSE-APACHE",
    "LICENSE-MIT",
    "apps",
    "docs",
    "examples",
    "experiments",
    "robots",
    "scenarios",
    "worlds",
];

/// The library of programs that run applications, for the compiler.
pub(super) const LIBRARY: &str = "libjde.so";
/// The same for a program that starts, as `programs/c/build.rs` names it.
pub(super) const SONAME: &str = "libjde.so.0";

/// The shells with completions, each with the file in which it looks for them.
const COMPLETIONS: &[(&str, &str)] = &[
    ("bash", "share/bash-completion/completions/jde"),
    ("fish", "share/fish/vendor_completions.d/jde.fish"),
    ("zsh", "share/zsh/vendor-completions/_jde"),
];

/// Writes the tree, and the symbols of its programs into the tree of `release`. Returns its folder, whose name states the
/// version and the kind of machine.
pub(super) fn write(release: &Release<'_>, built: &Path, plugins: &[&Package]) -> Result<PathBuf> {
    let name = format!("jde-{}-{}-linux", release.version, std::env::consts::ARCH);
    let prefix = release.folder.join(name);
    project_files::empty(&prefix)?;
    project_files::empty(&release.symbols())?;
    let install_stripped = |from: &Path, to: &Path| symbols::install_stripped(from, to, &release.symbols());
    let executable = prefix.join("bin/jde");
    install_stripped(&built.join("jde"), &executable)?;
    for plugin in plugins {
        let file = format!("lib{}.so", plugin.name.replace('-', "_"));
        install_stripped(&built.join(&file), &prefix.join("lib/jde").join(file))?;
    }
    let libraries = prefix.join("lib");
    install_stripped(&built.join(LIBRARY), &libraries.join(SONAME))?;
    // As Debian wants it: nobody executes it.
    fs::set_permissions(libraries.join(SONAME), Permissions::from_mode(0o644))?;
    symlink(SONAME, libraries.join(LIBRARY))?;
    python::write(
        release.root,
        built,
        &prefix.join("lib/jde/python"),
        install_stripped,
    )?;
    let data = prefix.join("share/jde");
    project_files::copy(release.root, DATA, &data)?;
    sdk::write(release.root, release.metadata, &data)?;
    project_files::copy(release.root, &["include"], &prefix)?;
    let cmake = prefix.join("lib/cmake/jde");
    fs::create_dir_all(&cmake)?;
    fs::copy(
        release.root.join("cmake/jdeConfig.cmake"),
        cmake.join("jdeConfig.cmake"),
    )?;
    write_generated(&executable, &prefix)?;
    let doc = prefix.join("share/doc/jde");
    fs::create_dir_all(&doc)?;
    let notices = doc.join("third-party.txt");
    fs::write(&notices, third_party::notices(release.metadata)?)?;
    gzip(&notices)?;
    // The permissions of the checkout depend on the umask of whoever made it.
    shell::read(
        Command::new("chmod")
            .args(["--recursive", "u=rwX,go=rX"])
            .arg(&prefix),
    )?;
    Ok(prefix)
}

/// Writes what the executable generates: manual pages and completions.
fn write_generated(executable: &Path, prefix: &Path) -> Result<()> {
    let pages = prefix.join("share/man/man1");
    fs::create_dir_all(&pages)?;
    shell::read(Command::new(executable).arg("man").arg(&pages))?;
    for page in fs::read_dir(&pages)? {
        gzip(&page?.path())?;
    }
    for (shell, file) in COMPLETIONS {
        let file = prefix.join(file);
        fs::create_dir_all(file.parent().unwrap_or(prefix))?;
        let script = shell::read(Command::new(executable).args(["completions", shell]))?;
        fs::write(file, script)?;
    }
    Ok(())
}

/// Replaces a file by its compressed form, which does not depend on the time.
pub(super) fn gzip(file: &Path) -> Result<()> {
    shell::read(
        Command::new("gzip")
            .args(["-9", "--no-name", "--force"])
            .arg(file),
    )
    .map(drop)
}
