//! Encodes values as messages and back: CDR, with stamps in the receiver's time.

use core::marker::PhantomData;
use core::time::Duration;

use jde_ros::{Type, cdr};
use jde_ros_node::{Clock, Quality, Topic};
use jde_schema::prelude::*;

/// Position of the stamp in a message: after the encapsulation header, because every stamped interface begins
/// with its header, and the header with its stamp.
pub(crate) const STAMP: core::ops::Range<usize> = 4..12;

/// Encodes and decodes messages of one type.
#[derive(Debug)]
pub(crate) struct Codec<T> {
    value_type: Type,
    value: PhantomData<fn() -> T>,
}

/// A value whose interface begins with a header.
pub(crate) trait Stamped: Value {
    /// Its header.
    fn header(&self) -> &Header;

    /// Its header, for writing.
    fn header_mut(&mut self) -> &mut Header;
}

/// A pose with its covariance, whose header has the frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Value)]
#[repr(C)]
#[value(name = "geometry_msgs/msg/PoseWithCovarianceStamped")]
pub(crate) struct PoseWithCovarianceStamped {
    pub(crate) header: Header,
    pub(crate) pose: PoseWithCovariance,
}

/// A variance of what is not measured, such as the heading: so large that it says nothing.
const UNKNOWN_VARIANCE: f64 = 1e6;

impl From<&PositionFix> for PoseWithCovarianceStamped {
    fn from(fix: &PositionFix) -> Self {
        let mut this = Self {
            header: fix.header,
            pose: PoseWithCovariance::default(),
        };
        this.pose.pose = Pose2D::new(fix.x, fix.y, 0.0).into();
        // Six rows of six: x, y, z, and the rotations about them.
        for axis in 0..6 {
            this.pose.covariance[7 * axis] = UNKNOWN_VARIANCE;
        }
        let [xx, xy, yx, yy] = fix.covariance;
        this.pose.covariance[..2].copy_from_slice(&[xx, xy]);
        this.pose.covariance[6..8].copy_from_slice(&[yx, yy]);
        this
    }
}

impl From<&PoseWithCovarianceStamped> for PositionFix {
    fn from(message: &PoseWithCovarianceStamped) -> Self {
        let PoseWithCovariance { pose, covariance } = &message.pose;
        Self {
            header: message.header,
            x: pose.position.x,
            y: pose.position.y,
            covariance: [covariance[0], covariance[1], covariance[6], covariance[7]],
        }
    }
}

macro_rules! stamped {
    ($($stamped:ty),*) => { $(
        impl Stamped for $stamped {
            fn header(&self) -> &Header {
                &self.header
            }

            fn header_mut(&mut self) -> &mut Header {
                &mut self.header
            }
        }
    )* };
}

stamped!(
    LaserScan,
    Odometry,
    Image,
    BatteryState,
    Range,
    Imu,
    PoseWithCovarianceStamped,
    crate::base::HazardDetectionVector,
    jde_schema::types::CameraInfo,
    crate::scan::Sweep
);

/// The value in bytes of that type.
pub(crate) fn typed<T: Value>(bytes: &[u8]) -> T {
    let mut value = T::zeroed();
    value.as_bytes_mut().copy_from_slice(bytes);
    value
}

impl<T: Value> Codec<T> {
    pub(crate) fn new() -> Self {
        Self {
            value_type: T::describe(),
            value: PhantomData,
        }
    }

    /// The topic of that name with these messages.
    pub(crate) fn topic(&self, name: String, quality: Quality) -> Topic {
        Topic::new(name, &self.value_type, quality)
    }

    pub(crate) fn encode(&self, value: &T) -> Vec<u8> {
        let mut message = Vec::new();
        cdr::encode(&self.value_type, value.as_bytes(), &mut message);
        message
    }

    /// Replaces a value by the contents of a message that came in these pieces.
    ///
    /// # Errors
    /// If the message is of another type or does not fit. The value is then unusable.
    pub(crate) fn decode_into(&self, pieces: &[&[u8]], value: &mut T) -> Result<(), cdr::Error> {
        cdr::decode_pieces(&self.value_type, pieces, value.as_bytes_mut())
    }
}

impl<T: Stamped> Codec<T> {
    /// Encodes a value that was measured at its stamp, or at `time` if it has none.
    pub(crate) fn encode_stamped(&self, value: &T, time: Duration, clock: &Clock) -> Vec<u8> {
        let mut message = self.encode(value);
        let stamp = clock.stamp(measured(value.header(), time));
        if let Some(field) = message.get_mut(STAMP) {
            let (seconds, nanos) = field.split_at_mut(4);
            seconds.copy_from_slice(&stamp.sec.to_le_bytes());
            nanos.copy_from_slice(&stamp.nanosec.to_le_bytes());
        }
        message
    }
}

/// The time of the header's stamp, in the application's time; `time` without a stamp.
pub(crate) fn measured(header: &Header, time: Duration) -> Duration {
    if header.stamp == Time::default() {
        return time;
    }
    header.stamp.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_encoded_stamp_is_wall_clock_time() {
        let mut clock = Clock::default();
        clock.compare(Duration::ZERO, Duration::from_secs(1_700_000_000));
        let codec = Codec::<Odometry>::new();
        let value = Odometry::planar(
            Duration::from_millis(2500),
            Pose2D::new(1.0, 2.0, 0.0),
            Twist::ZERO,
        );
        let message = codec.encode_stamped(&value, Duration::from_secs(9), &clock);
        let mut decoded = Odometry::default();
        codec.decode_into(&[&message], &mut decoded).unwrap();
        assert_eq!(
            (decoded.header.stamp.sec, decoded.header.stamp.nanosec),
            (1_700_000_002, 500_000_000)
        );
        assert_eq!(decoded.pose, value.pose);
        let unstamped = codec.encode_stamped(&Odometry::default(), Duration::from_secs(9), &clock);
        codec.decode_into(&[&unstamped], &mut decoded).unwrap();
        assert_eq!(decoded.header.stamp.sec, 1_700_000_009);
    }
}
