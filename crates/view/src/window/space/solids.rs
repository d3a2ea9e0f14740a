//! The shapes of schemas' own panels, put among the rest.

use glam::{Affine3A, Vec3};
use jde_panel::{Place, Solid};

use super::stage::{Form, Stage, placed};
use crate::look::{Look, exact};

/// How thick the shaft of an arrow is, beside its length, and at most, m.
const SHAFT: (f32, f32) = (0.04, 0.06);

/// Puts a shape that is told in a frame where that frame is. The list it is from has been checked.
pub(crate) fn put(stage: &mut Stage, frame: Affine3A, solid: &Solid, look: &Look) {
    let point = |point: &[f64; 3]| frame.transform_point3(vector(*point));
    match solid {
        Solid::Line { points, color, width } => {
            stage.lines(points.iter().map(point), *width, exact(*color, look))
        }
        Solid::Points { points, color, width } => {
            let color = exact(*color, look);
            points.iter().for_each(|at| stage.dot(point(at), *width, color));
        }
        Solid::Box { place, size, color } => {
            stage.form(Form::Box, frame * at(place), vector(*size), exact(*color, look));
        }
        Solid::Sphere {
            center,
            radius,
            color,
        } => {
            let place = frame * Affine3A::from_translation(vector(*center));
            let size = Vec3::splat(2.0 * *radius as f32);
            stage.form(Form::Sphere, place, size, exact(*color, look));
        }
        Solid::Cylinder {
            place,
            radius,
            height,
            color,
        } => {
            let wide = 2.0 * *radius as f32;
            let size = Vec3::new(wide, wide, *height as f32);
            stage.form(Form::Cylinder, frame * at(place), size, exact(*color, look));
        }
        Solid::Arrow { from, to, color } => {
            let (from, to) = (point(from), point(to));
            let thick = (SHAFT.0 * from.distance(to)).min(SHAFT.1);
            stage.arrow(from, to, thick, exact(*color, look));
        }
        Solid::Mesh { corners, color } => {
            let color = exact(*color, look);
            for corners in corners.chunks_exact(3) {
                stage.triangle(
                    [point(&corners[0]), point(&corners[1]), point(&corners[2])],
                    color,
                );
            }
        }
        Solid::Label { at, text, color } => stage.label(point(at), text, exact(*color, look)),
    }
}

pub(super) fn at(place: &Place) -> Affine3A {
    placed(vector(place.at), place.turned.map(|angle| angle as f32))
}

pub(super) fn vector([x, y, z]: [f64; 3]) -> Vec3 {
    Vec3::new(x as f32, y as f32, z as f32)
}
