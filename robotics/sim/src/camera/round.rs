//! Balls and upright cylinders, computed by one ray for every pixel that they may cover.
//!
//! There are no facets: edges and shades follow the exact formula.

use super::canvas::{Canvas, middles};
use super::light::Light;
use super::view::{Rays, V3, View, dot, sub};
use crate::color::Color;

/// Something round.
#[derive(Clone, Copy, Debug)]
pub(super) enum Round {
    Ball {
        center: V3,
        radius: f64,
    },
    /// Upright, closed at both ends.
    Cylinder {
        center: [f64; 2],
        radius: f64,
        bottom: f64,
        top: f64,
    },
}

impl Round {
    /// Returns the middle and the radius of its bounding sphere.
    pub(super) fn bounding_sphere(&self) -> (V3, f64) {
        match *self {
            Self::Ball { center, radius } => (center, radius),
            Self::Cylinder {
                center: [x, y],
                radius,
                bottom,
                top,
            } => {
                let half = (top - bottom) / 2.0;
                ([x, y, bottom + half], (radius * radius + half * half).sqrt())
            }
        }
    }

    pub(super) fn draw(
        &self,
        color: Color,
        light: &Light,
        view: &View,
        rays: &Rays,
        canvas: &mut Canvas<'_>,
    ) {
        let ([left, right], [top, bottom]) = self.extent(view);
        let (left, right) = middles(left, right, canvas.width);
        let (top, bottom) = middles(top, bottom, canvas.height);
        for row in top..bottom {
            for (column, (pixel, near)) in (left..).zip(canvas.span(row, left, right)) {
                let ray = rays.through(column as f64 + 0.5, row as f64 + 0.5);
                let Some((depth, normal)) = self.intersect(view.eye, ray) else {
                    continue;
                };
                let inverse = (1.0 / depth) as f32;
                if inverse > *near {
                    *near = inverse;
                    *pixel = light.shade(color, normal);
                }
            }
        }
    }

    /// Returns the columns and rows of the picture that it may cover: all of them when it extends behind the
    /// eye.
    fn extent(&self, view: &View) -> ([f64; 2], [f64; 2]) {
        let corners = self.corners().map(|corner| view.local(corner));
        if corners.iter().any(|corner| corner[2] < 1e-3) {
            return ([0.0, view.width as f64], [0.0, view.height as f64]);
        }
        let pixels = corners.map(|corner| view.pixel(corner));
        let reach = |axis: usize| {
            let along = pixels.iter().map(|pixel| pixel[axis]);
            [
                along.clone().fold(f64::INFINITY, f64::min),
                along.fold(f64::NEG_INFINITY, f64::max),
            ]
        };
        (reach(0), reach(1))
    }

    /// Returns the corners of its upright bounding box.
    fn corners(&self) -> [V3; 8] {
        let ([x, y], radius, bottom, top) = match *self {
            Self::Ball {
                center: [x, y, z],
                radius,
            } => ([x, y], radius, z - radius, z + radius),
            Self::Cylinder {
                center,
                radius,
                bottom,
                top,
            } => (center, radius, bottom, top),
        };
        std::array::from_fn(|index| {
            let side = |bit: usize| if index >> bit & 1 == 0 { -radius } else { radius };
            [
                x + side(0),
                y + side(1),
                if index >> 2 == 0 { bottom } else { top },
            ]
        })
    }

    /// Returns where a ray first hits it from outside: the parameter, and the normal there.
    fn intersect(&self, eye: V3, ray: V3) -> Option<(f64, V3)> {
        match *self {
            Self::Ball { center, radius } => {
                let away = sub(eye, center);
                let (a, b, c) = (dot(ray, ray), dot(away, ray), dot(away, away) - radius * radius);
                let depth = first(a, b, c)?;
                let normal = [0, 1, 2].map(|axis| (away[axis] + depth * ray[axis]) / radius);
                Some((depth, normal))
            }
            Self::Cylinder {
                center,
                radius,
                bottom,
                top,
            } => {
                let (dx, dy) = (eye[0] - center[0], eye[1] - center[1]);
                let square = radius * radius;
                let (a, b, c) = (
                    ray[0] * ray[0] + ray[1] * ray[1],
                    dx * ray[0] + dy * ray[1],
                    dx * dx + dy * dy - square,
                );
                if let Some(depth) = first(a, b, c) {
                    let height = eye[2] + depth * ray[2];
                    if (bottom..=top).contains(&height) {
                        let normal = [
                            (dx + depth * ray[0]) / radius,
                            (dy + depth * ray[1]) / radius,
                            0.0,
                        ];
                        return Some((depth, normal));
                    }
                }
                // The end that faces the eye, if the eye is above or below.
                let (end, normal) = if eye[2] > top { (top, 1.0) } else { (bottom, -1.0) };
                let depth = (end - eye[2]) / ray[2];
                let (x, y) = (dx + depth * ray[0], dy + depth * ray[1]);
                (depth > 0.0 && depth.is_finite() && x * x + y * y <= square)
                    .then_some((depth, [0.0, 0.0, normal]))
            }
        }
    }
}

/// Returns the first solution of `a·t² + 2·b·t + c = 0` ahead of the eye, if the eye is outside.
fn first(a: f64, b: f64, c: f64) -> Option<f64> {
    let square = b * b - a * c;
    (c > 0.0 && b < 0.0 && square >= 0.0).then(|| c / (square.sqrt() - b))
}
