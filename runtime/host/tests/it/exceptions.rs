//! Exceptions of a C++ plugin that is built here by `c++`. An exception that its functions catch becomes a
//! fault with the exception's text.

use std::path::Path;
use std::process::Command;

use jde_app::{Application, parse};
use jde_core::Health;
use jde_host::{Lockstep, Options};
use jde_loader::{Plugins, SearchPath};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Builds a schema that throws `thrown`, with the given macros. `extra` extends the application file.
fn thrower(thrown: &str, macros: &[&str], extra: &str) -> (Plugins, Application) {
    let folder = tempfile::tempdir().expect("a folder");
    let output = Command::new("c++")
        .args(["-std=c++11", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"])
        .arg(format!("-DTHROWN={thrown}"))
        .args(macros)
        .args(["-I", &format!("{ROOT}/../../include"), "-o"])
        .arg(folder.path().join("libthrower.so"))
        .arg(format!("{ROOT}/tests/abi/thrower.cpp"))
        .output()
        .expect("a C++ compiler named c++ is installed");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let mut path = SearchPath::default();
    path.push(folder.path(), "built for this test");
    let plugins = Plugins::new(path);
    let text =
        format!("roots = [\"low\"]\n[schemas.low]\ntype = \"thrower/thrower\"\nrestart = \"never\"\n{extra}");
    let application =
        parse(&text, Path::new("app.toml"), &[], &plugins).unwrap_or_else(|faults| panic!("{faults}"));
    (plugins, application)
}

/// Returns the health of a schema that has thrown `thrown` and caught it.
fn health(thrown: &str) -> Health {
    let (plugins, application) = thrower(thrown, &[], "");
    assert_eq!(
        application.warnings(),
        [""; 0],
        "the plugin declares that it catches exceptions"
    );
    let mut lockstep = Lockstep::start(application, &plugins, Options::default()).expect("it starts");
    lockstep.run_until(50_000_000);
    lockstep.handle().snapshot().schemas[0].health.clone()
}

#[test]
fn an_unguarded_cpp_plugin_causes_a_warning_unless_it_is_isolated() {
    let warnings = |extra: &str| thrower("7", &["-DUNGUARDED"], extra).1.warnings();
    let [warning] = &warnings("")[..] else {
        panic!("one warning is expected")
    };
    for expected in [
        "line 2: `low`",
        "the plugin `thrower`, which is in C++",
        "isolate = \"process\"",
    ] {
        assert!(warning.contains(expected), "{warning}");
    }
    assert_eq!(warnings("isolate = \"process\"\n"), [""; 0]);
}

#[test]
fn a_caught_exception_is_a_fault_with_the_text_of_the_exception() {
    let faulted = |reason: &str| Health::Faulted(reason.to_owned());
    assert_eq!(
        health("std::runtime_error(\"the cable is loose\")"),
        faulted("panicked in iterate: the cable is loose")
    );
    assert_eq!(
        health("7"),
        faulted("panicked in iterate: it threw something that is not a std::exception")
    );
}
