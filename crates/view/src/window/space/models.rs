//! Models of the robot, of people, and of things in a simulated world. Simulated cameras use their own
//! simpler models (`camera/figure.rs` of `crates/sim`). The two sets are independent.

use std::f32::consts::{FRAC_PI_2, TAU};

use eframe::egui::Color32;
use glam::{Affine3A, Vec3};
use jde_types::Thing;

use super::draw_list::{DrawList, Mesh, placed};

/// Height of the rays of a laser on a Pioneer's plate above the floor, in m.
pub(crate) const LASER_HEIGHT: f32 = 0.277;
/// Height of its sonars, in m.
pub(crate) const SONAR_HEIGHT: f32 = 0.165;
/// Where the axes of its pan-tilt head cross, in m: ahead, to the left, up.
pub(crate) const HEAD: Vec3 = Vec3::new(0.05, 0.0, 0.35);
/// Distance of its laser ahead of its middle, in m.
pub(crate) const LASER_AHEAD: f32 = 0.018;

const SHELL: Color32 = Color32::from_rgb(196, 38, 32);
const PLATE: Color32 = Color32::from_rgb(42, 44, 49);
const TYRE: Color32 = Color32::from_rgb(30, 31, 34);
const RIM: Color32 = Color32::from_rgb(176, 180, 186);
const LASER: Color32 = Color32::from_rgb(62, 96, 168);
const WINDOW: Color32 = Color32::from_rgb(18, 20, 26);
const SONAR: Color32 = Color32::from_rgb(202, 168, 84);
const HEAD_SHELL: Color32 = Color32::from_rgb(206, 208, 212);
const SKIN: Color32 = Color32::from_rgb(222, 178, 146);
const HAIR: Color32 = Color32::from_rgb(66, 48, 38);
const TROUSERS: Color32 = Color32::from_rgb(58, 62, 76);
/// Maximum height of things when they are cut off, in m: above the robot, below most things that would hide
/// it.
pub(crate) const CUT: f32 = 0.5;

/// The devices that a robot carries.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Payload {
    pub(crate) laser: bool,
    pub(crate) sonars: bool,
    /// Pan and tilt in rad, if there is a head.
    pub(crate) head: Option<[f32; 2]>,
    /// Angles of the left and right wheel, in rad.
    pub(crate) wheels: [f32; 2],
}

/// Draws a Pioneer: a red body between two wheels under a dark plate.
pub(crate) fn robot(draw_list: &mut DrawList, place: Affine3A, payload: &Payload) {
    let body = |draw_list: &mut DrawList, ahead: f32, size: [f32; 3], up: f32, color| {
        let size = Vec3::from_array(size);
        draw_list.upright(Mesh::Box, place, Vec3::new(ahead, 0.0, up), size, color);
    };
    // The body is narrower at the wheels, and round in front and at the rear.
    body(draw_list, -0.045, [0.31, 0.26, 0.165], 0.055, SHELL);
    body(draw_list, -0.02, [0.24, 0.29, 0.10], 0.115, SHELL);
    for (ahead, width) in [(0.075, 0.27), (-0.165, 0.25)] {
        draw_list.upright(
            Mesh::Cylinder,
            place,
            Vec3::new(ahead, 0.0, 0.06),
            Vec3::new(0.2, width, 0.16),
            SHELL,
        );
    }
    // The plate.
    body(draw_list, -0.03, [0.3, 0.36, 0.012], 0.222, PLATE);
    for ahead in [0.09, -0.16] {
        draw_list.upright(
            Mesh::Cylinder,
            place,
            Vec3::new(ahead, 0.0, 0.222),
            Vec3::new(0.2, 0.36, 0.012),
            PLATE,
        );
    }
    for (side, angle) in [(1.0, payload.wheels[0]), (-1.0, payload.wheels[1])] {
        wheel(draw_list, place, Vec3::new(0.0, side * 0.165, 0.0975), angle);
    }
    // The castor.
    let castor = place * placed(Vec3::new(-0.2, 0.0, 0.0375), [FRAC_PI_2, 0.0, 0.0]);
    draw_list.form(Mesh::Cylinder, castor, Vec3::new(0.075, 0.075, 0.03), TYRE);
    if payload.sonars {
        // Eight in front and eight at the rear, as on a P3-DX.
        for degrees in [90.0_f32, 50.0, 30.0, 10.0, -10.0, -30.0, -50.0, -90.0] {
            for (middle, rotated) in [(0.05, 0.0), (-0.14, 180.0)] {
                let heading = (degrees + rotated).to_radians();
                let (sin, cos) = heading.sin_cos();
                let at = Vec3::new(middle + 0.125 * cos, 0.138 * sin, SONAR_HEIGHT);
                let facing = place * placed(at, [0.0, FRAC_PI_2, heading]);
                draw_list.form(Mesh::Cylinder, facing, Vec3::new(0.034, 0.034, 0.02), SONAR);
            }
        }
    }
    if payload.laser {
        laser(draw_list, place);
    }
    if let Some([pan, tilt]) = payload.head {
        let foot = if payload.laser { 0.308 } else { 0.234 };
        let neck = Vec3::new(HEAD.x, 0.0, foot);
        let size = Vec3::new(0.09, 0.09, HEAD.z - foot);
        draw_list.upright(Mesh::Cylinder, place, neck, size, PLATE);
        let head = place * placed(HEAD, [0.0, tilt, pan]);
        draw_list.form(Mesh::Box, head, Vec3::new(0.1, 0.09, 0.07), HEAD_SHELL);
        let lens = head * placed(Vec3::new(0.055, 0.0, 0.0), [0.0, FRAC_PI_2, 0.0]);
        draw_list.form(Mesh::Cylinder, lens, Vec3::new(0.045, 0.045, 0.03), WINDOW);
    }
}

fn wheel(draw_list: &mut DrawList, place: Affine3A, at: Vec3, angle: f32) {
    // The axle is the z axis of the wheel's frame.
    let wheel = place * placed(at, [FRAC_PI_2, 0.0, 0.0]) * Affine3A::from_rotation_z(-angle);
    draw_list.form(Mesh::Cylinder, wheel, Vec3::new(0.195, 0.195, 0.045), TYRE);
    draw_list.form(Mesh::Cylinder, wheel, Vec3::new(0.115, 0.115, 0.05), RIM);
    for spoke in 0..5 {
        let rotated = wheel * Affine3A::from_rotation_z(spoke as f32 / 5.0 * TAU);
        let spoke = rotated * Affine3A::from_translation(Vec3::new(0.032, 0.0, 0.0));
        draw_list.form(Mesh::Box, spoke, Vec3::new(0.042, 0.012, 0.054), TYRE);
    }
}

/// Draws a laser scanner: its head above its dark window.
fn laser(draw_list: &mut DrawList, place: Affine3A) {
    let at = |up: f32| Vec3::new(LASER_AHEAD, 0.0, up);
    draw_list.upright(Mesh::Box, place, at(0.234), Vec3::new(0.14, 0.145, 0.026), LASER);
    draw_list.upright(
        Mesh::Cylinder,
        place,
        at(0.26),
        Vec3::new(0.125, 0.125, 0.034),
        WINDOW,
    );
    draw_list.upright(Mesh::Box, place, at(0.294), Vec3::new(0.14, 0.145, 0.014), LASER);
}

/// Draws a thing of a simulated world, in the frame in which it is given, cut off at a height if `cut` has
/// one.
pub(crate) fn thing(
    draw_list: &mut DrawList,
    frame: Affine3A,
    thing: &Thing,
    cut: Option<f32>,
    edge: Color32,
) {
    let sizes = [thing.length, thing.width, thing.height];
    let pose = [thing.pose.x, thing.pose.y, thing.pose.theta].map(|number| number as f32);
    if !sizes.iter().chain(&pose).all(|number| number.is_finite()) {
        return;
    }
    let place = frame * placed(Vec3::new(pose[0], pose[1], 0.0), [0.0, 0.0, pose[2]]);
    let color = Color32::from_rgb(thing.red, thing.green, thing.blue);
    let height = cut.map_or(thing.height, |cut| thing.height.min(cut));
    let size = Vec3::new(thing.length, thing.width.max(0.04), height);
    match thing.form {
        Thing::CYLINDER => draw_list.upright(Mesh::Cylinder, place, Vec3::ZERO, size, color),
        Thing::BALL => {
            let middle = place * Affine3A::from_translation(Vec3::Z * thing.length / 2.0);
            draw_list.form(Mesh::Sphere, middle, Vec3::splat(thing.length), color);
        }
        Thing::PERSON => person(draw_list, place, thing.length / 2.0, thing.height, color),
        Thing::ROBOT => {
            let scaled = place * Affine3A::from_scale(Vec3::splat(thing.length / 0.5));
            let payload = Payload {
                laser: true,
                sonars: true,
                ..Payload::default()
            };
            robot(draw_list, scaled, &payload);
        }
        Thing::PAINT => draw_list.upright(Mesh::Box, place, Vec3::ZERO, size, color),
        // A box, or a form that this version does not know.
        _ => {
            draw_list.upright(Mesh::Box, place, Vec3::ZERO, size, color);
            outline(draw_list, place, size, edge);
        }
    }
}

/// Draws the upper edges of a box, which separate things that are lit alike.
fn outline(draw_list: &mut DrawList, place: Affine3A, size: Vec3, edge: Color32) {
    let half = size / 2.0;
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let point = |[x, y]: [f32; 2]| place.transform_point3(Vec3::new(x * half.x, y * half.y, size.z));
    draw_list.lines(corners.map(point), 1.0, edge);
}

fn person(draw_list: &mut DrawList, place: Affine3A, radius: f32, height: f32, color: Color32) {
    let (hip, shoulder) = (0.48 * height, 0.83 * height);
    let mut part = |ahead: f32, left: f32, width: f32, [low, high]: [f32; 2], color| {
        let size = Vec3::new(width, width, high - low);
        draw_list.upright(Mesh::Cylinder, place, Vec3::new(ahead, left, low), size, color);
    };
    for side in [1.0, -1.0] {
        part(0.0, side * 0.4 * radius, 0.5 * radius, [0.0, hip], TROUSERS);
        part(
            0.0,
            side * 0.8 * radius,
            0.38 * radius,
            [0.46 * height, 0.81 * height],
            color,
        );
    }
    part(0.0, 0.0, 1.24 * radius, [hip, shoulder], color);
    part(0.0, 0.0, 0.44 * radius, [shoulder, 0.88 * height], SKIN);
    let skull = 0.132 * height;
    for (ahead, up, width, color) in [(0.0, 0.0, skull, SKIN), (-0.015, 0.02, 0.98 * skull, HAIR)] {
        let at = place * Affine3A::from_translation(Vec3::new(ahead, 0.0, 0.93 * height + up));
        draw_list.form(Mesh::Sphere, at, Vec3::splat(width), color);
    }
}
