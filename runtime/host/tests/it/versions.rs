//! Plugins and hosts of different minor versions of the ABI, built by `cc` from kept sources. A function that
//! only one side has does no harm; a function that both sides have works.

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
const CURRENT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../include");

/// A father with two children that collide, and the base that they move.
const APP: &str = r#"
roots = ["father"]
[schemas.base]
type = "versioned/base"
[schemas.father]
type = "versioned/father"
children = { first = "first", second = "second" }
groups.legs = { policy = "father" }
[schemas.first]
type = "versioned/child"
imports = { moves = "base.moved" }
actuators = { base = "base.speed" }
[schemas.second]
type = "versioned/child"
pace = 0.125
imports = { moves = "base.moved" }
actuators = { base = "base.speed" }
"#;

fn cc(arguments: &[&str], source: &str, include: &Path, to: &Path) {
    let output = Command::new("cc")
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
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

/// Builds the plugin `versioned` with the header in `include`.
fn build_plugin(folder: &TempDir, include: &Path) -> PathBuf {
    let file = folder.path().join("libversioned.so");
    cc(&["-shared", "-fPIC"], "versioned.c", include, &file);
    file
}

/// Returns a folder with the header of a future version: every table has more fields, and the minor version is 99.
fn future_header(folder: &TempDir) -> PathBuf {
    let header = fs::read_to_string(Path::new(CURRENT).join("jde.h")).expect("the header exists");
    let mut grown = 0;
    let mut text = String::new();
    let mut in_table = false;
    for line in header.lines() {
        in_table |= line.starts_with("struct jde_") && line.ends_with('{') && line != "struct jde_sample {";
        if in_table && line == "};" {
            text += "    uint64_t later[3];\n";
            (in_table, grown) = (false, grown + 1);
        }
        text += line;
        text += "\n";
    }
    assert_eq!(grown, 27, "all tables that have a size field");
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
    f64::from_bytes(reader.latch(0).expect("it has a value").bytes).expect("a number")
}

/// Runs the plugin `versioned` and checks all its functions.
#[track_caller]
fn assert_works(folder: &TempDir, minor: u32) {
    let mut path = SearchPath::default();
    path.push(folder.path(), "built for this test");
    let plugins = Plugins::new(path);
    let plugin = plugins
        .load("versioned", &[])
        .unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(plugin.description.abi, (1, minor));
    let inspects = plugin.description.schemas.iter().map(|schema| schema.inspects);
    let expected = [false, minor >= 5, false];
    assert_eq!(
        inspects.collect::<Vec<_>>(),
        expected,
        "ABI 1.5 added this ability"
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
    assert_eq!(state("second"), Some(State::Winner), "the father chose it");
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
    build_plugin(&folder, &Path::new(TESTS).join("v1.0"));
    assert_works(&folder, 0);
}

#[test]
fn plugins_of_the_current_version_run_in_this_host() {
    let folder = tempfile::tempdir().expect("a folder");
    build_plugin(&folder, Path::new(CURRENT));
    assert_works(&folder, raw::ABI_MINOR);
}

#[test]
fn plugins_of_a_future_version_run_in_this_host() {
    let folder = tempfile::tempdir().expect("a folder");
    let include = future_header(&folder);
    build_plugin(&folder, &include);
    assert_works(&folder, 99);
}

/// Runs a plugin in a host of ABI 1.0. Returns its output and its exit code. The code is 0 if the plugin
/// worked and all guard values are intact.
fn run_in_old_host(folder: &TempDir, plugin: &Path) -> (String, Option<i32>) {
    let host = folder.path().join("host");
    cc(&[], "host.c", &Path::new(TESTS).join("v1.0"), &host);
    let output = Command::new(host).arg(plugin).output().expect("it runs");
    (
        String::from_utf8_lossy(&output.stdout).into_owned(),
        output.status.code(),
    )
}

#[test]
fn plugins_of_the_current_and_of_a_future_version_run_in_an_older_host() {
    for grown in [false, true] {
        let folder = tempfile::tempdir().expect("a folder");
        let include = if grown {
            future_header(&folder)
        } else {
            PathBuf::from(CURRENT)
        };
        let (output, code) = run_in_old_host(&folder, &build_plugin(&folder, &include));
        assert_eq!(code, Some(0), "{output}");
        for line in [
            "base: iterate 0 \n",
            "child: check 0, ready 1 \n",
            "child: iterate 0 \n",
            "father: iterate 0 \n",
            "father: arbitrate 0, child 1, the second's turn\n",
        ] {
            assert!(output.contains(line), "{output}");
        }
    }
}

#[test]
fn plugins_of_this_sdk_run_in_an_older_host() {
    let plugins = delivered::plugins();
    let folder = tempfile::tempdir().expect("a folder");
    let in_host = |name: &str| {
        let plugin = plugins.load(name, &[]).expect("it was built");
        run_in_old_host(&folder, plugin.path.as_deref().expect("a file"))
    };
    assert_eq!(
        in_host("stop"),
        (
            String::from("stop: check 0, ready 1 \nstop: iterate 0 \n"),
            Some(0)
        )
    );
    let (output, code) = in_host("family");
    assert_eq!(code, Some(0), "{output}");
    assert!(output.contains("padre: iterate 0 \n"), "{output}");
    let (output, code) = in_host("example");
    assert_eq!(code, Some(0), "{output}");
    assert!(output.contains("example: arbitrate 0, child "), "{output}");
}
