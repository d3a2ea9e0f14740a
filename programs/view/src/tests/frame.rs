//! The main window: the start page, the bar, tiles, saved layouts, and recordings.

use std::ffi::OsString;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use eframe::egui::{self, Role, Vec2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use jde_core::State;
use jde_host::Handle;
use jde_link::{Folders, Reach};
use jde_loader::{Plugins, SearchPath};
use jde_records::event::{Outcome, What};
use jde_schema::prelude::*;

use super::common::{Robot, until};
use crate::Opening;
use crate::app::App;
use crate::settings::SettingsStore;

pub(super) type Window = Harness<'static, Option<App>>;

pub(super) fn opening(reach: Reach, application: Option<&str>) -> Opening {
    Opening {
        reach,
        application: application.map(str::to_owned),
        recording: None,
        from: None,
        player: Vec::new(),
        recorder: Vec::new(),
        recordings: Vec::new(),
    }
}

pub(super) fn open(opening: Opening, store: Option<&Path>) -> Window {
    open_sized(opening, store, vec2(1200.0, 800.0))
}

pub(super) fn open_sized(opening: Opening, store: Option<&Path>, size: Vec2) -> Window {
    let store = SettingsStore::at(store.map(Path::to_owned));
    Harness::builder().with_size(size).build_ui_state(
        move |ui, app: &mut Option<App>| {
            app.get_or_insert_with(|| App::new(ui.ctx(), opening.clone(), store.clone()))
                .frame(ui);
        },
        None,
    )
}

/// Opens the main window on a robot.
pub(super) fn open_robot(robot: &Robot, store: Option<&Path>) -> Window {
    let mut window = open(opening(robot.reach(), Some("safe-navigation")), store);
    until(&mut window, |window| has(window, "Oscilloscope"));
    window
}

pub(super) fn has(window: &Harness<'_, Option<App>>, label: &str) -> bool {
    window.query_all_by_label(label).next().is_some()
}

pub(super) fn has_text(window: &Harness<'_, Option<App>>, text: &str) -> bool {
    window.query_all_by_label_contains(text).next().is_some()
}

pub(super) fn click(window: &mut Window, label: &str) {
    window.get_by_label(label).click();
    window.run_steps(2);
}

pub(super) fn state(handle: &Handle, schema: &str) -> State {
    let snapshot = handle.snapshot();
    let view = snapshot.schemas.iter().find(|view| view.name == schema);
    view.expect("the application has the schema").state
}

#[test]
fn the_only_application_opens_at_once_and_again_from_the_start_page() {
    let robot = Robot::of("safe-navigation");
    let folder = tempfile::tempdir().expect("the folder is created");
    fs::write(folder.path().join("drive.mcap"), [0; 2048]).expect("the file is written");
    fs::write(folder.path().join("notes.txt"), "no recording").expect("the file is written");
    let mut opening = opening(robot.reach(), None);
    opening.recordings = vec![folder.path().to_owned()];
    let mut window = open(opening, None);
    until(&mut window, |window| has(window, "Oscilloscope"));
    click(&mut window, "Applications");
    until(&mut window, |window| {
        window
            .query_by_role_and_label(Role::Link, "safe-navigation")
            .is_some()
    });
    assert!(has(&window, "drive.mcap") && has(&window, "2.0 kB"));
    assert!(!has(&window, "notes.txt"));
    window
        .get_by_role_and_label(Role::Link, "safe-navigation")
        .click();
    until(&mut window, |window| has(window, "Oscilloscope"));
}

#[test]
fn the_start_page_says_who_acts_and_stops_one_application() {
    let robot = Robot::of("safe-navigation");
    let mut window = open_robot(&robot, None);
    click(&mut window, "Applications");
    until(&mut window, |window| {
        has_text(window, "example > ") && has_text(window, "under way, ")
    });
    click(&mut window, "stop safe-navigation");
    until(&mut window, |_| state(&robot.handle(), "example") == State::Slept);
    until(&mut window, |window| has(window, "nobody"));
}

#[test]
fn a_visit_to_the_applications_loses_nothing() {
    let robot = Robot::of("safe-navigation");
    let mut window = open_robot(&robot, None);
    until(&mut window, |window| has(window, "Pause"));
    click(&mut window, "Pause");
    click(&mut window, "Applications");
    until(&mut window, |window| !has(window, "Oscilloscope"));
    // What is known of the application arrives meanwhile and moves the link: a click may come too late for its place.
    until(&mut window, |window| {
        if let Some(link) = window.query_by_role_and_label(Role::Link, "safe-navigation") {
            link.click();
        }
        has(window, "Oscilloscope")
    });
    // The windows are those that were left, with all that they have received.
    assert!(has(&window, "Run") && !has(&window, "Pause"));
}

#[test]
fn a_lost_application_stays_visible_and_can_be_reopened_when_it_runs_again() {
    let robot = Robot::of("safe-navigation");
    let announcement_folder = tempfile::tempdir().expect("the folder is created");
    let reach = Reach::Local(Folders::at(announcement_folder.path().join("jde")));
    let settings = jde_link::Settings {
        folder: Folders::at(announcement_folder.path().join("jde")),
        ..jde_link::Settings::local("robot")
    };
    let first = robot.serve(&settings);
    let mut window = open(opening(reach, Some("robot")), None);
    until(&mut window, |window| has(window, "Oscilloscope"));
    drop(first);
    until(&mut window, |window| has(window, "lost"));
    assert!(has(&window, "Oscilloscope") && !has_text(&window, "runs again"));
    let second = robot.serve(&settings);
    until(&mut window, |window| has(window, "It runs again: open it"));
    click(&mut window, "It runs again: open it");
    until(&mut window, |window| {
        has(window, "Oscilloscope") && !has(window, "lost")
    });
    drop(second);
}

#[test]
fn an_application_that_has_ended_says_how_and_its_time_stands_still() {
    let robot = Robot::of("safe-navigation");
    let announcement_folder = tempfile::tempdir().expect("the folder is created");
    let folder = Folders::at(announcement_folder.path().join("jde"));
    let settings = jde_link::Settings {
        folder: folder.clone(),
        ..jde_link::Settings::local("robot")
    };
    let events = jde_link::Events::of_records();
    let link = robot.serve_with(&settings, &events);
    let mut window = open(opening(Reach::Local(folder), Some("robot")), None);
    until(&mut window, |window| has(window, "Oscilloscope"));
    // Its clock goes on, as where an application stays on a screen after its end.
    until(&mut window, |_| robot.handle().now() > 1_000_000_000);
    let outcome = Outcome::Done;
    events.push(What::Ended { outcome }.at(1_000_000_000).into());
    until(&mut window, |window| has(window, "done") && has(window, "1.0 s"));
    until(&mut window, |_| robot.handle().now() > 2_000_000_000);
    window.run_steps(2);
    assert!(has(&window, "1.0 s"));
    drop(link);
    window.run_steps(2);
    assert!(has(&window, "done") && !has(&window, "lost"));
}

#[test]
fn the_start_page_reports_that_an_application_does_not_exist() {
    let folder = tempfile::tempdir().expect("the folder is created");
    let reach = Reach::Local(Folders::at(folder.path().join("jde")));
    let mut window = open(opening(reach, Some("missing")), None);
    until(&mut window, |window| {
        has_text(window, "no application is called `missing`") && has(window, "Recordings")
    });
}

#[test]
fn the_layout_is_restored_and_an_unreadable_layout_file_is_renamed() {
    let robot = Robot::of("safe-navigation");
    let folder = tempfile::tempdir().expect("the folder is created");
    let mut window = open_robot(&robot, Some(folder.path()));
    assert!(has(&window, "3D") && has(&window, "Sensors and motors"));
    click(&mut window, "Windows");
    window.get_by_role_and_label(Role::CheckBox, "3D").click();
    window.run_steps(2);
    drop(window);
    let window = open_robot(&robot, Some(folder.path()));
    assert!(!has(&window, "3D") && has(&window, "Sensors and motors"));
    drop(window);

    let layout_file = folder.path().join("desk-safe-navigation.json");
    fs::write(&layout_file, "{ tree").expect("the file is written");
    let window = open_robot(&robot, Some(folder.path()));
    assert!(has(&window, "3D"), "the default layout");
    let renamed = fs::read_to_string(layout_file.with_extension("unreadable"));
    assert_eq!(renamed.expect("the renamed file is kept"), "{ tree");
}

#[test]
fn the_plot_button_of_a_variable_adds_a_trace() {
    let robot = Robot::of("safe-navigation");
    let mut window = open_robot(&robot, None);
    click(&mut window, "Variables");
    until(&mut window, |window| has(window, "Search"));
    window.get_by_label("Search").click();
    window.step();
    window.get_by_label("Search").type_text("goon.");
    until(&mut window, |window| has(window, "plot goon.fast"));
    click(&mut window, "plot goon.fast");
    until(&mut window, |window| has_text(window, "trace goon.fast: 0."));
    assert!(
        has(&window, "Remove trace goon.fast"),
        "the oscilloscope is in front"
    );
}

#[test]
fn cancel_stops_the_opening_of_a_recording_and_ends_its_player() {
    let folder = tempfile::tempdir().expect("the folder is created");
    let pid_file = folder.path().join("pid");
    let script = format!(
        "echo $$ > {0}.part; mv {0}.part {0}; exec cat",
        pid_file.display()
    );
    let mut opening = opening(Reach::Local(Folders::at(folder.path().to_owned())), None);
    opening.recording = Some(PathBuf::from("long.mcap"));
    opening.player = ["sh", "-c", &script].map(OsString::from).to_vec();
    let mut window = open(opening, None);
    until(&mut window, |window| {
        has(window, "Opening long.mcap") && pid_file.exists()
    });
    let player = fs::read_to_string(&pid_file).expect("the player wrote its process ID");
    let player = Path::new("/proc").join(player.trim());
    assert!(player.exists(), "the player runs");
    click(&mut window, "Cancel");
    until(&mut window, |window| {
        has(window, "Recordings") && !player.exists()
    });
}

/// A substitute for the schema that controls the playback of a recording.
#[derive(Describe)]
#[schema(motor, period = "20ms")]
#[expect(dead_code, reason = "only the window reads and writes them")]
struct Tape {
    /// The position.
    #[modulation(default = 10.0, unit = "s", min = 5.0, max = 100.0)]
    position: Modulation<f64>,
    /// Whether it is paused.
    #[modulation(default = Flag::TRUE)]
    paused: Modulation<Flag>,
    /// Seconds of the recording per second.
    #[modulation(default = 1.0, min = 0.1, max = 10.0)]
    speed: Modulation<f64>,
    /// Why the recording is damaged.
    #[export]
    damage: Export<Text<256>>,
    /// What is not played.
    #[export]
    left_out: Export<Text<1020>>,
}

impl Schema for Tape {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.damage.write(cx, Text::new("it ends too soon, at byte 7"));
        self.left_out
            .write(cx, Text::new("/notes is left out: its type is not known"));
        Ok(())
    }
}

static TAPE: jde_abi::raw::Plugin = jde_schema::plugin!("tape", "Controls a recording.", [Tape]);

const TAPED: &str = "name = \"taped\"\nroots = [\"replay\"]\n[schemas.replay]\ntype = \"tape/tape\"\n";

#[test]
fn space_pauses_a_recording_and_its_slider_seeks_and_stays_at_the_sought_position() {
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&TAPE).expect("the plugin is well formed");
    let tape = Robot::recorded(TAPED, plugins);
    let handle = tape.handle();
    let mut window = open(opening(tape.reach(), Some("taped")), None);
    until(&mut window, |window| {
        has(window, "Play") && has(window, "10.00 s")
    });
    assert!(!has(&window, "Stop everything"), "a recording moves nothing");
    window.key_press(eframe::egui::Key::Space);
    window.run_steps(2);
    let paused = || {
        let flag: Option<Flag> = handle.value("replay.paused").expect("the variable exists");
        flag.is_some_and(Flag::get)
    };
    until(&mut window, |window| !paused() && has(window, "Pause"));
    // In the oscilloscope, the key would have paused the picture.
    assert!(!has(&window, "Run"));

    let slider = "Position in the recording";
    let rect = window.get_by_label(slider).rect();
    let seek_position = |window: &Harness<'_, Option<App>>| {
        let slider = window.get_by_label(slider);
        slider
            .accesskit_node()
            .numeric_value()
            .expect("the slider has a number")
    };
    let end = rect.right_center() - vec2(1.0, 0.0);
    window.hover_at(rect.center());
    window.step();
    window.drag_at(rect.center());
    window.step();
    window.hover_at(end);
    window.step();
    let sought = seek_position(&window);
    assert!(sought > 90.0, "{sought}");
    window.drop_at(end);
    let position = || {
        let position: Option<f64> = handle.value("replay.position").expect("the variable exists");
        position.expect("the position has a value")
    };
    until(&mut window, |window| {
        assert_eq!(seek_position(window), sought, "the slider does not jump back");
        position() == sought
    });
    let shown = format!("{sought:.2} s");
    until(&mut window, |window| {
        assert_eq!(seek_position(window), sought);
        has(window, &shown)
    });
    until(&mut window, |window| has(window, "cut off"));
    until(&mut window, |window| has(window, "a part is not played"));
    // The left end is the beginning of the recording, at 5 s, and not the start of its application.
    let start = window.get_by_label(slider).rect().left_center() + vec2(1.0, 0.0);
    window.hover_at(start);
    window.step();
    window.drag_at(start);
    window.drop_at(start);
    window.step();
    until(&mut window, |_| position() == 5.0);
    // A tap within one frame works as a drag does.
    let middle = window.get_by_label(slider).rect().center();
    window.hover_at(middle);
    window.step();
    for pressed in [true, false] {
        window.input_mut().events.push(egui::Event::PointerButton {
            pos: middle,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: egui::Modifiers::NONE,
        });
    }
    window.step();
    until(&mut window, |_| (50.0..55.0).contains(&position()));
}

/// A separate process that serves a robot. It is killed when dropped.
pub(super) struct ServerProcess(Child);

/// Environment variable that makes [`an_application_prints_the_folder_of_its_announcement`] serve until its
/// input ends.
const SERVES: &str = "JDE_TEST_SERVES";

impl ServerProcess {
    /// Starts the process. Returns it and where tools find its application.
    pub(super) fn start() -> (Self, Reach) {
        let mut child = Command::new(std::env::current_exe().expect("the path of this program is known"))
            .args([
                "--nocapture",
                "--exact",
                "tests::frame::an_application_prints_the_folder_of_its_announcement",
            ])
            .env(SERVES, "1")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the process starts");
        let output = BufReader::new(child.stdout.take().expect("the output is piped"));
        let announcement_folder = output
            .lines()
            .map_while(Result::ok)
            .find_map(|line| Some(line.split_once("served at ")?.1.to_owned()));
        let announcement_folder = announcement_folder.expect("the process prints the folder");
        (
            Self(child),
            Reach::Local(Folders::at(PathBuf::from(announcement_folder))),
        )
    }

    /// Sends a signal, such as `-STOP`.
    pub(super) fn signal(&self, signal: &str) {
        let sent = Command::new("kill")
            .args([signal, &self.0.id().to_string()])
            .status();
        assert!(sent.expect("kill starts").success());
    }
}

impl Drop for ServerProcess {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// [`ServerProcess`] runs this test in its process, and suspends it there.
#[test]
fn an_application_prints_the_folder_of_its_announcement() {
    let robot = Robot::of("safe-navigation");
    assert!(robot.announcement_folder().exists());
    println!("\nserved at {}", robot.announcement_folder().display());
    if std::env::var_os(SERVES).is_some() {
        let _ = std::io::stdin().lock().read_to_end(&mut Vec::new());
    }
}

#[test]
fn a_suspended_application_is_shown_as_silent_and_not_as_live() {
    // Builds the plugins in this process, so that the other one does not have to.
    drop(super::common::plugins());
    let (server, reach) = ServerProcess::start();
    let mut window = open(opening(reach, Some("safe-navigation")), None);
    until(&mut window, |window| has_text(window, "live"));
    assert!(!has_text(&window, "no news for"));
    server.signal("-STOP");
    until(&mut window, |window| has_text(window, "no news for"));
    assert!(!has_text(&window, "live"));
}
