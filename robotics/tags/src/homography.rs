//! The projective map from a square to its picture.

use crate::Point;

/// The map from a square, (0, 0) to (1, 1), to a quadrilateral of a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Homography([[f64; 3]; 3]);

impl Homography {
    /// Returns the map that takes (0, 0), (1, 0), (1, 1) and (0, 1) to four corners, in this order (Heckbert,
    /// "Fundamentals of texture mapping and image warping", 1989). It is not finite if three of them lie on a
    /// line.
    pub(crate) fn to(corners: &[Point; 4]) -> Self {
        let [[x0, y0], [x1, y1], [x2, y2], [x3, y3]] = *corners;
        let (sum_x, sum_y) = (x0 - x1 + x2 - x3, y0 - y1 + y2 - y3);
        let [a, b] = [[x1 - x2, y1 - y2], [x3 - x2, y3 - y2]];
        let area = a[0] * b[1] - b[0] * a[1];
        let (g, h) = (
            (sum_x * b[1] - b[0] * sum_y) / area,
            (a[0] * sum_y - sum_x * a[1]) / area,
        );
        Self([
            [x1 - x0 + g * x1, x3 - x0 + h * x3, x0],
            [y1 - y0 + g * y1, y3 - y0 + h * y3, y0],
            [g, h, 1.0],
        ])
    }

    /// Returns the image of a point.
    pub(crate) fn project(&self, [u, v]: Point) -> Point {
        let [x, y, scale] = self.0.map(|row| row[0] * u + row[1] * v + row[2]);
        [x / scale, y / scale]
    }

    /// Returns the image of a point, and the derivatives of column and row by u and v.
    pub(crate) fn jacobian(&self, point: Point) -> (Point, [[f64; 2]; 2]) {
        let [g, h, one] = self.0[2];
        let scale = g * point[0] + h * point[1] + one;
        let place = self.project(point);
        let row = |axis: usize| [0, 1].map(|by| (self.0[axis][by] - place[axis] * self.0[2][by]) / scale);
        (place, [row(0), row(1)])
    }
}
