//! Poses in space.

use std::array;

/// A place, m, and a turn as a quaternion of length 1: w, x, y, z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pose3 {
    pub(super) at: [f64; 3],
    turn: [f64; 4],
}

impl Pose3 {
    pub(super) const ORIGIN: Self = Self::at([0.0; 3]);

    /// Returns a pose without a turn.
    pub(super) const fn at(at: [f64; 3]) -> Self {
        Self {
            at,
            turn: [1.0, 0.0, 0.0, 0.0],
        }
    }

    /// Returns a pose that is turned about the fixed axes x, y and z, in this order, rad.
    pub(super) fn euler(at: [f64; 3], angles: [f64; 3]) -> Self {
        let [(sr, cr), (sp, cp), (sy, cy)] = angles.map(|angle| libm::sincos(angle / 2.0));
        Self {
            at,
            turn: [
                cr * cp * cy + sr * sp * sy,
                sr * cp * cy - cr * sp * sy,
                cr * sp * cy + sr * cp * sy,
                cr * cp * sy - sr * sp * cy,
            ],
        }
    }

    /// Returns a pose with a quaternion x, y, z, w of any length; one without a length is no turn.
    pub(super) fn quaternion(at: [f64; 3], [x, y, z, w]: [f64; 4]) -> Self {
        let largest = [x, y, z, w]
            .into_iter()
            .fold(0.0, |most: f64, part| most.max(part.abs()));
        if largest <= 0.0 {
            return Self::at(at);
        }
        let parts = [w, x, y, z].map(|part| part / largest);
        let length = parts.iter().map(|part| part * part).sum::<f64>().sqrt();
        Self {
            at,
            turn: parts.map(|part| part / length),
        }
    }

    /// Returns a pose in this frame as one in the frame of this pose.
    pub(super) fn compose(self, inner: Self) -> Self {
        let ([a, b, c, d], [w, x, y, z]) = (self.turn, inner.turn);
        Self {
            at: self.point(inner.at),
            turn: [
                a * w - b * x - c * y - d * z,
                a * x + b * w + c * z - d * y,
                a * y - b * z + c * w + d * x,
                a * z + b * y - c * x + d * w,
            ],
        }
    }

    pub(super) fn inverse(self) -> Self {
        let [w, x, y, z] = self.turn;
        let back = Self {
            at: [0.0; 3],
            turn: [w, -x, -y, -z],
        };
        Self {
            at: back.point(self.at).map(|part| -part),
            ..back
        }
    }

    /// Returns a point in this frame as one in the frame of this pose.
    pub(super) fn point(self, point: [f64; 3]) -> [f64; 3] {
        let turned = self.turned(point);
        array::from_fn(|axis| self.at[axis] + turned[axis])
    }

    /// Returns a direction in this frame as one in the frame of this pose.
    pub(super) fn turned(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [along, across, up] = self.axes();
        array::from_fn(|axis| x * along[axis] + y * across[axis] + z * up[axis])
    }

    /// Returns the directions of the axes x, y and z.
    pub(super) fn axes(self) -> [[f64; 3]; 3] {
        let [w, x, y, z] = self.turn;
        [
            [
                1.0 - 2.0 * (y * y + z * z),
                2.0 * (x * y + w * z),
                2.0 * (x * z - w * y),
            ],
            [
                2.0 * (x * y - w * z),
                1.0 - 2.0 * (x * x + z * z),
                2.0 * (y * z + w * x),
            ],
            [
                2.0 * (x * z + w * y),
                2.0 * (y * z - w * x),
                1.0 - 2.0 * (x * x + y * y),
            ],
        ]
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    fn assert_near(pose: Pose3, point: [f64; 3], right: [f64; 3]) {
        let found = pose.point(point);
        let error = (0..3)
            .map(|axis| (found[axis] - right[axis]).abs())
            .fold(0.0, f64::max);
        assert!(error < 1e-12, "{found:?} instead of {right:?}");
    }

    #[test]
    fn angles_turn_about_fixed_axes_and_inverses_turn_back() {
        let pose = Pose3::euler([1.0, 2.0, 3.0], [FRAC_PI_2, 0.0, FRAC_PI_2]);
        // The roll puts y upward, then the yaw puts x to y.
        assert_near(pose, [1.0, 0.0, 0.0], [1.0, 3.0, 3.0]);
        assert_near(pose, [0.0, 1.0, 0.0], [1.0, 2.0, 4.0]);
        assert_near(pose.compose(pose.inverse()), [4.0, 5.0, 6.0], [4.0, 5.0, 6.0]);
        let quarter = Pose3::quaternion([0.0; 3], [0.0, 0.0, 2.0, 2.0]);
        assert_near(quarter, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        assert_eq!(Pose3::quaternion([1.0; 3], [0.0; 4]), Pose3::at([1.0; 3]));
    }
}
