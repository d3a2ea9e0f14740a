//! Stopping everything from the windows (R14): on each page, with the button and the key, while applications answer and
//! while they do not.

use eframe::egui::{self, Key, Modifiers, Pos2, Role, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use jde_core::State;

use super::common::{Robot, until};
use super::frame::{
    ServerProcess, Window, click, has, has_text, open, open_robot, open_sized, opening, state,
};
use crate::app::App;

const STOP: &str = "Stop everything";
const GO_ON: &str = "Go on ...";
const SURE: &str = "Let everything go on";

/// A click of a mouse, or several in quick succession, each with a frame of its own.
fn clicks(window: &mut Window, at: Pos2, count: usize) {
    window.hover_at(at);
    window.step();
    for pressed in [true, false].repeat(count) {
        window.input_mut().events.push(egui::Event::PointerButton {
            pos: at,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        });
        window.step();
    }
    window.run_steps(2);
}

fn center(window: &Window, label: &str) -> Pos2 {
    window.get_by_label(label).rect().center()
}

fn stopped_by_me() -> String {
    format!("Stopped by {}", jde_link::operator())
}

/// Waits until the windows on an application show that everything in it is stopped.
fn until_stopped(window: &mut Window) {
    until(window, |window| {
        has_text(window, &stopped_by_me()) && has(window, GO_ON)
    });
}

#[test]
fn r14_clicks_on_the_button_stop_everything_however_many_they_are() {
    let robot = Robot::of("safe-navigation");
    let handle = robot.handle();
    let mut window = open_robot(&robot, None);
    for count in [1, 2, 3] {
        until(&mut window, |_| state(&handle, "example") == State::Winner);
        let stop = center(&window, STOP);
        clicks(&mut window, stop, count);
        until_stopped(&mut window);
        // Some more of them, at the same place.
        clicks(&mut window, stop, count);
        until(&mut window, |window| !has_text(window, "Stopping"));
        for schema in ["example", "goon", "vff", "stop"] {
            assert_eq!(state(&handle, schema), State::Slept, "{schema} no longer acts");
        }
        assert!(has(&window, STOP), "it stays where it is");
        assert!((center(&window, STOP) - stop).length() < 1.0);
        let far = (center(&window, GO_ON) - stop).length();
        assert!(far > 300.0, "going on is {far} points from the stop");
        // Going on asks once, and a double click is no answer.
        let go_on = center(&window, GO_ON);
        clicks(&mut window, go_on, 2);
        assert!(has(&window, GO_ON) && !has(&window, SURE));
        assert_eq!(state(&handle, "example"), State::Slept);
        click(&mut window, GO_ON);
        click(&mut window, SURE);
        until(&mut window, |window| {
            state(&handle, "example") == State::Winner && !has_text(window, "Stopped by")
        });
    }
}

#[test]
fn r14_the_key_stops_everything_while_a_text_field_or_a_button_has_the_focus() {
    let robot = Robot::of("safe-navigation");
    let handle = robot.handle();
    let mut window = open_robot(&robot, None);
    click(&mut window, "Variables");
    until(&mut window, |window| has(window, "Search"));
    window.get_by_label("Search").click();
    window.step();
    window.get_by_label("Search").type_text("goon.");
    until(&mut window, |_| state(&handle, "example") == State::Winner);
    window.key_press_modifiers(Modifiers::CTRL, Key::Space);
    until_stopped(&mut window);
    click(&mut window, GO_ON);
    // Space would press the button that has the focus.
    window.get_by_label(SURE).focus();
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::CTRL, Key::Space);
    until(&mut window, |window| {
        !has_text(window, "Stopping") && has_text(window, &stopped_by_me())
    });
    assert_eq!(state(&handle, "example"), State::Slept);
    assert!(has(&window, SURE), "it was not pressed");
}

/// How long the window says that the application has not acknowledged a stop, in s.
fn waited(window: &Harness<'_, Option<App>>) -> Option<u64> {
    const TEXT: &str = "Stopping: not acknowledged by safe-navigation for ";
    let line = window.query_all_by_label_contains(TEXT).next()?;
    let line = line.accesskit_node();
    let text = line.label().or_else(|| line.value())?;
    text.strip_prefix(TEXT)?.strip_suffix(" s")?.parse().ok()
}

/// Opens the page of applications, where these run.
fn open_start(robot: &Robot) -> Window {
    let mut window = open_robot(robot, None);
    click(&mut window, "Applications");
    until(&mut window, |window| {
        window
            .query_by_role_and_label(Role::Link, "safe-navigation")
            .is_some()
    });
    window
}

#[test]
fn r14_the_button_and_the_key_stop_every_application_on_the_page_of_applications() {
    let robot = Robot::of("safe-navigation");
    let handle = robot.handle();
    let mut window = open_start(&robot);
    for press in [
        (|window| window.key_press_modifiers(Modifiers::CTRL, Key::Space)) as fn(&mut Window),
        |window| click(window, STOP),
    ] {
        until(&mut window, |_| state(&handle, "example") == State::Winner);
        press(&mut window);
        window.run_steps(2);
        until(&mut window, |window| {
            has_text(window, &stopped_by_me()) && has_text(window, " ago: safe-navigation")
        });
        assert_eq!(state(&handle, "example"), State::Slept);
        handle.operator("ana").release_all().expect("it is stopped");
    }
}

#[test]
fn r14_a_stop_of_an_application_that_does_not_answer_is_asked_until_it_is_acknowledged() {
    drop(super::common::plugins());
    let (server, reach) = ServerProcess::start();
    let mut window = open(opening(reach, Some("safe-navigation")), None);
    until(&mut window, |window| has_text(window, "live"));
    server.signal("-STOP");
    // Long enough for its connection to be lost.
    until(&mut window, |window| has(window, "lost"));
    click(&mut window, STOP);
    window.key_press_modifiers(Modifiers::CTRL, Key::Space);
    until(&mut window, |window| waited(window) >= Some(2));
    assert!(has(&window, STOP) && !has(&window, GO_ON));
    // Another page ends no stop.
    click(&mut window, "Applications");
    until(&mut window, |window| waited(window) >= Some(4));
    server.signal("-CONT");
    until(&mut window, |window| has_text(window, &stopped_by_me()));
    until(&mut window, |window| {
        window
            .query_by_role_and_label(Role::Link, "safe-navigation")
            .is_some()
    });
    window
        .get_by_role_and_label(Role::Link, "safe-navigation")
        .click();
    until_stopped(&mut window);
}

#[test]
fn r14_an_application_that_never_answers_is_asked_until_the_person_says_otherwise() {
    drop(super::common::plugins());
    let (server, reach) = ServerProcess::start();
    let mut window = open(opening(reach, Some("safe-navigation")), None);
    until(&mut window, |window| has_text(window, "live"));
    click(&mut window, "Applications");
    until(&mut window, |window| {
        window
            .query_by_role_and_label(Role::Link, "safe-navigation")
            .is_some()
    });
    server.signal("-STOP");
    window.key_press_modifiers(Modifiers::CTRL, Key::Space);
    // A round of questions ends after some seconds; another follows.
    until(&mut window, |window| waited(window) >= Some(12));
    click(&mut window, "Stop asking ...");
    assert!(has_text(&window, "not acknowledged"), "it asks once");
    click(&mut window, "Stop asking, although a robot may still move");
    assert!(!has_text(&window, "not acknowledged"));
}

#[test]
fn r14_the_button_is_inside_a_window_of_any_width() {
    let robot = Robot::of("safe-navigation");
    let handle = robot.handle();
    for width in [480.0, 640.0, 900.0] {
        let mut window = open_sized(
            opening(robot.reach(), Some("safe-navigation")),
            None,
            vec2(width, 320.0),
        );
        until(&mut window, |window| has(window, "Oscilloscope"));
        until(&mut window, |_| state(&handle, "example") == State::Winner);
        let rect = window.get_by_label(STOP).rect();
        assert!(rect.left() >= 0.0 && rect.right() <= width, "{rect:?} of {width}");
        clicks(&mut window, rect.left_center() + vec2(2.0, 0.0), 1);
        until_stopped(&mut window);
        click(&mut window, GO_ON);
        click(&mut window, SURE);
    }
}
