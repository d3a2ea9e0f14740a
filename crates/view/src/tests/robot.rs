//! Sensors and motors on real robots: sensor data is shown, a pad drives, and its release returns control.

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
use crate::session::Session;
use crate::style::{Style, Units};
use crate::window::Window as _;
use crate::window::robot::RobotWindow as Shown;
use crate::window::robot::fixture;

/// Maximum number of polls for a state of the robot: minutes, on any machine.
const LOOKS: usize = 2_000_000;

struct Desk {
    session: Session,
    window: Shown,
}

type Looking = Harness<'static, Desk>;

fn look(robot: &Robot) -> Looking {
    look_with(robot, &serde_json::Value::Null)
}

/// Opens the window with its saved state.
fn look_with(robot: &Robot, kept: &serde_json::Value) -> Looking {
    let workspace = Desk {
        session: robot.session(),
        window: Shown::open(kept),
    };
    let show = |ui: &mut egui::Ui, workspace: &mut Desk| {
        workspace.session.begin_frame();
        let style = Style::of(ui.ctx(), Units::default());
        workspace.window.show(ui, &workspace.session, &style);
    };
    Harness::builder()
        .with_size([900.0, 600.0])
        .build_ui_state(show, workspace)
}

/// Switches driving on. Returns the rectangle of the pad.
fn at_the_pad(harness: &mut Looking) -> Rect {
    until(harness, |harness| harness.query_by_label("Drive").is_some());
    assert!(harness.query_by_label("Drive pad").is_none(), "off at first");
    until(harness, |harness| {
        // New rows may have moved the switch away from the pointer.
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
    view.expect("it is in the application").state
}

fn turns_left(handle: &Handle) -> bool {
    let odometry: Option<Odometry> = handle.value("pioneer.odometry").expect("it is exported");
    odometry.is_some_and(|odometry| {
        let twist = odometry.twist.twist;
        twist.angular.z > 0.3 && twist.linear.x.abs() < 0.02
    })
}

fn says(harness: &Harness<'_, Desk>, words: &str) -> bool {
    harness.query_by_label_contains(words).is_some()
}

/// Waits until the pad drives: the robot turns on the spot, which `example` does not do on its way.
fn drives(harness: &mut Looking, handle: &Handle) {
    until(harness, |_| {
        state(handle, "teleop") == State::Winner && turns_left(handle)
    });
    until(harness, |harness| says(harness, "driving: "));
}

fn given_back(harness: &mut Looking, handle: &Handle) {
    until(harness, |_| state(handle, "example") == State::Winner);
    assert_ne!(state(handle, "teleop"), State::Winner);
    until(harness, |harness| says(harness, "example has control"));
    let snapshot = handle.snapshot();
    let teleop = snapshot.schemas.iter().find(|view| view.name == "teleop");
    assert_eq!(
        teleop.and_then(|view| view.operator.clone()),
        None,
        "nobody holds it"
    );
}

/// Gives the focus to a pad. One frame later, the arrow keys no longer move the focus elsewhere.
fn focus(harness: &mut Looking, pad: &str) {
    until(harness, |harness| harness.query_by_label(pad).is_some());
    harness.get_by_label(pad).focus();
    until(harness, |harness| harness.get_by_label(pad).is_focused());
    harness.run_steps(2);
}

fn push_left(harness: &mut Looking, pad: Rect) {
    harness.drag_at(pad.center());
    harness.step();
    harness.hover_at(pad.center() - vec2(0.49 * pad.width(), 0.0));
    harness.step();
}

/// A robot that is driven with the pad, and the rectangle of the pad.
fn driving() -> (Robot, Looking, Rect) {
    let robot = Robot::of("safe-navigation");
    let mut harness = look(&robot);
    let pad = at_the_pad(&mut harness);
    push_left(&mut harness, pad);
    drives(&mut harness, &robot.handle());
    (robot, harness, pad)
}

#[test]
fn r13_a_hand_on_the_pad_drives_and_letting_go_gives_the_robot_back() {
    let (robot, mut harness, pad) = driving();
    harness.drop_at(pad.center());
    given_back(&mut harness, &robot.handle());
}

#[test]
fn keys_drive_while_the_pad_has_the_focus_and_no_longer() {
    let robot = Robot::of("safe-navigation");
    let handle = robot.handle();
    let mut harness = look(&robot);
    at_the_pad(&mut harness);
    focus(&mut harness, "Drive pad");
    harness.key_down(Key::ArrowLeft);
    drives(&mut harness, &handle);
    assert!(
        harness.get_by_label("Drive pad").is_focused(),
        "arrows drive, and do not move the focus"
    );
    harness.key_up(Key::ArrowLeft);
    given_back(&mut harness, &handle);
    // Standing still is a command too.
    harness.key_down(Key::Space);
    until(&mut harness, |_| state(&handle, "teleop") == State::Winner);
    until(&mut harness, |harness| says(harness, "driving: 0.00 m/s"));
    harness.key_up(Key::Space);
    given_back(&mut harness, &handle);
}

#[test]
fn a_tap_on_the_pad_gives_it_the_keyboard() {
    let robot = Robot::of("safe-navigation");
    let mut harness = look(&robot);
    let pad = at_the_pad(&mut harness);
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
fn a_window_that_loses_the_focus_lets_go_although_the_button_is_down() {
    let (robot, mut harness, _) = driving();
    harness.input_mut().focused = false;
    given_back(&mut harness, &robot.handle());
}

#[test]
fn the_switch_turned_off_lets_go() {
    let robot = Robot::of("safe-navigation");
    let handle = robot.handle();
    let mut harness = look(&robot);
    at_the_pad(&mut harness);
    focus(&mut harness, "Drive pad");
    harness.key_down(Key::ArrowLeft);
    drives(&mut harness, &handle);
    harness.get_by_label("Drive").click();
    given_back(&mut harness, &handle);
    assert!(harness.query_by_label("Drive pad").is_none());
}

#[test]
fn the_speed_that_was_chosen_is_kept_through_a_robot_that_is_slower() {
    let robot = Robot::of("safe-navigation");
    let mut harness = look_with(&robot, &serde_json::json!({ "speed": 0.4 }));
    at_the_pad(&mut harness);
    let speed = |harness: &Looking| harness.state().window.keep()["speed"].clone();
    assert_eq!(speed(&harness), 0.4, "its limits were waited for");
    let slider = |harness: &Harness<'_, Desk>| {
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
fn comes_back(handle: &Handle) {
    let back = (0..LOOKS).any(|_| {
        std::thread::yield_now();
        state(handle, "example") == State::Winner
    });
    assert!(back, "the robot was not given back");
}

#[test]
fn r14_a_viewer_that_freezes_with_a_hand_on_the_pad_drives_no_longer() {
    let (robot, _harness, _) = driving();
    comes_back(&robot.handle());
}

#[test]
fn a_window_that_is_closed_with_a_hand_on_the_pad_drives_no_longer() {
    let (robot, harness, _) = driving();
    drop(harness);
    comes_back(&robot.handle());
}

/// As with a viewer that is killed: its lease is not renewed, and its wanted value grows old.
#[test]
fn r14_a_wish_that_nobody_renews_ends_with_or_without_its_lease() {
    let robot = Robot::of("safe-navigation");
    let handle = robot.handle();
    let client = Client::connect(&robot.reach()).expect("it is there");
    let remote = client.application(None).expect("it answers");
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
        remote.operate(&request).expect("it may");
        let won = (0..LOOKS).any(|_| {
            std::thread::yield_now();
            state(&handle, "teleop") == State::Winner
        });
        assert!(won, "it drives at first");
        comes_back(&handle);
    }
}

#[test]
fn what_the_robot_senses_is_told_in_numbers_and_in_words() {
    let robot = Robot::of("safe-navigation");
    let mut harness = look(&robot);
    for words in ["none pressed", "left ", "ahead, level", "nearest "] {
        until(&mut harness, |harness| {
            harness.query_all_by_label_contains(words).next().is_some()
        });
    }
    until(&mut harness, |harness| {
        harness.query_by_role(egui::Role::ProgressIndicator).is_some()
    });
    until(&mut harness, |harness| {
        says(harness, "no camera in this application")
    });
    assert!(
        harness.query_by_label("around the robot").is_some(),
        "the plane has a name"
    );
}

#[test]
fn the_picture_of_a_camera_is_shown_and_a_head_is_turned_by_its_pad() {
    let robot = Robot::of("follow-ball");
    let handle = robot.handle();
    let mut harness = look(&robot);
    until(&mut harness, |harness| {
        harness.query_by_label("picture of camera.image").is_some()
    });
    at_the_pad(&mut harness);
    focus(&mut harness, "Look pad");
    harness.key_down(Key::ArrowUp);
    until(&mut harness, |_| {
        let head: Option<PanTilt> = handle.value("pioneer.pan_tilt").expect("it is exported");
        state(&handle, "gaze") == State::Winner && head.is_some_and(|head| head.tilt < -0.1)
    });
    harness.key_up(Key::ArrowUp);
    until(&mut harness, |_| state(&handle, "follower") == State::Winner);
}

#[test]
fn an_application_that_nobody_can_drive_says_how_to_let_one() {
    let robot = Robot::of("family");
    let mut harness = look(&robot);
    until(&mut harness, |harness| {
        says(harness, "Nobody can drive this application by hand")
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
    assert!(shown, "the lines that are missing");
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
fn a_laser_that_is_taken_back_is_shown_as_none_and_comes_back() {
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&EYE).expect("it is well formed");
    let robot = Robot::linked(EYED, plugins);
    let mut harness = look(&robot);
    until(&mut harness, |harness| says(harness, "nearest 1.00 m"));
    let cover = |harness: &Looking, sees: bool| {
        harness.state().session.act(Action::Modulate {
            schema: "eye".to_owned(),
            variable: "sees".to_owned(),
            value: sees.into(),
        });
    };
    cover(&harness, false);
    until(&mut harness, |harness| {
        says(harness, "no value: eye has none now")
    });
    assert!(!says(&harness, "nearest"), "what it no longer says is not shown");
    cover(&harness, true);
    until(&mut harness, |harness| says(harness, "nearest 1.00 m"));
}

#[test]
fn a_driver_that_nobody_needs_is_said_to_sleep_and_can_be_played() {
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&EYE).expect("it is well formed");
    let lone = "name = \"lone\"\nroots = [\"watcher\"]\n[schemas.eye]\ntype = \"eye/eye\"\n[schemas.other]\ntype = \"eye/eye\"\n\
                [schemas.watcher]\ntype = \"eye/watcher\"\nimports = { laser = \"other.laser\" }\n";
    let robot = Robot::linked(lone, plugins);
    let handle = robot.handle();
    let mut harness = look(&robot);
    until(&mut harness, |harness| {
        harness.query_by_label("Play eye").is_some()
    });
    assert!(says(&harness, "eye sleeps"));
    until(&mut harness, |harness| {
        // A new row may have moved the button away from the pointer.
        if let Some(play) = harness.query_by_label("Play eye") {
            play.click();
            harness.run_steps(4);
        }
        state(&handle, "eye") == State::Winner
    });
    until(&mut harness, |harness| says(harness, "nearest 1.00 m"));
}

fn pictured(theme: Theme, name: &str) {
    let show = |ui: &mut egui::Ui, scene: &mut fixture::FixedRobot| {
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
fn a_fixed_scene_looks_as_it_should_in_the_dark() {
    pictured(Theme::Dark, "robot_dark");
}

#[test]
fn a_fixed_scene_looks_as_it_should_in_the_light() {
    pictured(Theme::Light, "robot_light");
}

#[test]
fn the_plane_is_turned_to_the_floor_by_its_button() {
    let robot = Robot::of("safe-navigation");
    let mut harness = look(&robot);
    until(&mut harness, |harness| harness.query_by_label("Floor").is_some());
    assert!(harness.query_by_label("Follow").is_none());
    harness.get_by_label("Floor").click();
    until(&mut harness, |harness| harness.query_by_label("Follow").is_some());
    harness.key_press_modifiers(Modifiers::NONE, Key::Escape);
    let kept = harness.state().window.keep();
    assert_eq!(kept["plane"]["ahead_up"], false, "kept for the next start");
}
