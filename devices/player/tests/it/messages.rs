//! Messages against bytes written by hand.

use jde_player::*;
use proptest::collection::vec;
use proptest::prelude::*;

use crate::checks;
use crate::server::{BASE, message};

/// A greeting of a version.
fn greeting(version: &str) -> Vec<u8> {
    let mut bytes = format!("Player v.{version}").into_bytes();
    bytes.resize(32, 0);
    bytes
}

fn receive(bytes: &[u8]) -> Result<Vec<Message>, Error> {
    let mut messages = Vec::new();
    Receiver::default().receive(bytes, |message| messages.push(message))?;
    Ok(messages)
}

fn error(bytes: &[u8]) -> String {
    receive(bytes)
        .expect_err("no Player server sends that")
        .to_string()
}

#[test]
fn a_message_is_a_header_of_40_bytes_and_a_body() {
    let bytes = Message::to(Interface::RANGER.at(1), Kind::Request, 5, vec![0xAB; 4]).to_bytes();
    let mut expected = vec![0; 8];
    expected.extend([0, 0, 0, 62, 0, 0, 0, 1, 0, 0, 0, 3, 0, 0, 0, 5]);
    expected.extend([0; 12]);
    expected.extend([0, 0, 0, 4, 0xAB, 0xAB, 0xAB, 0xAB]);
    assert_eq!(bytes, expected);
    let received = receive(&[greeting("3.1.1-dev"), bytes].concat()).unwrap();
    assert_eq!(
        received,
        [Message::to(
            Interface::RANGER.at(1),
            Kind::Request,
            5,
            vec![0xAB; 4]
        )]
    );
    let stamped = receive(&[greeting("3.0.2"), message(BASE, 1, 1, &[])].concat()).unwrap();
    assert_eq!((stamped[0].kind, stamped[0].stamp), (Kind::Data, 12.5));
}

#[test]
fn other_programs_and_other_versions_are_named() {
    assert_eq!(
        error(b"SSH-2.0"),
        "it is not a Player server: its first bytes are `SSH-2.0`"
    );
    assert_eq!(
        error(b"\xFF"),
        "it is not a Player server: its first bytes are `\\xff`"
    );
    assert_eq!(
        error(&greeting("2.1.0")),
        "it is Player 2.1.0, and only version 3 is supported"
    );
    assert_eq!(
        error(&greeting("30")),
        "it is Player 30, and only version 3 is supported"
    );
    assert_eq!(receive(b"Play"), Ok(vec![]));
}

#[test]
fn an_impossible_header_is_an_error_at_once() {
    let with = |word: usize, value: u32| {
        let mut bytes = message(BASE, 1, 1, &[0; 8]);
        bytes[4 * word..4 * word + 4].copy_from_slice(&value.to_be_bytes());
        error(&[greeting("3.1"), bytes].concat())
    };
    assert_eq!(
        with(2, 70_000),
        "it sent interface 70000, which no Player server sends"
    );
    assert_eq!(
        with(3, 70_000),
        "it sent index 70000, which no Player server sends"
    );
    assert_eq!(
        with(4, 0),
        "it sent a message of type 0, which no Player server sends"
    );
    assert_eq!(
        with(4, 7),
        "it sent a message of type 7, which no Player server sends"
    );
    assert_eq!(
        with(5, 256),
        "it sent a message of subtype 256, which no Player server sends"
    );
    assert_eq!(
        with(9, u32::MAX),
        "it sent a message of length 4294967295, which no Player server sends"
    );
}

proptest! {
    #[test]
    fn messages_are_found_after_any_split(
        bodies in vec((0..9_u16, 0..7_u32, 0..=255_u32, vec(any::<u8>(), 0..90)), 0..6),
        cut in any::<prop::sample::Index>(),
    ) {
        let mut stream = greeting("3.1.0");
        for (index, kind, subtype, body) in &bodies {
            stream.extend(message((62, *index), *kind, *subtype, body));
        }
        checks::stream(&stream);
        checks::stream(&stream[..cut.index(stream.len())]);
    }

    #[test]
    fn any_bytes_are_messages_or_an_error(data in vec(any::<u8>(), 0..400)) {
        checks::stream(&data);
        checks::stream(&[greeting("3.1.0"), data.clone()].concat());
        checks::session(&data);
    }
}
