//! A schema with `isolate` in the application's file runs in a process of its own, is restarted when that is
//! killed, and can be reloaded.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::attached::{Sandbox, schema};
use crate::reloading::{PluginFolder, version};
use crate::support::{jde_with_plugins, output_of, root};

/// Writes the application of the demonstration with `vff` in a process of its own.
fn application(folder: &Path) -> PathBuf {
    let app = fs::read_to_string(root().join("apps/safe-navigation.toml")).expect("the application exists");
    let world = format!("{}/worlds/", root().display());
    let isolated = app.replace("../worlds/", &world).replace(
        "[schemas.vff]\n",
        "[schemas.vff]\nisolate = { memory = \"1 GB\", network = false }\n",
    );
    assert_eq!(isolated.matches("isolate").count(), 1);
    let file = folder.join("app.toml");
    fs::write(&file, isolated).expect("the folder is writable");
    file
}

/// Returns the process id of `vff`.
fn process(snapshot: &Value) -> Option<u64> {
    schema(snapshot, "vff")["process"].as_u64()
}

#[test]
fn check_shows_the_limits_of_an_isolated_process() {
    let folder = tempfile::tempdir().expect("a folder");
    let app = application(folder.path());
    let checked = output_of(jde_with_plugins(&["check"]).arg(app));
    assert_eq!(checked.status, Some(0), "{checked:?}");
    let limits = "in a process of its own: at most 1000.0 MB of memory, no network";
    assert!(checked.out.contains(limits), "{checked:?}");
}

#[test]
fn a_killed_process_is_restarted_and_reloaded_while_the_robot_drives() {
    let (sandbox, plugin_folder) = (Sandbox::new(), PluginFolder::new());
    let _robot = plugin_folder.start(&sandbox, &application(sandbox.folder()), &[]);
    let first = process(&sandbox.until(&["ps"], |now| process(now).is_some()));
    let number = first.expect("vff has a process").to_string();
    let command = fs::read_to_string(format!("/proc/{number}/comm")).expect("the process runs");
    assert_eq!(command.trim(), "vff", "the process has the schema's name");

    let killed = Command::new("kill").args(["-9", &number]).status();
    assert!(killed.expect("kill is installed").success());
    let is_restarted = |now: &Value| process(now).is_some_and(|process| Some(process) != first);
    let restarted = sandbox.until(&["ps"], is_restarted);
    assert_eq!(schema(&restarted, "vff")["faults"], 1);
    assert!(
        !Path::new(&format!("/proc/{number}")).exists(),
        "the killed process was waited for"
    );

    plugin_folder.write(&plugin_folder.build("9.8.7"));
    let output = sandbox.run_ok(&["reload", "vff"]);
    assert!(output.contains("reloaded vff to 9.8.7"), "{output}");
    let now = sandbox.until(&["ps"], |now| version(now) == Some("9.8.7"));
    assert_ne!(
        process(&now),
        process(&restarted),
        "a new build runs in a new process"
    );
    let has_no_faults = |name: &str| schema(&now, name)["faults"] == 0;
    assert!(
        ["example", "goon", "stop", "pioneer"]
            .into_iter()
            .all(has_no_faults),
        "{now}"
    );
}
