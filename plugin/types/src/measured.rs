//! What a sensor has measured: the one definition, by which every reader and every check goes. A value that measures
//! nothing or contradicts itself is none; nothing is repaired or guessed here.

use core::f64::consts::TAU;
use core::fmt;

use jde_abi::describe::Type;

use crate::{CompressedImage, Image, LaserScan, Odometry, PointCloud2, Range, RangeRing, Value};

/// How many beams a scan may have more or fewer than its angles state: its writer may count the last angle or not.
const BEAMS: f64 = 2.0;
/// The same as a part of the beams: an increment that is rounded to two digits.
const ROUNDED: f64 = 0.02;
/// At distance 0 an object would be in no direction, m.
const CLOSE: f32 = 1e-6;
/// The most that the beams of a scan may turn, and its writer count the first one twice.
const TURN: f64 = 1.05 * TAU;

/// The fewest echoes of a ring that do not repeat by chance: a sonar measures whole millimetres.
const ECHOES: usize = 3;

/// What a distance sensor tells along one beam or cone, by REP-117 and the limits of the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Echo {
    /// An object at this distance, m: above 0, at least the least and below the greatest measurable distance.
    Hit(f32),
    /// An object too close to measure (−∞).
    TooClose,
    /// No object up to the greatest measurable distance: +∞, or exactly that distance, which older drivers report.
    Free,
    /// No measurement: NaN, 0, a negative distance, or one beyond the limits.
    Nothing,
}

/// Why a published value is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unmeasured {
    /// The first angle or the increment is not finite, the increment is 0, or the beams turn by more than a circle.
    Angles,
    /// There are not as many beams as the angles state.
    Beams {
        /// How many there are.
        found: usize,
        /// How many there should be.
        stated: f64,
    },
    /// The limits are not finite, negative or crossed.
    Limits {
        /// The least measurable distance, m.
        least: f32,
        /// The greatest measurable distance, m.
        greatest: f32,
    },
    /// Nothing in it is a measurement.
    Nothing,
    /// The orientation has no length, or is not finite.
    Orientation,
    /// A number that is needed is not finite.
    NotFinite,
    /// The bytes do not fit the sizes and fields that it states.
    Bytes,
}

/// For people, after the name of the value: "its limits are 8 m and 0.1 m".
impl fmt::Display for Unmeasured {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Angles => f.write_str("its angles contradict each other"),
            Self::Beams { found, stated } => {
                write!(f, "it has {found} beams, and its angles state {stated:.0}")
            }
            Self::Limits { least, greatest } => write!(f, "its limits are {least} m and {greatest} m"),
            Self::Nothing => f.write_str("it measures nothing"),
            Self::Orientation => f.write_str("its orientation is a quaternion without a length"),
            Self::NotFinite => f.write_str("its numbers are not finite"),
            Self::Bytes => f.write_str("its bytes do not fit its sizes and fields"),
        }
    }
}

impl core::error::Error for Unmeasured {}

/// Returns whether the bytes are a measurement.
pub type Check = fn(&[u8]) -> Result<(), Unmeasured>;
/// Returns whether a measurement is the same to the bit as the one before, whatever their headers, and shows something
/// that a motion of the sensor would change.
pub type Repeats = fn(now: &[u8], before: &[u8]) -> bool;

/// How values of a type are checked.
#[derive(Clone, Copy, Debug)]
pub struct Checks {
    /// Whether it is a measurement.
    pub measured: Check,
    /// Whether a sensor of the surroundings repeats itself; `None` of what does not measure the surroundings, or where
    /// equal values are likely: a single distance.
    pub repeats: Option<Repeats>,
}

impl Checks {
    /// Returns the checks of values of this type; `None` if each of them is a value.
    #[must_use]
    pub fn of(value_type: &Type) -> Option<Self> {
        fn checks<T: Value>(value_type: &Type, measured: Check, repeats: Option<Repeats>) -> Option<Checks> {
            let is_same = value_type.difference(&T::describe()).is_none();
            is_same.then_some(Checks { measured, repeats })
        }
        match value_type.name.as_str() {
            "sensor_msgs/msg/LaserScan" => checks::<LaserScan>(
                value_type,
                |bytes| view(bytes, LaserScan::measured),
                Some(|now, before| both(now, before, LaserScan::repeats)),
            ),
            "jde_msgs/msg/RangeRing" => checks::<RangeRing>(
                value_type,
                |bytes| view(bytes, RangeRing::measured),
                Some(|now, before| both(now, before, RangeRing::repeats)),
            ),
            "sensor_msgs/msg/PointCloud2" => checks::<PointCloud2>(
                value_type,
                |bytes| view(bytes, PointCloud2::measured),
                Some(|now, before| both(now, before, |a: &PointCloud2, b| a.data == b.data)),
            ),
            "sensor_msgs/msg/Image" => checks::<Image>(
                value_type,
                |bytes| view(bytes, Image::measured),
                Some(|now, before| both(now, before, Image::repeats)),
            ),
            "sensor_msgs/msg/CompressedImage" => checks::<CompressedImage>(
                value_type,
                |bytes| view(bytes, CompressedImage::measured),
                Some(|now, before| both(now, before, |a: &CompressedImage, b| a.data == b.data)),
            ),
            "sensor_msgs/msg/Range" => {
                checks::<Range>(value_type, |bytes| view(bytes, Range::measured), None)
            }
            "nav_msgs/msg/Odometry" => {
                checks::<Odometry>(value_type, |bytes| view(bytes, Odometry::measured), None)
            }
            _ => None,
        }
    }
}

fn view<T: Value>(bytes: &[u8], check: impl Fn(&T) -> Result<(), Unmeasured>) -> Result<(), Unmeasured> {
    T::view(bytes).map_or(Ok(()), check)
}

fn both<T: Value>(now: &[u8], before: &[u8], repeats: impl Fn(&T, &T) -> bool) -> bool {
    let values = T::view(now).zip(T::view(before));
    values.is_some_and(|(now, before)| repeats(now, before))
}

/// Whether all numbers are the same to the bit; NaN, too.
fn same(now: &[f32], before: &[f32]) -> bool {
    now.len() == before.len() && now.iter().zip(before).all(|(a, b)| a.to_bits() == b.to_bits())
}

impl Echo {
    /// Returns what `range` tells of a sensor that measures from `least` to `greatest` m.
    #[must_use]
    pub fn of(range: f32, least: f32, greatest: f32) -> Self {
        if range == f32::NEG_INFINITY {
            Self::TooClose
        } else if range == f32::INFINITY || range == greatest {
            Self::Free
        } else if range > 0.0 && least <= range && range < greatest {
            Self::Hit(range)
        } else {
            Self::Nothing
        }
    }

    /// Returns how far away the object is, m; `None` if there is none. One that is too close to measure counts as at
    /// the least distance.
    #[must_use]
    pub fn distance(&self, least: f32) -> Option<f64> {
        match self {
            Self::Hit(range) => Some(f64::from(*range)),
            Self::TooClose => Some(f64::from(least.max(CLOSE))),
            Self::Free | Self::Nothing => None,
        }
    }
}

fn limits(least: f32, greatest: f32, is_ordered: bool) -> Result<(), Unmeasured> {
    if is_ordered && least.is_finite() && least >= 0.0 && greatest > 0.0 {
        Ok(())
    } else {
        Err(Unmeasured::Limits { least, greatest })
    }
}

fn any(mut echoes: impl Iterator<Item = Echo>) -> Result<(), Unmeasured> {
    match echoes.any(|echo| echo != Echo::Nothing) {
        true => Ok(()),
        false => Err(Unmeasured::Nothing),
    }
}

/// Checks the beams of a scan as [`LaserScan::measured`]: the first and the last angle and the increment, the least and
/// the greatest distance, and the ranges, of which there may be more than fit into a `LaserScan`.
///
/// # Errors
/// Why it is no scan.
pub fn check_beams(angles: [f32; 3], [least, greatest]: [f32; 2], ranges: &[f32]) -> Result<(), Unmeasured> {
    limits(least, greatest, least < greatest)?;
    let ([first, last, increment], beams) = (angles.map(f64::from), ranges.len());
    let is_finite = angles.iter().all(|angle| angle.is_finite());
    let turned = increment.abs() * beams as f64;
    if !is_finite || (beams > 1 && (increment == 0.0 || turned > TURN)) {
        return Err(Unmeasured::Angles);
    }
    if beams > 1 {
        let stated = (last - first) / increment + 1.0;
        if (stated - beams as f64).abs() > BEAMS.max(ROUNDED * beams as f64) {
            return Err(Unmeasured::Beams { found: beams, stated });
        }
    }
    any(ranges.iter().map(|range| Echo::of(*range, least, greatest)))
}

impl LaserScan {
    /// Checks that the angles, the limits and the number of beams fit each other, and that a beam measures something.
    ///
    /// The increment of a single beam may be 0.
    ///
    /// # Errors
    /// Why it is no scan.
    pub fn measured(&self) -> Result<(), Unmeasured> {
        let angles = [self.angle_min, self.angle_max, self.angle_increment];
        check_beams(angles, [self.range_min, self.range_max], &self.ranges)
    }

    /// Whether it is the scan before, to the bit, and hits something. Where nothing is in range, all scans are equal.
    fn repeats(&self, before: &Self) -> bool {
        same(&self.ranges, &before.ranges)
            && same(&self.intensities, &before.intensities)
            && self.points().next().is_some()
    }

    /// Returns what each beam tells, first beam first; nothing of a scan that is none.
    pub fn echoes(&self) -> impl Iterator<Item = (usize, Echo)> + '_ {
        let beams = if self.measured().is_ok() {
            self.ranges.as_slice()
        } else {
            &[]
        };
        beams.iter().map(|range| self.echo_of(*range)).enumerate()
    }

    /// States the last angle for the beams that there are.
    pub fn state_last_angle(&mut self) {
        let last = self.ranges.len().saturating_sub(1) as f32;
        self.angle_max = self.angle_min + last * self.angle_increment;
    }

    fn echo_of(&self, range: f32) -> Echo {
        Echo::of(range, self.range_min, self.range_max)
    }
}

impl Range {
    /// Returns what the sensor tells. A sensor of a fixed distance has equal limits, and tells only +∞ or −∞.
    #[must_use]
    pub fn echo(&self) -> Echo {
        Echo::of(self.range, self.min_range, self.max_range)
    }

    /// Checks that the limits are in order and that the sensor measures.
    ///
    /// # Errors
    /// Why it is no measurement.
    pub fn measured(&self) -> Result<(), Unmeasured> {
        limits(self.min_range, self.max_range, self.min_range <= self.max_range)?;
        any(core::iter::once(self.echo()))
    }
}

impl RangeRing {
    /// Checks that the limits are in order and that one of the sonars measures.
    ///
    /// # Errors
    /// Why it is no measurement.
    pub fn measured(&self) -> Result<(), Unmeasured> {
        limits(self.min_range, self.max_range, self.min_range <= self.max_range)?;
        let echoes = self.ranges.iter();
        any(echoes.map(|range| Echo::of(*range, self.min_range, self.max_range)))
    }

    /// Whether it is the ring before, to the bit, with so many echoes that they are not equal by chance.
    fn repeats(&self, before: &Self) -> bool {
        same(&self.ranges, &before.ranges) && self.echoes().count() >= ECHOES
    }
}

impl PointCloud2 {
    /// Checks the fields and sizes, and that a point is finite.
    ///
    /// # Errors
    /// Why it is no measurement.
    pub fn measured(&self) -> Result<(), Unmeasured> {
        let mut points = self.points().map_err(|_| Unmeasured::Bytes)?;
        points.next().map(drop).ok_or(Unmeasured::Nothing)
    }
}

impl Image {
    /// Checks that the rows are there; and, of a picture of depths, that a pixel has one.
    ///
    /// # Errors
    /// Why it is no picture.
    pub fn measured(&self) -> Result<(), Unmeasured> {
        let (rows, row) = (self.height as usize, self.step as usize);
        if rows.checked_mul(row).is_none_or(|bytes| bytes > self.data.len()) {
            return Err(Unmeasured::Bytes);
        }
        if rows == 0 || row == 0 || self.width == 0 {
            return Err(Unmeasured::Nothing);
        }
        if self.encoding.as_str() != "32FC1" {
            return Ok(());
        }
        if (self.width as usize)
            .checked_mul(4)
            .is_none_or(|bytes| bytes > row)
        {
            return Err(Unmeasured::Bytes);
        }
        let number = |bytes: &[u8]| {
            let bytes: [u8; 4] = bytes.try_into().unwrap_or_default();
            if self.is_bigendian == 0 {
                f32::from_le_bytes(bytes)
            } else {
                f32::from_be_bytes(bytes)
            }
        };
        let depths = self.data.chunks_exact(row).take(rows);
        let depths = depths.flat_map(|row| row[..4 * self.width as usize].chunks_exact(4).map(number));
        any(depths.map(|depth| Echo::of(depth, 0.0, f32::INFINITY)))
    }
}

impl Image {
    /// Whether it is the picture before, to the bit, and its columns differ: a wall and the floor look the same from
    /// many places.
    fn repeats(&self, before: &Self) -> bool {
        let pixel = (self.step / self.width.max(1)).max(1) as usize;
        let mut rows = self.data.chunks_exact(self.step.max(1) as usize);
        self.data == before.data && rows.any(|row| row[..row.len() - pixel] != row[pixel..])
    }
}

impl CompressedImage {
    /// Checks that there is a file.
    ///
    /// # Errors
    /// If there is none.
    pub fn measured(&self) -> Result<(), Unmeasured> {
        if self.data.is_empty() {
            return Err(Unmeasured::Nothing);
        }
        Ok(())
    }
}

impl Odometry {
    /// Checks that what counts of it in the plane is finite, the pose and the velocity, and that the orientation is one.
    ///
    /// # Errors
    /// Why it is no odometry.
    pub fn measured(&self) -> Result<(), Unmeasured> {
        let (pose, twist) = (&self.pose.pose, &self.twist.twist);
        let velocity = [twist.linear.x, twist.linear.y, twist.angular.z];
        let numbers = [pose.position.x, pose.position.y].into_iter().chain(velocity);
        if !numbers.into_iter().all(f64::is_finite) {
            Err(Unmeasured::NotFinite)
        } else if pose.orientation.normalized().is_none() {
            Err(Unmeasured::Orientation)
        } else {
            Ok(())
        }
    }
}
