//! Encodes and decodes messages by the description of their type, with stamps in the receiver's time.

use std::sync::Arc;

use jde_ros::cdr;
use jde_ros_node::{Clock, Quality, Topic};
use jde_schema::describe::{Field, FieldKind, Form, Type};
use jde_schema::prelude::*;

use crate::messages::STAMP;

/// A type of message that is known by its description alone.
pub(crate) struct DescribedCodec {
    value_type: Arc<Type>,
    header: Option<HeaderPlace>,
    /// Whether it has times besides the stamp of its header.
    has_times: bool,
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
    pub(crate) fn new(value_type: &Arc<Type>) -> Self {
        Self {
            header: HeaderPlace::of(value_type),
            has_times: count_times(value_type) > usize::from(HeaderPlace::of(value_type).is_some()),
            value_type: Arc::clone(value_type),
        }
    }

    /// The topic of that name with these messages.
    pub(crate) fn topic(&self, name: String, quality: Quality) -> Topic {
        Topic::new(name, &self.value_type, quality)
    }

    /// The type of its values.
    pub(crate) fn value_type(&self) -> &Type {
        &self.value_type
    }

    /// Whether its messages begin with a header.
    pub(crate) fn has_header(&self) -> bool {
        self.header.is_some()
    }

    /// Encodes a value that was measured at its stamp, or at `time` if it has none; in `frame` unless that is empty.
    pub(crate) fn encode(&self, value: &[u8], frame: &str, time: Duration, clock: &Clock) -> Vec<u8> {
        let mut message = Vec::new();
        let frame = self
            .header
            .filter(|_| !frame.is_empty())
            .map(|header| (header, frame));
        if frame.is_some() || self.has_times {
            let mut value = value.to_vec();
            if let Some((header, frame)) = frame {
                header.set_frame(&mut value, frame);
            }
            convert_times(&self.value_type, &mut value, &mut |stamp| {
                clock.stamp(stamp.into())
            });
            cdr::encode(&self.value_type, &value, &mut message);
        } else {
            cdr::encode(&self.value_type, value, &mut message);
        }
        let Some(header) = self.header else {
            return message;
        };
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

    /// Encodes a value without the times in it.
    pub(crate) fn encode_without_times(&self, value: &[u8]) -> Vec<u8> {
        let (mut value, mut message) = (self.value_type.copy(value), Vec::new());
        convert_times(&self.value_type, &mut value, &mut |_| Time::default());
        cdr::encode(&self.value_type, &value, &mut message);
        message
    }

    /// Checks that a message is one of this type.
    ///
    /// # Errors
    /// If it is not, or does not fit.
    pub(crate) fn check(&self, message: &[u8]) -> Result<(), cdr::Error> {
        cdr::decode_pieces(&self.value_type, &[message], &mut vec![0; self.value_type.bytes])
    }

    /// The stamp of a message in pieces, if its type has a header.
    pub(crate) fn stamp(&self, pieces: &[&[u8]]) -> Option<Time> {
        self.header?;
        let mut bytes = pieces.iter().copied().flatten().copied().skip(STAMP.start);
        let mut number = || {
            let mut number = [0; 4];
            for byte in &mut number {
                *byte = bytes.next()?;
            }
            Some(number)
        };
        Some(Time {
            sec: i32::from_le_bytes(number()?),
            nanosec: u32::from_le_bytes(number()?),
        })
    }

    /// Replaces a value by the contents of a message in pieces, measured at `time`.
    ///
    /// # Errors
    /// If the message is of another type or does not fit. The value is then unusable.
    pub(crate) fn decode_into(
        &self,
        pieces: &[&[u8]],
        (time, clock): (Duration, &Clock),
        value: &mut [u8],
    ) -> Result<(), cdr::Error> {
        cdr::decode_pieces(&self.value_type, pieces, value)?;
        if self.has_times {
            convert_times(&self.value_type, value, &mut |stamp| clock.time(stamp).into());
        }
        if let Some(header) = self.header {
            let bytes = to_bytes(time.into(), u32::to_ne_bytes, i32::to_ne_bytes);
            value[header.stamp..][..8].copy_from_slice(&bytes);
        }
        Ok(())
    }
}

/// The name of the type of a stamp.
const TIME: &str = "builtin_interfaces/msg/Time";

/// The number of places in a type that have times, each element of a list once.
fn count_times(value_type: &Type) -> usize {
    let inner = value_type.fields.iter().filter_map(|field| match &field.kind {
        FieldKind::Struct(inner) => Some(inner),
        FieldKind::Scalar(_) => None,
    });
    inner
        .map(|inner| usize::from(inner.name == TIME) + count_times(inner))
        .sum()
}

/// Converts every time of a value that is not zero.
fn convert_times(value_type: &Type, value: &mut [u8], convert: &mut impl FnMut(Time) -> Time) {
    for field in &value_type.fields {
        let FieldKind::Struct(inner) = &field.kind else {
            continue;
        };
        let (count, bytes) = (field.length(value), inner.bytes);
        for element in value[field.offset..][..count * bytes].chunks_exact_mut(bytes) {
            if inner.name != TIME {
                convert_times(inner, element, convert);
                continue;
            }
            let time = read_time(element);
            if time != Time::default() {
                element[..8].copy_from_slice(&to_bytes(convert(time), u32::to_ne_bytes, i32::to_ne_bytes));
            }
        }
    }
}

fn read_time(bytes: &[u8]) -> Time {
    let number = |at: usize| bytes[at..].first_chunk().copied().unwrap_or_default();
    Time {
        sec: i32::from_ne_bytes(number(0)),
        nanosec: u32::from_ne_bytes(number(4)),
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
        let (time, stamp) = structure(header.fields.first()?, TIME)?;
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
        read_time(&value[self.stamp..])
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
        let stamp = codec.stamp(&[&message]).expect("a header");
        assert_eq!((stamp.sec, stamp.nanosec), (1_700_000_002, 500_000_000));
        let mut decoded = Odometry::default();
        let time = Duration::from_millis(2500);
        codec
            .decode_into(&[&message], (time, &clock()), decoded.as_bytes_mut())
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
            codec.stamp(&[&unstamped]).map(|stamp| stamp.sec),
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
        assert_eq!(codec.stamp(&[&message]), None);
        let mut decoded = Twist::ZERO;
        codec
            .decode_into(&[&message], (Duration::ZERO, &clock()), decoded.as_bytes_mut())
            .expect("it is one");
        assert_eq!(decoded, Twist::planar(0.5, 0.0));
        assert!(
            codec
                .decode_into(
                    &[&message[..9]],
                    (Duration::ZERO, &clock()),
                    decoded.as_bytes_mut()
                )
                .is_err()
        );
    }

    #[test]
    fn all_times_of_a_value_are_those_of_the_receiver() {
        let codec = DescribedCodec::new(&Arc::new(Path::describe()));
        let mut path = Path::default();
        for stamp in [Time { sec: 7, nanosec: 5 }, Time::default()] {
            let pose = PoseStamped {
                header: Header::new(stamp, "map"),
                ..PoseStamped::default()
            };
            path.poses.push(pose).expect("it fits");
        }
        let message = codec.encode(path.as_bytes(), "", Duration::from_secs(9), &clock());
        let mut sent = Path::default();
        cdr::decode_into(&Path::describe(), &message, sent.as_bytes_mut()).expect("it is one");
        let seconds = |path: &Path| {
            [
                path.header.stamp.sec,
                path.poses[0].header.stamp.sec,
                path.poses[1].header.stamp.sec,
            ]
        };
        assert_eq!(seconds(&sent), [1_700_000_009, 1_700_000_007, 0]);
        let mut received = Path::default();
        let time = Duration::from_secs(9);
        codec
            .decode_into(&[&message], (time, &clock()), received.as_bytes_mut())
            .expect("it is one");
        assert_eq!(seconds(&received), [9, 7, 0]);
    }
}
