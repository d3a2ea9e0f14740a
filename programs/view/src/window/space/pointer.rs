//! The user's control of the view: drags, wheel and keys move the eye, and a click selects a point.

use eframe::egui::{self, Key, Modifiers, PointerButton, Response, Ui};
use glam::{Vec2, Vec3};

use super::draw_list::Pickable;
use super::orbit::{Eye, Orbit};

/// Fraction of the picture's height by which a key moves.
const KEY_SHARE: f32 = 0.06;
/// Factor of the distance by which a key zooms in.
const KEY_ZOOM: f32 = 0.85;
/// Logarithm of the zoom per point of the wheel. A full turn of the wheel is about 100 points.
const WHEEL_ZOOM: f32 = 0.0022;

/// A request of the user other than moving the eye directly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ViewAction {
    /// Starts or stops following the robot.
    Follow,
    /// Looks from above.
    Top,
    /// Restores the initial view.
    Reset,
}

/// The input that a scene takes, and that does not move the eye.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PointerInput {
    /// The drag in progress.
    pub(crate) drag: bool,
    /// Keys.
    pub(crate) keys: bool,
}

/// The point that the user clicked.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pointed {
    /// The name of the object there, if any.
    pub(crate) name: Option<String>,
    /// The position in the frame of the odometry.
    pub(crate) at: Vec3,
}

/// Moves the eye by this frame's input. Returns the requested action, and whether the user moved the target.
///
/// Input that a scene takes, `taken`, does not move the eye.
pub(crate) fn steer(
    ui: &Ui,
    response: &Response,
    orbit: &mut Orbit,
    follows: bool,
    taken: PointerInput,
) -> (Option<ViewAction>, bool) {
    let mut target_moved = false;
    let height = response.rect.height().max(1.0);
    let shift = ui.input(|input| input.modifiers.shift);
    let drag = response.drag_delta() / height;
    let drag = Vec2::new(drag.x, drag.y);
    let pans = response.dragged_by(PointerButton::Middle)
        || response.dragged_by(PointerButton::Secondary)
        || (response.dragged_by(PointerButton::Primary) && shift);
    if taken.drag {
        // The drag belongs to a scene.
    } else if pans && drag != Vec2::ZERO {
        orbit.pan(drag);
        target_moved = true;
    } else if response.dragged_by(PointerButton::Primary) {
        orbit.turn(drag);
    }
    if response.clicked() || response.drag_started() {
        response.request_focus();
    }
    if let Some(pointer) = response.hover_pos() {
        let (wheel, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
        let factor = (-wheel * WHEEL_ZOOM).exp() / pinch.max(0.01);
        if factor != 1.0 {
            // While following, the robot stays in place on the screen; otherwise the point under the pointer
            // does.
            let eye = eye(orbit, response);
            let at = pointer - response.rect.min;
            let fixed = eye.ray(Vec2::new(at.x, at.y)).floor();
            let near = fixed.filter(|at| !follows && at.distance(eye.place) < 4.0 * orbit.distance);
            orbit.zoom(factor, near);
        }
    }
    let mut action = None;
    if response.has_focus() && !taken.keys {
        ui.memory_mut(|memory| {
            let keeps = egui::EventFilter {
                horizontal_arrows: true,
                vertical_arrows: true,
                ..egui::EventFilter::default()
            };
            memory.set_focus_lock_filter(response.id, keeps);
        });
        target_moved |= keys(ui, orbit);
        action = requested_action(ui);
    }
    (action, target_moved)
}

fn keys(ui: &Ui, orbit: &mut Orbit) -> bool {
    let pressed =
        |modifiers: Modifiers, key: Key| ui.input_mut(|input| input.count_and_consume_key(modifiers, key));
    let mut target_moved = false;
    for (key, delta) in [
        (Key::ArrowLeft, Vec2::new(KEY_SHARE, 0.0)),
        (Key::ArrowRight, Vec2::new(-KEY_SHARE, 0.0)),
        (Key::ArrowUp, Vec2::new(0.0, KEY_SHARE)),
        (Key::ArrowDown, Vec2::new(0.0, -KEY_SHARE)),
    ] {
        let (pans, turns) = (pressed(Modifiers::SHIFT, key), pressed(Modifiers::NONE, key));
        if pans > 0 {
            orbit.pan(delta * pans as f32);
            target_moved = true;
        }
        if turns > 0 {
            orbit.turn(delta * turns as f32);
        }
    }
    for (keys, factor) in [
        ([Key::Plus, Key::Equals], KEY_ZOOM),
        ([Key::Minus, Key::PageDown], 1.0 / KEY_ZOOM),
    ] {
        for key in keys {
            let times = pressed(Modifiers::NONE, key) + pressed(Modifiers::SHIFT, key);
            if times > 0 {
                orbit.zoom(factor.powi(times as i32), None);
            }
        }
    }
    target_moved
}

fn requested_action(ui: &Ui) -> Option<ViewAction> {
    let pressed = |key| ui.input_mut(|input| input.consume_key(Modifiers::NONE, key));
    if pressed(Key::F) {
        Some(ViewAction::Follow)
    } else if pressed(Key::T) {
        Some(ViewAction::Top)
    } else if pressed(Key::R) {
        Some(ViewAction::Reset)
    } else {
        None
    }
}

/// The nearest named object at a point of the picture, or else the floor.
pub(crate) fn point(eye: &Eye, things: &[Pickable], at: Vec2) -> Option<Pointed> {
    let ray = eye.ray(at);
    let hits = things.iter().filter_map(|thing| {
        // Small objects have a radius of at least six points of the screen.
        let radius = thing.radius.max(6.0 / eye.scale(thing.at));
        Some((ray.ball(thing.at, radius)?, thing))
    });
    let nearest = hits.min_by(|a, b| a.0.total_cmp(&b.0));
    match nearest {
        Some((_, thing)) => Some(Pointed {
            name: Some(thing.name.clone()),
            at: thing.at,
        }),
        None => ray.floor().map(|at| Pointed { name: None, at }),
    }
}

/// The eye of an orbit for the picture of a response.
pub(crate) fn eye(orbit: &Orbit, response: &Response) -> Eye {
    let size = response.rect.size();
    orbit.eye(Vec2::new(size.x, size.y))
}
