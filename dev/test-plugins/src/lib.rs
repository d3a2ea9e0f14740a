//! Builds the plugins that tests load.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The environment variable with a folder of plugins that are built already. No test writes to that folder, so
/// test programs that run side by side cannot replace each other's plugins.
pub const VARIABLE: &str = "JDE_TEST_PLUGINS";

/// Returns the folder that contains these plugins of the workspace: the one of [`VARIABLE`], or the folder of
/// the caller's build, in which cargo builds them first.
///
/// # Panics
/// If cargo fails, or if the folder of [`VARIABLE`] lacks one of the plugins.
#[must_use]
pub fn folder(plugins: &[&str]) -> PathBuf {
    let folder = match std::env::var_os(VARIABLE) {
        Some(folder) => PathBuf::from(folder),
        None => build(plugins),
    };
    for plugin in plugins {
        let file = folder.join(format!("lib{plugin}.so"));
        assert!(file.exists(), "{} does not exist", file.display());
    }
    folder
}

/// Returns the file of another library of the workspace, which `package` builds: of the folder of [`VARIABLE`], or of the
/// caller's build.
///
/// # Panics
/// As [`folder`].
#[must_use]
pub fn library(package: &str, name: &str) -> PathBuf {
    let folder = match std::env::var_os(VARIABLE) {
        Some(folder) => PathBuf::from(folder),
        None => build(&[package]),
    };
    let file = folder.join(format!("lib{name}.so"));
    assert!(file.exists(), "{} does not exist", file.display());
    file
}

/// Builds the plugins in the profile and the target folder of the calling test.
fn build(plugins: &[&str]) -> PathBuf {
    let test = std::env::current_exe().expect("the path of this program is known");
    let profile = test
        .ancestors()
        .nth(2)
        .expect("cargo keeps tests in PROFILE/deps");
    let target = profile.parent().expect("cargo keeps profiles in a target folder");
    let mut cargo = Command::new(env!("CARGO"));
    cargo
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."))
        .args(["build", "--quiet", "--target-dir"])
        .arg(target)
        .args(plugins.iter().flat_map(|plugin| ["--package", plugin]));
    if profile.ends_with("release") {
        cargo.arg("--release");
    }
    let output = cargo.output().expect("cargo starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    profile.to_owned()
}
