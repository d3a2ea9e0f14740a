//! Runs the executable as a user would, in a folder of its own, with the plugins of the workspace.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Once, OnceLock};

use jde_watchdog::Watchdog;
use serde_json::Value;
use signal_hook::consts::{SIGINT, SIGQUIT};
use signal_hook::flag;

/// The plugins that the tests use.
pub(crate) const PLUGINS: [&str; 32] = [
    "sim", "carmen", "p2os", "example", "goon", "vff", "stop", "pair", "family", "teleop", "fault", "see",
    "map", "plan", "drive", "navigate", "guard", "recover", "localize", "explore", "slam", "cover", "people",
    "follow", "father", "tags", "dock", "guide", "ros2", "base", "lidar", "policy",
];

/// The output of a process that has ended.
#[derive(Debug)]
pub(crate) struct RunOutput {
    /// Exit status; `None` if a signal ended the process.
    pub(crate) status: Option<i32>,
    /// Standard output.
    pub(crate) out: String,
    /// Standard error.
    pub(crate) err: String,
}

/// Returns the path of an application in `tests/apps`.
pub(crate) fn app(name: &str) -> String {
    format!("{}/tests/apps/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// Returns the path of an application without a mission, whose listener takes over repeatedly.
pub(crate) fn pair() -> String {
    root().join("apps/pair.toml").display().to_string()
}

/// Parses the JSON object in the last line.
pub(crate) fn json(out: &str) -> Value {
    let line = out.lines().last().expect("there is output");
    serde_json::from_str(line).expect("the last line is JSON")
}

/// Sends a signal to a process, as in `signal("INT", &child)`.
pub(crate) fn signal(name: &str, process: &Child) {
    let mut kill = Command::new("kill");
    kill.args([&format!("-{name}"), &process.id().to_string()]);
    assert!(kill.status().expect("kill is installed").success());
}

/// Returns the root of the checkout.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .ancestors()
        .nth(2)
        .expect("the crate is in programs/jde")
}

/// Returns a command for the executable that ignores the colour and plugin settings of the environment.
pub(crate) fn jde(args: &[&str]) -> Command {
    restore_interrupts();
    let mut command = Command::new(env!("CARGO_BIN_EXE_jde"));
    command
        .args(args)
        .env_remove("NO_COLOR")
        .env_remove("JDE_PLUGIN_PATH");
    command
}

/// Handles SIGINT and SIGQUIT with their default effect, so that child processes do not ignore them. A shell
/// without job control makes background processes ignore both signals, and children inherit this: a test that
/// interrupts the executable would wait forever.
fn restore_interrupts() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        for signal in [SIGINT, SIGQUIT] {
            flag::register_conditional_default(signal, Arc::new(AtomicBool::new(true)))
                .expect("the signal can be handled");
        }
    });
}

/// Returns a command for the executable with the plugins of the workspace.
pub(crate) fn jde_with_plugins(args: &[&str]) -> Command {
    let mut command = jde(args);
    command.env("JDE_PLUGIN_PATH", plugins());
    command
}

/// Runs a command until it ends.
pub(crate) fn output_of(command: &mut Command) -> RunOutput {
    let _watchdog = Watchdog::for_test();
    let Output {
        status,
        stdout,
        stderr,
    } = loop {
        match command.output() {
            // Another test's process still has the new executable open for writing, until it is replaced itself.
            Err(error) if error.kind() == ErrorKind::ExecutableFileBusy => std::thread::yield_now(),
            output => break output.expect("the executable starts"),
        }
    };
    let text = |bytes| String::from_utf8(bytes).expect("the output is UTF-8");
    RunOutput {
        status: status.code(),
        out: text(stdout),
        err: text(stderr),
    }
}

/// Builds the plugins once, and returns their folder.
pub(crate) fn plugins() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| jde_test_plugins::folder(&PLUGINS))
}
