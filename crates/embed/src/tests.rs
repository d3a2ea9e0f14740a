use jde_board::value::Value;
use jde_watchdog::{DEFAULT_LIMIT, Watchdog};

use crate::{LoadedApplication, Run, StartOptions};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
const SECOND: u64 = 1_000_000_000;

/// Starts the application of safe navigation, with the plugins of this build.
fn start(options: &StartOptions) -> Run {
    let plugins = jde_test_plugins::folder(&["sim", "example", "goon", "vff", "stop", "teleop"]);
    let text = std::fs::read_to_string(format!("{ROOT}/apps/safe-navigation.toml")).unwrap();
    let text = text.replace("../worlds", &format!("{ROOT}/worlds"));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("application.toml");
    std::fs::write(&file, format!("plugins = [{plugins:?}]\n{text}")).unwrap();
    let application = LoadedApplication::load(file, Vec::new(), Vec::new(), None).unwrap();
    application.start(options).unwrap()
}

fn lockstep() -> StartOptions {
    StartOptions {
        lockstep: true,
        ..StartOptions::default()
    }
}

fn watch() -> Watchdog {
    Watchdog::new(DEFAULT_LIMIT, || String::from("a call waits for another"))
}

#[test]
fn r14_who_operates_waits_for_nobody_who_lets_time_pass() {
    let _watchdog = watch();
    let run = start(&lockstep());
    run.step(None).unwrap();
    // As a thread does that lets time pass.
    let state = run.state();
    run.renew_lease(Some(SECOND));
    run.write("vff.ahead", Value::Float(0.9)).unwrap();
    run.stop("goon").unwrap();
    run.release("goon").unwrap();
    run.edit("pioneer", "{ remove = 'lab door' }").unwrap();
    drop(state);
}
