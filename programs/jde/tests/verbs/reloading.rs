//! `jde reload`, `run --watch`, `unload` and `load`: the libraries of plugins are replaced while applications
//! run.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::attached::{Running, Sandbox, schema};
use crate::support::{jde, plugins, root};

/// A folder with a copy of the plugin `vff`, which the search finds before the plugins of the workspace.
pub(crate) struct PluginFolder {
    folder: tempfile::TempDir,
    original: Vec<u8>,
}

impl PluginFolder {
    pub(crate) fn new() -> Self {
        let original = fs::read(plugins().join("libvff.so")).expect("the plugin is built");
        let plugin_folder = Self {
            folder: tempfile::tempdir().expect("a folder"),
            original,
        };
        plugin_folder.write(&plugin_folder.original);
        plugin_folder
    }

    fn file(&self) -> PathBuf {
        self.folder.path().join("libvff.so")
    }

    /// Replaces the library with a new file, as a linker does.
    pub(crate) fn write(&self, bytes: &[u8]) {
        let new = self.folder.path().join("new");
        fs::write(&new, bytes).expect("the folder is writable");
        fs::rename(new, self.file()).expect("the file is replaced");
    }

    /// Returns the library with another version.
    pub(crate) fn build(&self, version: &str) -> Vec<u8> {
        let old = concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes();
        let new = format!("{version}\0");
        assert_eq!(new.len(), old.len(), "the versions have the same length");
        let mut bytes = self.original.clone();
        let positions: Vec<_> = (0..bytes.len() - old.len())
            .filter(|position| bytes[*position..].starts_with(old))
            .collect();
        assert!(!positions.is_empty(), "the library contains its version");
        for position in positions {
            bytes[position..position + old.len()].copy_from_slice(new.as_bytes());
        }
        bytes
    }

    /// Starts an application that finds this folder first.
    pub(crate) fn start(&self, sandbox: &Sandbox, app: &Path, options: &[&str]) -> Running {
        let mut command = jde(&["run", app.to_str().expect("the path is UTF-8"), "--plain"]);
        let folders = std::env::join_paths([self.folder.path(), plugins()]).expect("no colons");
        command.env("JDE_PLUGIN_PATH", folders);
        sandbox.spawn(command, options)
    }
}

fn navigation() -> PathBuf {
    root().join("apps/safe-navigation.toml")
}

/// Returns the version of `vff` that was reloaded last.
pub(crate) fn version(snapshot: &Value) -> Option<&str> {
    schema(snapshot, "vff")["reload"]["build"]["version"].as_str()
}

#[test]
fn reload_replaces_the_code_of_a_running_schema() {
    let (sandbox, plugin_folder) = (Sandbox::new(), PluginFolder::new());
    let _robot = plugin_folder.start(&sandbox, &navigation(), &[]);
    let unchanged = sandbox.run_ok(&["reload", "vff"]);
    assert!(
        unchanged.contains("libvff.so, built ") && unchanged.contains(" ago: vff unchanged"),
        "{unchanged}"
    );

    plugin_folder.write(&plugin_folder.build("9.8.7"));
    let output = sandbox.run_ok(&["reload", "vff"]);
    for part in [
        "libvff.so, built ",
        " ago: reloaded vff to 9.8.7, with ",
        " bytes of memory, ",
        "on trial for 3 s",
    ] {
        assert!(output.contains(part), "`{part}` is not in: {output}");
    }
    assert_eq!(output.lines().count(), 1, "one line for each plugin: {output}");
    sandbox.until(&["ps"], |now| version(now) == Some("9.8.7"));

    plugin_folder.write(&plugin_folder.build("9.8.6"));
    let reloaded = sandbox.json(&["reload", "vff", "--probation", "0s"]);
    let [name, result] = reloaded["schemas"][0].as_array().expect("a pair").as_slice() else {
        panic!("{reloaded}");
    };
    let build = &result["reloaded"];
    assert_eq!(
        (name.as_str(), build["build"]["version"].as_str()),
        (Some("vff"), Some("9.8.6"))
    );
    assert_eq!(
        (build["carried"]["version"].as_u64(), build["probation"].as_u64()),
        (Some(1), Some(0))
    );
    assert_eq!(reloaded["memory"]["builds"], 2);

    let library = plugin_folder.build("9.8.5");
    plugin_folder.write(&library[..library.len() / 2]);
    let refused = sandbox.run(&["reload", "vff"]);
    assert_eq!(refused.status, Some(1), "{refused:?}");
    assert!(
        refused.err.contains("truncated or still being written"),
        "{refused:?}"
    );
    let now = sandbox.json(&["ps"]);
    assert_eq!(
        (version(&now), &schema(&now, "vff")["faults"]),
        (Some("9.8.6"), &Value::from(0))
    );

    let misspelled = sandbox.run(&["reload", "vfff"]);
    assert_eq!(misspelled.status, Some(2), "{misspelled:?}");
    assert!(misspelled.err.contains("`vff`"), "{misspelled:?}");
    let unknown = sandbox.run(&["reload", "zzzzzz"]);
    assert_eq!(unknown.status, Some(2), "{unknown:?}");
    assert!(unknown.err.contains("there are: "), "{unknown:?}");
}

#[test]
fn run_watch_reloads_a_plugin_after_each_build() {
    let (sandbox, plugin_folder) = (Sandbox::new(), PluginFolder::new());
    let _robot = plugin_folder.start(&sandbox, &navigation(), &["--watch"]);
    plugin_folder.write(&plugin_folder.build("7.6.5"));
    sandbox.until(&["ps"], |now| version(now) == Some("7.6.5"));
    plugin_folder.write(&plugin_folder.build("7.6.4"));
    let now = sandbox.until(&["ps"], |now| version(now) == Some("7.6.4"));
    assert_eq!(schema(&now, "vff")["reload"]["reloads"], 2);
    let faults = now["schemas"].as_array().expect("a list").iter();
    assert!(faults.map(|schema| &schema["faults"]).all(|faults| *faults == 0));
}

#[test]
fn r14_unload_and_load_of_a_plugin_affect_all_its_schemas() {
    let sandbox = Sandbox::new();
    let family = root().join("apps/family.toml");
    let _application = sandbox.start(family.to_str().expect("the path is UTF-8"), &[]);
    let all = |now: &Value, kind: &Value, asleep: bool| {
        let schemas = now["schemas"].as_array().expect("a list").iter();
        let mut of_family = schemas.filter(|schema| {
            schema["type_name"]
                .as_str()
                .is_some_and(|name| name.starts_with("family/"))
        });
        of_family.all(|schema| schema["operator"]["kind"] == *kind && (schema["state"] == "slept") == asleep)
    };
    sandbox.until(&["ps"], |now| all(now, &Value::Null, false));
    sandbox.run_ok(&["unload", "family"]);
    sandbox.until(&["ps"], |now| all(now, &Value::from("unloaded"), true));
    sandbox.run_ok(&["load", "family"]);
    sandbox.until(&["ps"], |now| all(now, &Value::Null, false));
}
