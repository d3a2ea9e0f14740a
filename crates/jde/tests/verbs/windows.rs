//! Real windows on a virtual screen: opened, clicked, stalled and killed, while the robot keeps its rules. If
//! the required programs are missing, `cargo xtask test` installs them or names them.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde_json::Value;

use crate::attached::Place;
use crate::support::{jde, said};

/// Set by `cargo xtask test` where windows can be opened. A test that opens none then fails.
const WANTED: &str = "JDE_TEST_SCREEN";

/// A virtual screen, closed when dropped. Only one at a time: a processor that draws for two is too slow for
/// the simulated mouse.
struct Screen {
    server: Child,
    name: String,
    _alone: MutexGuard<'static, ()>,
}

/// A process that shows windows. It is killed when dropped.
struct Windows(Child);

impl Screen {
    /// Returns `None` if the programs for it are missing.
    fn new() -> Option<Self> {
        static ALONE: Mutex<()> = Mutex::new(());
        let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
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
            let missing = "Xvfb or xdotool is missing: no window is opened (apt install xvfb xdotool)";
            assert!(std::env::var_os(WANTED).is_none(), "{missing}");
            println!("{missing}");
            return None;
        };
        let mut number = String::new();
        let mut said = BufReader::new(server.stdout.take().expect("it is piped"));
        said.read_line(&mut number).expect("it says its number");
        Some(Self {
            server,
            name: format!(":{}", number.trim()),
            _alone: alone,
        })
    }

    fn open(&self, place: &Place, application: &str) -> Windows {
        let mut view = place.command(jde(&["view", application]));
        let view = view
            .env("DISPLAY", &self.name)
            .env("XDG_CONFIG_HOME", place.folder())
            .env_remove("WAYLAND_DISPLAY")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the executable starts");
        let windows = Windows(view);
        // The window has its title once the application is open in it. Only the window with the keyboard
        // focus can drive.
        let title = format!("{application} - jde");
        self.hand(&[
            "search",
            "--sync",
            "--onlyvisible",
            "--name",
            &title,
            "windowfocus",
            "--sync",
        ]);
        windows
    }

    /// Moves or clicks the mouse, or presses keys, with xdotool.
    fn hand(&self, what: &[&str]) {
        let mut hand = Command::new("xdotool");
        let done = said(hand.args(what).env("DISPLAY", &self.name));
        assert_eq!(done.status, Some(0), "xdotool {what:?}: {done:?}");
    }

    fn click(&self, x: u32, y: u32) {
        self.hand(&["mousemove", &x.to_string(), &y.to_string()]);
        self.hand(&["click", "1"]);
    }

    /// Clicks until the expected effect occurs: the window may not have drawn the target of the click yet.
    fn click_until(&self, x: u32, y: u32, mut so: impl FnMut() -> bool) {
        for _ in 0..10 {
            self.click(x, y);
            if (0..200).any(|_| so()) {
                return;
            }
        }
        panic!("a click at {x}, {y} came to nothing");
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
        let mut words = String::new();
        let mut said = self.0.stderr.take().expect("it is piped");
        said.read_to_string(&mut words).expect("it says UTF-8");
        (self.0.wait().expect("it ends").code(), words)
    }
}

impl Drop for Windows {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn state(place: &Place, schema: &str) -> String {
    let all = place.json(&["ps"]);
    let schemas = all["schemas"].as_array().expect("a list");
    let found = schemas
        .iter()
        .find(|one| one["name"] == schema)
        .expect("it is there");
    found["state"].as_str().expect("a word").to_owned()
}

fn iterations(place: &Place, schema: &str) -> u64 {
    let all = place.json(&["ps"]);
    let schemas = all["schemas"].as_array().expect("a list");
    let found = schemas
        .iter()
        .find(|one| one["name"] == schema)
        .expect("it is there");
    found["iterations"].as_u64().expect("a number")
}

#[test]
fn a_robot_is_stopped_driven_and_sent_from_a_window_that_may_stall_and_die() {
    let Some(screen) = Screen::new() else { return };
    let place = Place::new();
    let robot = place.start("apps/safe-navigation.toml", &["--set", "example.rounds=0"]);
    let windows = screen.open(&place, "safe-navigation");
    // The button stops everything, and then releases it.
    screen.click_until(1383, 13, || state(&place, "example") == "slept");
    screen.click_until(1383, 13, || state(&place, "example") == "winner");
    // Ctrl+Space stops everything too, wherever the focus is.
    screen.hand(&["key", "ctrl+space"]);
    wait(|| state(&place, "example") == "slept");
    screen.click_until(1383, 13, || state(&place, "example") == "winner");
    drive(&screen, &place);
    // Opens the panel of `example` and clicks a target in it, once a frame has brought its tab to the front.
    let sent = || place.told(&["panel", "example"]).contains("To the target of");
    let came = (0..20).any(|_| {
        screen.click(992, 37);
        let _ = (0..20).any(|_| sent());
        screen.click(1078, 249);
        (0..40).any(|_| sent())
    });
    assert!(came, "a click in the panel sets no target");
    // A viewer that stalls or is killed has no effect on the robot.
    windows.stall();
    goes_on(&place);
    drop(windows);
    goes_on(&place);
    // The application can be viewed again.
    drop(screen.open(&place, "safe-navigation"));
    goes_on(&place);
    let all = place.json(&["ps"]);
    let schemas = all["schemas"].as_array().expect("a list");
    assert!(
        schemas
            .iter()
            .all(|one| one["faults"] == 0 && one["refused"] == 0),
        "{all}"
    );
    drop(robot);
}

/// Drives by hand, with the mouse and then with a key, and releases the control each time.
fn drive(screen: &Screen, place: &Place) {
    let driven = || state(place, "teleop") == "winner";
    let given_back = || state(place, "example") == "winner";
    // The switch, or the pad below it, may not be drawn yet. Then the next click turns it off, and the one
    // after that on.
    let taken = (0..20).any(|_| {
        screen.click(1137, 88);
        screen.hand(&["mousemove", "1200", "208", "mousedown", "1"]);
        let taken = (0..100).any(|_| driven());
        if !taken {
            screen.hand(&["mouseup", "1"]);
        }
        taken
    });
    assert!(taken, "a hand on the pad does not drive");
    screen.hand(&["mouseup", "1"]);
    wait(given_back);
    // The widget that was clicked last has the keyboard focus.
    screen.hand(&["keydown", "Left"]);
    wait(driven);
    screen.hand(&["keyup", "Left"]);
    wait(given_back);
}

/// Waits until a condition is true.
fn wait(mut so: impl FnMut() -> bool) {
    assert!((0..20_000).any(|_| so()), "it did not come to be so");
}

/// Waits until `example` has acted as WINNER for another second.
fn goes_on(place: &Place) {
    let enough = iterations(place, "example") + 14;
    place.until(&["ps"], |all| {
        acts(all, "example") && iterations(place, "example") >= enough
    });
}

fn acts(all: &Value, schema: &str) -> bool {
    let schemas = all["schemas"].as_array().expect("a list");
    schemas
        .iter()
        .any(|one| one["name"] == schema && one["state"] == "winner" && one["authority"] == true)
}

#[test]
fn a_screen_that_takes_the_window_away_ends_it_in_words_and_not_the_robot() {
    let Some(screen) = Screen::new() else { return };
    let place = Place::new();
    let robot = place.start("apps/safe-navigation.toml", &["--set", "example.rounds=0"]);
    let says_so = |mut windows: Windows| {
        let (status, words) = windows.end();
        assert_eq!(status, Some(1), "{words}");
        assert!(words.contains("its window disappeared"), "{words}");
        assert!(!words.contains("panicked"), "{words}");
    };
    let windows = screen.open(&place, "safe-navigation");
    let title = "safe-navigation - jde";
    screen.hand(&["search", "--onlyvisible", "--name", title, "windowclose"]);
    says_so(windows);
    let windows = screen.open(&place, "safe-navigation");
    drop(screen);
    says_so(windows);
    goes_on(&place);
    drop(robot);
}

#[test]
fn without_a_screen_a_window_is_refused_in_words() {
    let place = Place::new();
    let mut view = place.command(jde(&["view"]));
    let refused = said(view.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY"));
    assert_eq!(refused.status, Some(2), "{refused:?}");
    assert!(refused.err.contains("there is no screen"), "{refused:?}");
    assert!(refused.err.contains("jde top"), "{refused:?}");
}

#[test]
fn of_two_things_to_look_at_neither_is_left_out_without_a_word() {
    let place = Place::new();
    for (args, status, why) in [
        (&["view", "one", "--app", "other"][..], 2, "name two applications"),
        (
            &["view", "drive.mcap", "--app", "other"],
            2,
            "names an application",
        ),
        (
            &["view", "drive.mcap", "--at", "tcp/robot2:7447"],
            2,
            "--at looks elsewhere",
        ),
        (&["view", "./nowhere"], 1, "nowhere: No such file"),
        (&["view", "nowhere.mcap"], 1, "nowhere.mcap: No such file"),
    ] {
        let refused = said(&mut place.command(jde(args)));
        assert_eq!(refused.status, Some(status), "{args:?}: {refused:?}");
        assert!(refused.err.contains(why), "{args:?}: {refused:?}");
    }
    // A setting for all tools is no second name, and a file in the folder does not hide an application.
    std::fs::write(place.folder().join("one"), "").expect("it can be written");
    let mut view = place.command(jde(&["view", "one"]));
    view.env("JDE_APP", "other").current_dir(place.folder());
    let refused = said(view.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY"));
    assert!(refused.err.contains("there is no screen"), "{refused:?}");
}

#[test]
fn without_a_graphics_card_it_says_what_to_install() {
    let Some(screen) = Screen::new() else { return };
    let place = Place::new();
    let mut view = place.command(jde(&["view"]));
    let refused = said(
        view.env("DISPLAY", &screen.name)
            .env_remove("WAYLAND_DISPLAY")
            // A backend of another system, so that no adapter can draw here.
            .env("WGPU_BACKEND", "dx12"),
    );
    assert_eq!(refused.status, Some(1), "{refused:?}");
    assert!(
        refused.err.contains("apt install mesa-vulkan-drivers"),
        "{refused:?}"
    );
}
