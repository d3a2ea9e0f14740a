//! The pose of a camera, and the ray through each of its pixels.
//!
//! This module draws nothing.

pub(super) type V3 = [f64; 3];

/// A camera in the world, with its picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    pub(super) eye: V3,
    /// Unit vectors ahead, to the left and up, in the frame of the world.
    ahead: V3,
    left: V3,
    up: V3,
    focal: f64,
    /// The place of the optical axis in the picture, in pixels.
    center: [f64; 2],
    pub(super) width: usize,
    pub(super) height: usize,
}

/// The vectors of the rays of a picture. The ray through the point (u, v) is `origin + u * column + v * row`.
/// A unit of its parameter advances one metre ahead of the eye, so the depth of a point is the parameter of
/// its ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rays {
    pub(super) origin: V3,
    pub(super) column: V3,
    pub(super) row: V3,
}

impl View {
    /// Creates an eye that looks along a heading, level.
    pub(super) fn new(eye: V3, heading: f64, focal: f64, (size, center): ([usize; 2], [f64; 2])) -> Self {
        let [width, height] = size;
        let (sin, cos) = libm::sincos(heading);
        Self {
            eye,
            ahead: [cos, sin, 0.0],
            left: [-sin, cos, 0.0],
            up: [0.0, 0.0, 1.0],
            focal,
            center,
            width,
            height,
        }
    }

    /// Returns the view moved by metres ahead, to the left and up, in its own axes.
    pub(super) fn moved(mut self, [x, y, z]: V3) -> Self {
        for axis in 0..3 {
            self.eye[axis] += x * self.ahead[axis] + y * self.left[axis] + z * self.up[axis];
        }
        self
    }

    /// Returns the view turned to the left about its own upright axis.
    pub(super) fn panned(mut self, angle: f64) -> Self {
        (self.ahead, self.left) = turned(self.ahead, self.left, angle);
        self
    }

    /// Returns the view turned down about its own left axis.
    pub(super) fn tilted(mut self, angle: f64) -> Self {
        (self.up, self.ahead) = turned(self.up, self.ahead, angle);
        self
    }

    pub(super) fn rays(&self) -> Rays {
        let (column, row) = (
            scaled(self.left, -1.0 / self.focal),
            scaled(self.up, -1.0 / self.focal),
        );
        let [u, v] = self.center;
        let origin = [0, 1, 2].map(|axis| self.ahead[axis] - u * column[axis] - v * row[axis]);
        Rays { origin, column, row }
    }

    /// Returns a point of the world in the camera's frame: to the right, down and ahead, in metres.
    pub(super) fn local(&self, point: V3) -> V3 {
        let away = sub(point, self.eye);
        [-dot(away, self.left), -dot(away, self.up), dot(away, self.ahead)]
    }

    /// Returns the position in the picture of a point ahead of the camera.
    pub(super) fn pixel(&self, [x, y, z]: V3) -> [f64; 2] {
        [
            self.center[0] + self.focal * x / z,
            self.center[1] + self.focal * y / z,
        ]
    }

    /// Returns whether the bounding sphere of a thing may be in the picture; may be true for a sphere just
    /// outside.
    pub(super) fn is_visible(&self, center: V3, radius: f64) -> bool {
        let [x, y, z] = self.local(center);
        let side = |offset: f64, half: f64| {
            // The distance to the plane through the eye and the edge of the picture, times the length of its
            // normal.
            offset.abs() * self.focal - z * half <= radius * (self.focal + half)
        };
        // The farther edge of each two.
        let [u, v] = self.center;
        let (across, along) = (u.max(self.width as f64 - u), v.max(self.height as f64 - v));
        z > -radius && side(x, across) && side(y, along)
    }
}

impl Rays {
    pub(super) fn through(&self, u: f64, v: f64) -> V3 {
        [0, 1, 2].map(|axis| self.origin[axis] + u * self.column[axis] + v * self.row[axis])
    }
}

pub(super) fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn sub(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn scaled(a: V3, by: f64) -> V3 {
    a.map(|value| value * by)
}

/// Turns two axes: the first toward the second.
fn turned(first: V3, second: V3, angle: f64) -> (V3, V3) {
    let (sin, cos) = libm::sincos(angle);
    (
        [0, 1, 2].map(|axis| cos * first[axis] + sin * second[axis]),
        [0, 1, 2].map(|axis| cos * second[axis] - sin * first[axis]),
    )
}
