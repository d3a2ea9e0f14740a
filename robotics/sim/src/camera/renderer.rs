//! The contents of a picture: faces and round things, collected from the shapes of a world.
//!
//! It knows outlines and heights, not what they represent. `figure` composes people and robots.

use super::canvas::Canvas;
use super::flat::Face;
use super::floor;
use super::light::Light;
use super::round::Round;
use super::tag;
use super::view::{V3, View, dot, sub};
use crate::color::Color;
use crate::floor::Floor;
use crate::shape::Outline;
use crate::tag::Tag;

/// The things in a picture, without those that the camera cannot see.
pub(crate) struct Renderer<'a> {
    view: View,
    floor: &'a Floor,
    light: &'a Light,
    /// Each with the depth of its nearest corner.
    faces: Vec<(f64, Face)>,
    rounds: Vec<(Round, Color)>,
    tags: &'a [Tag],
}

impl<'a> Renderer<'a> {
    pub(crate) fn new(view: View, (floor, light): (&'a Floor, &'a Light), tags: &'a [Tag]) -> Self {
        Self {
            view,
            floor,
            light,
            faces: Vec::new(),
            rounds: Vec::new(),
            tags,
        }
    }

    /// Adds an upright thing from `bottom` to `top`.
    pub(crate) fn add_outline(&mut self, outline: Outline, [bottom, top]: [f64; 2], color: Color) {
        match outline {
            Outline::Segment { from, to } => self.add_wall(from, to, [bottom, top], color),
            Outline::Box { center, size, angle } => self.add_block(center, size, angle, [bottom, top], color),
            Outline::Circle { center, radius } => {
                let cylinder = Round::Cylinder {
                    center,
                    radius,
                    bottom,
                    top,
                };
                self.add_round(cylinder, color);
            }
        }
    }

    pub(crate) fn add_ball(&mut self, center: V3, radius: f64, color: Color) {
        self.add_round(Round::Ball { center, radius }, color);
    }

    /// Adds an upright convex body from `bottom` to `top`, open at the bottom.
    pub(crate) fn add_prism(&mut self, corners: &[[f64; 2]], [bottom, top]: [f64; 2], color: Color) {
        for (index, from) in corners.iter().enumerate() {
            let to = corners[(index + 1) % corners.len()];
            self.add_wall(*from, to, [bottom, top], color);
            // The top is a fan of triangles around the first corner.
            let lid = [corners[0], *from, to, to].map(|[x, y]| [x, y, top]);
            self.add_outer_face(lid, [0.0, 0.0, 1.0], color);
        }
    }

    /// Draws the picture: three bytes a pixel, rows from the top. Returns the inverse of each pixel's depth in
    /// metres; 0 for the sky.
    pub(crate) fn draw(mut self, picture: &mut [u8]) -> Vec<f32> {
        let rays = self.view.rays();
        let mut canvas = Canvas::new(self.view.width, self.view.height, picture);
        // From near to far: most hidden pixels are then rejected before a colour is written.
        self.faces.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, face) in &self.faces {
            face.draw(&self.view, &rays, &mut canvas);
        }
        for (round, color) in &self.rounds {
            round.draw(*color, self.light, &self.view, &rays, &mut canvas);
        }
        for tag in self.tags {
            tag::draw(tag, self.light, (&self.view, &rays), &mut canvas);
        }
        floor::draw((self.floor, self.light), &self.view, &rays, &mut canvas);
        canvas.into_near()
    }

    fn add_round(&mut self, round: Round, color: Color) {
        let (center, radius) = round.bounding_sphere();
        if self.view.is_visible(center, radius) {
            self.rounds.push((round, color));
        }
    }

    fn add_wall(&mut self, from: [f64; 2], to: [f64; 2], heights: [f64; 2], color: Color) {
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let length = libm::hypot(dx, dy);
        let eye = self.view.eye;
        // The wall is lit on the side that the camera sees.
        let side = dy * (eye[0] - from[0]) - dx * (eye[1] - from[1]);
        let sign = if side < 0.0 { -1.0 } else { 1.0 };
        let normal = [sign * dy / length, sign * -dx / length, 0.0];
        self.add_face(upright(from, to, heights), normal, color);
    }

    fn add_block(
        &mut self,
        [x, y]: [f64; 2],
        size: [f64; 2],
        angle: f64,
        [bottom, top]: [f64; 2],
        color: Color,
    ) {
        let (sin, cos) = libm::sincos(angle);
        let half = size.map(|size| size / 2.0);
        let middle = (bottom + top) / 2.0;
        let around = (half[0] * half[0] + half[1] * half[1] + (top - middle) * (top - middle)).sqrt();
        if !self.view.is_visible([x, y, middle], around) {
            return;
        }
        let corner = |a: f64, b: f64| {
            let (a, b) = (a * half[0], b * half[1]);
            [x + cos * a - sin * b, y + sin * a + cos * b]
        };
        let corners = [
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ];
        let normals = [[sin, -cos], [cos, sin], [-sin, cos], [-cos, -sin]];
        for (side, normal) in normals.into_iter().enumerate() {
            let (from, to) = (corners[side], corners[(side + 1) % 4]);
            self.add_outer_face(
                upright(from, to, [bottom, top]),
                [normal[0], normal[1], 0.0],
                color,
            );
        }
        for (height, up) in [(top, 1.0), (bottom, -1.0)] {
            self.add_outer_face(corners.map(|[x, y]| [x, y, height]), [0.0, 0.0, up], color);
        }
    }

    /// Adds a face of a solid, unless the face looks away from the eye.
    fn add_outer_face(&mut self, corners: [V3; 4], normal: V3, color: Color) {
        if dot(normal, sub(self.view.eye, corners[0])) > 0.0 {
            self.add_face(corners, normal, color);
        }
    }

    fn add_face(&mut self, corners: [V3; 4], normal: V3, color: Color) {
        let depths = corners.map(|corner| self.view.local(corner)[2]);
        if depths.iter().any(|depth| *depth > 0.0) {
            let face = Face {
                corners,
                normal,
                color: self.light.shade(color, normal),
            };
            self.faces
                .push((depths.into_iter().fold(f64::INFINITY, f64::min), face));
        }
    }
}

fn upright(from: [f64; 2], to: [f64; 2], [bottom, top]: [f64; 2]) -> [V3; 4] {
    [
        [from[0], from[1], bottom],
        [to[0], to[1], bottom],
        [to[0], to[1], top],
        [from[0], from[1], top],
    ]
}
