//! Encodes and decodes messages by the description of their type, with stamps in the receiver's time.

use std::sync::Arc;

use jde_ros::cdr;
use jde_ros_node::{Clock, Quality, Topic};
use jde_schema::describe::{Field, FieldKind, Form, Type};
use jde_schema::prelude::*;

use crate::messages::STAMP;

/// A type of message that is known by its description alone.
pub(super) struct DescribedCodec {
    value_type: Arc<Type>,
    header: Option<HeaderPlace>,
}

/// The place of the header's fields in a value.
#[derive(Clone, Copy)]
struct HeaderPlace {
    /// Seconds, then nanoseconds, four bytes each.
    stamp: usize,
    frame: usize,
    frame_length: usize,
    frame_capacity: usize,
}

impl DescribedCodec {
    pub(super) fn new(value_type: &Arc<Type>) -> Self {
        Self {
            header: HeaderPlace::of(value_type),
            value_type: Arc::clone(value_type),
        }
    }

    /// The topic of that name with these messages.
    pub(super) fn topic(&self, name: String, quality: Quality) -> Topic {
        Topic::new(name, &self.value_type, quality)
    }

    /// Whether its messages begin with a header.
    pub(super) fn has_header(&self) -> bool {
        self.header.is_some()
    }

    /// Encodes a value that was measured at its stamp, or at `time` if it has none; in `frame` unless that is empty.
    pub(super) fn encode(&self, value: &[u8], frame: &str, time: Duration, clock: &Clock) -> Vec<u8> {
        let mut message = Vec::new();
        let Some(header) = self.header else {
            cdr::encode(&self.value_type, value, &mut message);
            return message;
        };
        if frame.is_empty() {
            cdr::encode(&self.value_type, value, &mut message);
        } else {
            let mut value = value.to_vec();
            header.set_frame(&mut value, frame);
            cdr::encode(&self.value_type, &value, &mut message);
        }
        let stamp = header.stamp(value);
        let measured = if stamp == Time::default() {
            time
        } else {
            stamp.into()
        };
        if let Some(field) = message.get_mut(STAMP) {
            field.copy_from_slice(&to_bytes(
                clock.stamp(measured),
                u32::to_le_bytes,
                i32::to_le_bytes,
            ));
        }
        message
    }

    /// The stamp of a message, if its type has a header.
    pub(super) fn stamp(&self, message: &[u8]) -> Option<Time> {
        self.header?;
        let (sec, nanosec) = message.get(STAMP)?.split_first_chunk::<4>()?;
        Some(Time {
            sec: i32::from_le_bytes(*sec),
            nanosec: u32::from_le_bytes(nanosec.try_into().ok()?),
        })
    }

    /// Replaces a value by the contents of a message, measured at `time`.
    ///
    /// # Errors
    /// If the message is of another type or does not fit. The value is then unusable.
    pub(super) fn decode_into(
        &self,
        message: &[u8],
        time: Duration,
        value: &mut [u8],
    ) -> Result<(), cdr::Error> {
        cdr::decode_into(&self.value_type, message, value)?;
        if let Some(header) = self.header {
            let bytes = to_bytes(time.into(), u32::to_ne_bytes, i32::to_ne_bytes);
            value[header.stamp..][..8].copy_from_slice(&bytes);
        }
        Ok(())
    }
}

fn to_bytes(time: Time, unsigned: fn(u32) -> [u8; 4], signed: fn(i32) -> [u8; 4]) -> [u8; 8] {
    let mut bytes = [0; 8];
    bytes[..4].copy_from_slice(&signed(time.sec));
    bytes[4..].copy_from_slice(&unsigned(time.nanosec));
    bytes
}

impl HeaderPlace {
    /// The place of the header in a type whose first field is one.
    fn of(value_type: &Type) -> Option<Self> {
        let (header, at) = structure(value_type.fields.first()?, "std_msgs/msg/Header")?;
        let (time, stamp) = structure(header.fields.first()?, "builtin_interfaces/msg/Time")?;
        let frame = header.fields.get(1)?;
        let Form::Text {
            capacity,
            length_offset,
        } = frame.form
        else {
            return None;
        };
        (time.bytes == 8).then_some(Self {
            stamp: at + stamp,
            frame: at + frame.offset,
            frame_length: at + length_offset,
            frame_capacity: capacity,
        })
    }

    fn stamp(self, value: &[u8]) -> Time {
        let number = |at: usize| value[at..].first_chunk().copied().unwrap_or_default();
        Time {
            sec: i32::from_ne_bytes(number(self.stamp)),
            nanosec: u32::from_ne_bytes(number(self.stamp + 4)),
        }
    }

    fn set_frame(self, value: &mut [u8], frame: &str) {
        let frame = &frame[..frame.floor_char_boundary(self.frame_capacity)];
        value[self.frame..][..frame.len()].copy_from_slice(frame.as_bytes());
        value[self.frame_length..][..4].copy_from_slice(&(frame.len() as u32).to_ne_bytes());
    }
}

/// The structure of that name in a field, and its place.
fn structure<'t>(field: &'t Field, name: &str) -> Option<(&'t Type, usize)> {
    match &field.kind {
        FieldKind::Struct(inner) if inner.name == name && field.form == Form::One => {
            Some((inner, field.offset))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock() -> Clock {
        let mut clock = Clock::default();
        clock.compare(Duration::ZERO, Duration::from_secs(1_700_000_000));
        clock
    }

    #[test]
    fn a_described_value_has_the_stamp_and_frame_of_its_message() {
        let codec = DescribedCodec::new(&Arc::new(Odometry::describe()));
        let value = Odometry::planar(
            Duration::from_millis(2500),
            Pose2D::new(1.0, 2.0, 0.0),
            Twist::ZERO,
        );
        let message = codec.encode(value.as_bytes(), "wheels", Duration::from_secs(9), &clock());
        let stamp = codec.stamp(&message).expect("a header");
        assert_eq!((stamp.sec, stamp.nanosec), (1_700_000_002, 500_000_000));
        let mut decoded = Odometry::default();
        let time = Duration::from_millis(2500);
        codec
            .decode_into(&message, time, decoded.as_bytes_mut())
            .expect("it is one");
        assert_eq!(decoded.header, Header::new(value.header.stamp, "wheels"));
        assert_eq!(decoded.pose, value.pose);
        let unstamped = codec.encode(
            Odometry::default().as_bytes(),
            "",
            Duration::from_secs(9),
            &clock(),
        );
        assert_eq!(
            codec.stamp(&unstamped).map(|stamp| stamp.sec),
            Some(1_700_000_009)
        );
    }

    #[test]
    fn a_type_without_a_header_has_no_stamp() {
        let codec = DescribedCodec::new(&Arc::new(Twist::describe()));
        let message = codec.encode(
            Twist::planar(0.5, 0.0).as_bytes(),
            "base",
            Duration::ZERO,
            &clock(),
        );
        assert_eq!(codec.stamp(&message), None);
        let mut decoded = Twist::ZERO;
        codec
            .decode_into(&message, Duration::ZERO, decoded.as_bytes_mut())
            .expect("it is one");
        assert_eq!(decoded, Twist::planar(0.5, 0.0));
        assert!(
            codec
                .decode_into(&message[..9], Duration::ZERO, decoded.as_bytes_mut())
                .is_err()
        );
    }
}
