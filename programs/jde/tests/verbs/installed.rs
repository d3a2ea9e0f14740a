//! The executable away from its checkout: in an installation it finds plugins and data beside itself, and as a
//! service it reports to systemd.

use std::fs::{self, Permissions};
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::os::unix::net::UnixDatagram;
use std::path::Path;
use std::process::{Command, Stdio};

use jde_watchdog::Watchdog;

use crate::support::{jde_with_plugins, output_of, pair, plugins, root};

#[test]
fn an_installation_finds_its_plugins_applications_worlds_and_crates() {
    let prefix = tempfile::tempdir().unwrap();
    let prefix = prefix.path();
    let share = prefix.join("share/jde");
    for folder in ["bin", "lib", "share/jde/apps"] {
        fs::create_dir_all(prefix.join(folder)).unwrap();
    }
    fs::copy(env!("CARGO_BIN_EXE_jde"), prefix.join("bin/jde")).unwrap();
    symlink(plugins(), prefix.join("lib/jde")).unwrap();
    for folder in ["worlds", "plugin"] {
        symlink(root().join(folder), share.join(folder)).unwrap();
    }
    fs::copy(pair(), share.join("apps/twins.toml")).unwrap();
    let jde = |args: &[&str]| {
        let mut jde = Command::new(prefix.join("bin/jde"));
        jde.args(args).current_dir(prefix).env_remove("JDE_PLUGIN_PATH");
        output_of(&mut jde)
    };
    let run = jde(&["run", "twins", "--lockstep", "--for", "1s"]);
    assert_eq!(run.status, Some(0), "{run:?}");
    // The checkout has this application, the installation does not.
    let missing = jde(&["check", "pair"]);
    assert_eq!(missing.status, Some(2), "{missing:?}");
    assert!(missing.err.contains("one of: twins"), "{missing:?}");
    let created = jde(&["new", "schema", "follow-wall"]);
    assert_eq!(created.status, Some(0), "{created:?}");
    let manifest = fs::read_to_string(prefix.join("follow-wall/Cargo.toml")).unwrap();
    let schema = format!("path = {:?}", share.join("plugin/schema").display().to_string());
    assert!(manifest.contains(&schema), "{manifest}");
}

#[test]
fn in_a_virtual_environment_its_interpreter_runs_schemas() {
    let prefix = tempfile::tempdir().unwrap();
    let prefix = prefix.path();
    for folder in ["bin", "share/jde"] {
        fs::create_dir_all(prefix.join(folder)).unwrap();
    }
    fs::write(prefix.join("pyvenv.cfg"), "").unwrap();
    fs::copy(env!("CARGO_BIN_EXE_jde"), prefix.join("bin/jde")).unwrap();
    let interpreter = prefix.join("bin/python3");
    fs::write(
        &interpreter,
        "#!/bin/sh\necho that of the environment >&2\nexit 1\n",
    )
    .unwrap();
    fs::set_permissions(&interpreter, Permissions::from_mode(0o755)).unwrap();
    fs::write(prefix.join("shy.py"), "").unwrap();
    let mut describe = Command::new(prefix.join("bin/jde"));
    describe
        .args(["describe", "./shy.py"])
        .current_dir(prefix)
        .env_remove("JDE_PYTHON");
    let described = output_of(&mut describe);
    assert!(described.err.contains("that of the environment"), "{described:?}");
    // What to do next names it, by its path unless the environment is active.
    let (bin, interpreter) = (prefix.join("bin"), interpreter.display().to_string());
    for (name, path, expected) in [
        ("inactive", Path::new("/usr/bin"), &*interpreter),
        ("active", &*bin, "python3"),
    ] {
        let mut new = Command::new(prefix.join("bin/jde"));
        new.args(["new", "schema", name, "--python"])
            .current_dir(prefix)
            .env("PATH", path);
        let created = output_of(&mut new);
        let next = format!("  {expected} -m pytest\n");
        assert!(created.out.contains(&next), "{created:?}");
    }
}

#[test]
fn a_service_reports_its_start_and_that_it_is_alive() {
    let _watchdog = Watchdog::for_test();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("notify");
    let socket = UnixDatagram::bind(&path).unwrap();
    let mut run = jde_with_plugins(&["run", &pair(), "--plain", "--no-link"])
        .env("NOTIFY_SOCKET", Path::new(&path))
        .env("WATCHDOG_USEC", "20000")
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let mut buffer = [0; 64];
    for expected in ["READY=1", "WATCHDOG=1", "WATCHDOG=1"] {
        let length = socket.recv(&mut buffer).unwrap();
        assert_eq!(str::from_utf8(&buffer[..length]), Ok(expected));
    }
    run.kill().unwrap();
    run.wait().unwrap();
}
