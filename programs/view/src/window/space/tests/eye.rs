//! The geometry of the eye.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::super::draw_list::Pickable;
use super::super::orbit::Orbit;
use super::super::pointer;

const SIZE: Vec2 = Vec2::new(640.0, 400.0);

fn orbits() -> impl Iterator<Item = Orbit> {
    (0..60).map(|number| {
        let share = number as f32 / 59.0;
        Orbit {
            target: Vec3::new(8.0 * share - 3.0, 5.0 - 9.0 * share, 0.3 * share),
            yaw: -PI + 2.0 * PI * share,
            pitch: 0.1 + 1.47 * (share * 7.0).fract(),
            distance: 0.5 + 40.0 * (share * 3.0).fract(),
        }
    })
}

#[test]
fn a_projected_floor_point_is_found_by_its_ray() {
    for orbit in orbits() {
        let eye = orbit.eye(SIZE);
        for place in [[0.3, 0.1], [-0.2, 0.3], [0.0, 0.0], [0.25, -0.3]] {
            let floor = orbit.target.with_z(0.0);
            let at = floor + Vec3::new(place[0], place[1], 0.0) * orbit.distance;
            let Some(screen) = eye.project(at) else {
                continue;
            };
            let found = eye.ray(screen).floor().expect("the ray meets the floor");
            assert!(
                found.distance(at) < 3e-3 * orbit.distance,
                "{found} instead of {at} with {orbit:?}"
            );
        }
    }
}

#[test]
fn the_target_is_in_the_middle_from_every_orbit() {
    for mut orbit in orbits() {
        for _ in 0..4 {
            let middle = orbit
                .eye(SIZE)
                .project(orbit.target)
                .expect("the target is in front of the eye");
            assert!(middle.distance(SIZE / 2.0) < 0.05, "{middle} with {orbit:?}");
            let before = orbit.target;
            orbit.turn(Vec2::new(0.37, -0.21));
            assert_eq!(orbit.target, before);
        }
    }
}

#[test]
fn a_drag_from_above_moves_points_with_the_pointer() {
    let mut orbit = Orbit::default().above();
    let at = Vec3::new(0.7, -0.4, 0.2);
    let before = orbit.eye(SIZE).project(at).unwrap();
    orbit.pan(Vec2::new(0.1, -0.05));
    let moved = orbit.eye(SIZE).project(at).unwrap() - before;
    assert!(moved.distance(Vec2::new(0.1, -0.05) * SIZE.y) < 0.5, "{moved}");
}

#[test]
fn from_above_x_is_to_the_right_and_y_up() {
    let eye = Orbit::default().above().eye(SIZE);
    let [origin, x, y] = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|at| eye.project(at).unwrap());
    assert!(x.x > origin.x && (x.y - origin.y).abs() < 0.1);
    assert!(y.y < origin.y && (y.x - origin.x).abs() < 0.1);
}

#[test]
fn a_zoom_keeps_the_point_under_the_pointer() {
    let mut orbit = Orbit::default();
    let at = Vec3::new(1.4, 0.6, 0.0);
    let before = orbit.eye(SIZE).project(at).unwrap();
    orbit.zoom(0.6, Some(at));
    assert!(orbit.eye(SIZE).project(at).unwrap().distance(before) < 0.1);
    orbit.zoom(1e-9, None);
    assert!(orbit.is_valid(), "the distance has a minimum");
    orbit.zoom(1e9, None);
    assert!(orbit.is_valid(), "the distance has a maximum");
}

#[test]
fn the_transition_to_another_view_turns_the_short_way_and_ends() {
    let goal = Orbit {
        yaw: -3.0,
        ..Orbit::default()
    };
    let mut orbit = Orbit { yaw: 3.0, ..goal };
    let half = orbit.toward(&goal, 0.5);
    assert!(half.yaw.abs() > 3.0, "across ±π, and not around: {}", half.yaw);
    for _ in 0..60 {
        orbit = orbit.toward(&goal, 0.3);
    }
    assert!(orbit.is_at(&goal));
}

#[test]
fn a_point_behind_the_eye_is_not_on_the_screen() {
    let orbit = Orbit::default();
    let eye = orbit.eye(SIZE);
    let point_behind = eye.place + (eye.place - orbit.target);
    assert_eq!(eye.project(point_behind), None);
}

#[test]
fn the_pointer_selects_the_nearest_of_two_things() {
    let eye = Orbit::default().eye(SIZE);
    let near = Vec3::new(0.0, 0.0, 0.2);
    let along = (near - eye.place).normalize();
    let thing = |name: &str, at| Pickable {
        name: name.to_owned(),
        at,
        radius: 0.2,
    };
    let things = [thing("far", near + along * 2.0), thing("near", near)];
    let found = pointer::point(&eye, &things, SIZE / 2.0).unwrap();
    assert_eq!(found.name.as_deref(), Some("near"));
    let beside = pointer::point(&eye, &things, SIZE * 0.9).unwrap();
    assert_eq!((beside.name, beside.at.z), (None, 0.0));
}
