//! Where a sensor is above the floor, and how it is inclined.

/// The height and the inclination of a sensor, by the axes of REP-103.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Level {
    /// Above the floor, m.
    pub height: f64,
    /// Rotation about the axis to the left, rad: positive looks down.
    pub pitch: f64,
    /// Rotation about the axis ahead, rad: positive leans to the right.
    pub roll: f64,
}

impl Level {
    /// Returns a point of the frame of the sensor, x ahead, y to the left, z up, in the level frame on the floor.
    #[must_use]
    pub fn point(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let (sin, cos) = libm::sincos(self.roll);
        let (y, z) = (cos * y - sin * z, sin * y + cos * z);
        let (sin, cos) = libm::sincos(self.pitch);
        [cos * x + sin * z, y, cos * z - sin * x + self.height]
    }

    /// Returns a point of the optical frame, x to the right, y down, z into the picture, in the level frame on the floor.
    #[must_use]
    pub fn optical(&self, [right, down, into]: [f64; 3]) -> [f64; 3] {
        self.point([into, -right, -down])
    }
}
