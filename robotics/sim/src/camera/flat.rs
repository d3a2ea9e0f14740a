//! Flat faces: convex, filled row by row, most of them with one colour.
//!
//! The inverse of the depth is linear across a face, so a pixel costs one addition and one comparison.

use super::canvas::{Canvas, middles};
use super::view::{Rays, V3, View, dot, sub};

/// Nothing nearer than this is drawn, in metres: the inside of the camera.
const NEAR_PLANE: f64 = 0.01;

/// A convex face with its corners in order.
pub(super) struct Face {
    pub(super) corners: [V3; 4],
    /// The unit normal. Both sides of a face are visible.
    pub(super) normal: V3,
    pub(super) color: [u8; 3],
}

/// Greatest number of corners of a face in front of the eye: the near plane can cut off one corner and make
/// two.
const CORNERS: usize = 5;

impl Face {
    pub(super) fn draw(&self, view: &View, rays: &Rays, canvas: &mut Canvas<'_>) {
        fill((&self.corners, self.normal), (view, rays, canvas), 1.0, |_, _| {
            self.color
        });
    }
}

/// Fills a convex face, given by its corners and its normal. `color` returns the colour at a column and a row of the
/// picture. What was drawn before is hidden if `nearer` times the inverse of the depth is greater.
pub(super) fn fill(
    (corners, normal): (&[V3; 4], V3),
    (view, rays, canvas): (&View, &Rays, &mut Canvas<'_>),
    nearer: f32,
    color: impl Fn(f64, f64) -> [u8; 3],
) {
    // The ray through (u, v) hits the plane of the face at depth t: n·(eye + t·ray) = n·corner.
    let offset = dot(normal, sub(corners[0], view.eye));
    if offset == 0.0 {
        return;
    }
    let near = [rays.origin, rays.column, rays.row].map(|ray| dot(normal, ray) / offset);
    let mut pixels = [[0.0; 2]; CORNERS];
    let pixels = in_picture(corners, view, &mut pixels);
    let extent = pixels
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), pixel| {
            (low.min(pixel[1]), high.max(pixel[1]))
        });
    let (top, bottom) = middles(extent.0, extent.1, canvas.height);
    for row in top..bottom {
        let v = row as f64 + 0.5;
        let (left, right) = across(pixels, v);
        let (left, right) = middles(left, right, canvas.width);
        let mut inverse = (near[0] + v * near[2] + (left as f64 + 0.5) * near[1]) as f32;
        let step = near[1] as f32;
        for (column, (pixel, depth)) in (left..).zip(canvas.span(row, left, right)) {
            if nearer * inverse > *depth {
                *depth = depth.max(inverse);
                *pixel = color(column as f64 + 0.5, v);
            }
            inverse += step;
        }
    }
}

/// Returns the corners, in the picture, of the part of a face in front of the eye.
fn in_picture<'a>(corners: &[V3; 4], view: &View, pixels: &'a mut [[f64; 2]; CORNERS]) -> &'a [[f64; 2]] {
    let local = corners.map(|corner| view.local(corner));
    let mut count = 0;
    let mut push = |point: V3| {
        pixels[count] = view.pixel(point);
        count += 1;
    };
    for (index, &from) in local.iter().enumerate() {
        let to = local[(index + 1) % local.len()];
        if from[2] >= NEAR_PLANE {
            push(from);
        }
        if (from[2] >= NEAR_PLANE) != (to[2] >= NEAR_PLANE) {
            let part = (NEAR_PLANE - from[2]) / (to[2] - from[2]);
            push([
                from[0] + part * (to[0] - from[0]),
                from[1] + part * (to[1] - from[1]),
                NEAR_PLANE,
            ]);
        }
    }
    &pixels[..count]
}

/// Returns where a row enters and leaves a convex face.
fn across(corners: &[[f64; 2]], v: f64) -> (f64, f64) {
    let mut found = (f64::INFINITY, f64::NEG_INFINITY);
    for (index, from) in corners.iter().enumerate() {
        let to = corners[(index + 1) % corners.len()];
        if (from[1] <= v) != (to[1] <= v) {
            let u = from[0] + (v - from[1]) / (to[1] - from[1]) * (to[0] - from[0]);
            found = (found.0.min(u), found.1.max(u));
        }
    }
    found
}
