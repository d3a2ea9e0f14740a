//! Tags in pictures. Each pixel has the mean of the part of the tag that it shows, so that distant tags become grey
//! instead of flickering.

use super::canvas::Canvas;
use super::flat::fill;
use super::light::Light;
use super::view::{Rays, V3, View, dot, sub};
use crate::color::Color;
use crate::tag::Tag;

const BLACK: Color = Color::new(24, 24, 26);
const WHITE: Color = Color::new(245, 245, 242);
/// How much nearer than its wall a tag counts, to hide it, as a part of the distance.
const AHEAD: f32 = 1e-3;

pub(super) fn draw(tag: &Tag, light: &Light, (view, rays): (&View, &Rays), canvas: &mut Canvas<'_>) {
    let (sin, cos) = libm::sincos(tag.facing);
    let (normal, right) = ([cos, sin, 0.0], [-sin, cos, 0.0]);
    let toward = sub(tag.place, view.eye);
    let half = tag.cells.side as f64 * tag.cell / 2.0;
    // Nothing is on its back.
    let away = dot(normal, toward);
    if away >= 0.0 || !view.is_visible(tag.place, 2.0 * half) {
        return;
    }
    let corner = |x: f64, z: f64| {
        let [a, b, c] = tag.place;
        [a + x * half * right[0], b + x * half * right[1], c + z * half]
    };
    let [black, white] = [BLACK, WHITE].map(|color| light.shade(color, normal).map(f64::from));
    let corners = [
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ];
    fill((&corners, normal), (view, rays, canvas), 1.0 + AHEAD, |u, v| {
        let ray = rays.through(u, v);
        let depth = away / dot(normal, ray);
        // Along each axis of the tag: the place, and how much of it the pixel shows.
        let along = |axis: V3| {
            let step = |by: V3| {
                (depth * (dot(axis, by) - dot(axis, ray) / dot(normal, ray) * dot(normal, by))).abs()
            };
            let place = depth * dot(axis, ray) - dot(axis, toward);
            [
                (place + half) / tag.cell,
                (step(rays.column) + step(rays.row)) / tag.cell,
            ]
        };
        let [[x, width], [y, height]] = [along(right), along([0.0, 0.0, -1.0])];
        let share = tag.cells.white([x, y], [width, height]);
        [0, 1, 2].map(|part| (black[part] + share * (white[part] - black[part]) + 0.5) as u8)
    });
}
