//! The main window: the start page, the bar, tiles, saved layouts, and recordings.

use std::ffi::OsString;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use eframe::egui::{self, Role, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use jde_core::State;
use jde_host::Handle;
use jde_link::{Folders, Reach};
use jde_loader::{Plugins, SearchPath};
use jde_records::snapshot::HoldKind;
use jde_schema::prelude::*;

use super::common::{Robot, until};
use crate::Opening;
use crate::app::App;
use crate::settings::SettingsStore;

type Window = Harness<'static, Option<App>>;

fn opening(reach: Reach, application: Option<&str>) -> Opening {
    Opening {
        reach,
        application: application.map(str::to_owned),
        recording: None,
        player: Vec::new(),
        recordings: Vec::new(),
    }
}

fn open(opening: Opening, store: Option<&Path>) -> Window {
    let store = SettingsStore::at(store.map(Path::to_owned));
    Harness::builder().with_size([1200.0, 800.0]).build_ui_state(
        move |ui, app: &mut Option<App>| {
            app.get_or_insert_with(|| App::new(ui.ctx(), opening.clone(), store.clone()))
                .frame(ui);
        },
        None,
    )
}

/// Opens the windows on a robot.
fn desk(robot: &Robot, store: Option<&Path>) -> Window {
    let mut window = open(opening(robot.reach(), Some("safe-navigation")), store);
    until(&mut window, |window| has(window, "Oscilloscope"));
    window
}

fn has(window: &Harness<'_, Option<App>>, label: &str) -> bool {
    window.query_all_by_label(label).next().is_some()
}

fn says(window: &Harness<'_, Option<App>>, words: &str) -> bool {
    window.query_all_by_label_contains(words).next().is_some()
}

fn click(window: &mut Window, label: &str) {
    window.get_by_label(label).click();
    window.run_steps(2);
}

fn state(handle: &Handle, schema: &str) -> State {
    let snapshot = handle.snapshot();
    let view = snapshot.schemas.iter().find(|view| view.name == schema);
    view.expect("it is in the application").state
}

#[test]
fn the_only_application_is_opened_at_once_and_left_for_the_start_page_which_opens_it_again() {
    let robot = Robot::of("safe-navigation");
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("drive.mcap"), [0; 2048]).expect("it can be written");
    fs::write(folder.path().join("notes.txt"), "no recording").expect("it can be written");
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
fn an_application_that_died_is_shown_as_it_was_and_opened_again_once_it_runs_again() {
    let robot = Robot::of("safe-navigation");
    let place = tempfile::tempdir().expect("a folder");
    let reach = Reach::Local(Folders::at(place.path().join("jde")));
    let settings = jde_link::Settings {
        folder: Folders::at(place.path().join("jde")),
        ..jde_link::Settings::local("robot")
    };
    let first = robot.serve(&settings);
    let mut window = open(opening(reach, Some("robot")), None);
    until(&mut window, |window| has(window, "Oscilloscope"));
    drop(first);
    until(&mut window, |window| has(window, "gone"));
    assert!(has(&window, "Oscilloscope") && !says(&window, "runs again"));
    let second = robot.serve(&settings);
    until(&mut window, |window| has(window, "It runs again: open it"));
    click(&mut window, "It runs again: open it");
    until(&mut window, |window| {
        has(window, "Oscilloscope") && !has(window, "gone")
    });
    drop(second);
}

#[test]
fn an_application_that_is_not_there_is_said_on_the_start_page() {
    let folder = tempfile::tempdir().expect("a folder");
    let reach = Reach::Local(Folders::at(folder.path().join("jde")));
    let mut window = open(opening(reach, Some("nobody")), None);
    until(&mut window, |window| {
        says(window, "no application is called `nobody`") && has(window, "Recordings")
    });
}

#[test]
fn r14_everything_is_stopped_by_one_button_and_goes_on_by_the_next() {
    let robot = Robot::of("safe-navigation");
    let handle = robot.handle();
    let mut window = desk(&robot, None);
    until(&mut window, |_| state(&handle, "example") == State::Winner);
    click(&mut window, "Stop everything");
    until(&mut window, |_| {
        let snapshot = handle.snapshot();
        ["example", "teleop"].iter().all(|root| {
            let view = snapshot.schemas.iter().find(|view| view.name == *root);
            let hold = view.and_then(|view| view.operator.as_ref());
            hold.is_some_and(|hold| hold.kind == HoldKind::Stopped && hold.by == jde_link::operator())
        })
    });
    for below in ["goon", "vff", "stop"] {
        assert_eq!(state(&handle, below), State::Slept, "{below} acts no more");
    }
    until(&mut window, |window| has(window, "Let it go on"));
    click(&mut window, "Let it go on");
    until(&mut window, |_| state(&handle, "example") == State::Winner);
}

#[test]
fn windows_are_as_they_were_left_and_a_desk_that_cannot_be_read_is_put_aside() {
    let robot = Robot::of("safe-navigation");
    let folder = tempfile::tempdir().expect("a folder");
    let mut window = desk(&robot, Some(folder.path()));
    assert!(has(&window, "3D") && has(&window, "Sensors and motors"));
    click(&mut window, "Windows");
    window.get_by_role_and_label(Role::CheckBox, "3D").click();
    window.run_steps(2);
    drop(window);
    let window = desk(&robot, Some(folder.path()));
    assert!(!has(&window, "3D") && has(&window, "Sensors and motors"));
    drop(window);

    let desk_file = folder.path().join("desk-safe-navigation.json");
    fs::write(&desk_file, "{ tree").expect("it can be written");
    let window = desk(&robot, Some(folder.path()));
    assert!(has(&window, "3D"), "as they usually are");
    let aside = fs::read_to_string(desk_file.with_extension("unreadable"));
    assert_eq!(aside.expect("it is kept"), "{ tree");
}

#[test]
fn a_number_of_the_variables_is_shown_over_time_by_its_button() {
    let robot = Robot::of("safe-navigation");
    let mut window = desk(&robot, None);
    click(&mut window, "Variables");
    until(&mut window, |window| has(window, "Search"));
    window.get_by_label("Search").click();
    window.step();
    window.get_by_label("Search").type_text("goon.");
    until(&mut window, |window| has(window, "plot goon.fast"));
    click(&mut window, "plot goon.fast");
    until(&mut window, |window| says(window, "trace goon.fast: 0."));
    assert!(
        has(&window, "Remove trace goon.fast"),
        "the oscilloscope is in front"
    );
}

#[test]
fn a_recording_that_takes_too_long_is_cancelled_and_its_player_ends() {
    let folder = tempfile::tempdir().expect("a folder");
    let told = folder.path().join("pid");
    let script = format!("echo $$ > {0}.part; mv {0}.part {0}; exec cat", told.display());
    let mut opening = opening(Reach::Local(Folders::at(folder.path().to_owned())), None);
    opening.recording = Some(PathBuf::from("long.mcap"));
    opening.player = ["sh", "-c", &script].map(OsString::from).to_vec();
    let mut window = open(opening, None);
    until(&mut window, |window| {
        has(window, "Opening long.mcap") && told.exists()
    });
    let player = fs::read_to_string(&told).expect("it was told");
    let player = Path::new("/proc").join(player.trim());
    assert!(player.exists(), "it runs");
    click(&mut window, "Cancel");
    until(&mut window, |window| {
        has(window, "Recordings") && !player.exists()
    });
}

/// Stands for the schema that controls a recording.
#[derive(Describe)]
#[schema(motor, period = "20ms")]
#[expect(dead_code, reason = "the window reads and writes them, nobody here")]
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
}

impl Schema for Tape {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.damage.write(cx, Text::new("it ends too soon, at byte 7"));
        Ok(())
    }
}

static TAPE: jde_abi::raw::Plugin = jde_schema::plugin!("tape", "What steers a recording.", [Tape]);

const TAPED: &str = "name = \"taped\"\nroots = [\"replay\"]\n[schemas.replay]\ntype = \"tape/tape\"\n";

#[test]
fn a_recording_is_paused_by_space_and_sought_by_its_slider_which_stays_where_it_is_put() {
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&TAPE).expect("it is well formed");
    let tape = Robot::recorded(TAPED, plugins);
    let handle = tape.handle();
    let mut window = open(opening(tape.reach(), Some("taped")), None);
    until(&mut window, |window| {
        has(window, "Play") && has(window, "10.00 s")
    });
    window.key_press(eframe::egui::Key::Space);
    window.run_steps(2);
    let paused = || {
        let flag: Option<Flag> = handle.value("replay.paused").expect("it is there");
        flag.is_some_and(Flag::get)
    };
    until(&mut window, |window| !paused() && has(window, "Pause"));
    // In the oscilloscope, the key would have paused the picture.
    assert!(!has(&window, "Run"));

    let slider = "Place in the recording";
    let rect = window.get_by_label(slider).rect();
    let place = |window: &Harness<'_, Option<App>>| {
        let slider = window.get_by_label(slider);
        slider.accesskit_node().numeric_value().expect("it is a number")
    };
    let end = rect.right_center() - vec2(1.0, 0.0);
    window.hover_at(rect.center());
    window.step();
    window.drag_at(rect.center());
    window.step();
    window.hover_at(end);
    window.step();
    let sought = place(&window);
    assert!(sought > 90.0, "{sought}");
    window.drop_at(end);
    let position = || {
        let position: Option<f64> = handle.value("replay.position").expect("it is there");
        position.expect("it has a value")
    };
    until(&mut window, |window| {
        assert_eq!(place(window), sought, "it does not jump back");
        position() == sought
    });
    let shown = format!("{sought:.2} s");
    until(&mut window, |window| {
        assert_eq!(place(window), sought);
        has(window, &shown)
    });
    until(&mut window, |window| has(window, "cut off"));
    // The left end is the begin of the recording, at 5 s, not the start of its application.
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

/// A separate process with a robot, killed when dropped.
struct Elsewhere(Child);

/// Environment variable that makes [`an_application_is_served_where_it_says`] serve until its input ends.
const SERVES: &str = "JDE_TEST_SERVES";

impl Elsewhere {
    /// Starts the process. Returns it, and where its application is found.
    fn start() -> (Self, Reach) {
        let mut child = Command::new(std::env::current_exe().expect("this program is known"))
            .args([
                "--nocapture",
                "--exact",
                "tests::frame::an_application_is_served_where_it_says",
            ])
            .env(SERVES, "1")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("it starts");
        let said = BufReader::new(child.stdout.take().expect("it is piped"));
        let place = said
            .lines()
            .map_while(Result::ok)
            .find_map(|line| Some(line.split_once("served at ")?.1.to_owned()));
        let place = place.expect("it says where");
        (Self(child), Reach::Local(Folders::at(PathBuf::from(place))))
    }

    fn suspend(&self) {
        let stopped = Command::new("kill")
            .args(["-STOP", &self.0.id().to_string()])
            .status();
        assert!(stopped.expect("kill starts").success());
    }
}

impl Drop for Elsewhere {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// In the separate process of [`Elsewhere`], it is the application that hangs.
#[test]
fn an_application_is_served_where_it_says() {
    let robot = Robot::of("safe-navigation");
    assert!(robot.place().exists());
    println!("\nserved at {}", robot.place().display());
    if std::env::var_os(SERVES).is_some() {
        let _ = std::io::stdin().lock().read_to_end(&mut Vec::new());
    }
}

#[test]
fn an_application_that_hangs_is_said_to_give_no_news_and_nothing_of_it_is_live() {
    // Builds the plugins here, so that the other process need not.
    drop(super::common::plugins());
    let (elsewhere, reach) = Elsewhere::start();
    let mut window = open(opening(reach, Some("safe-navigation")), None);
    until(&mut window, |window| says(window, "live"));
    assert!(!says(&window, "no news for"));
    elsewhere.suspend();
    until(&mut window, |window| says(window, "no news for"));
    assert!(!says(&window, "live"));
}
