//! Code that changes while an application runs: the files of plugins are replaced under real processes.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::attached::{Place, Running, schema};
use crate::support::{jde, plugins, root};

/// A folder of plugins for one test, which precedes the plugins of the workspace.
pub(crate) struct Shelf {
    folder: tempfile::TempDir,
    original: Vec<u8>,
}

impl Shelf {
    pub(crate) fn new() -> Self {
        let original = fs::read(plugins().join("libvff.so")).expect("it was built");
        let shelf = Self {
            folder: tempfile::tempdir().expect("a folder"),
            original,
        };
        shelf.write(&shelf.original);
        shelf
    }

    fn file(&self) -> PathBuf {
        self.folder.path().join("libvff.so")
    }

    /// Writes the library as a linker does: as a new file that replaces the old one.
    pub(crate) fn write(&self, bytes: &[u8]) {
        let beside = self.folder.path().join("new");
        fs::write(&beside, bytes).expect("it is written");
        fs::rename(beside, self.file()).expect("it takes the place");
    }

    /// Returns the same code with another version.
    pub(crate) fn build(&self, version: &str) -> Vec<u8> {
        let mark = concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes();
        let new = format!("{version}\0");
        assert_eq!(new.len(), mark.len(), "versions as long as the workspace's");
        let mut bytes = self.original.clone();
        let places: Vec<_> = (0..bytes.len() - mark.len())
            .filter(|place| bytes[*place..].starts_with(mark))
            .collect();
        assert!(!places.is_empty(), "it says its version");
        for place in places {
            bytes[place..place + mark.len()].copy_from_slice(new.as_bytes());
        }
        bytes
    }

    /// Starts an application with these plugins before all others.
    pub(crate) fn start(&self, place: &Place, app: &Path, more: &[&str]) -> Running {
        let mut command = jde(&["run", app.to_str().expect("it is UTF-8"), "--plain"]);
        let folders = std::env::join_paths([self.folder.path(), plugins()]).expect("no colons");
        command.env("JDE_PLUGIN_PATH", folders);
        place.found(command, more)
    }
}

fn navigation() -> PathBuf {
    root().join("apps/safe-navigation.toml")
}

pub(crate) fn version(now: &Value) -> Option<&str> {
    schema(now, "vff")["reload"]["build"]["version"].as_str()
}

#[test]
fn a_schema_drives_on_by_the_code_that_is_in_its_file() {
    let (place, shelf) = (Place::new(), Shelf::new());
    let _robot = shelf.start(&place, &navigation(), &[]);
    let same = place.told(&["reload", "vff"]);
    assert!(
        same.contains("libvff.so, built ") && same.contains(" ago: vff unchanged"),
        "{same}"
    );

    shelf.write(&shelf.build("9.8.7"));
    let told = place.told(&["reload", "vff"]);
    for words in [
        "libvff.so, built ",
        " ago: reloaded vff to 9.8.7, with ",
        " bytes of memory, ",
        "on trial for 3 s",
    ] {
        assert!(told.contains(words), "`{words}` is not in: {told}");
    }
    assert_eq!(told.lines().count(), 1, "one line a plugin: {told}");
    place.until(&["ps"], |now| version(now) == Some("9.8.7"));

    shelf.write(&shelf.build("9.8.6"));
    let reloaded = place.json(&["reload", "vff", "--probation", "0s"]);
    let [name, became] = reloaded["schemas"][0].as_array().expect("a pair").as_slice() else {
        panic!("{reloaded}");
    };
    let build = &became["reloaded"];
    assert_eq!(
        (name.as_str(), build["build"]["version"].as_str()),
        (Some("vff"), Some("9.8.6"))
    );
    assert_eq!(
        (build["carried"]["version"].as_u64(), build["probation"].as_u64()),
        (Some(1), Some(0))
    );
    assert_eq!(reloaded["memory"]["builds"], 2);

    let whole = shelf.build("9.8.5");
    shelf.write(&whole[..whole.len() / 2]);
    let refused = place.says(&["reload", "vff"]);
    assert_eq!(refused.status, Some(1), "{refused:?}");
    assert!(
        refused.err.contains("truncated or still being written"),
        "{refused:?}"
    );
    let now = place.json(&["ps"]);
    assert_eq!(
        (version(&now), &schema(&now, "vff")["faults"]),
        (Some("9.8.6"), &Value::from(0))
    );

    let slip = place.says(&["reload", "vfff"]);
    assert_eq!(slip.status, Some(2), "{slip:?}");
    assert!(slip.err.contains("`vff`"), "{slip:?}");
}

#[test]
fn a_run_that_watches_reloads_what_is_built() {
    let (place, shelf) = (Place::new(), Shelf::new());
    let _robot = shelf.start(&place, &navigation(), &["--watch"]);
    shelf.write(&shelf.build("7.6.5"));
    place.until(&["ps"], |now| version(now) == Some("7.6.5"));
    shelf.write(&shelf.build("7.6.4"));
    let now = place.until(&["ps"], |now| version(now) == Some("7.6.4"));
    assert_eq!(schema(&now, "vff")["reload"]["reloads"], 2);
    let faults = now["schemas"].as_array().expect("a list").iter();
    assert!(faults.map(|schema| &schema["faults"]).all(|faults| *faults == 0));
}

#[test]
fn r14_a_plugin_is_unloaded_and_loaded_with_all_its_schemas() {
    let place = Place::new();
    let family = root().join("apps/family.toml");
    let _toy = place.start(family.to_str().expect("it is UTF-8"), &[]);
    let all = |now: &Value, kind: &Value, asleep: bool| {
        let schemas = now["schemas"].as_array().expect("a list").iter();
        let mut of_family = schemas.filter(|schema| {
            schema["type_name"]
                .as_str()
                .is_some_and(|name| name.starts_with("family/"))
        });
        of_family.all(|schema| schema["operator"]["kind"] == *kind && (schema["state"] == "slept") == asleep)
    };
    place.until(&["ps"], |now| all(now, &Value::Null, false));
    place.told(&["unload", "family"]);
    place.until(&["ps"], |now| all(now, &Value::from("unloaded"), true));
    place.told(&["load", "family"]);
    place.until(&["ps"], |now| all(now, &Value::Null, false));
}
