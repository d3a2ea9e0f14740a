//! The types that can state a place: pairs, points and poses.

use jde_types::{LaserPoint, Point, Point2D, Pose2D};

/// A place in a plane (two coordinates) or in space (three), in m.
pub trait At<const N: usize> {
    /// Returns the coordinates, in m.
    fn at(&self) -> [f64; N];
}

impl<const N: usize> At<N> for [f64; N] {
    fn at(&self) -> [f64; N] {
        *self
    }
}

impl At<2> for (f64, f64) {
    fn at(&self) -> [f64; 2] {
        [self.0, self.1]
    }
}

impl At<3> for (f64, f64, f64) {
    fn at(&self) -> [f64; 3] {
        [self.0, self.1, self.2]
    }
}

impl At<2> for Pose2D {
    fn at(&self) -> [f64; 2] {
        [self.x, self.y]
    }
}

impl At<2> for Point2D {
    fn at(&self) -> [f64; 2] {
        [self.x, self.y]
    }
}

impl At<2> for LaserPoint {
    fn at(&self) -> [f64; 2] {
        [self.x, self.y]
    }
}

impl At<3> for Point {
    fn at(&self) -> [f64; 3] {
        [self.x, self.y, self.z]
    }
}

impl<const N: usize, T: At<N> + ?Sized> At<N> for &T {
    fn at(&self) -> [f64; N] {
        (**self).at()
    }
}
