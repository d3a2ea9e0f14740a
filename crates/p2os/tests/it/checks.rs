//! Properties for any bytes: nothing panics, nothing grows, decoding after encoding returns the same, and no
//! robot moves without a wish.

use core::fmt::Debug;
use core::time::Duration;

use jde_p2os::*;

/// A stream gives the same packets however it is split. Every byte is in a packet, discarded or held.
pub(crate) fn receiver(data: &[u8]) {
    let found = |cut: usize| {
        let (mut receiver, mut found) = (Receiver::new(), Vec::new());
        for part in data.chunks(cut.max(1)) {
            receiver.receive(part, Duration::ZERO, |packet| found.push(packet));
        }
        let taken: usize = found.iter().map(|packet| packet.to_bytes().len()).sum();
        let known = taken as u64 + receiver.dropped().bytes;
        assert!(known <= data.len() as u64 && data.len() as u64 - known <= 203);
        (found, receiver.dropped())
    };
    let whole = found(data.len());
    assert_eq!(whole, found(1));
    assert_eq!(whole, found(7));
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

/// Any answer that can be decoded is the same after encoding and decoding.
pub(crate) fn answer(data: &[u8]) {
    let Ok(packet) = Packet::new(data) else { return };
    again(&packet, Names::from_packet, Names::to_packet);
    again(&packet, Sip::from_packet, Sip::to_packet);
    again(&packet, Config::from_packet, Config::to_packet);
    again(&packet, LaserPacket::from_packet, LaserPacket::to_packet);
    again(&packet, SimState::from_packet, SimState::to_packet);
    again(&packet, SerialAux::from_packet, SerialAux::to_packet);
    again(
        &packet,
        Encoders::from_packet,
        |encoders| Ok(encoders.to_packet()),
    );
}

fn again<T: PartialEq + Debug>(
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
            HeadFrame::Reply(answer) => answer.to_bytes(),
        };
        assert_eq!(frames(&bytes), [frame]);
    }
}

/// Runs a session against a robot that follows the script of `data`. Whatever it sends, the session moves it
/// only on a wish and within its limits, and sends only packets.
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
    let mut wished = false;
    while let [what, length, tail @ ..] = rest {
        let (bytes, tail) = tail.split_at(tail.len().min((*length).into()));
        rest = tail;
        now += Duration::from_millis(u64::from(*length) * 2);
        match what % 8 {
            0 => session.receive(bytes, now),
            1 | 2 => {
                if let Ok(packet) = Packet::new(bytes) {
                    session.receive(&packet.to_bytes(), now);
                }
            }
            3 => hello(&mut session, now),
            4 => {
                wished = true;
                let number = |place: usize| f64::from(*bytes.get(place).unwrap_or(&0)) - 128.0;
                let wish = Setpoint {
                    linear: number(0),
                    angular: number(1),
                    ..Setpoint::default()
                };
                session.drive(&wish, now);
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
            command if command.moves() && !wished => panic!("it moves by itself: {command:?}"),
            Command::Velocity(speed) => assert!(speed.abs() <= 2200),
            Command::RotVelocity(speed) => assert!(speed.abs() <= 500),
            _ => {}
        }
    });
    assert_eq!(receiver.dropped(), Dropped::default());
}

/// The robot's side of a handshake, until it can be driven.
fn hello(session: &mut Session, now: Duration) {
    let names = Names {
        name: "a".into(),
        class: "Pioneer".into(),
        subclass: "p3dx".into(),
    };
    let says = [
        SyncStep::Zero.to_packet(),
        SyncStep::One.to_packet(),
        names.to_packet().expect("short names"),
        Sip::default().to_packet().expect("a SIP"),
        Config::default().to_packet().expect("short names"),
    ];
    for packet in says {
        session.receive(&packet.to_bytes(), now);
    }
}
