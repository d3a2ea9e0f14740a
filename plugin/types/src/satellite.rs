//! Positions on the Earth, as satellite receivers measure them.

use crate::{Header, Padding, Value};

/// Whether a satellite receiver has a fix.
#[derive(Clone, Copy, Debug, PartialEq, Value)]
#[repr(C)]
#[value(name = "sensor_msgs/msg/NavSatStatus")]
pub struct NavSatStatus {
    /// -2 unknown, -1 no fix, 0 a fix, 1 one with corrections of satellites, 2 one with corrections of ground stations.
    pub status: i8,
    /// Unused bytes.
    pub padding: Padding<1>,
    /// The systems in use, a sum: 1 GPS, 2 GLONASS, 4 BeiDou, 8 Galileo.
    pub service: u16,
}

/// A position on the Earth (WGS 84), as a satellite receiver measures it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "sensor_msgs/msg/NavSatFix")]
pub struct NavSatFix {
    /// Time, and the frame of the antenna.
    pub header: Header,
    /// Whether there is a fix, and of which systems.
    pub status: NavSatStatus,
    /// Unused bytes.
    pub padding: Padding<4>,
    /// Latitude, positive to the north.
    #[value(unit = "deg")]
    pub latitude: f64,
    /// Longitude, positive to the east.
    #[value(unit = "deg")]
    pub longitude: f64,
    /// Height above the ellipsoid; NaN if it is unknown.
    #[value(unit = "m")]
    pub altitude: f64,
    /// Covariance to the east, to the north and up, row by row.
    #[value(unit = "m2")]
    pub position_covariance: [f64; 9],
    /// The covariance is 0 unknown, 1 estimated, 2 known on its diagonal, 3 known.
    pub position_covariance_type: u8,
    /// Unused bytes.
    pub tail: Padding<7>,
}

/// Unknown.
impl Default for NavSatStatus {
    fn default() -> Self {
        Self {
            status: -2,
            ..Self::zeroed()
        }
    }
}

impl NavSatFix {
    /// Returns whether there is a fix. Without one the position says nothing.
    #[must_use]
    pub const fn has_fix(&self) -> bool {
        self.status.status >= 0
    }

    /// Checks the position of a fix.
    ///
    /// # Errors
    /// If there is a fix, and its latitude or longitude is none.
    pub fn check(&self) -> Result<(), &'static str> {
        let is_place = self.latitude.abs() <= 90.0 && self.longitude.abs() <= 180.0;
        if is_place || !self.has_fix() {
            Ok(())
        } else {
            Err("a fix with a latitude beyond 90° or a longitude beyond 180°, or with none")
        }
    }
}
