//! Properties that hold for any bytes: nothing panics, memory stays bounded, and no robot moves without a
//! request.

use core::time::Duration;

use jde_player::*;

/// A stream gives the same messages however it is split, and each is the same after encoding.
pub(crate) fn stream(data: &[u8]) {
    let receive = |chunk_size: usize| {
        let (mut receiver, mut messages) = (Receiver::default(), Vec::new());
        let ends = data
            .chunks(chunk_size.max(1))
            .map(|chunk| receiver.receive(chunk, |message| messages.push(message)));
        let error = ends.into_iter().find_map(Result::err);
        (messages, error, receiver.version().map(str::to_owned))
    };
    let whole = receive(data.len());
    for size in [1, 7, 41] {
        let (messages, error, version) = receive(size);
        // The greeting is refused at its first wrong byte, so the bytes in the message differ.
        assert_eq!(
            error.map(|error| core::mem::discriminant(&error)),
            whole.1.as_ref().map(core::mem::discriminant)
        );
        assert_eq!((messages.len(), version), (whole.0.len(), whole.2.clone()));
    }
    let mut receiver = Receiver::default();
    receiver
        .receive(b"Player v.3\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0", |_| {})
        .expect("a greeting");
    for message in whole.0 {
        let mut again = Vec::new();
        receiver
            .receive(&message.to_bytes(), |message| again.push(message))
            .expect("a message");
        let [again] = &again[..] else {
            panic!("one message gives {}", again.len())
        };
        assert_eq!(
            (again.device, again.kind, again.subtype),
            (message.device, message.kind, message.subtype)
        );
        assert_eq!(
            (again.stamp.to_bits(), &again.body),
            (message.stamp.to_bits(), &message.body)
        );
    }
}

/// Runs a session against a server that sends any bytes. Whatever it sends, the session moves the robot only
/// on request, and what it exports is finite where a robot is steered by it.
pub(crate) fn session(data: &[u8]) {
    let [first, script @ ..] = data else { return };
    let laser = if first & 1 == 0 {
        Choice::Auto
    } else {
        Choice::Device(Interface::LASER.at(0))
    };
    let mut session = Session::new(
        Options {
            laser,
            ..Options::default()
        },
        Duration::ZERO,
    );
    let (mut now, mut output, mut is_requested) = (Duration::ZERO, Vec::new(), false);
    let mut rest = script;
    while let [kind, length, tail @ ..] = rest {
        let (bytes, tail) = tail.split_at(tail.len().min(usize::from(*length)));
        rest = tail;
        now += Duration::from_millis(50);
        if kind % 8 == 7 {
            is_requested = true;
            let velocity = [0, 1, 2].map(|index| f64::from(*bytes.get(index).unwrap_or(&0)));
            session.drive(
                &Setpoint {
                    velocity,
                    ..Setpoint::default()
                },
                now,
            );
        } else {
            session.receive(bytes, now);
            session.drive(&Setpoint::default(), now);
        }
        for event in session.events() {
            if let Event::Base(base) = event {
                assert!(
                    [base.pose, base.velocity]
                        .as_flattened()
                        .iter()
                        .all(|number| number.is_finite())
                );
            }
        }
        output.extend(session.output());
    }
    output.extend(session.stop());
    let mut receiver = Receiver::default();
    let mut stream = b"Player v.3".to_vec();
    stream.resize(32, 0);
    stream.extend(output);
    let checked = receiver.receive(&stream, |message| {
        let moves = message.kind == Kind::Command && message.body.iter().take(24).any(|byte| *byte != 0);
        assert!(!moves || is_requested, "{message:?}");
    });
    assert_eq!(checked, Ok(()));
}
