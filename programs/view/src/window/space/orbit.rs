//! The view of space: an eye around a target, at a distance. Pure geometry in metres and radians. Points of
//! the screen are relative to the upper left corner of the picture.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::camera::rh::proj::directx::perspective;
use glam::camera::rh::view::look_to_mat4;
use glam::{Mat4, Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};

/// Vertical field of view, in rad: that of a normal lens, with little distortion.
const FIELD_OF_VIEW: f32 = 40.0 * PI / 180.0;
/// Distance of the near plane, as a fraction of the distance of the target.
const NEAR_PLANE: f32 = 0.02;
/// Distance of the far plane, in m: beyond any building.
const FAR_PLANE: f32 = 2000.0;
/// Least and greatest distance of the eye from its target, in m.
const DISTANCE_RANGE: (f32, f32) = (0.3, 400.0);
/// Least and greatest pitch, in rad. The eye stays above the floor, below which nothing is visible.
const PITCH_RANGE: (f32, f32) = (0.02, FRAC_PI_2);

/// An eye that looks at a target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Orbit {
    /// The target, in m.
    pub(crate) target: Vec3,
    /// Direction from the target to the eye in the plane, in rad counterclockwise from x.
    pub(crate) yaw: f32,
    /// Elevation of the eye above the plane, in rad: π/2 is vertically above.
    pub(crate) pitch: f32,
    /// Distance of the eye from the target, in m.
    pub(crate) distance: f32,
}

/// The view of an orbit for a picture of a size. It maps points of space to points of the screen and back.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Eye {
    pub(crate) place: Vec3,
    pub(crate) size: Vec2,
    pub(crate) view_projection: Mat4,
    /// Distance of the target, in m.
    pub(crate) distance: f32,
    /// The target, in the middle of the picture.
    pub(crate) target: Vec3,
    /// Unit vectors to the right and up on the screen.
    pub(crate) right: Vec3,
    pub(crate) up: Vec3,
}

/// A half line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub(crate) from: Vec3,
    /// The direction, of length 1.
    pub(crate) along: Vec3,
}

/// From behind and above the robot.
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
    /// The same view from vertically above, as a map: x to the right and y up.
    pub(crate) fn above(self) -> Self {
        Self {
            yaw: -FRAC_PI_2,
            pitch: FRAC_PI_2,
            ..self
        }
    }

    /// Turns around the target, by fractions of the picture's height.
    pub(crate) fn turn(&mut self, delta: Vec2) {
        self.yaw = (self.yaw - delta.x * PI + PI).rem_euclid(TAU) - PI;
        self.pitch = (self.pitch + delta.y * PI).clamp(PITCH_RANGE.0, PITCH_RANGE.1);
    }

    /// Moves the target with the pointer, by fractions of the picture's height.
    pub(crate) fn pan(&mut self, delta: Vec2) {
        let (right, up) = (self.right(), self.up());
        let scale = 2.0 * (FIELD_OF_VIEW / 2.0).tan() * self.distance;
        // An upward drag moves away on the floor, limited at flat angles.
        let ahead = Vec3::new(-self.yaw.cos(), -self.yaw.sin(), 0.0);
        let lift = up.dot(ahead).max(0.35);
        self.target -= right * (delta.x * scale) - ahead * (delta.y * scale / lift);
    }

    /// Zooms: factors below 1 move nearer. The point `fixed` stays in place on the screen.
    pub(crate) fn zoom(&mut self, factor: f32, fixed: Option<Vec3>) {
        let distance = (self.distance * factor).clamp(DISTANCE_RANGE.0, DISTANCE_RANGE.1);
        let ratio = distance / self.distance;
        if let Some(fixed) = fixed {
            self.target = fixed + (self.target - fixed) * ratio;
        }
        self.distance = distance;
    }

    /// Interpolates to another view by a fraction from 0 to 1. Turns the shorter way.
    pub(crate) fn toward(&self, goal: &Self, share: f32) -> Self {
        let turn = (goal.yaw - self.yaw + PI).rem_euclid(TAU) - PI;
        Self {
            target: self.target.lerp(goal.target, share),
            yaw: self.yaw + turn * share,
            pitch: self.pitch + (goal.pitch - self.pitch) * share,
            distance: self.distance + (goal.distance - self.distance) * share,
        }
    }

    /// Whether the view is indistinguishable from `goal`.
    pub(crate) fn is_at(&self, goal: &Self) -> bool {
        let turn = (goal.yaw - self.yaw + PI).rem_euclid(TAU) - PI;
        let small = 1e-3;
        self.target.distance(goal.target) < small * goal.distance
            && turn.abs() < small
            && (self.pitch - goal.pitch).abs() < small
            && (self.distance - goal.distance).abs() < small * goal.distance
    }

    /// Whether all numbers are finite and within their limits. Saved state may contain anything.
    pub(crate) fn is_valid(&self) -> bool {
        self.target.is_finite()
            && self.yaw.is_finite()
            && (PITCH_RANGE.0..=PITCH_RANGE.1).contains(&self.pitch)
            && (DISTANCE_RANGE.0..=DISTANCE_RANGE.1).contains(&self.distance)
    }

    /// The eye for a picture of a size in points.
    pub(crate) fn eye(&self, size: Vec2) -> Eye {
        let size = size.max(Vec2::ONE);
        let place = self.target + self.back() * self.distance;
        let view = look_to_mat4(place, -self.back(), self.up());
        let projection = perspective(
            FIELD_OF_VIEW,
            size.x / size.y,
            NEAR_PLANE * self.distance,
            FAR_PLANE,
        );
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

    /// The unit vector from the target to the eye.
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
    /// The point of the screen that shows a point of space, if it is in front of the eye.
    pub(crate) fn project(&self, point: Vec3) -> Option<Vec2> {
        let clip = self.view_projection * point.extend(1.0);
        (clip.w > 1e-4).then(|| {
            let at = Vec2::new(clip.x, -clip.y) / clip.w;
            (at * 0.5 + 0.5) * self.size
        })
    }

    /// The ray through a point of the screen.
    pub(crate) fn ray(&self, at: Vec2) -> Ray {
        let at = (at / self.size) * 2.0 - 1.0;
        let far = self.view_projection.inverse() * Vec4::new(at.x, -at.y, 1.0, 1.0);
        let along = (far.truncate() / far.w - self.place).normalize();
        Ray {
            from: self.place,
            along,
        }
    }

    /// Points of the screen per metre at a position.
    pub(crate) fn scale(&self, at: Vec3) -> f32 {
        let depth = (at - self.place).length().max(1e-3);
        self.size.y / (2.0 * (FIELD_OF_VIEW / 2.0).tan() * depth)
    }
}

impl Ray {
    /// The point where the ray meets the floor, if it is nearer than [`FAR_PLANE`].
    pub(crate) fn floor(&self) -> Option<Vec3> {
        let distance = -self.from.z / self.along.z;
        (distance.is_finite() && distance > 0.0 && distance < FAR_PLANE).then(|| {
            let at = self.from + self.along * distance;
            Vec3::new(at.x, at.y, 0.0)
        })
    }

    /// Distance along the ray to a sphere.
    pub(crate) fn ball(&self, center: Vec3, radius: f32) -> Option<f32> {
        let to_center = center - self.from;
        let middle = to_center.dot(self.along);
        let offset_squared = to_center.length_squared() - middle * middle;
        let half = radius * radius - offset_squared;
        (middle > 0.0 && half >= 0.0).then(|| middle - half.sqrt())
    }
}
