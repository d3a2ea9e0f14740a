//! Sessions with the emulator in virtual time.

use core::f64::consts::TAU;

use jde_device::emulate::Emulator;

use super::*;
use crate::emulator::EmulatedScanner;

/// A session and a scanner, connected by a wire.
struct Wire {
    session: Session,
    scanner: EmulatedScanner,
    now: Duration,
    baud: Option<u32>,
    /// A speed that the line lacks.
    lacks: Option<u32>,
    events: Vec<Event>,
}

impl Wire {
    fn new(scanner: EmulatedScanner, baud: Option<u32>, letters: Letters) -> Self {
        let config = ScannerConfig {
            view: TAU,
            skip: 0,
            letters,
            baud,
        };
        let mut events = Vec::new();
        let session = Session::start(config, Duration::ZERO, &mut events);
        let mut wire = Self {
            session,
            scanner,
            now: Duration::ZERO,
            baud,
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
                Event::Baud(baud) => self.baud = Some(*baud),
                Event::Send(bytes) => {
                    let reply = self
                        .scanner
                        .receive(bytes, self.baud.unwrap_or(self.scanner.baud));
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
    fn settle(mut self) -> Self {
        while !self.session.is_ready() && self.lost().is_none() {
            self.now += Duration::from_millis(100);
            let turn = self.scanner.poll_output();
            let same_baud = self.baud.is_none_or(|baud| baud == self.scanner.baud);
            let garbled = if same_baud {
                turn
            } else {
                turn.iter().map(|byte| byte ^ 0x95).collect()
            };
            self.receive(&garbled);
        }
        self
    }

    fn turn(&mut self) {
        let turn = self.scanner.poll_output();
        self.receive(&turn);
    }

    fn lost(&self) -> Option<&str> {
        self.events.iter().find_map(|event| match event {
            Event::Disconnect(reason) => Some(&**reason),
            Event::Send(_) | Event::Baud(_) | Event::Ready(_) | Event::Data(_) | Event::Warn(_) => None,
        })
    }

    fn count(&self, matches: fn(&Event) -> bool) -> usize {
        self.events.iter().filter(|event| matches(event)).count()
    }

    fn scans(&self) -> usize {
        self.count(|event| matches!(event, Event::Data(ScannerData::Scan(_))))
    }
}

fn ready(scanner: EmulatedScanner, baud: Option<u32>, letters: Letters) -> Wire {
    let wire = Wire::new(scanner, baud, letters).settle();
    assert_eq!(wire.lost(), None);
    wire
}

fn refused(scanner: EmulatedScanner, baud: Option<u32>) -> String {
    let wire = Wire::new(scanner, baud, Letters::Three).settle();
    wire.lost().expect("the session is lost").to_owned()
}

#[test]
fn a_scanner_reports_its_name_and_sends_scans() {
    let mut wire = ready(EmulatedScanner::urg(), Some(19_200), Letters::Three);
    let name = wire.events.iter().find_map(|event| match event {
        Event::Ready(name) => Some(name.clone()),
        Event::Send(_) | Event::Baud(_) | Event::Data(_) | Event::Warn(_) | Event::Disconnect(_) => None,
    });
    let expected = "URG-04LX(Hokuyo Automatic Co., Ltd.), 3.4.03, H0906091, Sensor works well.";
    assert_eq!(name.as_deref(), Some(expected));
    let beams = wire.events.iter().find_map(|event| match event {
        Event::Data(ScannerData::Beams(beams)) => Some(beams.count()),
        _ => None,
    });
    assert_eq!(beams, Some(682));
    wire.turn();
    let Some(Event::Data(ScannerData::Scan(scan))) = wire.events.last() else {
        panic!("a scan is expected")
    };
    assert_eq!(scan.ranges, [1.5; 682]);
}

#[test]
fn a_scanner_is_found_at_any_speed_and_switched_to_that_of_its_address() {
    for baud in SPEEDS {
        for (scip1, streaming) in [
            (true, None),
            (false, None),
            (false, Some("MD0044072501000".to_owned())),
        ] {
            let scanner = EmulatedScanner {
                baud,
                scip1,
                streaming,
                ..EmulatedScanner::urg()
            };
            let wire = ready(scanner, Some(115_200), Letters::Three);
            assert_eq!((wire.scanner.baud, wire.baud), (115_200, Some(115_200)));
        }
    }
}

#[test]
fn a_speed_that_the_line_lacks_is_skipped() {
    let scanner = EmulatedScanner {
        baud: 500_000,
        ..EmulatedScanner::urg()
    };
    let mut wire = Wire::new(scanner, Some(115_200), Letters::Three);
    wire.lacks = Some(750_000);
    let wire = wire.settle();
    assert!(wire.session.is_ready(), "{:?}", wire.lost());
}

#[test]
fn a_laser_that_is_already_on_is_accepted() {
    let scanner = EmulatedScanner {
        refuses: Some(("QT", "00")),
        laser: true,
        ..EmulatedScanner::utm()
    };
    assert!(ready(scanner, None, Letters::Three).scanner.streaming.is_some());
}

#[test]
fn scans_in_two_letters_are_decoded() {
    let mut wire = ready(
        EmulatedScanner {
            distance: 4000,
            ..EmulatedScanner::urg()
        },
        Some(19_200),
        Letters::Two,
    );
    wire.turn();
    let Some(Event::Data(ScannerData::Scan(scan))) = wire.events.last() else {
        panic!("a scan is expected")
    };
    assert_eq!(scan.ranges, [4.0; 682]);
}

#[test]
fn scans_are_found_between_noise_after_any_split() {
    let mut wire = ready(
        EmulatedScanner {
            noisy: true,
            ..EmulatedScanner::utm()
        },
        None,
        Letters::Three,
    );
    for size in 1..20 {
        let turn = wire.scanner.poll_output();
        turn.chunks(size).for_each(|piece| wire.receive(piece));
    }
    assert_eq!((wire.scans(), wire.lost()), (19, None));
}

#[test]
fn a_scan_with_a_wrong_byte_is_skipped_with_one_warning() {
    let mut wire = ready(EmulatedScanner::utm(), None, Letters::Three);
    for _ in 0..3 {
        let mut turn = wire.scanner.poll_output();
        turn[200] ^= 1;
        wire.receive(&turn);
    }
    wire.turn();
    assert_eq!(wire.count(|event| matches!(event, Event::Warn(_))), 1);
    assert_eq!((wire.scans(), wire.lost()), (1, None));
}

#[test]
fn a_refused_step_is_named_in_the_reason() {
    let silent = EmulatedScanner {
        silent: true,
        ..EmulatedScanner::utm()
    };
    assert_eq!(
        refused(silent.clone(), None),
        "it would not answer as a SCIP 2 scanner: no answer"
    );
    assert!(refused(silent, Some(19_200)).contains("at any speed"));
    let refuses = |request, status| EmulatedScanner {
        refuses: Some((request, status)),
        scip1: false,
        ..EmulatedScanner::urg()
    };
    assert_eq!(
        refused(refuses("BM", "01"), Some(19_200)),
        "it would not switch its laser on: status 01"
    );
    assert_eq!(
        refused(refuses("MD", "04"), Some(19_200)),
        "it would not send scans: status 04"
    );
    assert!(
        refused(refuses("SS", "03"), Some(38_400)).starts_with("it would not go at the speed of its address")
    );
    assert!(refused(refuses("PP", "00"), Some(19_200)).ends_with("it does not report its DMIN"));
}

#[test]
fn silence_and_a_fault_of_the_scanner_end_the_session() {
    let mut wire = ready(EmulatedScanner::utm(), None, Letters::Three);
    wire.now += SILENCE - Duration::from_nanos(1);
    wire.receive(&[]);
    assert_eq!(wire.lost(), None);
    wire.now += Duration::from_nanos(1);
    wire.receive(&[]);
    assert_eq!(wire.lost(), Some("no scan came for 3 s"));

    let mut wire = ready(EmulatedScanner::utm(), None, Letters::Three);
    wire.scanner.status = "98";
    wire.turn();
    assert_eq!(wire.lost(), None, "scans continue after a pause");
    wire.scanner.status = "51";
    wire.turn();
    assert!(
        wire.lost()
            .is_some_and(|reason| reason.starts_with("it stopped with status 51"))
    );
}
