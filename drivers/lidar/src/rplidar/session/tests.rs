//! Sessions with the emulator in virtual time.

use jde_device::emulate::Emulator;

use super::*;
use crate::rplidar::emulator::{EmulatedRplidar, Fault};
use crate::rplidar::samples::Format;

/// A session and a lidar, connected by a wire.
struct Wire {
    session: RplidarSession,
    lidar: EmulatedRplidar,
    now: Duration,
    baud: u32,
    /// A speed that the line lacks.
    lacks: u32,
    events: Vec<Event>,
}

/// 2 m ahead, 4 m to the right, 3 m behind and 1 m to the left.
fn room(angle: f64) -> u16 {
    [2000, 4000, 3000, 1000][((angle + 45.0) / 90.0) as usize % 4]
}

fn config(baud: Option<u32>) -> RplidarConfig {
    RplidarConfig {
        beams: 360,
        inverted: false,
        baud,
        serial_number: String::new(),
        standard: false,
    }
}

impl Wire {
    fn new(lidar: EmulatedRplidar, config: RplidarConfig) -> Self {
        let mut events = Vec::new();
        let baud = config.baud.unwrap_or(lidar.baud);
        let session = RplidarSession::start(config, Duration::ZERO, &mut events);
        let mut wire = Self {
            session,
            lidar,
            now: Duration::ZERO,
            baud,
            lacks: 0,
            events: Vec::new(),
        };
        wire.exchange(events);
        wire
    }

    fn exchange(&mut self, mut events: Vec<Event>) {
        let mut at = 0;
        while let Some(event) = events.get(at).cloned() {
            at += 1;
            match event {
                Event::Baud(baud) if baud == self.lacks => {
                    events.truncate(at);
                    self.session.refuse_baud(self.now, &mut events);
                }
                Event::Baud(baud) => self.baud = baud,
                Event::Send(bytes) => {
                    let reply = self.lidar.receive(&bytes, self.baud);
                    self.session.receive(&reply, self.now, &mut events);
                }
                _ => {}
            }
        }
        self.events.extend(events);
    }

    /// Lets time pass, in steps of 5 ms.
    fn run(&mut self, seconds: f64) {
        let end = self.now + Duration::from_secs_f64(seconds);
        while self.now < end && self.lost().is_none() {
            self.now += Duration::from_millis(5);
            let mut bytes = self.lidar.advance(0.005);
            if self.baud != self.lidar.baud {
                bytes
                    .iter_mut()
                    .for_each(|byte| *byte = byte.rotate_left(3) ^ 0x95);
            }
            let mut events = Vec::new();
            self.session.receive(&bytes, self.now, &mut events);
            self.exchange(events);
        }
    }

    fn scans(&self) -> Vec<&Scan> {
        let scans = self.events.iter().filter_map(|event| match event {
            Event::Data(scan) => Some(scan),
            _ => None,
        });
        scans.collect()
    }

    fn lost(&self) -> Option<&str> {
        self.events.iter().find_map(|event| match event {
            Event::Disconnect(reason) => Some(&**reason),
            _ => None,
        })
    }

    fn warnings(&self) -> usize {
        let is_warning = |event: &&Event| matches!(event, Event::Warn(_));
        self.events.iter().filter(is_warning).count()
    }
}

fn ready(lidar: EmulatedRplidar, config: RplidarConfig) -> Wire {
    let mut wire = Wire::new(lidar, config);
    wire.run(12.0);
    assert_eq!(wire.lost(), None);
    assert!(wire.session.is_ready());
    wire
}

fn refused(lidar: EmulatedRplidar, config: RplidarConfig) -> String {
    let mut wire = Wire::new(lidar, config);
    wire.run(30.0);
    wire.lost().expect("the session is lost").to_owned()
}

#[test]
fn every_format_shows_a_room_where_it_is() {
    let standard = RplidarConfig {
        standard: true,
        ..config(Some(115_200))
    };
    let s2 = (EmulatedRplidar::s2(room), config(Some(1_000_000)), Format::Dense);
    let a1 = (EmulatedRplidar::a1(room), config(Some(115_200)), Format::Express);
    for (lidar, config, format) in [a1, s2, (EmulatedRplidar::a1(room), standard, Format::Nodes)] {
        let wire = ready(lidar, config);
        assert_eq!(wire.lidar.scanning, Some(format));
        for scan in wire.scans() {
            let Scan { turn, age, .. } = scan;
            assert_eq!(scan.has_intensities, format == Format::Nodes);
            assert!(!scan.has_intensities || turn.intensities == [47.0; 360]);
            let beams = [180, 90, 0, 270].map(|beam| turn.ranges[beam]);
            assert_eq!(
                beams,
                [2.0, 4.0, 3.0, 1.0],
                "ahead, right, behind, left: {format:?}"
            );
            assert!(turn.ranges.iter().all(|range| !range.is_nan()));
            assert!(
                (turn.duration - 0.1).abs() < 0.02 && age.as_secs_f64() < 0.03,
                "{turn:?} {age:?}"
            );
        }
        assert!(wire.scans().len() > 100);
    }
}

#[test]
fn a_lidar_says_what_it_is() {
    let wire = ready(EmulatedRplidar::a1(room), config(Some(115_200)));
    let name = wire.events.iter().find_map(|event| match event {
        Event::Ready(name) => Some(&**name),
        _ => None,
    });
    let expected = "RPLIDAR A1M8, firmware 1.29, serial number A0A0A0A0A0A0A0A0A0A0A0A0A0A0A0A0";
    assert_eq!(name, Some(expected));
}

#[test]
fn a_lidar_is_found_at_any_speed_also_while_it_scans() {
    for baud in SPEEDS {
        for scanning in [
            None,
            Some(Format::Nodes),
            Some(Format::Express),
            Some(Format::Dense),
        ] {
            let lidar = EmulatedRplidar {
                baud,
                scanning,
                ..EmulatedRplidar::a1(room)
            };
            let wire = ready(lidar, config(Some(115_200)));
            assert_eq!(wire.baud, baud);
        }
    }
}

#[test]
fn a_speed_that_the_line_lacks_is_skipped() {
    let s2 = || EmulatedRplidar::s2(room);
    for lacks in SPEEDS {
        let mut wire = Wire::new(s2(), config(Some(115_200)));
        wire.lacks = lacks;
        wire.run(20.0);
        if lacks == s2().baud {
            assert!(wire.lost().is_some_and(|reason| reason.contains("at any speed")));
        } else {
            assert!(wire.session.is_ready() && wire.baud == s2().baud, "{lacks}");
        }
    }
}

#[test]
fn the_mode_is_one_that_lidar_and_driver_know() {
    let modes = |kinds: &[u8], typical: u16, firmware: [u8; 2]| {
        let lidar = EmulatedRplidar {
            modes: (kinds.to_vec(), typical),
            firmware,
            ..EmulatedRplidar::a1(room)
        };
        ready(lidar, config(Some(115_200))).lidar.scanning
    };
    assert_eq!(
        modes(&[0x81, 0x82, 0x84], 2, [24, 1]),
        Some(Format::Express),
        "an A3"
    );
    assert_eq!(modes(&[0x81, 0x84], 1, [24, 1]), Some(Format::Nodes));
    assert_eq!(modes(&[0x81], 0, [24, 1]), Some(Format::Nodes));
    assert_eq!(modes(&[], 0, [17, 1]), Some(Format::Express), "it is not asked");
    assert_eq!(modes(&[], 0, [16, 1]), Some(Format::Nodes));
}

#[test]
fn a_lidar_that_does_not_answer_about_its_modes_scans_in_the_standard_one() {
    for ignored in [0x84, 0x82] {
        let lidar = EmulatedRplidar {
            ignores: vec![ignored],
            ..EmulatedRplidar::a1(room)
        };
        let wire = ready(lidar, config(Some(115_200)));
        assert_eq!(wire.lidar.scanning, Some(Format::Nodes));
    }
}

#[test]
fn the_motor_is_started_as_its_model_needs() {
    for (model, motor) in [
        (0x18, None),
        (0x28, Some((0xf0, 660_u16))),
        (0x41, None),
        (0x61, Some((0xa8, 600))),
    ] {
        let lidar = EmulatedRplidar {
            model,
            ..EmulatedRplidar::a1(room)
        };
        let wire = ready(lidar, config(Some(115_200)));
        let sent = wire
            .lidar
            .commands
            .iter()
            .find(|(command, _)| [0xf0, 0xa8].contains(command));
        let expected = motor.map(|(command, value)| (command, value.to_le_bytes().to_vec()));
        assert_eq!(sent.cloned(), expected, "model {model:#x}");
    }
}

#[test]
fn a_lidar_that_does_not_start_is_lost_with_the_reason() {
    let a1 = || EmulatedRplidar::a1(room);
    let at = config(Some(115_200));
    let silent = EmulatedRplidar {
        fault: Fault::Silent,
        ..a1()
    };
    assert!(refused(silent.clone(), at.clone()).contains("at any speed"));
    assert!(refused(silent, config(None)).contains("no answer: it would not say what it is"));
    let protected = EmulatedRplidar {
        health: (2, 0x8001),
        ..a1()
    };
    let reason = refused(protected, at.clone());
    assert_eq!(
        reason,
        "it stopped to protect itself (error 0x8001): free its head, unplug it and plug it in again"
    );
    let deaf = EmulatedRplidar {
        ignores: vec![0x20, 0x82],
        ..a1()
    };
    assert!(refused(deaf, at.clone()).contains("start to scan"));
    let other = RplidarConfig {
        serial_number: "B0".repeat(16),
        ..at
    };
    let reason = refused(a1(), other);
    assert!(
        reason.contains(&"A0".repeat(16)) && reason.contains("adapters swapped"),
        "{reason}"
    );
}

#[test]
fn what_a_lidar_is_counts_when_it_says_so_twice() {
    let misread = |misread| EmulatedRplidar {
        misread,
        ..EmulatedRplidar::a1(room)
    };
    let wanted = RplidarConfig {
        serial_number: "A0".repeat(16),
        ..config(Some(115_200))
    };
    ready(misread(1), wanted.clone());
    assert!(refused(misread(9), wanted).contains("says something else of what it is"));
}

#[test]
fn a_lidar_that_sends_only_formats_that_are_not_read_is_lost_with_the_reason() {
    let lidar = EmulatedRplidar {
        modes: (vec![0x83, 0x84], 0),
        ..EmulatedRplidar::a1(room)
    };
    assert_eq!(
        refused(lidar, config(Some(115_200))),
        "it answers in a format (0x83) that this driver does not read"
    );
}

#[test]
fn the_greatest_distance_is_one_that_the_format_can_send() {
    let limits = |lidar: EmulatedRplidar| ready(lidar, config(Some(115_200))).scans()[0].limits;
    let a3 = EmulatedRplidar {
        model: 0x31,
        ..EmulatedRplidar::a1(room)
    };
    assert_eq!(limits(a3), [0.15, 16.38]);
    assert_eq!(limits(EmulatedRplidar::a1(room)), [0.15, 12.0]);
    assert_eq!(limits(EmulatedRplidar::s2(room)), [0.05, 30.0]);
}

#[test]
fn the_last_bytes_stop_the_motor_and_then_the_scan() {
    let mut lidar = EmulatedRplidar {
        scanning: Some(Format::Nodes),
        ..EmulatedRplidar::a1(room)
    };
    lidar.receive(&RplidarSession::closing_bytes(), lidar.baud);
    let expected = [(0xf0, vec![0, 0]), (0xa8, vec![0, 0]), (0x25, Vec::new())];
    assert_eq!(lidar.commands, expected);
    assert_eq!(lidar.scanning, None);
}

#[test]
fn the_serial_number_is_compared_in_any_case() {
    let wanted = RplidarConfig {
        serial_number: "a0".repeat(16),
        ..config(Some(115_200))
    };
    ready(EmulatedRplidar::a1(room), wanted);
}

#[test]
fn a_warning_of_the_lidar_is_passed_on_and_it_scans() {
    let lidar = EmulatedRplidar {
        health: (1, 3),
        ..EmulatedRplidar::a1(room)
    };
    assert_eq!(ready(lidar, config(Some(115_200))).warnings(), 1);
}

#[test]
fn single_wrong_and_missing_bytes_cost_beams_and_no_turns() {
    for fault in [Fault::Corrupt(2000), Fault::Cut(2000)] {
        let lidar = EmulatedRplidar {
            fault,
            ..EmulatedRplidar::a1(room)
        };
        let wire = ready(lidar, config(Some(115_200)));
        assert!(wire.scans().len() > 100, "{} scans", wire.scans().len());
        assert_eq!(wire.warnings(), 1);
        let seen = wire.scans().into_iter().flat_map(|scan| &scan.turn.ranges);
        assert!(seen.clone().any(|range| range.is_nan()));
        assert!(
            seen.filter(|range| !range.is_nan())
                .all(|range| [1.0, 2.0, 3.0, 4.0].contains(range))
        );
    }
}

#[test]
fn a_lidar_whose_turns_end_is_lost_with_the_reason() {
    let lost_after = |change: fn(&mut EmulatedRplidar)| {
        let mut wire = ready(EmulatedRplidar::a1(room), config(Some(115_200)));
        wire.events.clear();
        change(&mut wire.lidar);
        wire.run(2.0);
        assert!(wire.scans().len() <= 1, "a turn may have been complete");
        wire.lost().expect("the lidar is lost").to_owned()
    };
    for (reason, words) in [
        (
            lost_after(|lidar| lidar.fault = Fault::Silent),
            "it sends no measurements",
        ),
        (
            lost_after(|lidar| lidar.fault = Fault::Corrupt(50)),
            "wrong checksums",
        ),
        (lost_after(|lidar| lidar.hertz = 0.0), "its head does not turn"),
        (lost_after(|lidar| lidar.hertz = 25.0), "which is no speed"),
    ] {
        assert!(reason.contains(words), "{words}: {reason}");
    }
}

#[test]
fn what_waited_during_a_pause_of_the_driver_is_discarded() {
    let mut wire = ready(EmulatedRplidar::a1(room), config(Some(115_200)));
    wire.events.clear();
    let bytes = wire.lidar.advance(2.0);
    wire.now += Duration::from_secs(2);
    wire.session.receive(&bytes, wire.now, &mut wire.events);
    assert_eq!(wire.events, []);
    wire.run(1.0);
    assert!(wire.lost().is_none() && wire.scans().len() >= 3);
}

#[test]
fn no_turn_with_a_pause_between_its_bytes_is_given_with_false_times() {
    for is_read in [false, true] {
        for pause in [45, 55, 90, 150, 350] {
            for phase in 0..10 {
                let mut wire = Wire::new(EmulatedRplidar::a1(room), config(Some(115_200)));
                wire.run(2.0 + f64::from(phase) * 0.01);
                wire.events.clear();
                // The driver pauses, or reads and nothing comes.
                let bytes = wire.lidar.advance(f64::from(pause) / 1000.0);
                for _ in 0..pause {
                    wire.now += Duration::from_millis(1);
                    if is_read {
                        wire.session.receive(&[], wire.now, &mut wire.events);
                    }
                }
                wire.session.receive(&bytes, wire.now, &mut wire.events);
                wire.run(1.0);
                assert!(wire.lost().is_none() && wire.scans().len() >= 5);
                for Scan { turn, age, .. } in wire.scans() {
                    assert!((turn.duration - 0.1).abs() < 0.03, "{} s", turn.duration);
                    assert!(age.as_secs_f64() < 0.05, "{age:?}");
                }
            }
        }
    }
}
