//! Sensors that measure distance: laser scans, sonars and rings of sonars.
//!
//! By REP-117 a range is a distance, +∞ (nothing within range), −∞ (something too close to measure) or NaN
//! (no measurement). [`Echo`] is what a reader takes it for.

use core::f64::consts::FRAC_PI_2;

use crate::{Echo, Header, Padding, Point2D, Pose2D, Seq, Value, normalize_angle};

/// One scan of a laser scanner with up to 1088 beams.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "sensor_msgs/msg/LaserScan")]
pub struct LaserScan {
    /// Time of the first beam, and the frame of the scanner: x ahead, angles counter-clockwise about z.
    pub header: Header,
    /// Angle of the first beam.
    #[value(unit = "rad")]
    pub angle_min: f32,
    /// Angle of the last beam.
    #[value(unit = "rad")]
    pub angle_max: f32,
    /// Angle from one beam to the next.
    #[value(unit = "rad")]
    pub angle_increment: f32,
    /// Time from one beam to the next.
    #[value(unit = "s")]
    pub time_increment: f32,
    /// Time from one scan to the next.
    #[value(unit = "s")]
    pub scan_time: f32,
    /// Least measurable distance.
    #[value(unit = "m")]
    pub range_min: f32,
    /// Greatest measurable distance.
    #[value(unit = "m")]
    pub range_max: f32,
    /// Distances, in the order of the beams.
    #[value(unit = "m")]
    pub ranges: Seq<f32, 1088>,
    /// Intensities, in units of the device; empty if it has none.
    pub intensities: Seq<f32, 1088>,
}

/// One sonar or infrared sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "sensor_msgs/msg/Range")]
pub struct Range {
    /// Time, and the frame of the sensor: x ahead.
    pub header: Header,
    /// 0 ultrasound, 1 infrared.
    pub radiation_type: u8,
    /// Unused bytes.
    pub padding: Padding<3>,
    /// Angular width of the cone.
    #[value(unit = "rad")]
    pub field_of_view: f32,
    /// Least measurable distance.
    #[value(unit = "m")]
    pub min_range: f32,
    /// Greatest measurable distance.
    #[value(unit = "m")]
    pub max_range: f32,
    /// Measured distance.
    #[value(unit = "m")]
    pub range: f32,
    /// Variance of the distance; 0 if unknown.
    #[value(unit = "m2")]
    pub variance: f32,
}

/// A ring of up to 32 range sensors of one type around a base.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/RangeRing")]
pub struct RangeRing {
    /// Time, and the frame of the base.
    pub header: Header,
    /// 0 ultrasound, 1 infrared.
    pub radiation_type: u8,
    /// Unused bytes.
    pub padding: Padding<3>,
    /// Angular width of each cone.
    #[value(unit = "rad")]
    pub field_of_view: f32,
    /// Least measurable distance.
    #[value(unit = "m")]
    pub min_range: f32,
    /// Greatest measurable distance.
    #[value(unit = "m")]
    pub max_range: f32,
    /// Position and direction of each sensor, in the frame of the base.
    pub poses: Seq<Pose2D, 32>,
    /// Measured distance of each sensor.
    #[value(unit = "m")]
    pub ranges: Seq<f32, 32>,
}

/// The hit of one laser beam, in the frame of the scanner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaserPoint {
    /// The index of the beam in the scan.
    pub beam: usize,
    /// Its angle, rad.
    pub angle: f64,
    /// The distance, m.
    pub range: f64,
    /// Ahead, m.
    pub x: f64,
    /// To the left, m.
    pub y: f64,
}

/// The echo of one sonar of a ring, in the frame of the base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SonarEcho {
    /// The index of the sonar in the ring.
    pub sonar: usize,
    /// The distance from the sonar, m.
    pub range: f64,
    /// Ahead, m, on the axis of the cone.
    pub x: f64,
    /// To the left, m, on the axis of the cone.
    pub y: f64,
}

impl LaserScan {
    /// Returns the angle of a beam, rad.
    #[must_use]
    pub fn angle(&self, beam: usize) -> f64 {
        f64::from(self.angle_min) + beam as f64 * f64::from(self.angle_increment)
    }

    /// Returns the hits of the beams, first beam first. Beams without a hit or a measurement are left out. An
    /// object too close to measure counts as at `range_min`.
    pub fn points(&self) -> impl Iterator<Item = LaserPoint> + '_ {
        self.hits()
            .map(|(beam, angle, range)| LaserPoint::new(beam, angle, range))
    }

    /// Returns where each measured beam ends, for a scanner at `sensor`, and whether it ends at an object. A beam
    /// without an object is free up to `range_max`; one without a measurement, or with an object too close to measure,
    /// says nothing, and so does a scan that is none.
    pub fn rays(&self, sensor: &Pose2D) -> impl Iterator<Item = (Point2D, bool)> + '_ {
        let sensor = *sensor;
        self.lengths().map(move |(beam, length, hit)| {
            let (sin, cos) = libm::sincos(sensor.theta + self.angle(beam));
            let end = Point2D {
                x: sensor.x + f64::from(length) * cos,
                y: sensor.y + f64::from(length) * sin,
            };
            (end, hit)
        })
    }

    /// Returns how far each measured beam goes, m, and whether it ends at an object, by the number of the beam; as
    /// [`Self::rays`]. A beam without an object is left out if the greatest distance is +∞.
    pub fn lengths(&self) -> impl Iterator<Item = (usize, f32, bool)> + '_ {
        self.echoes().filter_map(|(beam, echo)| match echo {
            Echo::Hit(range) => Some((beam, range, true)),
            Echo::Free => self
                .range_max
                .is_finite()
                .then_some((beam, self.range_max, false)),
            Echo::TooClose | Echo::Nothing => None,
        })
    }

    /// Makes each beam that met nothing no measurement. It is for the scans of drivers that say +∞, or the greatest distance,
    /// also where no return came back from an object: glass, a black surface, one that is hit at a flat angle.
    pub fn remove_free(&mut self) {
        let (least, greatest) = (self.range_min, self.range_max);
        for range in self.ranges.as_mut_slice() {
            if Echo::of(*range, least, greatest) == Echo::Free {
                *range = f32::NAN;
            }
        }
    }

    /// Returns the beam, angle and distance of each hit.
    fn hits(&self) -> impl Iterator<Item = (usize, f64, f64)> + '_ {
        self.echoes()
            .filter_map(|(beam, echo)| Some((beam, self.angle(beam), echo.distance(self.range_min)?)))
    }

    /// Returns how far ahead the nearest hit within `half_width` m to either side is, m; `None` if there is
    /// none.
    #[must_use]
    pub fn nearest_ahead(&self, half_width: f64) -> Option<f64> {
        let mut nearest = None;
        for (beam, angle, range) in self.hits() {
            // Most hits are beside the area or behind its nearest one, which bounds show without a sine.
            if is_beside(angle, range, half_width) || nearest.is_some_and(|x| is_beyond(angle, range, x)) {
                continue;
            }
            let point = LaserPoint::new(beam, angle, range);
            if point.x > 0.0 && point.y.abs() <= half_width && nearest.is_none_or(|x| point.x < x) {
                nearest = Some(point.x);
            }
        }
        nearest
    }

    /// Returns what is in the area that reaches `reach` m ahead of the scanner, and `half_width` m to either side.
    #[must_use]
    pub fn ahead(&self, half_width: f64, reach: f64) -> Ahead {
        match self.nearest_ahead(half_width) {
            Some(nearest) if nearest <= reach => Ahead::Hit(nearest),
            _ if self.sees_ahead(half_width, reach) => Ahead::Free,
            _ => Ahead::Unseen,
        }
    }

    /// Whether a beam measures that goes through the far side of an area ahead, or is the one nearest to straight ahead.
    fn sees_ahead(&self, half_width: f64, reach: f64) -> bool {
        let most = libm::atan2(half_width, reach).max(f64::from(self.angle_increment).abs() / 2.0) * MARGIN;
        self.echoes()
            .any(|(beam, echo)| echo != Echo::Nothing && normalize_angle(self.angle(beam)).abs() <= most)
    }
}

/// What a scan tells of the area straight ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ahead {
    /// The nearest hit in the area is so far ahead, m.
    Hit(f64),
    /// No hit is in the area.
    Free,
    /// No beam into the area measures anything, so nobody knows.
    Unseen,
}

impl LaserPoint {
    fn new(beam: usize, angle: f64, range: f64) -> Self {
        let (sin, cos) = libm::sincos(angle);
        Self {
            beam,
            angle,
            range,
            x: range * cos,
            y: range * sin,
        }
    }
}

impl RangeRing {
    /// Returns the echoes of the sonars. Sonars without an echo are left out. An object too close to measure
    /// counts as at `min_range`.
    pub fn echoes(&self) -> impl Iterator<Item = SonarEcho> + '_ {
        let sonars = self.poses.iter().zip(&self.ranges).enumerate();
        sonars.filter_map(|(sonar, (pose, &range))| {
            let range = Echo::of(range, self.min_range, self.max_range).distance(self.min_range)?;
            let (sin, cos) = libm::sincos(pose.theta);
            Some(SonarEcho {
                sonar,
                range,
                x: pose.x + range * cos,
                y: pose.y + range * sin,
            })
        })
    }
}

/// Far more than the rounding of the bounds below, as a factor.
const MARGIN: f64 = 1.0 + 1e-9;

/// Whether a hit up to a quarter turn to either side is certainly more than `half_width` m to the side: the
/// sine of an angle `a` is at least `a - a³ / 6`.
fn is_beside(angle: f64, range: f64, half_width: f64) -> bool {
    let angle = angle.abs();
    let sine = angle * (1.0 - angle * angle / 6.0);
    angle <= FRAC_PI_2 && range * sine > half_width * MARGIN
}

/// Whether a hit is certainly more than `x` m ahead: the cosine of an angle `a` is at least `1 - a² / 2`.
fn is_beyond(angle: f64, range: f64, x: f64) -> bool {
    range > 0.0 && range * (1.0 - angle * angle / 2.0) > x * MARGIN
}
