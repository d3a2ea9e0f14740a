//! Exceptions of a C++ plugin that is built here by `c++`. An exception that its functions catch becomes a
//! fault with the exception's text.

use std::path::Path;
use std::process::Command;

use jde_app::{Application, parse};
use jde_core::Health;
use jde_host::{Lockstep, Options};
use jde_loader::{Plugins, SearchPath};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Builds a schema that throws `thrown`, with the given macros. `adds` extends the application file.
fn thrower(thrown: &str, macros: &[&str], adds: &str) -> (Plugins, Application) {
    let folder = tempfile::tempdir().expect("a folder");
    let done = Command::new("c++")
        .args(["-std=c++11", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"])
        .arg(format!("-DTHROWN={thrown}"))
        .args(macros)
        .args(["-I", &format!("{ROOT}/../../include"), "-o"])
        .arg(folder.path().join("libthrower.so"))
        .arg(format!("{ROOT}/tests/abi/thrower.cpp"))
        .output()
        .expect("a C++ compiler named c++ is installed");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let mut path = SearchPath::default();
    path.push(folder.path(), "built for this test");
    let plugins = Plugins::new(path);
    let text =
        format!("roots = [\"it\"]\n[schemas.it]\ntype = \"thrower/thrower\"\nrestart = \"never\"\n{adds}");
    let application =
        parse(&text, Path::new("app.toml"), &[], &plugins).unwrap_or_else(|faults| panic!("{faults}"));
    (plugins, application)
}

/// Returns the health of a schema after it caught what it threw.
fn health(thrown: &str) -> Health {
    let (plugins, application) = thrower(thrown, &[], "");
    assert_eq!(application.warnings(), [""; 0], "it says that it catches");
    let mut lockstep = Lockstep::start(application, &plugins, Options::default()).expect("it starts");
    lockstep.run_until(50_000_000);
    lockstep.handle().snapshot().schemas[0].health.clone()
}

#[test]
fn a_plugin_in_cpp_that_does_not_say_that_it_catches_is_warned_of_unless_it_is_isolated() {
    let warnings = |adds: &str| thrower("7", &["-DUNGUARDED"], adds).1.warnings();
    let [warning] = &warnings("")[..] else {
        panic!("a warning")
    };
    for words in [
        "line 2: `it`",
        "the plugin `thrower`, which is in C++",
        "isolate = \"process\"",
    ] {
        assert!(warning.contains(words), "{warning}");
    }
    assert_eq!(warnings("isolate = \"process\"\n"), [""; 0]);
}

#[test]
fn an_exception_that_is_caught_in_the_plugin_is_a_fault_in_its_words() {
    let faulted = |words: &str| Health::Faulted(words.to_owned());
    assert_eq!(
        health("std::runtime_error(\"the cable is loose\")"),
        faulted("panicked in iterate: the cable is loose")
    );
    assert_eq!(
        health("7"),
        faulted("panicked in iterate: it threw what is no std::exception")
    );
}
