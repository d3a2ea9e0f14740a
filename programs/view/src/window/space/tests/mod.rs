//! Pictures of a constant scene, and the effects of pointer, keys and labels on them.

mod eye;
mod room;
mod touch;

use eframe::egui::{self, Event, Key, Modifiers, MouseWheelUnit, Pos2, Vec2, pos2, vec2};
use eframe::egui_wgpu::{RenderState, RendererOptions};
use egui_kittest::kittest::Queryable;
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state, default_wgpu_setup};
use egui_kittest::{Harness, SnapshotOptions};
use glam::Vec3;

use super::scene_data::SceneData;
use super::{Quality, Space, offer};
use crate::style::{Style, Units};
use room::room;

const SIZE: [f32; 2] = [800.0, 520.0];
const NAME: &str = "Space: the robot and what it senses, in 3D";

fn state() -> RenderState {
    create_render_state(default_wgpu_setup(), RendererOptions::PREDICTABLE)
}

fn window(seen: SceneData, dark: bool) -> Harness<'static, Space> {
    window_with_quality(seen, dark, Quality::Fine)
}

fn window_with_quality(seen: SceneData, dark: bool, quality: Quality) -> Harness<'static, Space> {
    let state = state();
    let card = state.clone();
    let mut space = Space::open(&serde_json::Value::Null);
    space.seen = seen;
    Harness::builder()
        .with_size(SIZE)
        .with_theme(if dark {
            egui::Theme::Dark
        } else {
            egui::Theme::Light
        })
        .with_render_cursor(false)
        .with_options(SnapshotOptions::new().threshold(2.0).max_failed_pixels(400))
        .with_context_setup(move |ctx| offer(ctx, &card, quality))
        .renderer(WgpuTestRenderer::from_render_state(state))
        .build_ui_state(
            |ui, space: &mut Space| {
                let style = Style::of(ui.ctx(), Units::default());
                drop(space.picture(ui, &style));
            },
            space,
        )
}

#[test]
fn a_room_matches_its_snapshot_in_the_dark_theme() {
    let mut window = window(room(), true);
    window.run();
    window.snapshot("space-dark");
}

#[test]
fn a_room_matches_its_snapshot_in_the_light_theme() {
    let mut window = window(room(), false);
    window.run();
    window.snapshot("space-light");
}

#[test]
fn each_item_is_drawn_until_it_is_switched_off() {
    let mut window = window(room(), true);
    window.run();
    let mut before = window.render().unwrap();
    for item in [
        "Grid",
        "Axes",
        "Robot",
        "Laser",
        "Sonars",
        "Path",
        "Targets",
        "Cameras",
        "Walls",
        "Movers",
        "Panels' shapes",
    ] {
        window.get_by_label("Show").click();
        window.run();
        window.get_by_label(item).click();
        window.run();
        window.key_press(Key::Escape);
        window.run();
        let after = window.render().unwrap();
        assert!(before != after, "without {item}, the picture is the same");
        before = after;
    }
}

#[test]
fn a_click_selects_a_thing_or_a_floor_point() {
    let mut window = window(room(), true);
    window.run();
    window.state_mut().kept.items.labels = false;
    for (at, name) in [
        (Vec3::new(2.6, -0.6, 0.11), Some("orange ball")),
        (Vec3::new(0.2, 1.0, 0.0), None),
    ] {
        let place = on_screen(&window, at);
        click(&mut window, place);
        let pointed = window.state().pointed.clone().expect("the click hits something");
        assert_eq!(pointed.name.as_deref(), name);
        assert!(pointed.at.distance(at) < 0.03, "{} instead of {at}", pointed.at);
    }
}

#[test]
fn a_drag_turns_the_view_and_with_shift_it_pans() {
    let mut window = window(room(), true);
    window.run();
    let before = window.state().kept;
    drag(&mut window, vec2(80.0, 30.0), Modifiers::NONE);
    let turned = window.state().kept;
    assert_eq!(turned.orbit.target, before.orbit.target);
    assert!(turned.orbit.yaw != before.orbit.yaw && turned.orbit.pitch > before.orbit.pitch);
    assert!(turned.follow, "a turn keeps following the robot");
    drag(&mut window, vec2(80.0, 30.0), Modifiers::SHIFT);
    let moved = window.state().kept;
    assert_eq!(
        (moved.orbit.yaw, moved.orbit.pitch),
        (turned.orbit.yaw, turned.orbit.pitch)
    );
    assert!(moved.orbit.target != turned.orbit.target && !moved.follow);
}

#[test]
fn keys_turn_zoom_and_reset_the_view() {
    let mut window = window(room(), true);
    window.run();
    window.get_by_label(NAME).focus();
    window.run();
    let before = window.state().kept.orbit;
    for key in [Key::ArrowLeft, Key::ArrowUp, Key::Plus] {
        window.key_press(key);
        window.run();
    }
    let after = window.state().kept.orbit;
    assert!(after.yaw < before.yaw && after.pitch > before.pitch && after.distance < before.distance);
    window.key_press(Key::F);
    window.run();
    assert!(!window.state().kept.follow);
    window.key_press(Key::T);
    window.run();
    assert!((window.state().kept.orbit.pitch - std::f32::consts::FRAC_PI_2).abs() < 1e-3);
    window.key_press(Key::R);
    window.run();
    let kept = window.state().kept;
    assert!(kept.follow && (kept.orbit.pitch - before.pitch).abs() < 1e-3);
}

#[test]
fn the_wheel_zooms_to_the_point_under_the_pointer() {
    let mut window = window(room(), true);
    window.run();
    window.state_mut().kept.follow = false;
    let at = Vec3::new(3.0, 1.0, 0.0);
    let place = on_screen(&window, at);
    let before = window.state().kept.orbit.distance;
    window.hover_at(place);
    window.run();
    window.event(Event::MouseWheel {
        unit: MouseWheelUnit::Point,
        delta: vec2(0.0, 120.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    window.run();
    assert!(window.state().kept.orbit.distance < before);
    assert!(on_screen(&window, at).distance(place) < 2.0);
}

#[test]
fn a_followed_robot_stays_in_the_middle() {
    let mut window = window(room(), true);
    window.run();
    let first = window.render().unwrap();
    window.state_mut().seen.robots[0].pose = Some(jde_types::Pose2D::new(3.0, 1.0, 0.0));
    window.run();
    assert!(first != window.render().unwrap());
    let middle = window.get_by_label(NAME).rect().center();
    assert!(on_screen(&window, Vec3::new(3.0, 1.0, 0.2)).distance(middle) < 1.0);
}

#[test]
fn a_software_renderer_draws_with_lower_quality_and_matches_its_snapshot() {
    let mut window = window_with_quality(room(), true, Quality::Quick);
    window.run();
    window.snapshot("space-quick");
}

#[test]
fn an_unchanged_scene_is_not_drawn_again() {
    let mut window = window(room(), true);
    window.run();
    let drawn = |window: &Harness<'_, Space>| match &window.state().card {
        Some(Ok(card)) => card.pictures_drawn(),
        Some(Err(_)) | None => panic!("the window has a graphics card"),
    };
    let before = drawn(&window);
    window.run_steps(5);
    assert_eq!(drawn(&window), before);
}

#[test]
fn a_panel_in_an_unknown_frame_is_reported() {
    let mut seen = room();
    let window = |seen| {
        let mut window = window(seen, true);
        window.run();
        window
    };
    assert!(
        window(room())
            .state()
            .troubles
            .iter()
            .any(|trouble| trouble.contains("gripper"))
    );
    seen.panels.clear();
    assert!(window(seen).state().troubles.is_empty());
}

#[test]
fn without_a_graphics_card_the_window_shows_a_message_and_keeps_running() {
    let mut space = Space::open(&serde_json::Value::Null);
    space.seen = room();
    let mut window = Harness::builder().with_size(SIZE).build_ui_state(
        |ui, space: &mut Space| {
            let style = Style::of(ui.ctx(), Units::default());
            drop(space.picture(ui, &style));
        },
        space,
    );
    window.run();
    window.get_by_label_contains("There is no 3D picture");
    window.get_by_label("Try again").click();
    window.run();
    window.get_by_label_contains("There is no 3D picture");
}

#[test]
fn valid_choices_are_saved_and_invalid_ones_are_ignored() {
    let mut space = Space::open(&serde_json::Value::Null);
    space.kept.items.laser = false;
    space.kept.orbit.distance = 3.5;
    let kept = crate::window::Window::keep(&space);
    assert_eq!(Space::open(&kept).kept, space.kept);
    let invalid = serde_json::json!({ "orbit": { "distance": -1.0 } });
    assert_eq!(
        Space::open(&invalid).kept,
        Space::open(&serde_json::Value::Null).kept
    );
}

fn on_screen(window: &Harness<'_, Space>, at: Vec3) -> Pos2 {
    let rect = window.get_by_label(NAME).rect();
    let eye = window
        .state()
        .kept
        .orbit
        .eye(glam::Vec2::new(rect.width(), rect.height()));
    let at = eye.project(at).expect("the point is in front of the eye");
    rect.min + vec2(at.x, at.y)
}

fn click(window: &mut Harness<'_, Space>, at: Pos2) {
    window.hover_at(at);
    window.run();
    window.drag_at(at);
    window.run();
    window.drop_at(at);
    window.run();
}

fn drag(window: &mut Harness<'_, Space>, by: Vec2, modifiers: Modifiers) {
    let from = pos2(400.0, 300.0);
    window.event_modifiers(Event::PointerMoved(from), modifiers);
    window.run();
    let button = |pos, pressed| Event::PointerButton {
        pos,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers,
    };
    window.event_modifiers(button(from, true), modifiers);
    window.run();
    window.event_modifiers(Event::PointerMoved(from + by), modifiers);
    window.run();
    window.event_modifiers(button(from + by, false), modifiers);
    window.run();
}
