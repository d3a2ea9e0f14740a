//! The oscilloscope on real applications: the user's actions take effect in the application, and its changes
//! are shown.

use eframe::egui::{Key, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use jde_board::value::Value;
use jde_core::State;
use jde_records::snapshot::{HoldKind, SchemaView};

use super::common::{Robot, until};
use crate::session::WindowSession;
use crate::style::{Style, Units};
use crate::window::Window;
use crate::window::scope::Scope;

struct Shown {
    session: WindowSession,
    scope: Scope,
}

fn shown(robot: &Robot) -> Harness<'static, Shown> {
    let shown = Shown {
        session: robot.session(),
        scope: Scope::open(&serde_json::Value::Null),
    };
    Harness::builder().with_size(vec2(1000.0, 600.0)).build_ui_state(
        |ui, shown: &mut Shown| {
            shown.session.begin_frame();
            shown.scope.follow(&shown.session);
            let style = Style::of(ui.ctx(), Units::default());
            shown.scope.show(ui, &shown.session, &style);
        },
        shown,
    )
}

fn has(harness: &Harness<'_, Shown>, text: &str) -> bool {
    harness.query_all_by_label_contains(text).next().is_some()
}

fn click(harness: &mut Harness<'_, Shown>, label: &str) {
    harness.get_by_label(label).click();
    harness.run_steps(2);
}

fn select(harness: &mut Harness<'_, Shown>, schema: &str) {
    harness.get_by_label_contains(&format!("{schema}, ")).click();
    harness.run_steps(2);
}

/// The state of a schema, read from the application without the link.
fn view(robot: &Robot, name: &str) -> SchemaView {
    let snapshot = robot.handle().snapshot();
    let mut schemas = snapshot.schemas.into_iter();
    schemas
        .find(|view| view.name == name)
        .expect("the application has the schema")
}

fn hold(robot: &Robot, name: &str) -> Option<HoldKind> {
    view(robot, name).operator.map(|hold| hold.kind)
}

#[test]
fn r14_play_stop_force_and_release_take_effect_and_are_shown_with_their_operator() {
    let robot = Robot::of("family");
    let mut harness = shown(&robot);
    until(&mut harness, |harness| has(harness, "hijo1, "));

    select(&mut harness, "hijo1");
    click(&mut harness, "Stop hijo1");
    until(&mut harness, |_| view(&robot, "hijo1").state == State::Slept);
    until(&mut harness, |harness| {
        has(harness, "hijo1, SLEPT, ok, stopped by ")
    });
    click(&mut harness, "Play hijo1");
    until(&mut harness, |_| view(&robot, "hijo1").state != State::Slept);
    select(&mut harness, "hijo2");
    click(&mut harness, "Force hijo2");
    until(&mut harness, |_| hold(&robot, "hijo2") == Some(HoldKind::Forced));
    until(&mut harness, |harness| {
        has(harness, "hijo2, WINNER, ok, forced by ")
    });
    for name in ["hijo1", "hijo2"] {
        select(&mut harness, name);
        click(&mut harness, &format!("Release {name}"));
        until(&mut harness, |_| hold(&robot, name).is_none());
    }
    until(&mut harness, |harness| !has(harness, " by "));
}

#[test]
fn a_typed_period_becomes_the_period_of_the_schema() {
    let robot = Robot::of("family");
    let mut harness = shown(&robot);
    until(&mut harness, |harness| has(harness, "Period of padre: 1 s"));
    click(&mut harness, "Period of padre: 1 s");
    harness.step();
    harness.get_by_label("New period of padre").type_text("20 Hz");
    harness.run_steps(2);
    harness.key_press(Key::Enter);
    until(&mut harness, |_| view(&robot, "padre").period == 50_000_000);
    until(&mut harness, |harness| has(harness, "Period of padre: 50 ms"));
}

#[test]
fn a_trigger_fires_on_a_conflict_and_the_record_shows_the_cause() {
    let robot = Robot::of("family");
    let mut harness = shown(&robot);
    until(&mut harness, |harness| has(harness, "hijo1, "));
    harness.get_by_label("Trigger").focus();
    harness.step();
    harness.get_by_label("Trigger").type_text("conflict:padre/base");
    harness.step();
    harness.key_press(Key::Enter);
    harness.run_steps(2);
    assert!(has(&harness, "armed"));
    // Now both children are ready.
    let handle = robot.handle();
    let hijo2 = handle.application().instance("hijo2").expect("it exists");
    let set = handle.operator("test").modulate(hijo2, "to", &Value::Float(8.0));
    set.expect("the value is in range");
    until(&mut harness, |harness| has(harness, "triggered at "));
    until(&mut harness, |harness| {
        has(harness, "conflict: two or more were ready") && has(harness, "holds")
    });
}

#[test]
fn a_trace_of_a_variable_shows_its_value() {
    let robot = Robot::of("family");
    let mut harness = shown(&robot);
    until(&mut harness, |harness| has(harness, "hijo1, "));
    click(&mut harness, "+ trace");
    harness.run_steps(2);
    harness
        .get_by_label("Name of the trace")
        .type_text("odometry position.x");
    harness.run_steps(2);
    harness.key_press(Key::Enter);
    harness.run_steps(2);
    let name = "trace pioneer.odometry.pose.pose.position.x: ";
    until(&mut harness, |harness| {
        let label = harness.query_by_label_contains(name);
        label.is_some_and(|label| {
            use egui_kittest::kittest::NodeT;
            let text = label.accesskit_node().label().unwrap_or_default();
            !text.ends_with('–')
        })
    });
    click(&mut harness, "Remove trace pioneer.odometry.pose.pose.position.x");
    assert!(!has(&harness, name));
}
