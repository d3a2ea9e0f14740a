//! Sessions with the emulator in virtual time.

use jde_device::emulate::Emulator;

use super::*;
use crate::emulator::EmulatedScanner;

/// A session and a scanner, connected by a wire.
struct Wire {
    session: Session,
    scanner: EmulatedScanner,
    now: Duration,
    baud: u32,
    /// A speed that the line lacks.
    lacks: Option<u32>,
    events: Vec<Event>,
}

impl Wire {
    fn new(scanner: EmulatedScanner, first: u32, working: u32, (beams, reach): (u32, u32)) -> Self {
        let config = ScannerConfig {
            beams: Beams::with_count(beams).expect("the scanner supports it"),
            reach: Reach::metres(reach).expect("the scanner supports it"),
            speed: SerialSpeed::Serial { first, working },
        };
        let mut events = Vec::new();
        let session = Session::start(config, Duration::ZERO, &mut events);
        let mut wire = Self {
            session,
            scanner,
            now: Duration::ZERO,
            baud: first,
            lacks: None,
            events: Vec::new(),
        };
        wire.exchange(events);
        wire
    }

    /// Exchanges messages until neither side sends any more.
    fn exchange(&mut self, mut events: Vec<Event>) {
        let mut at = 0;
        while let Some(event) = events.get(at).cloned() {
            at += 1;
            match &event {
                Event::Baud(baud) if self.lacks == Some(*baud) => {
                    events.truncate(at);
                    self.session.refuse_baud(self.now, &mut events);
                }
                Event::Baud(baud) => self.baud = *baud,
                Event::Send(bytes) => {
                    let reply = self.scanner.receive(bytes, self.baud);
                    self.session.receive(&reply, self.now, &mut events);
                }
                Event::Ready(_) | Event::Data(_) | Event::Warn(_) | Event::Disconnect(_) => {}
            }
        }
        self.events.extend(events);
    }

    fn receive(&mut self, bytes: &[u8]) {
        let mut events = Vec::new();
        self.session.receive(bytes, self.now, &mut events);
        self.exchange(events);
    }

    /// Advances time in steps of 100 ms until the session is ready or lost.
    fn settle(&mut self) {
        while !self.session.is_ready() && self.lost().is_none() {
            self.now += Duration::from_millis(100);
            let turn = self.scanner.poll_output();
            let garbled = if self.baud == self.scanner.baud {
                turn
            } else {
                turn.iter().map(|byte| byte ^ 0x95).collect()
            };
            self.receive(&garbled);
        }
    }

    fn lost(&self) -> Option<&str> {
        self.events.iter().find_map(|event| match event {
            Event::Disconnect(reason) => Some(&**reason),
            Event::Send(_) | Event::Baud(_) | Event::Ready(_) | Event::Data(_) | Event::Warn(_) => None,
        })
    }

    fn scans(&mut self) -> Vec<Scan> {
        let events = std::mem::take(&mut self.events);
        let scan = |event| match event {
            Event::Data(scan) => Some(scan),
            Event::Send(_) | Event::Baud(_) | Event::Ready(_) | Event::Warn(_) | Event::Disconnect(_) => None,
        };
        events.into_iter().filter_map(scan).collect()
    }
}

fn ready(scanner: EmulatedScanner, first: u32, working: u32, config: (u32, u32)) -> Wire {
    let mut wire = Wire::new(scanner, first, working, config);
    wire.settle();
    assert_eq!(wire.lost(), None);
    wire
}

fn refused(scanner: EmulatedScanner) -> String {
    let mut wire = Wire::new(scanner, 9600, 38_400, (181, 8));
    wire.settle();
    wire.lost().expect("the session is lost").to_owned()
}

#[test]
fn a_scanner_from_the_factory_is_configured_and_sends_scans() {
    let mut wire = ready(EmulatedScanner::new(), 9600, 38_400, (361, 8));
    assert_eq!((wire.baud, wire.scanner.baud), (38_400, 38_400));
    assert_eq!(
        (wire.scanner.view, wire.scanner.step, wire.scanner.block[6]),
        (180, 50, 1)
    );
    assert_eq!(wire.scanner.block[2], 70, "the other settings are unchanged");
    assert!(
        wire.events
            .contains(&Event::Ready("LMS200;30106;V02.10, 38400 baud".to_owned()))
    );
    let turn = wire.scanner.poll_output();
    wire.receive(&turn);
    let scans = wire.scans();
    assert_eq!(scans.len(), 1);
    assert_eq!(scans[0].ranges, [1.5; 361]);
    // 732 bytes of 10 bits at 38400 baud.
    assert_eq!(scans[0].transfer.as_millis(), 190);
}

#[test]
fn a_scanner_is_found_at_any_speed_even_while_it_sends_scans() {
    for first in SPEEDS {
        for baud in SPEEDS {
            for streaming in [false, true] {
                let scanner = EmulatedScanner {
                    baud,
                    streaming,
                    ..EmulatedScanner::new()
                };
                let wire = ready(scanner, first, 19_200, (181, 8));
                assert_eq!(wire.scanner.baud, 19_200);
            }
        }
    }
}

#[test]
fn a_speed_that_the_line_lacks_is_skipped() {
    let scanner = EmulatedScanner {
        baud: 19_200,
        ..EmulatedScanner::new()
    };
    let mut wire = Wire::new(scanner, 9600, 9600, (181, 8));
    wire.lacks = Some(38_400);
    wire.settle();
    assert!(wire.session.is_ready(), "{:?}", wire.lost());
}

#[test]
fn the_memory_of_the_scanner_is_written_only_for_a_change() {
    let wire = ready(EmulatedScanner::new(), 9600, 9600, (181, 16));
    assert_eq!(
        (wire.scanner.writes, wire.scanner.block[5], wire.scanner.block[6]),
        (1, 4, 1)
    );
    let wire = ready(wire.scanner, 9600, 9600, (181, 16));
    assert_eq!(wire.scanner.writes, 1);
    let wire = ready(wire.scanner, 9600, 9600, (181, 80));
    assert_eq!(
        (wire.scanner.writes, wire.scanner.block[5], wire.scanner.block[6]),
        (2, 0, 0)
    );
}

#[test]
fn a_telegram_that_noise_destroyed_is_sent_again() {
    let wire = ready(
        EmulatedScanner {
            nacks: 2,
            baud: 9600,
            ..EmulatedScanner::new()
        },
        9600,
        9600,
        (101, 8),
    );
    assert_eq!(wire.scanner.view, 100);
}

#[test]
fn scans_are_found_between_noise() {
    let mut wire = ready(
        EmulatedScanner {
            noisy: true,
            ..EmulatedScanner::new()
        },
        9600,
        9600,
        (401, 8),
    );
    for _ in 0..20 {
        let turn = wire.scanner.poll_output();
        for piece in turn.chunks(13) {
            wire.receive(piece);
        }
    }
    assert_eq!(wire.scans().len(), 20);
}

#[test]
fn a_refused_step_is_named_in_the_reason() {
    assert!(
        refused(EmulatedScanner {
            silent: true,
            ..EmulatedScanner::new()
        })
        .contains("no scanner answers at any speed")
    );
    assert!(
        refused(EmulatedScanner {
            refuses: Some(0x3b),
            ..EmulatedScanner::new()
        })
        .starts_with("it would not measure as many")
    );
    assert!(
        refused(EmulatedScanner {
            refuses: Some(0x77),
            ..EmulatedScanner::new()
        })
        .starts_with("it would not take another")
    );
    let speed = refused(EmulatedScanner {
        refuses: Some(0x20),
        ..EmulatedScanner::new()
    });
    assert!(
        speed.starts_with("it would not go at the speed `baud`") && speed.ends_with("it has a fault"),
        "{speed}"
    );
}

#[test]
fn silence_a_restart_and_a_fault_of_the_scanner_end_the_session() {
    let mut wire = ready(EmulatedScanner::new(), 9600, 9600, (181, 8));
    wire.now += SILENCE - Duration::from_nanos(1);
    wire.receive(&[]);
    assert_eq!(wire.lost(), None);
    wire.now += Duration::from_nanos(1);
    wire.receive(&[]);
    assert_eq!(wire.lost(), Some("no scan came for 3 s"));

    let mut wire = ready(EmulatedScanner::new(), 9600, 9600, (181, 8));
    let bytes = wire.scanner.restart();
    wire.receive(&bytes);
    assert!(
        wire.lost()
            .is_some_and(|reason| reason.contains("switched off and on"))
    );

    let mut wire = ready(EmulatedScanner::new(), 9600, 9600, (181, 8));
    wire.scanner.status = 0x13;
    let turn = wire.scanner.poll_output();
    wire.receive(&turn);
    assert!(wire.lost().is_some_and(|reason| reason.contains("status 0x13")));
    assert_eq!(wire.scans(), [], "measurements of a faulty scanner are discarded");
}

#[test]
fn a_dirty_window_causes_one_warning_and_scans_continue() {
    let mut wire = ready(
        EmulatedScanner {
            status: 0x90,
            ..EmulatedScanner::new()
        },
        9600,
        9600,
        (181, 8),
    );
    for _ in 0..3 {
        let turn = wire.scanner.poll_output();
        wire.receive(&turn);
    }
    let warnings = wire
        .events
        .iter()
        .filter(|event| matches!(event, Event::Warn(_)))
        .count();
    assert_eq!((warnings, wire.scans().len()), (1, 3));
}
