//! Properties that hold for any bytes: nothing panics, memory stays bounded, decoding after encoding returns
//! the same value, and no robot moves without a request.

use core::fmt::Debug;
use core::time::Duration;

use jde_p2os::*;

/// A stream gives the same packets however it is split. Every byte is in a packet, discarded or held.
pub(crate) fn receiver(data: &[u8]) {
    let receive = |chunk_size: usize| {
        let (mut receiver, mut packets) = (Receiver::new(), Vec::new());
        for chunk in data.chunks(chunk_size.max(1)) {
            receiver.receive(chunk, Duration::ZERO, |packet| packets.push(packet));
        }
        let in_packets: usize = packets.iter().map(|packet| packet.to_bytes().len()).sum();
        let accounted = in_packets as u64 + receiver.dropped().bytes;
        assert!(accounted <= data.len() as u64 && data.len() as u64 - accounted <= 203);
        (packets, receiver.dropped())
    };
    let whole = receive(data.len());
    assert_eq!(whole, receive(1));
    assert_eq!(whole, receive(7));
}

/// Any payload is a command, and its packet decodes to the same command.
pub(crate) fn command(data: &[u8]) {
    let Ok(packet) = Packet::new(data) else { return };
    let command = Command::from_packet(&packet);
    // Some arguments are encoded one byte longer than they were received, and may not fit into a packet.
    if let Ok(written) = command.to_packet() {
        assert_eq!(Command::from_packet(&written), command);
        assert_eq!(Command::from_packet(&written).moves(), command.moves());
    }
}

/// Any reply that can be decoded is the same after encoding and decoding.
pub(crate) fn answer(data: &[u8]) {
    let Ok(packet) = Packet::new(data) else { return };
    check_round_trip(&packet, Names::from_packet, Names::to_packet);
    check_round_trip(&packet, Sip::from_packet, Sip::to_packet);
    check_round_trip(&packet, Config::from_packet, Config::to_packet);
    check_round_trip(&packet, LaserPacket::from_packet, LaserPacket::to_packet);
    check_round_trip(&packet, SimState::from_packet, SimState::to_packet);
    check_round_trip(&packet, SerialAux::from_packet, SerialAux::to_packet);
    check_round_trip(
        &packet,
        Encoders::from_packet,
        |encoders| Ok(encoders.to_packet()),
    );
}

fn check_round_trip<T: PartialEq + Debug>(
    packet: &Packet,
    read: impl Fn(&Packet) -> Result<T, Error>,
    write: impl Fn(&T) -> Result<Packet, Error>,
) {
    // An old configuration, encoded with every field, may be too long for a packet.
    if let Ok(value) = read(packet)
        && let Ok(written) = write(&value)
    {
        assert_eq!(read(&written).as_ref(), Ok(&value));
    }
}

/// Any stream gives frames that are the same after encoding and decoding.
pub(crate) fn head(data: &[u8]) {
    let frames = |bytes: &[u8]| {
        let (mut parser, mut frames) = (HeadParser::default(), Vec::new());
        parser.receive(bytes, |frame| frames.push(frame));
        frames
    };
    for frame in frames(data) {
        let bytes = match &frame {
            HeadFrame::Command(command) => command.to_bytes(),
            HeadFrame::Reply(reply) => reply.to_bytes(),
        };
        assert_eq!(frames(&bytes), [frame]);
    }
}

/// Runs a session against a robot that follows the script of `data`. Whatever the robot sends, the session
/// moves it only on request and within its limits, and sends only valid packets.
pub(crate) fn session(data: &[u8]) {
    let [first, script @ ..] = data else { return };
    let options = Options {
        laser: if first & 1 == 0 {
            LaserMode::Off
        } else {
            LaserMode::On(Beams::spread(180, 3.0))
        },
        head: if first & 2 == 0 {
            HeadKind::None
        } else {
            HeadKind::VcC4
        },
        ..Options::default()
    };
    let mut session = Session::new(options);
    let mut now = Duration::ZERO;
    session.connected(now);
    let mut output = session.output();
    let mut rest = script;
    let mut motion_requested = false;
    while let [kind, length, tail @ ..] = rest {
        let (bytes, tail) = tail.split_at(tail.len().min((*length).into()));
        rest = tail;
        now += Duration::from_millis(u64::from(*length) * 2);
        match kind % 8 {
            0 => session.receive(bytes, now),
            1 | 2 => {
                if let Ok(packet) = Packet::new(bytes) {
                    session.receive(&packet.to_bytes(), now);
                }
            }
            3 => complete_handshake(&mut session, now),
            4 => {
                motion_requested = true;
                let number = |index: usize| f64::from(*bytes.get(index).unwrap_or(&0)) - 128.0;
                let setpoint = Setpoint {
                    linear: number(0),
                    angular: number(1),
                    ..Setpoint::default()
                };
                session.drive(&setpoint, now);
            }
            5 => session.connected(now),
            _ => session.drive(&Setpoint::default(), now),
        }
        output.extend(session.output());
        while session.next_event().is_some() {}
    }
    output.extend(session.close());
    assert!(session.output().is_empty());
    let pose = session.pose();
    assert!(pose.x.is_finite() && pose.y.is_finite() && pose.heading.is_finite());
    let mut receiver = Receiver::new();
    receiver.receive(&output, Duration::ZERO, |packet| {
        match Command::from_packet(&packet) {
            command if command.moves() && !motion_requested => {
                panic!("the robot moves without a request: {command:?}")
            }
            Command::Velocity(speed) => assert!(speed.abs() <= 2200),
            Command::RotVelocity(speed) => assert!(speed.abs() <= 500),
            _ => {}
        }
    });
    assert_eq!(receiver.dropped(), Dropped::default());
}

/// Sends the robot's side of a handshake, after which the robot can be driven.
fn complete_handshake(session: &mut Session, now: Duration) {
    let names = Names {
        name: "a".into(),
        class: "Pioneer".into(),
        subclass: "p3dx".into(),
    };
    let replies = [
        SyncStep::Zero.to_packet(),
        SyncStep::One.to_packet(),
        names.to_packet().expect("short names"),
        Sip::default().to_packet().expect("a SIP"),
        Config::default().to_packet().expect("short names"),
    ];
    for packet in replies {
        session.receive(&packet.to_bytes(), now);
    }
}
