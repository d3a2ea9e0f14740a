//! The pose of a tag before a pinhole camera.
//!
//! A square has two poses under which it looks nearly the same, above all when it is small or far. Both are computed
//! from the derivatives at its middle (Collins and Bartoli, "Infinitesimal plane-based pose estimation", IJCV 2014),
//! and both are improved by orthogonal iteration (Lu, Hager and Mjolsness, "Fast and globally convergent pose
//! estimation from video images", PAMI 2000).

use crate::Point;
use crate::homography::Homography;

type Vector = [f64; 3];
/// The columns of a matrix: the axes of a rotated frame.
type Matrix = [Vector; 3];

/// A pinhole camera without distortion: x to the right, y down, z into the picture. A point is at column
/// `middle[0] + focal[0]·x/z` and row `middle[1] + focal[1]·y/z`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pinhole {
    /// Focal lengths, px.
    pub focal: [f64; 2],
    /// Column and row of the optical axis, px.
    pub middle: [f64; 2],
}

/// The pose of a tag in the frame of a camera.
///
/// The frame of a tag has its origin in the middle of the tag, x to the right and y down as one who reads the tag
/// sees it, and z into the tag: a tag that is read straight ahead has the axes of the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TagPose {
    /// The middle of the tag, m.
    pub position: [f64; 3],
    /// The axes x, y and z of the tag.
    pub axes: [[f64; 3]; 3],
    /// The mean distance between the corners and where the pose puts them, px.
    pub error: f64,
    /// `error` as a share of that of the other pose under which the tag looks alike, 0 to 1: close to 1, either of
    /// both may be the true one.
    pub ambiguity: f64,
}

/// How often a pose is improved: most need ten.
const ROUNDS: usize = 50;

impl Pinhole {
    /// Returns the camera of pictures of some columns and rows, with a horizontal field of view in rad.
    #[must_use]
    pub fn new([width, height]: [usize; 2], field_of_view: f64) -> Self {
        let middle = [width as f64 / 2.0, height as f64 / 2.0];
        Self {
            focal: [middle[0] / libm::tan(field_of_view / 2.0); 2],
            middle,
        }
    }

    /// Returns the pose of a tag whose border is `size` m wide, by its corners in the order of a
    /// [`Detection`](crate::Detection); `None` if no pose before the camera has such corners.
    #[must_use]
    pub fn pose(&self, corners: &[[f64; 2]; 4], size: f64) -> Option<TagPose> {
        let seen =
            corners.map(|corner| [0, 1].map(|axis| (corner[axis] - self.middle[axis]) / self.focal[axis]));
        let poses = starts(&seen, size)?.map(|axes| {
            let (position, axes) = improved(&seen, size, axes);
            let error = self.error(corners, size, position, &axes);
            TagPose {
                position,
                axes,
                error,
                ambiguity: 0.0,
            }
        });
        let [a, b] = poses;
        let (mut best, other) = if b.error < a.error { (b, a) } else { (a, b) };
        best.ambiguity = if other.error > 0.0 {
            best.error / other.error
        } else {
            1.0
        };
        best.error.is_finite().then_some(best)
    }

    /// Returns the mean distance between the corners and where a pose puts them, px; infinite for a pose behind the
    /// camera.
    fn error(&self, corners: &[Point; 4], size: f64, position: Vector, axes: &Matrix) -> f64 {
        let distances = places(size).into_iter().zip(corners).map(|(place, corner)| {
            let [x, y, z] = transformed(position, axes, place);
            if z <= 0.0 {
                return f64::INFINITY;
            }
            let part =
                |axis: usize, across: f64| self.middle[axis] + self.focal[axis] * across / z - corner[axis];
            let [dx, dy] = [part(0, x), part(1, y)];
            (dx * dx + dy * dy).sqrt()
        });
        let mean = distances.sum::<f64>() / 4.0;
        if mean.is_nan() { f64::INFINITY } else { mean }
    }
}

/// Returns the corners of a tag in its own frame.
fn places(size: f64) -> [Point; 4] {
    let half = size / 2.0;
    [[-half, half], [half, half], [half, -half], [-half, -half]]
}

fn transformed(position: Vector, axes: &Matrix, [x, y]: Point) -> Vector {
    [0, 1, 2].map(|index| position[index] + axes[0][index] * x + axes[1][index] * y)
}

/// Returns the two rotations that the derivatives at the middle of the tag allow.
fn starts(seen: &[Point; 4], size: f64) -> Option<[Matrix; 2]> {
    let [lower_left, lower_right, upper_right, upper_left] = *seen;
    let homography = Homography::to(&[upper_left, upper_right, lower_right, lower_left]);
    let (middle, slopes) = homography.jacobian([0.5; 2]);
    let slopes = slopes.map(|row| row.map(|slope| slope / size));
    // The rotation that turns the optical axis to the middle of the tag.
    let length = (middle[0] * middle[0] + middle[1] * middle[1] + 1.0).sqrt();
    let [a, b, c] = [middle[0] / length, middle[1] / length, 1.0 / length];
    let toward = [
        [1.0 - a * a / (1.0 + c), -a * b / (1.0 + c), -a],
        [-a * b / (1.0 + c), 1.0 - b * b / (1.0 + c), -b],
        [a, b, c],
    ];
    // What the picture shows of a step in the turned frame, and its inverse times the slopes.
    let shown = [0, 1].map(|row| [0, 1].map(|axis| toward[axis][row] - middle[row] * toward[axis][2]));
    let determinant = shown[0][0] * shown[1][1] - shown[0][1] * shown[1][0];
    let column = |by: usize| {
        let (x, y) = (slopes[0][by], slopes[1][by]);
        [
            (shown[1][1] * x - shown[0][1] * y) / determinant,
            (shown[0][0] * y - shown[1][0] * x) / determinant,
        ]
    };
    let [u, v] = [column(0), column(1)];
    // The greatest singular value is the scale, the inverse of the distance.
    let [uu, uv, vv] = [
        u[0] * u[0] + u[1] * u[1],
        u[0] * v[0] + u[1] * v[1],
        v[0] * v[0] + v[1] * v[1],
    ];
    let scale = ((uu + vv + ((uu - vv) * (uu - vv) + 4.0 * uv * uv).sqrt()) / 2.0).sqrt();
    if !(scale > 0.0 && scale.is_finite()) {
        return None;
    }
    let depth = [uu, vv].map(|square| (1.0 - square / (scale * scale)).max(0.0).sqrt());
    let sign = if uv > 0.0 { -1.0 } else { 1.0 };
    Some([1.0, -1.0].map(|side| {
        let x = [u[0] / scale, u[1] / scale, side * depth[0]];
        let y = [v[0] / scale, v[1] / scale, side * sign * depth[1]];
        [x, y, cross(x, y)].map(|axis| turned(&toward, axis))
    }))
}

/// Improves a rotation by orthogonal iteration, and returns the position that belongs to it and the rotation.
fn improved(seen: &[Point; 4], size: f64, mut axes: Matrix) -> (Vector, Matrix) {
    let places = places(size);
    let rays = seen.map(|[x, y]| {
        let length = (x * x + y * y + 1.0).sqrt();
        [x / length, y / length, 1.0 / length]
    });
    let mut position = position(&rays, &places, &axes);
    for _ in 0..ROUNDS {
        // Each corner moves onto its ray; then the rotation turns the tag to where the corners are.
        let moved: [Vector; 4] = [0, 1, 2, 3].map(|corner| {
            let at = transformed(position, &axes, places[corner]);
            rays[corner].map(|part| part * dot(rays[corner], at))
        });
        let column = |axis: usize| {
            [0, 1, 2].map(|index| {
                (0..4)
                    .map(|corner| moved[corner][index] * places[corner][axis])
                    .sum::<f64>()
            })
        };
        axes = nearest_rotation(column(0), column(1));
        position = self::position(&rays, &places, &axes);
    }
    (position, axes)
}

/// Returns the position with the least squared distances of the corners from their rays.
fn position(rays: &[Vector; 4], places: &[Point; 4], axes: &Matrix) -> Vector {
    // (I - ray rayᵀ) summed over the corners, times the position, is minus its sum times the rotated corners.
    let mut matrix = [[0.0; 3]; 3];
    let mut side = [0.0; 3];
    for (ray, place) in rays.iter().zip(places) {
        let arm = transformed([0.0; 3], axes, *place);
        let along = dot(*ray, arm);
        for row in 0..3 {
            side[row] -= arm[row] - ray[row] * along;
            for column in 0..3 {
                matrix[row][column] += if row == column { 1.0 } else { 0.0 } - ray[row] * ray[column];
            }
        }
    }
    let [a, b, c] = matrix;
    // It is symmetric: its rows are its columns, and Cramer's rule needs their products only.
    let determinant = dot(a, cross(b, c));
    [cross(b, c), cross(c, a), cross(a, b)].map(|product| dot(product, side) / determinant)
}

/// Returns the rotation whose first two axes are nearest to two vectors: their polar decomposition.
fn nearest_rotation(x: Vector, y: Vector) -> Matrix {
    let [xx, xy, yy] = [dot(x, x), dot(x, y), dot(y, y)];
    // The square root of the 2 × 2 matrix of their products is (products + root) / trace.
    let root = (xx * yy - xy * xy).max(0.0).sqrt();
    let trace = (xx + yy + 2.0 * root).sqrt();
    let [a, b, c] = [(xx + root) / trace, xy / trace, (yy + root) / trace];
    let determinant = a * c - b * b;
    let x_axis = [0, 1, 2].map(|index| (c * x[index] - b * y[index]) / determinant);
    let y_axis = [0, 1, 2].map(|index| (a * y[index] - b * x[index]) / determinant);
    [x_axis, y_axis, cross(x_axis, y_axis)]
}

fn turned(axes: &Matrix, vector: Vector) -> Vector {
    [0, 1, 2].map(|index| (0..3).map(|axis| axes[axis][index] * vector[axis]).sum())
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
