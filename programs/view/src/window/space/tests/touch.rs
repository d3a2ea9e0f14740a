//! Gestures on the scenes of panels.

use std::sync::Arc;

use eframe::egui::{Key, Pos2, Vec2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use glam::Vec3;
use jde_panel::{Button, Color, Gesture, Ink, Item, List, Solid, Touch, Wants};
use jde_types::Pose2D;

use super::super::Space;
use super::super::scene_data::{RobotData, SceneData};
use super::{NAME, SIZE};
use crate::style::{Style, Units};

struct Shown {
    space: Space,
    gestures: Vec<(String, Gesture)>,
}

type Window = Harness<'static, Shown>;

const ALL: Wants = Wants {
    clicks: true,
    drags: true,
    keys: true,
};

/// A ball 1 m above the floor, 2 m ahead of a robot at x = 1 m.
fn ball(id: &str, wants: Wants) -> Item {
    Item::Scene {
        id: id.to_owned(),
        frame: "base_link".to_owned(),
        solids: vec![Solid::Sphere {
            center: [2.0, 0.0, 1.0],
            radius: 0.3,
            color: Color::Ink(Ink::Goal),
        }],
        wants,
    }
}

/// A window without a renderer, which these tests do not need.
fn window(scenes: Vec<Item>) -> Window {
    let robot = RobotData {
        name: "pioneer".to_owned(),
        pose: Some(Pose2D::new(1.0, 0.0, 0.0)),
        ..RobotData::default()
    };
    let list = List {
        time: 0,
        items: scenes,
    };
    let mut space = Space::open(&serde_json::Value::Null);
    space.seen = SceneData {
        robots: vec![robot],
        panels: vec![("goon".to_owned(), Arc::new(list))],
        ..SceneData::default()
    };
    let shown = Shown {
        space,
        gestures: Vec::new(),
    };
    let mut window = Harness::builder().with_size(SIZE).build_ui_state(
        |ui, shown: &mut Shown| {
            let style = Style::of(ui.ctx(), Units::default());
            let gestures = shown.space.picture(ui, &style);
            shown.gestures.extend(gestures);
        },
        shown,
    );
    window.run();
    window
}

fn on_screen(window: &Window, at: Vec3) -> Pos2 {
    let rect = window.get_by_label(NAME).rect();
    let size = glam::Vec2::new(rect.width(), rect.height());
    let eye = window.state().space.kept.orbit.eye(size);
    let at = eye.project(at).expect("the point is in front of the eye");
    rect.min + vec2(at.x, at.y)
}

fn drag(window: &mut Window, from: Pos2, by: Vec2) {
    window.hover_at(from);
    window.run();
    window.drag_at(from);
    window.run();
    for step in 1..=4 {
        window.hover_at(from + by * (step as f32 / 4.0));
        window.run();
    }
    window.drop_at(from + by);
    window.run();
}

fn click(window: &mut Window, at: Pos2) {
    window.hover_at(at);
    window.run();
    window.drag_at(at);
    window.drop_at(at);
    window.run();
}

#[track_caller]
fn assert_near(at: [f64; 3], expected: [f64; 3], tolerance: f64) {
    let errors = (0..3).map(|axis| (at[axis] - expected[axis]).abs());
    assert!(
        errors.fold(0.0, f64::max) < tolerance,
        "{at:?} instead of {expected:?}"
    );
}

#[test]
fn a_click_on_a_shape_is_reported_with_its_position_in_the_shapes_frame() {
    let mut window = window(vec![ball("ball", ALL)]);
    let at = on_screen(&window, Vec3::new(3.0, 0.0, 1.0));
    click(&mut window, at);
    let gestures = std::mem::take(&mut window.state_mut().gestures);
    let [(schema, Gesture { widget, touch })] = gestures.as_slice() else {
        panic!("expected one click, got {gestures:?}");
    };
    assert_eq!((schema.as_str(), widget.as_str()), ("goon", "ball"));
    let Touch::Clicked {
        at,
        button: Button::Primary,
    } = touch
    else {
        panic!("expected a click, got {touch:?}");
    };
    let off = (at[0] - 2.0).hypot(at[1]).hypot(at[2] - 1.0);
    assert!((off - 0.3).abs() < 0.01, "{at:?} is on the ball");
}

#[test]
fn a_click_on_the_ground_goes_to_the_only_scene_that_wants_clicks_and_to_none_of_two() {
    let ground = Vec3::new(2.0, 1.0, 0.0);
    let mut one = window(vec![ball("ball", ALL), ball("ignoring", Wants::default())]);
    let at = on_screen(&one, ground);
    click(&mut one, at);
    let [
        (
            _,
            Gesture {
                touch: Touch::Clicked { at, .. },
                ..
            },
        ),
    ] = one.state().gestures.as_slice()
    else {
        panic!("expected one click, got {:?}", one.state().gestures);
    };
    assert_near(*at, [1.0, 1.0, 0.0], 0.02);
    let mut two = window(vec![ball("ball", ALL), ball("other", ALL)]);
    let at = on_screen(&two, ground);
    click(&mut two, at);
    assert_eq!(two.state().gestures, []);
}

#[test]
fn a_drag_of_a_shape_is_reported_at_its_height_and_does_not_turn_the_view() {
    let mut window = window(vec![ball("ball", ALL)]);
    let before = window.state().space.kept.orbit;
    let from = on_screen(&window, Vec3::new(3.0, 0.0, 1.3));
    let to = on_screen(&window, Vec3::new(3.0, 1.0, 1.3));
    drag(&mut window, from, to - from);
    let gestures = &window.state().gestures;
    let Some((
        _,
        Gesture {
            touch: Touch::Dragged { from, to, ended, .. },
            ..
        },
    )) = gestures.last()
    else {
        panic!("expected a drag, got {gestures:?}");
    };
    assert!(*ended);
    let moved = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
    assert_near(moved, [0.0, 1.0, 0.0], 0.1);
    assert_eq!(window.state().space.kept.orbit, before);
}

#[test]
fn a_drag_of_the_ground_turns_the_view() {
    let mut window = window(vec![ball("ball", ALL)]);
    let before = window.state().space.kept.orbit;
    let from = on_screen(&window, Vec3::new(2.0, 1.0, 0.0));
    drag(&mut window, from, vec2(60.0, 20.0));
    assert!(window.state().space.kept.orbit != before);
    assert_eq!(window.state().gestures, []);
}

#[test]
fn keys_go_to_the_touched_scene_or_else_to_the_view() {
    let mut window = window(vec![ball("ball", ALL)]);
    window.get_by_label(NAME).focus();
    window.run();
    window.key_press(Key::F);
    window.run();
    assert!(!window.state().space.kept.follow && window.state().gestures.is_empty());
    let at = on_screen(&window, Vec3::new(3.0, 0.0, 1.0));
    click(&mut window, at);
    window.state_mut().gestures.clear();
    window.key_press(Key::F);
    window.run();
    let keys: Vec<_> = window
        .state()
        .gestures
        .iter()
        .map(|(_, gesture)| gesture.touch.clone())
        .collect();
    let key = |down| Touch::Key {
        key: "f".to_owned(),
        down,
    };
    assert_eq!(keys, [key(true), key(false)]);
    assert!(
        !window.state().space.kept.follow,
        "the key does not reach the view"
    );
}
