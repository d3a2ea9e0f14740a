//! Any bytes, and mutations of good ones, through the readers and the sessions.

use core::time::Duration;

use jde_device::Protocol;
use proptest::prelude::*;

use crate::checks;
use crate::ld::emulator::EmulatedLd;
use crate::ld::session::{LdConfig, LdSession};
use crate::rplidar::emulator::EmulatedRplidar;
use crate::rplidar::samples::Format;
use crate::rplidar::session::{RplidarConfig, RplidarSession};

/// Good bytes of each protocol.
fn streams() -> [Vec<u8>; 4] {
    let stream = |format| {
        let mut lidar = EmulatedRplidar {
            scanning: Some(format),
            ..EmulatedRplidar::a1(|_| 1500)
        };
        lidar.advance(0.1)
    };
    let ld = EmulatedLd::new(|_| 1500).turns(1.0);
    [
        ld,
        stream(Format::Nodes),
        stream(Format::Express),
        stream(Format::Dense),
    ]
}

/// Gives bytes to a session, a tenth of a second apart.
fn run<P: Protocol>(config: P::Config, pieces: &[Vec<u8>]) {
    let mut events = Vec::new();
    let mut session = P::start(config, Duration::ZERO, &mut events);
    for (tenth, piece) in (1..).zip(pieces) {
        session.receive(piece, Duration::from_millis(tenth * 100), &mut events);
    }
}

proptest! {
    #[test]
    fn no_bytes_break_a_reader_or_a_session(pieces in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..400), 0..8)) {
        let bytes = pieces.concat();
        checks::ld(&bytes);
        checks::rplidar(&bytes);
        run::<LdSession>(LdConfig { beams: 450, inverted: false }, &pieces);
        let config = RplidarConfig {
            beams: 360,
            inverted: false,
            baud: Some(115_200),
            serial_number: String::new(),
            standard: false,
        };
        run::<RplidarSession>(config, &pieces);
    }

    #[test]
    fn mutations_of_good_bytes_break_no_reader(
        stream in 0..4_usize,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..20),
    ) {
        let mut bytes = streams()[stream].clone();
        for (index, byte) in changes {
            let index = index.index(bytes.len());
            bytes[index] = byte;
        }
        checks::ld(&bytes);
        checks::rplidar(&bytes);
    }
}
