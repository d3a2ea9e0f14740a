//! The window of events, and the button that records.

use std::ffi::OsString;
use std::fs;

use eframe::egui;
use egui_kittest::kittest::Queryable;
use jde_loader::{Plugins, SearchPath};
use jde_schema::prelude::*;

use super::common::{Robot, until};
use super::frame::{click, has, has_text, open, opening};

/// A schema that fails.
#[derive(Describe)]
#[schema(motor, period = "20ms")]
struct Blind {
    /// What is wanted.
    #[modulation(default = 1.0, unit = "m")]
    far: Modulation<f64>,
}

impl Schema for Blind {
    fn iterate(&mut self, cx: &Context) -> Result {
        Err(format!("nothing is seen {} m away", self.far.get(cx)).into())
    }
}

static BLIND: jde_abi::raw::Plugin = jde_schema::plugin!("blind", "Fails.", [Blind]);

const FAILING: &str = "name = \"failing\"\nroots = [\"eye\"]\n[schemas.eye]\ntype = \"blind/blind\"\n";

#[test]
fn a_schema_in_trouble_leads_to_its_events_which_a_search_filters() {
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&BLIND).expect("the plugin is well formed");
    let robot = Robot::linked(FAILING, plugins);
    let mut window = open(opening(robot.reach(), Some("failing")), None);
    until(&mut window, |window| has(window, "1 schema in trouble"));
    assert!(!has(&window, "Kind"), "the window is behind another one");
    click(&mut window, "1 schema in trouble");
    until(&mut window, |window| has_text(window, "nothing is seen 1 m away"));
    assert!(has(&window, "Kind"));
    window.get_by_label("Search").click();
    window.step();
    window.get_by_label("Search").type_text("gripper");
    until(&mut window, |window| has(window, "No event passes the filter."));
    click(&mut window, "Reset");
    until(&mut window, |window| has_text(window, "nothing is seen 1 m away"));
}

/// The program of a recorder: a shell script, with the application as `$1` and the file as `$2`.
fn script(text: &str) -> Vec<OsString> {
    ["sh", "-c", text].map(OsString::from).to_vec()
}

#[test]
fn the_button_records_until_it_is_pressed_again_and_says_where() {
    let robot = Robot::of("safe-navigation");
    let folder = tempfile::tempdir().expect("the folder is created");
    fs::write(folder.path().join("safe-navigation-1.mcap"), "an earlier one").expect("it is written");
    let mut opening = opening(robot.reach(), Some("safe-navigation"));
    opening.recordings = vec![folder.path().to_owned()];
    opening.recorder = script("cat; echo \"$1\" > \"$2\"");
    let mut window = open(opening, None);
    until(&mut window, |window| has(window, "Record"));
    click(&mut window, "Record");
    until(&mut window, |window| has(window, "Stop recording"));
    click(&mut window, "Stop recording");
    until(&mut window, |window| {
        has(window, "recorded in safe-navigation-2.mcap")
    });
    let recorded = fs::read_to_string(folder.path().join("safe-navigation-2.mcap"));
    assert!(recorded.expect("it is written").starts_with("safe-navigation@"));
}

#[test]
fn a_recording_that_fails_says_why_and_one_of_closed_windows_is_completed() {
    let robot = Robot::of("safe-navigation");
    let folder = tempfile::tempdir().expect("the folder is created");
    let mut opening = opening(robot.reach(), Some("safe-navigation"));
    opening.recordings = vec![folder.path().to_owned()];
    opening.recorder = script("echo 'the disk is full' >&2; exit 1");
    let mut window = open(opening.clone(), None);
    until(&mut window, |window| has(window, "Record"));
    click(&mut window, "Record");
    until(&mut window, |window| {
        has(window, "the disk is full") && has(window, "Record")
    });
    drop(window);

    opening.recorder = script("cat; echo complete > \"$2\"");
    let mut window = open(opening, None);
    until(&mut window, |window| has(window, "Record"));
    click(&mut window, "Record");
    drop(window);
    let file = folder.path().join("safe-navigation-1.mcap");
    let mut other = egui_kittest::Harness::new_ui(|ui: &mut egui::Ui| drop(ui.label("waits")));
    until(&mut other, |_| {
        fs::read_to_string(&file).is_ok_and(|text| text == "complete\n")
    });
}
