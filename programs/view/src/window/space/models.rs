//! Models of the robot, of people, and of things in a simulated world. Simulated cameras use their own
//! simpler models (`camera/figure.rs` of `robotics/sim`). The two sets are independent.

use std::f32::consts::FRAC_PI_2;

use eframe::egui::Color32;
use glam::{Affine3A, Vec3};
use jde_types::{Pose2D, Thing};

use super::draw_list::{DrawList, Mesh, placed};
use super::scene_data::frame;
use crate::canvas::nose;
use jde_timeline::round;

/// Heights of the rays of a laser and of sonars above the floor, in m.
pub(crate) const LASER_HEIGHT: f32 = 0.277;
pub(crate) const SONAR_HEIGHT: f32 = 0.165;
/// Where the axes of a pan-tilt head cross, in m: ahead, to the left, up.
pub(crate) const HEAD: Vec3 = Vec3::new(0.05, 0.0, 0.35);
/// Lower and upper end of a body, in m.
const BODY_HEIGHTS: [f32; 2] = [0.03, 0.22];

const SHELL: Color32 = Color32::from_rgb(196, 38, 32);
const PLATE: Color32 = Color32::from_rgb(42, 44, 49);
const LASER: Color32 = Color32::from_rgb(62, 96, 168);
const WINDOW: Color32 = Color32::from_rgb(18, 20, 26);
const HEAD_SHELL: Color32 = Color32::from_rgb(206, 208, 212);
const SKIN: Color32 = Color32::from_rgb(222, 178, 146);
const HAIR: Color32 = Color32::from_rgb(66, 48, 38);
const TROUSERS: Color32 = Color32::from_rgb(58, 62, 76);
/// Maximum height of things when they are cut off, in m: above the robot, below most things that would hide
/// it.
pub(crate) const CUT: f32 = 0.5;

/// The devices that a robot carries.
#[derive(Clone, Debug, Default)]
pub(crate) struct Payload {
    /// The poses of its lasers.
    pub(crate) lasers: Vec<Pose2D>,
    /// Pan and tilt in rad, if there is a head.
    pub(crate) head: Option<[f32; 2]>,
}

/// Draws a robot with its outline: a red body whose dark mark shows the heading.
pub(crate) fn robot(draw_list: &mut DrawList, place: Affine3A, outline: &[[f64; 2]], payload: &Payload) {
    let [low, high] = BODY_HEIGHTS;
    let at = |[x, y]: [f64; 2], up: f32| place.transform_point3(Vec3::new(x as f32, y as f32, up));
    let middle = place.transform_point3(Vec3::Z * high);
    for (&one, &two) in outline.iter().zip(outline.iter().cycle().skip(1)) {
        draw_list.triangle([at(one, low), at(two, low), at(two, high)], SHELL);
        draw_list.triangle([at(one, low), at(two, high), at(one, high)], SHELL);
        draw_list.triangle([middle, at(one, high), at(two, high)], SHELL);
    }
    draw_list.triangle(nose(outline).map(|corner| at(corner, high + 0.002)), PLATE);
    for mount in &payload.lasers {
        laser(draw_list, place * frame(*mount));
    }
    if let Some([pan, tilt]) = payload.head {
        let neck = Vec3::new(HEAD.x, 0.0, high);
        let size = Vec3::new(0.09, 0.09, HEAD.z - high);
        draw_list.upright(Mesh::Cylinder, place, neck, size, PLATE);
        let head = place * placed(HEAD, [0.0, tilt, pan]);
        draw_list.form(Mesh::Box, head, Vec3::new(0.1, 0.09, 0.07), HEAD_SHELL);
        let lens = head * placed(Vec3::new(0.055, 0.0, 0.0), [0.0, FRAC_PI_2, 0.0]);
        draw_list.form(Mesh::Cylinder, lens, Vec3::new(0.045, 0.045, 0.03), WINDOW);
    }
}

/// Draws a laser scanner: its head above its dark window.
fn laser(draw_list: &mut DrawList, place: Affine3A) {
    for (form, up, size, color) in [
        (Mesh::Box, 0.22, [0.07, 0.07, 0.04], LASER),
        (Mesh::Cylinder, 0.26, [0.06, 0.06, 0.034], WINDOW),
        (Mesh::Box, 0.294, [0.07, 0.07, 0.014], LASER),
    ] {
        draw_list.upright(form, place, Vec3::Z * up, Vec3::from_array(size), color);
    }
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
            let [half_length, half_width] = [thing.length, thing.width].map(|side| f64::from(side) / 2.0);
            let outline = if thing.length == thing.width {
                round(half_length)
            } else {
                let sides = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
                sides.map(|[x, y]| [x * half_length, y * half_width]).into()
            };
            robot(draw_list, place, &outline, &Payload::default());
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
