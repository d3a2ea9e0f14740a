//! Builds plugins with cargo, which reports the paths of the libraries.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Builds plugins of this workspace in the caller's profile, and returns the folder that contains them.
pub(crate) fn build(plugins: &[&str]) -> PathBuf {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["build", "--message-format=json"]);
    cargo.current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    if !cfg!(debug_assertions) {
        cargo.arg("--release");
    }
    cargo.args(plugins.iter().flat_map(|plugin| ["-p", plugin]));
    let output = cargo.output().expect("cargo starts");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let messages = String::from_utf8(output.stdout).expect("cargo prints UTF-8");
    let mut libraries = messages.lines().filter_map(|line| {
        let message: serde_json::Value = serde_json::from_str(line).ok()?;
        let is_requested = plugins.iter().any(|plugin| message["target"]["name"] == *plugin);
        let file = is_requested.then(|| message["filenames"][0].as_str())??;
        Some(Path::new(file).parent()?.to_owned())
    });
    libraries.next().expect("cargo prints the paths of the libraries")
}
