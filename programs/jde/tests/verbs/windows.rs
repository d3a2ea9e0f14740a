//! Real windows on a virtual screen: they are opened, clicked, stalled and killed without effect on the robot
//! that they view. If the required programs are missing, `cargo xtask test` installs them or names them.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};

use parking_lot::{Mutex, MutexGuard};
use serde_json::Value;

use crate::attached::Sandbox;
use crate::support::{RunOutput, jde, output_of};

/// `cargo xtask test` sets this variable where windows can be opened. A test that cannot open any then fails.
const REQUIRED_BY: &str = "JDE_TEST_SCREEN";

/// A virtual screen, closed when dropped. Only one exists at a time: drawing two makes the processor too slow
/// for the simulated mouse.
struct Screen {
    server: Child,
    name: String,
    _lock: MutexGuard<'static, ()>,
}

/// A process that shows windows. It is killed when dropped.
struct Windows(Child);

impl Screen {
    /// Returns `None` if the programs for it are missing.
    fn new() -> Option<Self> {
        static LOCK: Mutex<()> = Mutex::new(());
        let lock = LOCK.lock();
        let xdotool = Command::new("xdotool").arg("version").output();
        let server = Command::new("Xvfb")
            .args([
                "-displayfd",
                "1",
                "-screen",
                "0",
                "1440x900x24",
                "-nolisten",
                "tcp",
            ])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        let (Ok(_), Ok(mut server)) = (xdotool, server) else {
            let missing = "Xvfb or xdotool is missing, so no window can be opened (apt install xvfb xdotool)";
            assert!(std::env::var_os(REQUIRED_BY).is_none(), "{missing}");
            println!("{missing}");
            return None;
        };
        let mut number = String::new();
        let mut output = BufReader::new(server.stdout.take().expect("the output is piped"));
        output
            .read_line(&mut number)
            .expect("Xvfb prints the number of its display");
        Some(Self {
            server,
            name: format!(":{}", number.trim()),
            _lock: lock,
        })
    }

    fn open(&self, sandbox: &Sandbox, application: &str) -> Windows {
        let mut view = sandbox.command(jde(&["view", application]));
        let view = view
            .env("DISPLAY", &self.name)
            .env("XDG_CONFIG_HOME", sandbox.folder())
            .env_remove("WAYLAND_DISPLAY")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the executable starts");
        let windows = Windows(view);
        // The window gets its title when the application is open in it. Keys only drive in the focused
        // window, and a window is found before it can have the focus. The sandbox has a watchdog.
        let title = format!("{application} - jde");
        let search = ["search", "--sync", "--onlyvisible", "--name", &title];
        while self
            .run(&[&search[..], &["windowfocus", "--sync"]].concat())
            .status
            != Some(0)
        {}
        windows
    }

    /// Moves or clicks the mouse, or presses keys, with xdotool.
    fn xdotool(&self, args: &[&str]) {
        let output = self.run(args);
        assert_eq!(output.status, Some(0), "xdotool {args:?}: {output:?}");
    }

    fn run(&self, args: &[&str]) -> RunOutput {
        output_of(Command::new("xdotool").args(args).env("DISPLAY", &self.name))
    }

    fn click(&self, x: u32, y: u32) {
        self.xdotool(&["mousemove", &x.to_string(), &y.to_string()]);
        self.xdotool(&["click", "1"]);
    }

    /// Clicks until a condition is true: the window may not have drawn the target of the click yet.
    fn click_until(&self, x: u32, y: u32, mut condition: impl FnMut() -> bool) {
        for _ in 0..10 {
            self.click(x, y);
            if (0..200).any(|_| condition()) {
                return;
            }
        }
        panic!("a click at {x}, {y} has no effect");
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

impl Windows {
    /// Stops the process, as if it hung.
    fn stall(&self) {
        let stopped = Command::new("kill")
            .args(["-STOP", &self.0.id().to_string()])
            .status();
        assert!(stopped.expect("kill starts").success());
    }
}

impl Windows {
    /// Waits until the process ends. Returns its exit status and its standard error.
    fn end(&mut self) -> (Option<i32>, String) {
        let mut errors = String::new();
        let mut stderr = self.0.stderr.take().expect("the output is piped");
        stderr.read_to_string(&mut errors).expect("the output is UTF-8");
        (self.0.wait().expect("the process ends").code(), errors)
    }
}

impl Drop for Windows {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn state(sandbox: &Sandbox, schema: &str) -> String {
    let all = sandbox.json(&["ps"]);
    let schemas = all["schemas"].as_array().expect("a list");
    let found = schemas
        .iter()
        .find(|listed| listed["name"] == schema)
        .expect("the schema is listed");
    found["state"].as_str().expect("a string").to_owned()
}

fn iterations(sandbox: &Sandbox, schema: &str) -> u64 {
    let all = sandbox.json(&["ps"]);
    let schemas = all["schemas"].as_array().expect("a list");
    let found = schemas
        .iter()
        .find(|listed| listed["name"] == schema)
        .expect("the schema is listed");
    found["iterations"].as_u64().expect("a number")
}

#[test]
fn a_window_stops_and_drives_a_robot_that_is_not_affected_when_the_window_stalls() {
    let Some(screen) = Screen::new() else { return };
    let sandbox = Sandbox::new();
    let robot = sandbox.start("apps/safe-navigation.toml", &["--set", "example.rounds=0"]);
    let windows = screen.open(&sandbox, "safe-navigation");
    // A click stops everything, and two others let everything go on.
    screen.click_until(1383, 13, || state(&sandbox, "example") == "slept");
    let_everything_go_on(&screen, &sandbox);
    // Ctrl+Space stops everything too.
    screen.xdotool(&["key", "ctrl+space"]);
    wait(|| state(&sandbox, "example") == "slept");
    let_everything_go_on(&screen, &sandbox);
    drive(&screen, &sandbox);
    // Opens the panel of `example` and clicks a target in it. A frame must first bring the tab to the front.
    let has_target = || sandbox.run_ok(&["panel", "example"]).contains("To the target of");
    let reached = (0..20).any(|_| {
        screen.click(992, 37);
        let _ = (0..20).any(|_| has_target());
        screen.click(1078, 249);
        (0..40).any(|_| has_target())
    });
    assert!(reached, "a click in the panel sets no target");
    windows.stall();
    check_continues(&sandbox);
    drop(windows);
    check_continues(&sandbox);
    drop(screen.open(&sandbox, "safe-navigation"));
    check_continues(&sandbox);
    let all = sandbox.json(&["ps"]);
    let schemas = all["schemas"].as_array().expect("a list");
    // A stop may refuse the command of an iteration under way.
    assert!(schemas.iter().all(|schema| schema["faults"] == 0), "{all}");
    drop(robot);
}

/// Clicks on "Go on ..." below the bar, and then on "Let everything go on" beside it.
fn let_everything_go_on(screen: &Screen, sandbox: &Sandbox) {
    // The first button may not be drawn yet, and a second click on it is "Keep it stopped".
    let goes_on = (0..40).any(|_| {
        screen.click(38, 37);
        (0..2).any(|_| {
            screen.click(192, 37);
            (0..15).any(|_| state(sandbox, "example") == "winner")
        })
    });
    assert!(goes_on, "two clicks do not let everything go on");
}

/// Drives with the mouse and then with a key, and releases the control each time.
fn drive(screen: &Screen, sandbox: &Sandbox) {
    let driven = || state(sandbox, "teleop") == "winner";
    let released = || state(sandbox, "example") == "winner";
    // The switch may still be lower, below the row of "Go on ...", or the pad may not be drawn yet. A press before the
    // pad is drawn has no effect, and a second click on the switch turns it off.
    let taken = (0..20).any(|_| {
        // Within the switch also where a wide value has widened its column.
        screen.click(1128, 88);
        (0..2).any(|_| {
            screen.xdotool(&["mousemove", "1200", "208", "mousedown", "1"]);
            let taken = (0..15).any(|_| driven());
            if !taken {
                screen.xdotool(&["mouseup", "1"]);
            }
            taken
        })
    });
    assert!(taken, "the pad does not drive");
    screen.xdotool(&["mouseup", "1"]);
    wait(released);
    // The widget that was clicked last has the keyboard focus.
    screen.xdotool(&["keydown", "Left"]);
    wait(driven);
    screen.xdotool(&["keyup", "Left"]);
    wait(released);
}

/// Waits until a condition is true.
fn wait(mut condition: impl FnMut() -> bool) {
    assert!((0..20_000).any(|_| condition()), "the condition stayed false");
}

/// Checks that `example` is WINNER for another second.
fn check_continues(sandbox: &Sandbox) {
    let enough = iterations(sandbox, "example") + 14;
    sandbox.until(&["ps"], |all| {
        has_authority(all, "example") && iterations(sandbox, "example") >= enough
    });
}

fn has_authority(all: &Value, schema: &str) -> bool {
    let schemas = all["schemas"].as_array().expect("a list");
    schemas
        .iter()
        .any(|listed| listed["name"] == schema && listed["state"] == "winner" && listed["authority"] == true)
}

#[test]
fn a_closed_window_ends_the_view_with_a_message_and_the_robot_continues() {
    let Some(screen) = Screen::new() else { return };
    let sandbox = Sandbox::new();
    let robot = sandbox.start("apps/safe-navigation.toml", &["--set", "example.rounds=0"]);
    let check_message = |mut windows: Windows| {
        let (status, errors) = windows.end();
        assert_eq!(status, Some(1), "{errors}");
        assert!(errors.contains("its window disappeared"), "{errors}");
        assert!(!errors.contains("panicked"), "{errors}");
    };
    let windows = screen.open(&sandbox, "safe-navigation");
    let title = "safe-navigation - jde";
    screen.xdotool(&["search", "--onlyvisible", "--name", title, "windowclose"]);
    check_message(windows);
    let windows = screen.open(&sandbox, "safe-navigation");
    drop(screen);
    check_message(windows);
    check_continues(&sandbox);
    drop(robot);
}

#[test]
fn view_without_a_screen_fails_with_a_message() {
    let sandbox = Sandbox::new();
    let mut view = sandbox.command(jde(&["view"]));
    let refused = output_of(view.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY"));
    assert_eq!(refused.status, Some(2), "{refused:?}");
    assert!(refused.err.contains("there is no screen"), "{refused:?}");
    assert!(refused.err.contains("jde top"), "{refused:?}");
}

#[test]
fn view_refuses_two_sources() {
    let sandbox = Sandbox::new();
    for (args, status, error) in [
        (&["view", "one", "--app", "other"][..], 2, "name two applications"),
        (
            &["view", "drive.mcap", "--app", "other"],
            2,
            "names an application",
        ),
        (
            &["view", "drive.mcap", "--at", "tcp/robot2:7447"],
            2,
            "--at is for another machine",
        ),
        (&["view", "./nowhere"], 1, "nowhere: No such file"),
        (&["view", "nowhere.mcap"], 1, "nowhere.mcap: No such file"),
    ] {
        let refused = output_of(&mut sandbox.command(jde(args)));
        assert_eq!(refused.status, Some(status), "{args:?}: {refused:?}");
        assert!(refused.err.contains(error), "{args:?}: {refused:?}");
    }
    // JDE_APP does not count as a second source, and a file does not hide an application of the same name.
    std::fs::write(sandbox.folder().join("one"), "").expect("the folder is writable");
    let mut view = sandbox.command(jde(&["view", "one"]));
    view.env("JDE_APP", "other").current_dir(sandbox.folder());
    let refused = output_of(view.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY"));
    assert!(refused.err.contains("there is no screen"), "{refused:?}");
}

#[test]
fn view_without_a_graphics_adapter_names_the_package_to_install() {
    let Some(screen) = Screen::new() else { return };
    let sandbox = Sandbox::new();
    let mut view = sandbox.command(jde(&["view"]));
    let refused = output_of(
        view.env("DISPLAY", &screen.name)
            .env_remove("WAYLAND_DISPLAY")
            // This backend exists on Windows only, so there is no adapter.
            .env("WGPU_BACKEND", "dx12"),
    );
    assert_eq!(refused.status, Some(1), "{refused:?}");
    assert!(
        refused.err.contains("apt install mesa-vulkan-drivers"),
        "{refused:?}"
    );
}
