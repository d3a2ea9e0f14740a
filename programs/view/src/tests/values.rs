//! Variables of a running application: values are read, and modulations are changed in place and checked in
//! the application.

use eframe::egui::{self, Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::common::until;
use super::painter;
use crate::session::WindowSession;
use crate::style::{Style, Units};
use crate::window::Window;
use crate::window::panel::Panel;
use crate::window::values::Values;

struct Shown<W> {
    session: WindowSession,
    window: W,
}

fn shown<W: Window + 'static>(session: WindowSession, window: W) -> Harness<'static, Shown<W>> {
    let show = |ui: &mut egui::Ui, shown: &mut Shown<W>| {
        shown.session.begin_frame();
        let style = Style::of(ui.ctx(), Units::default());
        shown.window.show(ui, &shown.session, &style);
    };
    Harness::builder()
        .with_size([720.0, 480.0])
        .build_ui_state(show, Shown { session, window })
}

fn number<W>(harness: &Harness<'_, Shown<W>>, name: &str) -> f64 {
    let sample = harness
        .state()
        .session
        .remote()
        .get(name)
        .expect("the variable exists");
    let bytes = sample.bytes.expect("the variable has a value");
    f64::from_ne_bytes((*bytes).try_into().expect("the value is a number"))
}

fn enter(harness: &mut Harness<'_, Shown<Values>>, field: &str, text: &str) {
    let role = egui::accesskit::Role::TextInput;
    // Not by a click: new values change the widths of the columns, and therefore the position of the field.
    harness.get_by_role_and_label(role, field).focus();
    harness.step();
    harness.step();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.step();
    harness.get_by_role_and_label(role, field).type_text(text);
    harness.step();
    harness.key_press(Key::Enter);
    harness.step();
    harness.step();
}

fn field(harness: &Harness<'_, Shown<Values>>, name: &str) -> Option<String> {
    let node = harness.query_by_role_and_label(egui::accesskit::Role::TextInput, name)?;
    node.value()
}

#[test]
fn r14_a_typed_modulation_is_in_force_until_it_is_reset() {
    let robot = painter::robot();
    let mut harness = shown(robot.session(), Values::open(&serde_json::Value::Null));
    until(&mut harness, |harness| {
        field(harness, "goon.speed").as_deref() == Some("0.500 m/s")
    });
    enter(&mut harness, "goon.speed", "1.5");
    until(&mut harness, |harness| number(harness, "goon.speed") == 1.5);
    until(&mut harness, |harness| {
        field(harness, "goon.speed").as_deref() == Some("1.50 m/s")
    });
    // The number is typed in the displayed unit and arrives in the SI unit.
    enter(&mut harness, "goon.turn", "180");
    until(&mut harness, |harness| {
        number(harness, "goon.turn") == std::f64::consts::PI
    });
    until(&mut harness, |harness| {
        harness.query_by_label("Reset goon").is_some()
    });
    harness.get_by_label("Reset goon").click();
    until(&mut harness, |harness| number(harness, "goon.speed") == 0.5);
}

#[test]
fn tuned_values_are_listed_and_saved_to_the_file_and_set_back() {
    let folder = tempfile::tempdir().expect("the folder is created");
    let (robot, file) = (
        painter::robot_in(folder.path()),
        folder.path().join("painters.toml"),
    );
    let mut harness = shown(robot.session(), Values::open(&serde_json::Value::Null));
    until(&mut harness, |harness| {
        field(harness, "goon.speed").as_deref() == Some("0.500 m/s")
    });
    enter(&mut harness, "goon.speed", "1.5");
    enter(&mut harness, "goon.turn", "90");
    harness.get_by_label("Tuned only").click();
    until(&mut harness, |harness| {
        harness.query_by_label("file 0.500 m/s").is_some()
    });
    until(&mut harness, |harness| {
        harness.query_by_label("set back goon.turn").is_some()
    });
    harness.get_by_label("set back goon.turn").click();
    until(&mut harness, |harness| {
        number(harness, "goon.turn") == 0.0 && field(harness, "goon.turn").is_none()
    });
    harness.get_by_label("Save to the file").click();
    until(&mut harness, |harness| {
        harness.query_by_label("saved goon.speed = 1.5").is_some()
    });
    let written = std::fs::read_to_string(&file).expect("the file is read");
    assert!(
        written.ends_with("type = \"painters/painter\"\nspeed = 1.5\n"),
        "{written}"
    );
    // It differs no more, and what somebody else writes meanwhile is not overwritten.
    until(&mut harness, |harness| {
        harness
            .query_by_label("No modulation differs from the application's file.")
            .is_some()
    });
    std::fs::write(&file, written.replace("1.5", "1.6")).expect("the file is written");
    harness.get_by_label("Tuned only").click();
    until(&mut harness, |harness| field(harness, "goon.speed").is_some());
    enter(&mut harness, "goon.speed", "1.7");
    harness.get_by_label("Tuned only").click();
    until(&mut harness, |harness| {
        harness.query_by_label("file 1.50 m/s").is_some()
    });
    harness.get_by_label("Save to the file").click();
    let changed = "was changed here since the run began";
    until(&mut harness, |harness| {
        harness.query_by_label_contains(changed).is_some()
    });
    harness.get_by_label("All back").click();
    until(&mut harness, |harness| number(harness, "goon.speed") == 1.5);
}

#[test]
fn recorded_values_are_shown_and_cannot_be_changed() {
    let robot = painter::recorded();
    let mut harness = shown(robot.session(), Values::open(&serde_json::Value::Null));
    until(&mut harness, |harness| {
        harness.query_by_label("0.500 m/s").is_some()
    });
    assert_eq!(field(&harness, "goon.speed"), None);
}

#[test]
fn a_value_out_of_range_or_in_another_unit_is_refused_beside_its_field() {
    let robot = painter::robot();
    let mut harness = shown(robot.session(), Values::open(&serde_json::Value::Null));
    until(&mut harness, |harness| {
        field(harness, "goon.speed").as_deref() == Some("0.500 m/s")
    });
    enter(&mut harness, "goon.speed", "9");
    harness.get_by_label("enter 0.000 m/s to 2.00 m/s");
    enter(&mut harness, "goon.speed", "1 kg");
    harness.get_by_label("its unit is m/s, not kg");
    assert_eq!(number(&harness, "goon.speed"), 0.5);
}

#[test]
fn variables_can_be_searched_and_unfolded() {
    let robot = painter::robot();
    let mut harness = shown(robot.session(), Values::open(&serde_json::Value::Null));
    until(&mut harness, |harness| {
        harness.query_by_label("unfold goon.velocity").is_some()
    });
    harness.get_by_label("unfold goon.velocity").click();
    until(&mut harness, |harness| harness.query_by_label("linear").is_some());
    harness.get_by_label("Search").click();
    harness.step();
    harness.get_by_label("Search").type_text("count");
    harness.step();
    harness.step();
    assert!(harness.query_by_label("velocity").is_none());
    assert!(harness.query_by_label("count").is_some());
}

#[test]
fn a_click_on_the_panel_of_a_running_schema_reaches_it_and_changes_the_panel() {
    let robot = painter::robot();
    let mut harness = shown(robot.session(), Panel::open("goon", &serde_json::Value::Null));
    until(&mut harness, |harness| {
        let drawn = harness.query_by_label("no target").is_some();
        // Until the schema has drawn, the window shows what it waits for.
        assert!(drawn || harness.query_by_label("waiting for the first picture").is_some());
        drawn
    });
    harness.get_by_label("field").click();
    until(&mut harness, |harness| {
        harness.query_by_label("target 0, 0").is_some()
    });
    // A SLEPT schema is shown as such, and its panel stays visible.
    let schema = "goon".to_owned();
    let stop = jde_link::message::Action::Stop { schema };
    harness.state().session.act(stop);
    until(&mut harness, |harness| {
        harness.query_by_label("it is asleep").is_some()
    });
    assert!(harness.query_by_label("target 0, 0").is_some());
}

#[test]
fn a_panel_of_an_unknown_schema_is_refused_with_the_reason() {
    let robot = painter::robot();
    let mut harness = shown(robot.session(), Panel::open("goom", &serde_json::Value::Null));
    harness.step();
    harness.get_by_label("There is no schema goom in this application.");
}
