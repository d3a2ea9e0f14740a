//! The window of sensors and motors on real robots: it shows sensor data, its pad drives, and a release of
//! the pad returns control.

use eframe::egui::accesskit::Toggled;
use eframe::egui::{self, Key, Modifiers, Rect, Theme, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use egui_kittest::{Harness, SnapshotOptions};
use jde_core::State;
use jde_host::Handle;
use jde_link::Client;
use jde_link::message::{Action, Request};
use jde_loader::{Plugins, SearchPath};
use jde_schema::prelude::*;

use super::common::{Robot, until};
use crate::session::WindowSession;
use crate::style::{Style, Units};
use crate::window::Window as _;
use crate::window::robot::RobotWindow as Shown;
use crate::window::robot::fixture;

/// Maximum number of polls for a state of the robot: minutes, on any machine.
const MAX_POLLS: usize = 2_000_000;

struct Fixture {
    session: WindowSession,
    window: Shown,
}

type RobotHarness = Harness<'static, Fixture>;

fn open(robot: &Robot) -> RobotHarness {
    open_with(robot, &serde_json::Value::Null)
}

/// Opens the window with its saved state.
fn open_with(robot: &Robot, saved: &serde_json::Value) -> RobotHarness {
    let fixture = Fixture {
        session: robot.session(),
        window: Shown::open(saved),
    };
    let show = |ui: &mut egui::Ui, fixture: &mut Fixture| {
        fixture.session.begin_frame();
        let style = Style::of(ui.ctx(), Units::default());
        fixture.window.show(ui, &fixture.session, &style);
    };
    Harness::builder()
        .with_size([900.0, 600.0])
        .build_ui_state(show, fixture)
}

/// Switches driving on. Returns the rectangle of the pad.
fn enable_driving(harness: &mut RobotHarness) -> Rect {
    until(harness, |harness| harness.query_by_label("Drive").is_some());
    assert!(
        harness.query_by_label("Drive pad").is_none(),
        "driving is off at first"
    );
    until(harness, |harness| {
        // New rows may move the switch away from the pointer.
        let drive = harness.get_by_label("Drive");
        if drive.accesskit_node().toggled() != Some(Toggled::True) {
            drive.click();
            harness.run_steps(4);
        }
        harness.query_by_label("Drive pad").is_some()
    });
    harness.step();
    harness.get_by_label("Drive pad").rect()
}

fn state(handle: &Handle, schema: &str) -> State {
    let snapshot = handle.snapshot();
    let view = snapshot.schemas.iter().find(|view| view.name == schema);
    view.expect("the application has the schema").state
}

fn is_turning_left(handle: &Handle) -> bool {
    let odometry: Option<Odometry> = handle
        .value("pioneer.odometry")
        .expect("the variable is exported");
    odometry.is_some_and(|odometry| {
        let twist = odometry.twist.twist;
        twist.angular.z > 0.3 && twist.linear.x.abs() < 0.02
    })
}

fn has_text(harness: &Harness<'_, Fixture>, text: &str) -> bool {
    harness.query_by_label_contains(text).is_some()
}

/// Waits until the pad drives: the robot turns on the spot, which `example` does not do on its way.
fn wait_until_driving(harness: &mut RobotHarness, handle: &Handle) {
    until(harness, |_| {
        state(handle, "teleop") == State::Winner && is_turning_left(handle)
    });
    until(harness, |harness| has_text(harness, "driving: "));
}

fn wait_until_returned(harness: &mut RobotHarness, handle: &Handle) {
    until(harness, |_| state(handle, "example") == State::Winner);
    assert_ne!(state(handle, "teleop"), State::Winner);
    until(harness, |harness| has_text(harness, "example has control"));
    let snapshot = handle.snapshot();
    let teleop = snapshot.schemas.iter().find(|view| view.name == "teleop");
    assert_eq!(
        teleop.and_then(|view| view.operator.clone()),
        None,
        "no operator holds teleop"
    );
}

/// Focuses a pad. One frame later, the arrow keys no longer move the focus to another widget.
fn focus(harness: &mut RobotHarness, pad: &str) {
    until(harness, |harness| harness.query_by_label(pad).is_some());
    harness.get_by_label(pad).focus();
    until(harness, |harness| harness.get_by_label(pad).is_focused());
    harness.run_steps(2);
}

fn push_left(harness: &mut RobotHarness, pad: Rect) {
    harness.drag_at(pad.center());
    harness.step();
    harness.hover_at(pad.center() - vec2(0.49 * pad.width(), 0.0));
    harness.step();
}

/// Returns a robot that the pad drives, its window, and the rectangle of the pad.
fn driving_robot() -> (Robot, RobotHarness, Rect) {
    let robot = Robot::of("safe-navigation");
    let mut harness = open(&robot);
    let pad = enable_driving(&mut harness);
    push_left(&mut harness, pad);
    wait_until_driving(&mut harness, &robot.handle());
    (robot, harness, pad)
}

#[test]
fn r13_the_pad_drives_while_it_is_pressed_and_its_release_returns_control() {
    let (robot, mut harness, pad) = driving_robot();
    harness.drop_at(pad.center());
    wait_until_returned(&mut harness, &robot.handle());
}

#[test]
fn keys_drive_only_while_the_pad_has_the_focus() {
    let robot = Robot::of("safe-navigation");
    let handle = robot.handle();
    let mut harness = open(&robot);
    enable_driving(&mut harness);
    focus(&mut harness, "Drive pad");
    harness.key_down(Key::ArrowLeft);
    wait_until_driving(&mut harness, &handle);
    assert!(
        harness.get_by_label("Drive pad").is_focused(),
        "arrow keys drive and do not move the focus"
    );
    harness.key_up(Key::ArrowLeft);
    wait_until_returned(&mut harness, &handle);
    // A standstill is a command too.
    harness.key_down(Key::Space);
    until(&mut harness, |_| state(&handle, "teleop") == State::Winner);
    until(&mut harness, |harness| has_text(harness, "driving: 0.00 m/s"));
    harness.key_up(Key::Space);
    wait_until_returned(&mut harness, &handle);
}

#[test]
fn a_tap_on_the_pad_focuses_it() {
    let robot = Robot::of("safe-navigation");
    let mut harness = open(&robot);
    let pad = enable_driving(&mut harness);
    harness.hover_at(pad.center());
    harness.step();
    // A tap within one frame, as on a trackpad.
    for pressed in [true, false] {
        harness.input_mut().events.push(egui::Event::PointerButton {
            pos: pad.center(),
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        });
    }
    harness.step();
    until(&mut harness, |harness| {
        harness.get_by_label("Drive pad").is_focused()
    });
}

#[test]
fn a_window_that_loses_the_focus_returns_control_although_the_button_is_down() {
    let (robot, mut harness, _) = driving_robot();
    harness.input_mut().focused = false;
    wait_until_returned(&mut harness, &robot.handle());
}

#[test]
fn switching_driving_off_returns_control() {
    let robot = Robot::of("safe-navigation");
    let handle = robot.handle();
    let mut harness = open(&robot);
    enable_driving(&mut harness);
    focus(&mut harness, "Drive pad");
    harness.key_down(Key::ArrowLeft);
    wait_until_driving(&mut harness, &handle);
    harness.get_by_label("Drive").click();
    wait_until_returned(&mut harness, &handle);
    assert!(harness.query_by_label("Drive pad").is_none());
}

#[test]
fn the_chosen_speed_is_kept_although_the_robot_limits_it() {
    let robot = Robot::of("safe-navigation");
    let mut harness = open_with(&robot, &serde_json::json!({ "speed": 0.4 }));
    enable_driving(&mut harness);
    let speed = |harness: &RobotHarness| harness.state().window.keep()["speed"].clone();
    assert_eq!(
        speed(&harness),
        0.4,
        "the chosen speed is kept until the limits are known"
    );
    let slider = |harness: &Harness<'_, Fixture>| {
        let slider = harness.get_by_role(egui::Role::Slider);
        slider.accesskit_node().numeric_value()
    };
    assert_eq!(slider(&harness), Some(0.4));
    let slower = Action::Modulate {
        schema: "teleop".to_owned(),
        variable: "fast".to_owned(),
        value: 0.2.into(),
    };
    harness.state().session.act(slower);
    until(&mut harness, |harness| slider(harness) == Some(0.2));
    assert_eq!(speed(&harness), 0.4);
}

/// Polls until `example` has control, without a step of any window.
fn assert_returned(handle: &Handle) {
    let returned = (0..MAX_POLLS).any(|_| {
        std::thread::yield_now();
        state(handle, "example") == State::Winner
    });
    assert!(returned, "`example` did not get control back");
}

#[test]
fn r14_a_viewer_that_freezes_while_the_pad_is_pressed_stops_driving() {
    let (robot, _harness, _) = driving_robot();
    assert_returned(&robot.handle());
}

#[test]
fn a_window_that_is_closed_while_the_pad_is_pressed_stops_driving() {
    let (robot, harness, _) = driving_robot();
    drop(harness);
    assert_returned(&robot.handle());
}

/// As after the death of a viewer: the lease is not renewed, and the value of `want` grows old.
#[test]
fn r14_a_command_that_is_not_renewed_ends_with_or_without_a_lease() {
    let robot = Robot::of("safe-navigation");
    let handle = robot.handle();
    let client = Client::connect(&robot.reach()).expect("the application is running");
    let remote = client.application(None).expect("the application replies");
    for lease_ms in [Some(600), None] {
        let value = serde_json::json!({ "twist": { "angular": { "z": 0.5 } }, "wanted": true });
        let request = Request {
            by: "ana@laptop".to_owned(),
            action: Action::Modulate {
                schema: "teleop".to_owned(),
                variable: "want".to_owned(),
                value,
            },
            lease_ms,
        };
        remote.operate(&request).expect("the request is accepted");
        let won = (0..MAX_POLLS).any(|_| {
            std::thread::yield_now();
            state(&handle, "teleop") == State::Winner
        });
        assert!(won, "`teleop` drives at first");
        assert_returned(&handle);
    }
}

#[test]
fn sensor_data_is_shown_as_numbers_and_text() {
    let robot = Robot::of("safe-navigation");
    let mut harness = open(&robot);
    for text in ["none pressed", "left ", "ahead, level", "nearest "] {
        until(&mut harness, |harness| {
            harness.query_all_by_label_contains(text).next().is_some()
        });
    }
    until(&mut harness, |harness| {
        harness.query_by_role(egui::Role::ProgressIndicator).is_some()
    });
    until(&mut harness, |harness| {
        has_text(harness, "no camera in this application")
    });
    assert!(
        harness.query_by_label("around the robot").is_some(),
        "the plane has a label"
    );
}

#[test]
fn the_camera_image_is_shown_and_the_look_pad_turns_the_head() {
    let robot = Robot::of("follow-ball");
    let handle = robot.handle();
    let mut harness = open(&robot);
    until(&mut harness, |harness| {
        harness.query_by_label("picture of camera.image").is_some()
    });
    enable_driving(&mut harness);
    focus(&mut harness, "Look pad");
    harness.key_down(Key::ArrowUp);
    until(&mut harness, |_| {
        let head: Option<PanTilt> = handle
            .value("pioneer.pan_tilt")
            .expect("the variable is exported");
        state(&handle, "gaze") == State::Winner && head.is_some_and(|head| head.tilt < -0.1)
    });
    harness.key_up(Key::ArrowUp);
    until(&mut harness, |_| state(&handle, "follower") == State::Winner);
}

#[test]
fn an_application_without_teleoperation_shows_the_lines_that_add_it() {
    let robot = Robot::of("family");
    let mut harness = open(&robot);
    until(&mut harness, |harness| {
        has_text(harness, "This application cannot be driven by hand")
    });
    let lines = "roots = [\"teleop\", \"padre\"]\n\n[schemas.teleop]\ntype      = \"teleop/base\"\n\
                 actuators = { base = \"pioneer.velocity\" }\n";
    let shown = harness
        .get_all_by_role(egui::Role::MultilineTextInput)
        .any(|node| {
            node.accesskit_node()
                .value()
                .is_some_and(|value| value.trim() == lines.trim())
        });
    assert!(shown, "the window shows the missing lines");
    harness.get_by_label("Copy").click();
    harness.step();
    let copied = |command: &egui::OutputCommand| matches!(command, egui::OutputCommand::CopyText(text) if text == lines);
    assert!(harness.output().platform_output.commands.iter().any(copied));
}

/// A laser that can be covered.
#[derive(Describe)]
#[schema(driver, period = "20ms")]
struct Eye {
    /// Whether it is uncovered.
    #[modulation(default = Flag::TRUE)]
    sees: Modulation<Flag>,
    /// The scan.
    #[export]
    laser: Export<LaserScan>,
}

impl Schema for Eye {
    fn iterate(&mut self, cx: &Context) -> Result {
        if !self.sees.get(cx).get() {
            self.laser.retract(cx);
            return Ok(());
        }
        self.laser.write(cx, fixture::scan());
        Ok(())
    }
}

/// Keeps the laser awake.
#[derive(Describe)]
#[schema(motor, period = "100ms")]
struct Watcher {
    /// The scan.
    #[import]
    laser: Import<LaserScan>,
}

impl Schema for Watcher {
    fn iterate(&mut self, cx: &Context) -> Result {
        let _ = self.laser.get(cx);
        Ok(())
    }
}

static EYE: jde_abi::raw::Plugin = jde_schema::plugin!("eye", "A laser that can be covered.", [Eye, Watcher]);

const EYED: &str = r#"
name  = "eyed"
roots = ["watcher"]

[schemas.eye]
type = "eye/eye"

[schemas.watcher]
type    = "eye/watcher"
imports = { laser = "eye.laser" }
"#;

#[test]
fn a_retracted_scan_is_no_longer_shown_until_the_next_one() {
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&EYE).expect("the plugin is well formed");
    let robot = Robot::linked(EYED, plugins);
    let mut harness = open(&robot);
    until(&mut harness, |harness| has_text(harness, "nearest 1.00 m"));
    let cover = |harness: &RobotHarness, sees: bool| {
        harness.state().session.act(Action::Modulate {
            schema: "eye".to_owned(),
            variable: "sees".to_owned(),
            value: sees.into(),
        });
    };
    cover(&harness, false);
    until(&mut harness, |harness| {
        has_text(harness, "no value from eye any more")
    });
    assert!(!has_text(&harness, "nearest"), "the retracted scan is not shown");
    cover(&harness, true);
    until(&mut harness, |harness| has_text(harness, "nearest 1.00 m"));
}

#[test]
fn an_unused_driver_is_shown_as_asleep_and_can_be_played() {
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&EYE).expect("the plugin is well formed");
    let lone = "name = \"lone\"\nroots = [\"watcher\"]\n[schemas.eye]\ntype = \"eye/eye\"\n[schemas.other]\ntype = \"eye/eye\"\n\
                [schemas.watcher]\ntype = \"eye/watcher\"\nimports = { laser = \"other.laser\" }\n";
    let robot = Robot::linked(lone, plugins);
    let handle = robot.handle();
    let mut harness = open(&robot);
    until(&mut harness, |harness| {
        harness.query_by_label("Play eye").is_some()
    });
    assert!(has_text(&harness, "eye sleeps"));
    until(&mut harness, |harness| {
        // A new row may move the button away from the pointer.
        if let Some(play) = harness.query_by_label("Play eye") {
            play.click();
            harness.run_steps(4);
        }
        state(&handle, "eye") == State::Winner
    });
    until(&mut harness, |harness| has_text(harness, "nearest 1.00 m"));
}

fn assert_snapshot(theme: Theme, name: &str) {
    let show = |ui: &mut egui::Ui, scene: &mut fixture::FixedRobot| {
        crate::style::install(ui.ctx());
        let style = Style::of(ui.ctx(), Units::default());
        scene.show(ui, &style);
    };
    let mut harness = Harness::builder()
        .with_size([860.0, 520.0])
        .with_theme(theme)
        .build_ui_state(show, fixture::FixedRobot::new());
    harness.run();
    harness.snapshot_options(name, &SnapshotOptions::new().threshold(1.5).max_failed_pixels(60));
}

#[test]
fn a_fixed_scene_matches_its_snapshot_in_the_dark_theme() {
    assert_snapshot(Theme::Dark, "robot_dark");
}

#[test]
fn a_fixed_scene_matches_its_snapshot_in_the_light_theme() {
    assert_snapshot(Theme::Light, "robot_light");
}

#[test]
fn the_floor_button_turns_the_plane_to_the_floor() {
    let robot = Robot::of("safe-navigation");
    let mut harness = open(&robot);
    until(&mut harness, |harness| harness.query_by_label("Floor").is_some());
    assert!(harness.query_by_label("Follow").is_none());
    harness.get_by_label("Floor").click();
    until(&mut harness, |harness| harness.query_by_label("Follow").is_some());
    harness.key_press_modifiers(Modifiers::NONE, Key::Escape);
    let saved = harness.state().window.keep();
    assert_eq!(saved["plane"]["ahead_up"], false, "saved for the next start");
}
