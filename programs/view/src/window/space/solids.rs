//! Adds the shapes of schemas' panels to the draw list.

use glam::{Affine3A, Vec3};
use jde_panel::{Place, Solid};

use super::draw_list::{DrawList, Mesh, placed};
use crate::style::{Style, exact};

/// Diameter of an arrow's shaft: as a fraction of its length, and its maximum in m.
const SHAFT_DIAMETER: (f32, f32) = (0.04, 0.06);

/// Adds a shape that is given in `frame`. Its list has been validated.
pub(crate) fn add(draw_list: &mut DrawList, frame: Affine3A, solid: &Solid, style: &Style) {
    let point = |point: &[f64; 3]| frame.transform_point3(vector(*point));
    match solid {
        Solid::Line { points, color, width } => {
            draw_list.lines(points.iter().map(point), *width, exact(*color, style))
        }
        Solid::Points { points, color, width } => {
            let color = exact(*color, style);
            points
                .iter()
                .for_each(|at| draw_list.dot(point(at), *width, color));
        }
        Solid::Box { place, size, color } => {
            draw_list.form(Mesh::Box, frame * at(place), vector(*size), exact(*color, style));
        }
        Solid::Sphere {
            center,
            radius,
            color,
        } => {
            let place = frame * Affine3A::from_translation(vector(*center));
            let size = Vec3::splat(2.0 * *radius as f32);
            draw_list.form(Mesh::Sphere, place, size, exact(*color, style));
        }
        Solid::Cylinder {
            place,
            radius,
            height,
            color,
        } => {
            let diameter = 2.0 * *radius as f32;
            let size = Vec3::new(diameter, diameter, *height as f32);
            draw_list.form(Mesh::Cylinder, frame * at(place), size, exact(*color, style));
        }
        Solid::Arrow { from, to, color } => {
            let (from, to) = (point(from), point(to));
            let shaft_diameter = (SHAFT_DIAMETER.0 * from.distance(to)).min(SHAFT_DIAMETER.1);
            draw_list.arrow(from, to, shaft_diameter, exact(*color, style));
        }
        Solid::Mesh { corners, color } => {
            let color = exact(*color, style);
            for corners in corners.chunks_exact(3) {
                draw_list.triangle(
                    [point(&corners[0]), point(&corners[1]), point(&corners[2])],
                    color,
                );
            }
        }
        Solid::Label { at, text, color } => draw_list.label(point(at), text, exact(*color, style)),
    }
}

pub(super) fn at(place: &Place) -> Affine3A {
    placed(vector(place.at), place.turned.map(|angle| angle as f32))
}

pub(super) fn vector([x, y, z]: [f64; 3]) -> Vec3 {
    Vec3::new(x as f32, y as f32, z as f32)
}
