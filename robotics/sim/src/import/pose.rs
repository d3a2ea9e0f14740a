//! Poses of things that stand upright.

/// A pose without tilt: m, and rad counter-clockwise.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) z: f64,
    pub(super) yaw: f64,
}

impl Pose {
    pub(super) const ORIGIN: Self = Self {
        x: 0.0,
        y: 0.0,
        z: 0.0,
        yaw: 0.0,
    };

    /// Returns a pose in this frame as one in the frame of this pose.
    pub(super) fn compose(self, inner: Self) -> Self {
        let [x, y] = self.point([inner.x, inner.y]);
        Self {
            x,
            y,
            z: self.z + inner.z,
            yaw: self.yaw + inner.yaw,
        }
    }

    /// Returns a point in this frame as one in the frame of this pose.
    pub(super) fn point(self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = libm::sincos(self.yaw);
        [self.x + cos * x - sin * y, self.y + sin * x + cos * y]
    }

    /// Inverts [`Self::point`].
    pub(super) fn local(self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = libm::sincos(self.yaw);
        let (x, y) = (x - self.x, y - self.y);
        [cos * x + sin * y, cos * y - sin * x]
    }
}
