//! The floor with its faint grid of metres, and the sky: the background where there is no thing.
//!
//! It is drawn last, and skips pixels that already have a depth.

use super::canvas::Canvas;
use super::light::Light;
use super::view::{Rays, V3, View};
use crate::color::Color;

/// Half the width of a line of the grid, in metres.
const LINE: f64 = 0.012;
/// How much a line darkens the floor.
const FAINT: f64 = 0.16;
/// How much darker the sky is at the zenith than at the horizon.
const ZENITH: f64 = 0.3;

pub(super) fn draw(light: &Light, view: &View, rays: &Rays, canvas: &mut Canvas<'_>) {
    let floor = light.shade(light.floor, [0.0, 0.0, 1.0]);
    for row in 0..canvas.height {
        let v = row as f64 + 0.5;
        let width = canvas.width;
        for (column, (pixel, near)) in canvas.span(row, 0, width).enumerate() {
            if *near > 0.0 {
                continue;
            }
            let ray = rays.through(column as f64 + 0.5, v);
            *pixel = if ray[2] >= 0.0 {
                sky(light.sky, ray)
            } else {
                let line = line(view.eye, ray, rays);
                floor.map(|part| (f64::from(part) * (1.0 - FAINT * line) + 0.5) as u8)
            };
        }
    }
}

/// Returns how much of a pixel of the floor the lines of the grid cover, from 0 to 1.
fn line(eye: V3, ray: V3, rays: &Rays) -> f64 {
    // An eye below the floor has no floor ahead of it.
    let depth = (-eye[2] / ray[2]).max(0.0);
    let cover = |axis: usize| {
        // How far the point on the floor moves from one pixel to the next: distant lines fade instead of
        // flickering.
        let slope = ray[axis] / ray[2];
        let moves = |step: V3| (depth * (step[axis] - slope * step[2])).abs();
        let pixel = moves(rays.column) + moves(rays.row) + 1e-9;
        let place = eye[axis] + depth * ray[axis];
        let from_line = (place - libm::rint(place)).abs();
        ((LINE + pixel / 2.0 - from_line) / pixel).clamp(0.0, (2.0 * LINE / pixel).min(1.0))
    };
    cover(0).max(cover(1))
}

fn sky(color: Color, [x, y, z]: V3) -> [u8; 3] {
    let up = z * z / (x * x + y * y + z * z);
    [color.r, color.g, color.b].map(|part| (f64::from(part) * (1.0 - ZENITH * up) + 0.5) as u8)
}
