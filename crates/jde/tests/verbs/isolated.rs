//! A schema in a process of its own, requested by one word in the application's file: shown, killed,
//! restarted and reloaded.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::attached::{Place, schema};
use crate::reloading::{Shelf, version};
use crate::support::{jde_with_plugins, root, said};

/// Writes an application: the robot in the office, with the avoiding schema in a process of its own.
fn application(folder: &Path) -> PathBuf {
    let app = fs::read_to_string(root().join("apps/safe-navigation.toml")).expect("it is there");
    let world = format!("{}/worlds/", root().display());
    let isolated = app.replace("../worlds/", &world).replace(
        "[schemas.vff]\n",
        "[schemas.vff]\nisolate = { memory = \"1 GB\", network = false }\n",
    );
    assert_eq!(isolated.matches("isolate").count(), 1);
    let file = folder.join("app.toml");
    fs::write(&file, isolated).expect("it is written");
    file
}

fn process(now: &Value) -> Option<u64> {
    schema(now, "vff")["process"].as_u64()
}

#[test]
fn what_a_process_may_use_is_shown_before_anything_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let app = application(folder.path());
    let checked = said(jde_with_plugins(&["check"]).arg(app));
    assert_eq!(checked.status, Some(0), "{checked:?}");
    let words = "in a process of its own: at most 1000.0 MB of memory, no network";
    assert!(checked.out.contains(words), "{checked:?}");
}

#[test]
fn a_process_that_is_killed_is_missed_replaced_and_reloaded_while_the_robot_drives() {
    let (place, shelf) = (Place::new(), Shelf::new());
    let _robot = shelf.start(&place, &application(place.folder()), &[]);
    let first = process(&place.until(&["ps"], |now| process(now).is_some()));
    let number = first.expect("it has one").to_string();
    let command = fs::read_to_string(format!("/proc/{number}/comm")).expect("it lives");
    assert_eq!(command.trim(), "vff", "it is known by the schema's name");

    let killed = Command::new("kill").args(["-9", &number]).status();
    assert!(killed.expect("there is a kill").success());
    let is_back = |now: &Value| process(now).is_some_and(|process| Some(process) != first);
    let back = place.until(&["ps"], is_back);
    assert_eq!(schema(&back, "vff")["faults"], 1);
    assert!(
        !Path::new(&format!("/proc/{number}")).exists(),
        "nobody waits to be buried"
    );

    shelf.write(&shelf.build("9.8.7"));
    let told = place.told(&["reload", "vff"]);
    assert!(told.contains("reloaded vff to 9.8.7"), "{told}");
    let now = place.until(&["ps"], |now| version(now) == Some("9.8.7"));
    assert_ne!(process(&now), process(&back), "another build, another process");
    let steady = |name: &str| schema(&now, name)["faults"] == 0;
    assert!(
        ["example", "goon", "stop", "pioneer"].into_iter().all(steady),
        "{now}"
    );
}
