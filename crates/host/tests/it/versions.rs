//! Plugins and hosts of different minor versions of the ABI, built here by `cc` from kept sources. What one
//! has and the other lacks does no harm; what both have works.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use jde_abi::raw;
use jde_app::parse;
use jde_board::Variable;
use jde_core::{Health, State};
use jde_host::{Lockstep, Options};
use jde_loader::{Plugins, SearchPath};
use jde_types::Value as _;

use crate::delivered;
use tempfile::TempDir;

const TESTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/abi");
const TODAY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../include");

/// A father with two children that collide, and the base that they move.
const APP: &str = r#"
roots = ["father"]
[schemas.base]
type = "troupe/base"
[schemas.father]
type = "troupe/father"
children = { first = "first", second = "second" }
groups.legs = { policy = "father" }
[schemas.first]
type = "troupe/child"
imports = { moves = "base.moved" }
actuators = { base = "base.speed" }
[schemas.second]
type = "troupe/child"
pace = 0.125
imports = { moves = "base.moved" }
actuators = { base = "base.speed" }
"#;

fn cc(arguments: &[&str], source: &str, include: &Path, to: &Path) {
    let done = Command::new("cc")
        .args([
            "-std=c11",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-Wno-missing-field-initializers",
        ])
        .args(arguments)
        .arg("-I")
        .arg(include)
        .arg("-o")
        .arg(to)
        .arg(Path::new(TESTS).join(source))
        .args(["-lm", "-ldl"])
        .output()
        .expect("a C compiler named cc is installed");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}

/// Builds the plugin `troupe` with the header in `include`.
fn troupe(folder: &TempDir, include: &Path) -> PathBuf {
    let file = folder.path().join("libtroupe.so");
    cc(&["-shared", "-fPIC"], "troupe.c", include, &file);
    file
}

/// A folder with the header of a future version: every table has more fields, and the minor version is 99.
fn later(folder: &TempDir) -> PathBuf {
    let now = fs::read_to_string(Path::new(TODAY).join("jde.h")).expect("it is there");
    let mut grown = 0;
    let mut text = String::new();
    let mut in_table = false;
    for line in now.lines() {
        in_table |= line.starts_with("struct jde_") && line.ends_with('{') && line != "struct jde_sample {";
        if in_table && line == "};" {
            text += "    uint64_t later[3];\n";
            (in_table, grown) = (false, grown + 1);
        }
        text += line;
        text += "\n";
    }
    assert_eq!(grown, 21, "every table that states its size");
    let minor = format!("#define JDE_ABI_MINOR {}u", raw::ABI_MINOR);
    assert!(text.contains(&minor));
    let include = folder.path().join("later");
    fs::create_dir(&include).expect("a folder");
    fs::write(
        include.join("jde.h"),
        text.replace(&minor, "#define JDE_ABI_MINOR 99u"),
    )
    .expect("it is written");
    include
}

fn number(variable: Option<std::sync::Arc<Variable>>) -> f64 {
    let mut reader = variable.expect("it is declared").reader("test");
    f64::from_bytes(reader.latch().expect("it has a value").bytes).expect("a number")
}

/// Runs the plugin `troupe` and checks all its functions.
#[track_caller]
fn performs(folder: &TempDir, minor: u32) {
    let mut path = SearchPath::default();
    path.push(folder.path(), "built for this test");
    let plugins = Plugins::new(path);
    let plugin = plugins
        .load("troupe", &[])
        .unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(plugin.description.abi, (1, minor));
    let inspects = plugin.description.schemas.iter().map(|schema| schema.inspects);
    let expected = [false, minor >= 5, false];
    assert_eq!(
        inspects.collect::<Vec<_>>(),
        expected,
        "the ability that 1.5 brought"
    );
    let application = parse(APP, &folder.path().join("app.toml"), &[], &plugins)
        .unwrap_or_else(|faults| panic!("{faults}"));
    let mut lockstep = Lockstep::start(application, &plugins, Options::default()).expect("it starts");
    lockstep.run_until(1_000_000_000);
    let handle = lockstep.handle();
    let snapshot = handle.snapshot();
    for schema in &snapshot.schemas {
        assert_eq!(
            (&schema.health, schema.faults),
            (&Health::Ok, 0),
            "{}",
            schema.name
        );
    }
    let state = |name: &str| {
        snapshot
            .schemas
            .iter()
            .find(|schema| schema.name == name)
            .map(|schema| schema.state)
    };
    assert_eq!(state("second"), Some(State::Winner), "whom the father chose");
    assert_eq!(state("first"), Some(State::Ready));
    let board = handle.board();
    assert_eq!(number(board.find("father.seen")), f64::from(raw::WINNER));
    assert_eq!(number(board.find("first.pace")), 0.5, "what the father wrote");
    assert!(
        number(board.find("base.moved")) > 5.0,
        "it drove at 0.125 for a second"
    );
}

#[test]
fn plugins_of_abi_1_0_run_in_this_host() {
    let folder = tempfile::tempdir().expect("a folder");
    troupe(&folder, &Path::new(TESTS).join("v1.0"));
    performs(&folder, 0);
}

#[test]
fn plugins_of_today_run_in_this_host() {
    let folder = tempfile::tempdir().expect("a folder");
    troupe(&folder, Path::new(TODAY));
    performs(&folder, raw::ABI_MINOR);
}

#[test]
fn plugins_of_a_version_to_come_run_in_this_host() {
    let folder = tempfile::tempdir().expect("a folder");
    let later = later(&folder);
    troupe(&folder, &later);
    performs(&folder, 99);
}

/// Runs a plugin in a host of ABI 1.0. Returns its output and its exit code. The code is 0 if the plugin
/// worked and all guard marks are intact.
fn in_an_old_host(folder: &TempDir, plugin: &Path) -> (String, Option<i32>) {
    let host = folder.path().join("host");
    cc(&[], "host.c", &Path::new(TESTS).join("v1.0"), &host);
    let done = Command::new(host).arg(plugin).output().expect("it runs");
    (
        String::from_utf8_lossy(&done.stdout).into_owned(),
        done.status.code(),
    )
}

#[test]
fn plugins_of_today_and_of_a_version_to_come_run_in_a_host_that_knows_less() {
    for grown in [false, true] {
        let folder = tempfile::tempdir().expect("a folder");
        let include = if grown {
            later(&folder)
        } else {
            PathBuf::from(TODAY)
        };
        let (said, code) = in_an_old_host(&folder, &troupe(&folder, &include));
        assert_eq!(code, Some(0), "{said}");
        for line in [
            "base: iterate 0 \n",
            "child: check 0, ready 1 \n",
            "child: iterate 0 \n",
            "father: iterate 0 \n",
            "father: arbitrate 0, child 1, the second's turn\n",
        ] {
            assert!(said.contains(line), "{said}");
        }
    }
}

#[test]
fn plugins_of_this_sdk_run_in_a_host_that_knows_less() {
    let plugins = delivered::plugins();
    let folder = tempfile::tempdir().expect("a folder");
    let in_host = |name: &str| {
        let plugin = plugins.load(name, &[]).expect("it was built");
        in_an_old_host(&folder, plugin.path.as_deref().expect("a file"))
    };
    assert_eq!(
        in_host("stop"),
        (
            String::from("stop: check 0, ready 0 \nstop: iterate 0 \n"),
            Some(0)
        )
    );
    let (said, code) = in_host("family");
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("padre: iterate 0 \n"), "{said}");
    let (said, code) = in_host("example");
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("example: arbitrate 0, child "), "{said}");
}
