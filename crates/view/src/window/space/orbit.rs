//! From where space is looked at: around a target, from a distance. Pure geometry in metres and radians; points of the screen are
//! counted from the upper left corner of the picture.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::camera::rh::proj::directx::perspective;
use glam::camera::rh::view::look_to_mat4;
use glam::{Mat4, Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};

/// The vertical angle of the picture: that of a normal lens, which distorts little.
const FIELD: f32 = 40.0 * PI / 180.0;
/// Nearest thing that is drawn, beside the distance of the target.
const NEAR: f32 = 0.02;
/// Farthest thing that is drawn, m: beyond any building.
const FAR: f32 = 2000.0;
/// Nearest and farthest that the eye goes, m.
const DISTANCES: (f32, f32) = (0.3, 400.0);
/// Just under the floor is the lowest view: from below nothing is to be seen.
const PITCHES: (f32, f32) = (0.02, FRAC_PI_2);

/// An eye that looks at a target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Orbit {
    /// What it looks at, m.
    pub(crate) target: Vec3,
    /// Where the eye is as seen from the target: its direction in the plane, from x to the left.
    pub(crate) yaw: f32,
    /// How far above the plane; a quarter of a turn is straight above.
    pub(crate) pitch: f32,
    /// How far from the target, m.
    pub(crate) distance: f32,
}

/// An orbit and the size of the picture: what takes points of space to points of the screen and back.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Eye {
    pub(crate) place: Vec3,
    pub(crate) size: Vec2,
    pub(crate) view_projection: Mat4,
    /// How far away what the orbit looks at is, m.
    pub(crate) distance: f32,
    /// The middle of the picture: what the orbit looks at.
    pub(crate) target: Vec3,
    /// To the right and up on the screen, of length 1.
    pub(crate) right: Vec3,
    pub(crate) up: Vec3,
}

/// A half line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub(crate) from: Vec3,
    /// Of length 1.
    pub(crate) along: Vec3,
}

/// From behind the robot and above it, as one follows a toy.
impl Default for Orbit {
    fn default() -> Self {
        Self {
            target: Vec3::new(0.0, 0.0, 0.2),
            yaw: -2.4,
            pitch: 0.72,
            distance: 6.5,
        }
    }
}

impl Orbit {
    /// The same as a map: x to the right and y up.
    pub(crate) fn above(self) -> Self {
        Self {
            yaw: -FRAC_PI_2,
            pitch: FRAC_PI_2,
            ..self
        }
    }

    /// Goes around the target, by parts of the picture's height.
    pub(crate) fn turn(&mut self, by: Vec2) {
        self.yaw = (self.yaw - by.x * PI + PI).rem_euclid(TAU) - PI;
        self.pitch = (self.pitch + by.y * PI).clamp(PITCHES.0, PITCHES.1);
    }

    /// Takes the target along with the pointer, by parts of the picture's height.
    pub(crate) fn pan(&mut self, by: Vec2) {
        let (right, up) = (self.right(), self.up());
        let scale = 2.0 * (FIELD / 2.0).tan() * self.distance;
        // What is dragged up moves away on the floor, however flat one looks at it.
        let ahead = Vec3::new(-self.yaw.cos(), -self.yaw.sin(), 0.0);
        let lift = up.dot(ahead).max(0.35);
        self.target -= right * (by.x * scale) - ahead * (by.y * scale / lift);
    }

    /// Nearer with factors below 1; what lies at `fixed` stays where it is on the screen.
    pub(crate) fn zoom(&mut self, factor: f32, fixed: Option<Vec3>) {
        let distance = (self.distance * factor).clamp(DISTANCES.0, DISTANCES.1);
        let done = distance / self.distance;
        if let Some(fixed) = fixed {
            self.target = fixed + (self.target - fixed) * done;
        }
        self.distance = distance;
    }

    /// Part of the way to another view, from 0 to 1; turns by the shorter way.
    pub(crate) fn toward(&self, goal: &Self, part: f32) -> Self {
        let turn = (goal.yaw - self.yaw + PI).rem_euclid(TAU) - PI;
        Self {
            target: self.target.lerp(goal.target, part),
            yaw: self.yaw + turn * part,
            pitch: self.pitch + (goal.pitch - self.pitch) * part,
            distance: self.distance + (goal.distance - self.distance) * part,
        }
    }

    /// Whether nobody would see the difference.
    pub(crate) fn is_at(&self, goal: &Self) -> bool {
        let turn = (goal.yaw - self.yaw + PI).rem_euclid(TAU) - PI;
        let small = 1e-3;
        self.target.distance(goal.target) < small * goal.distance
            && turn.abs() < small
            && (self.pitch - goal.pitch).abs() < small
            && (self.distance - goal.distance).abs() < small * goal.distance
    }

    /// Whether every number is one; a file may say anything.
    pub(crate) fn is_sound(&self) -> bool {
        self.target.is_finite()
            && self.yaw.is_finite()
            && (PITCHES.0..=PITCHES.1).contains(&self.pitch)
            && (DISTANCES.0..=DISTANCES.1).contains(&self.distance)
    }

    /// With a picture of so many points.
    pub(crate) fn eye(&self, size: Vec2) -> Eye {
        let size = size.max(Vec2::ONE);
        let place = self.target + self.back() * self.distance;
        let view = look_to_mat4(place, -self.back(), self.up());
        let projection = perspective(FIELD, size.x / size.y, NEAR * self.distance, FAR);
        Eye {
            place,
            size,
            view_projection: projection * view,
            distance: self.distance,
            target: self.target,
            right: self.right(),
            up: self.up(),
        }
    }

    /// From the target to the eye.
    fn back(&self) -> Vec3 {
        let (sin, cos) = self.pitch.sin_cos();
        Vec3::new(cos * self.yaw.cos(), cos * self.yaw.sin(), sin)
    }

    fn right(&self) -> Vec3 {
        Vec3::new(-self.yaw.sin(), self.yaw.cos(), 0.0)
    }

    fn up(&self) -> Vec3 {
        self.back().cross(self.right())
    }
}

impl Eye {
    /// Where a point of space is on the screen, if it is before the eye.
    pub(crate) fn project(&self, point: Vec3) -> Option<Vec2> {
        let clip = self.view_projection * point.extend(1.0);
        (clip.w > 1e-4).then(|| {
            let at = Vec2::new(clip.x, -clip.y) / clip.w;
            (at * 0.5 + 0.5) * self.size
        })
    }

    /// What a point of the screen may show.
    pub(crate) fn ray(&self, at: Vec2) -> Ray {
        let at = (at / self.size) * 2.0 - 1.0;
        let far = self.view_projection.inverse() * Vec4::new(at.x, -at.y, 1.0, 1.0);
        let along = (far.truncate() / far.w - self.place).normalize();
        Ray {
            from: self.place,
            along,
        }
    }

    /// Points of the screen that a metre takes at a place.
    pub(crate) fn scale(&self, at: Vec3) -> f32 {
        let depth = (at - self.place).length().max(1e-3);
        self.size.y / (2.0 * (FIELD / 2.0).tan() * depth)
    }
}

impl Ray {
    /// Where it meets the floor, if it does so within reach.
    pub(crate) fn floor(&self) -> Option<Vec3> {
        let way = -self.from.z / self.along.z;
        (way.is_finite() && way > 0.0 && way < FAR).then(|| {
            let at = self.from + self.along * way;
            Vec3::new(at.x, at.y, 0.0)
        })
    }

    /// How far along it a ball begins.
    pub(crate) fn ball(&self, center: Vec3, radius: f32) -> Option<f32> {
        let to = center - self.from;
        let middle = to.dot(self.along);
        let aside = to.length_squared() - middle * middle;
        let half = radius * radius - aside;
        (middle > 0.0 && half >= 0.0).then(|| middle - half.sqrt())
    }
}
