//! Delivered applications, with their plugins built on demand. No result of another test is used.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use jde_loader::{Plugins, SearchPath};

pub(crate) const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
pub(crate) const SECOND: u64 = 1_000_000_000;

/// The plugins that the tests use.
const NAMES: [&str; 9] = [
    "ball", "example", "family", "father", "goon", "sim", "stop", "teleop", "vff",
];

/// Returns the folder with the plugins. The first call builds them, all at once: a second build of some of
/// them could replace files that another test reads.
pub(crate) fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(["build", "--message-format=json"]).current_dir(ROOT);
        if !cfg!(debug_assertions) {
            cargo.arg("--release");
        }
        cargo.args(NAMES.iter().flat_map(|plugin| ["-p", plugin]));
        let output = cargo.output().expect("cargo starts");
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        let messages = String::from_utf8(output.stdout).expect("cargo prints UTF-8");
        let mut libraries = messages.lines().filter_map(|line| {
            let message: serde_json::Value = serde_json::from_str(line).ok()?;
            let is_ours = NAMES.iter().any(|plugin| message["target"]["name"] == *plugin);
            let file = is_ours.then(|| message["filenames"][0].as_str())??;
            Some(Path::new(file).parent()?.to_owned())
        });
        libraries.next().expect("cargo prints the paths of the libraries")
    })
}

/// The plugins of delivered applications.
pub(crate) fn plugins() -> Plugins {
    let mut path = SearchPath::default();
    path.push(folder(), "built for this test");
    Plugins::new(path)
}
