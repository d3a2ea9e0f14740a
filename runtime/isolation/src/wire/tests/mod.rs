//! Every message arrives as it was sent; bytes that are no message are refused, and cost no more memory than they have.

mod memory;
mod parts;

use jde_abi::describe::{FieldKind, Type};
use jde_watchdog::Watchdog;
use memory::OBTAINED;
use parts::Parts;
use proptest::prelude::*;

use super::*;
use crate::inspect::{InspectorRequest, InspectorResponse};
use crate::messages::{Bytes, FromChild, ToChild};

fn pair() -> (Wire, UnixStream) {
    let (first, second) = UnixStream::pair().expect("a pair");
    (Wire::new(first), second)
}

/// Checks that each message arrives.
macro_rules! assert_arrives {
    ($messages:expr, $type:ty) => {
        for sent in &$messages {
            let (mut wire, other) = pair();
            wire.send(sent).expect("a sent message");
            let mut other = Wire::new(other);
            let received: $type = other.receive().expect("a message");
            assert_eq!(format!("{received:?}"), format!("{sent:?}"));
        }
    };
}

/// Receives bytes as messages of each type, until an error. `room` is what may be obtained besides the words for what was
/// read. Checks the error.
macro_rules! assert_ends {
    ($bytes:expr, $room:expr, $($type:ty),*) => {$({
        let (mut wire, mut other) = pair();
        other.write_all($bytes).expect("sent bytes");
        drop(other);
        let before = OBTAINED.get();
        let error = loop {
            if let Err(error) = wire.receive::<$type>() {
                break error.kind();
            }
        };
        let obtained = OBTAINED.get() - before;
        assert!(
            matches!(error, io::ErrorKind::InvalidData | io::ErrorKind::UnexpectedEof),
            "{error}"
        );
        assert!(obtained <= $room + 200 * $bytes.len(), "{obtained} bytes for {}", $bytes.len());
    })*};
    ($bytes:expr, $room:expr) => {
        assert_ends!($bytes, $room, ToChild<'_>, FromChild<'_>, InspectorRequest, InspectorResponse)
    };
}

/// Returns bytes behind their length.
fn framed(bytes: &[u8]) -> Vec<u8> {
    [&(bytes.len() as u64).to_ne_bytes(), bytes].concat()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_message_arrives_as_it_was_sent(parts in Parts::any()) {
        assert_arrives!(parts.of_host(), ToChild<'_>);
        assert_arrives!(parts.of_child(), FromChild<'_>);
        assert_arrives!(parts.inspections(), InspectorRequest);
        assert_arrives!(parts.inspected(), InspectorResponse);
    }

    #[test]
    fn damaged_messages_cost_no_more_memory_than_they_have(parts in Parts::any(), place: u16, byte: u8) {
        for mut message in parts.encoded() {
            let message = &mut message[size_of::<u64>()..];
            let place = usize::from(place) % message.len();
            message[place] = byte;
            assert_ends!(&framed(message), 1000);
            assert_ends!(&framed(&message[..place]), 1000);
        }
    }
}

proptest! {
    #[test]
    fn bytes_that_are_no_message_are_refused(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        assert_ends!(&framed(&bytes), 1000);
        assert_ends!(&bytes, ROOM_STEP);
    }
}

#[test]
fn a_message_with_more_than_its_value_is_refused() {
    let (mut wire, mut other) = pair();
    other.write_all(&framed(&[0, 0])).expect("sent bytes");
    let error = wire.receive::<bool>().expect_err("no message");
    assert_eq!(error.kind(), io::ErrorKind::InvalidData);
}

#[test]
fn a_length_that_no_message_has_is_refused() {
    for length in [MAX_BYTES + 1, u64::MAX] {
        let (mut wire, mut other) = pair();
        other.write_all(&length.to_ne_bytes()).expect("sent bytes");
        let error = wire.receive::<FromChild<'_>>().expect_err("no message");
        assert_eq!(error.kind(), io::ErrorKind::InvalidData);
    }
}

#[test]
fn a_long_message_that_does_not_arrive_gets_little_room() {
    let (mut wire, mut other) = pair();
    other.write_all(&MAX_BYTES.to_ne_bytes()).expect("sent bytes");
    drop(other);
    let error = wire.receive::<FromChild<'_>>().expect_err("no message");
    assert_eq!(error.kind(), io::ErrorKind::UnexpectedEof);
    assert_eq!(wire.input.capacity(), ROOM_STEP);
}

#[test]
fn a_message_of_several_steps_arrives_and_its_room_is_not_kept() {
    let _watchdog = Watchdog::for_test();
    let (mut wire, other) = pair();
    let value = vec![7; 3 * ROOM_STEP + 5];
    let publish = |value| FromChild::Publish {
        port: 1,
        time: 2,
        value: Some(Bytes(value)),
        unanswered: true,
    };
    std::thread::scope(|scope| {
        let sender = scope.spawn(|| {
            let mut other = Wire::new(other);
            other.send(&publish(&value)).expect("a sent message");
            other.send(&publish(&[1])).expect("a sent message");
        });
        for expected in [&value[..], &[1]] {
            let received = wire.receive::<FromChild<'_>>().expect("a message");
            assert!(
                matches!(received, FromChild::Publish { value: Some(Bytes(value)), .. } if value == expected)
            );
        }
        sender.join().expect("the sender ends");
    });
    assert!(wire.input.capacity() <= ROOM_STEP);
}

#[test]
fn types_that_nest_without_end_are_refused() {
    let mut listed = Parts::default().listed();
    for _ in 0..100 {
        let inner = listed[0].value_type.clone();
        let mut outer = Type::clone(&inner);
        outer.fields.truncate(1);
        outer.fields[0].kind = FieldKind::Struct(inner);
        listed[0].value_type = outer.into();
    }
    let (mut wire, other) = pair();
    wire.send(&InspectorRequest::Inspect {
        path: "deep".into(),
        number: 0,
        name: String::new(),
        listed,
    })
    .expect("a sent message");
    let error = Wire::new(other)
        .receive::<InspectorRequest>()
        .expect_err("no message");
    assert_eq!(error.kind(), io::ErrorKind::InvalidData);
}

#[test]
fn the_end_of_the_stream_is_detected() {
    let (mut wire, mut other) = pair();
    other.write_all(&[0; 3]).expect("sent bytes");
    drop(other);
    let error = wire.receive::<FromChild<'_>>().expect_err("no complete message");
    assert_eq!(error.kind(), io::ErrorKind::UnexpectedEof);
}
