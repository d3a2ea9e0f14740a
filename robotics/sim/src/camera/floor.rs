//! The floor with its faint grid of metres and its paint, and the sky: the background where there is no thing.
//!
//! It is drawn last, and skips pixels that already have a depth.

use super::canvas::Canvas;
use super::light::Light;
use super::view::{Rays, V3, View};
use crate::color::Color;
use crate::floor::{Floor, Patch, strip};

/// Half the width of a line of the grid, in metres.
const LINE: f64 = 0.012;
/// How much a line darkens the floor.
const FAINT: f64 = 0.16;
/// How much darker the sky is at the zenith than at the horizon.
const ZENITH: f64 = 0.3;

pub(super) fn draw((floor, light): (&Floor, &Light), view: &View, rays: &Rays, canvas: &mut Canvas<'_>) {
    let shade = |color: Color| light.shade(color, [0.0, 0.0, 1.0]).map(f64::from);
    let bare = shade(floor.color);
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
                if view.eye[2] > 0.0 {
                    *near = (-ray[2] / view.eye[2]) as f32;
                }
                let patch = patch(view.eye, ray, rays);
                let bare = bare.map(|part| part * (1.0 - FAINT * line(&patch)));
                floor.mean(&patch, bare, shade).map(|part| (part + 0.5) as u8)
            };
        }
    }
}

/// Returns the part of the floor that a pixel shows: distant lines fade instead of flickering.
fn patch(eye: V3, ray: V3, rays: &Rays) -> Patch {
    // An eye below the floor has no floor ahead of it.
    let depth = (-eye[2] / ray[2]).max(0.0);
    // How far the point on the floor moves from one pixel to the next.
    let side = |step: V3| [0, 1].map(|axis| depth * (step[axis] - ray[axis] / ray[2] * step[2]));
    Patch {
        center: [0, 1].map(|axis| eye[axis] + depth * ray[axis]),
        sides: [side(rays.column), side(rays.row)],
    }
}

/// Returns how much of a patch of the floor the lines of the grid cover, from 0 to 1.
fn line(patch: &Patch) -> f64 {
    let cover = |axis: usize, direction: [f64; 2]| {
        let place = patch.center[axis];
        strip((place - libm::rint(place)).abs(), LINE, patch.width(direction))
    };
    cover(0, [1.0, 0.0]).max(cover(1, [0.0, 1.0]))
}

fn sky(color: Color, [x, y, z]: V3) -> [u8; 3] {
    let up = z * z / (x * x + y * y + z * z);
    [color.r, color.g, color.b].map(|part| (f64::from(part) * (1.0 - ZENITH * up) + 0.5) as u8)
}
