//! A program with the library of an installation: schemas in Python are run with what that contains.

use std::fs::{self, Permissions};
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::path::Path;
use std::process::Command;

use jde_watchdog::Watchdog;

/// An application of one schema in Python.
const APPLICATION: &str = "name = \"try\"\nroots = [\"shy\"]\n[schemas.shy]\ntype = \"shy.py\"\n";
/// Prints itself and the first folder of packages, in place of Python.
const INTERPRETER: &str = "#!/bin/sh\necho \"$0 with $5\" >&2\nexit 1\n";

#[test]
fn the_interpreter_and_the_package_are_those_of_the_installation() {
    let _watchdog = Watchdog::for_test();
    let (prefix, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let prefix = prefix.path().canonicalize().unwrap();
    for folder in ["bin", "lib"] {
        fs::create_dir(prefix.join(folder)).unwrap();
    }
    let library = jde_test_plugins::library("jde-c", "jde");
    fs::copy(library, prefix.join("lib/libjde.so.0")).unwrap();
    symlink("libjde.so.0", prefix.join("lib/libjde.so")).unwrap();
    fs::write(prefix.join("bin/jde"), "").unwrap();
    fs::write(prefix.join("pyvenv.cfg"), "").unwrap();
    let interpreter = prefix.join("bin/python3");
    fs::write(&interpreter, INTERPRETER).unwrap();
    fs::set_permissions(&interpreter, Permissions::from_mode(0o755)).unwrap();
    fs::write(elsewhere.path().join("app.toml"), APPLICATION).unwrap();
    fs::write(elsewhere.path().join("shy.py"), "").unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let compiled = Command::new("cc")
        .current_dir(&elsewhere)
        .arg(root.join("examples/embed/lockstep.c"))
        .arg("-I")
        .arg(root.join("include"))
        .arg("-L")
        .arg(prefix.join("lib"))
        .args(["-ljde", "-lm", "-o", "program"])
        .output()
        .expect("a C compiler");
    assert!(compiled.status.success(), "{compiled:?}");
    let run = Command::new(elsewhere.path().join("program"))
        .arg("app.toml")
        .current_dir(&elsewhere)
        .env("LD_LIBRARY_PATH", prefix.join("lib"))
        .env_remove("JDE_PYTHON")
        .output()
        .unwrap();
    let said = format!(
        "{} with {}/lib/jde/python",
        interpreter.display(),
        prefix.display()
    );
    let errors = String::from_utf8_lossy(&run.stderr);
    assert!(errors.contains(&said), "{errors}");
}
