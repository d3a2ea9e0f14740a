//! Sessions with the emulator in virtual time.

use super::*;
use crate::ld::emulator::{EmulatedLd, Fault};

const CONFIG: LdConfig = LdConfig {
    beams: 450,
    inverted: false,
};

/// A session and a lidar, connected by a wire.
struct Wire {
    session: LdSession,
    lidar: EmulatedLd,
    now: Duration,
    events: Vec<Event<Scan>>,
}

/// 2 m ahead, 4 m to the right, 3 m behind and 1 m to the left.
fn room(angle: f64) -> u16 {
    [2000, 4000, 3000, 1000][((angle + 45.0) / 90.0) as usize % 4]
}

impl Wire {
    fn new(lidar: EmulatedLd) -> Self {
        let mut events = Vec::new();
        Self {
            session: LdSession::start(CONFIG, Duration::ZERO, &mut events),
            lidar,
            now: Duration::ZERO,
            events,
        }
    }

    fn with(fault: Fault) -> Self {
        Self::new(EmulatedLd {
            fault,
            ..EmulatedLd::new(room)
        })
    }

    /// Lets time pass, in steps of a frame.
    fn run(&mut self, seconds: f64) {
        let end = self.now + Duration::from_secs_f64(seconds);
        while self.now < end && self.lost().is_none() {
            self.now += Duration::from_secs_f64(12.0 / 4500.0);
            let bytes = self.lidar.next_output();
            self.session.receive(&bytes, self.now, &mut self.events);
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
        let is_warning = |event: &&Event<Scan>| matches!(event, Event::Warn(_));
        self.events.iter().filter(is_warning).count()
    }
}

/// Why a lidar with a fault is lost, before it was ready and after.
fn reasons(fault: Fault) -> [String; 2] {
    let mut first = Wire::with(fault);
    first.run(6.0);
    assert_eq!(first.scans(), [] as [&Scan; 0]);
    let mut later = Wire::with(Fault::None);
    later.run(1.0);
    let scans = later.scans().len();
    later.lidar.fault = fault;
    later.run(2.0);
    assert!(later.scans().len() <= scans + 1, "a turn may have been complete");
    [first, later].map(|wire| wire.lost().expect("the lidar is lost").to_owned())
}

#[test]
fn a_room_is_seen_where_it_is_ten_times_a_second() {
    let mut wire = Wire::with(Fault::None);
    wire.run(2.0);
    let scans = wire.scans();
    assert!((13..=15).contains(&scans.len()), "{} scans", scans.len());
    assert!(matches!(wire.events[0], Event::Ready(_)));
    for Scan { turn, .. } in scans {
        // Beams of 0.8 degrees, counter-clockwise from behind.
        let beams = [225, 112, 0, 337].map(|beam| turn.ranges[beam]);
        assert_eq!(beams, [2.0, 4.0, 3.0, 1.0], "ahead, right, behind, left");
        assert!(turn.ranges.iter().all(|range| !range.is_nan()));
        assert!(
            turn.intensities
                .iter()
                .all(|intensity| (100.0..112.0).contains(intensity))
        );
        assert!((turn.duration - 0.1).abs() < 0.003, "{} s", turn.duration);
    }
}

#[test]
fn time_goes_on_when_the_clock_of_the_lidar_wraps() {
    let mut wire = Wire::with(Fault::None);
    wire.run(40.0);
    let ends: Vec<f64> = wire.scans().iter().map(|scan| scan.turn.end).collect();
    assert!(ends.len() > 390);
    assert!(
        ends.windows(2)
            .all(|pair| (pair[1] - pair[0] - 0.1).abs() < 0.005)
    );
}

#[test]
fn a_turn_that_is_read_late_is_as_old_as_it_is() {
    let mut wire = Wire::with(Fault::None);
    wire.run(1.0);
    wire.events.clear();
    let bytes = wire.lidar.turns(3.0);
    wire.session.receive(&bytes, wire.now, &mut wire.events);
    let ages: Vec<f64> = wire.scans().iter().map(|scan| scan.age.as_secs_f64()).collect();
    assert_eq!(ages.len(), 3);
    assert!(
        ages.windows(2)
            .all(|pair| (pair[0] - pair[1] - 0.1).abs() < 0.005),
        "{ages:?}"
    );
}

#[test]
fn no_measurement_and_what_is_too_near_or_too_far_are_told_apart() {
    let distance = |angle: f64| [0, 19, 20, 12_000, 12_001, 0][(angle / 60.0) as usize % 6];
    let mut wire = Wire::new(EmulatedLd::new(distance));
    wire.run(1.0);
    let at = |clockwise: usize| wire.scans()[0].turn.ranges[(540 - clockwise) % 360 * 450 / 360];
    assert!(at(30).is_nan() && at(330).is_nan());
    assert_eq!((at(90), at(150)), (f32::NEG_INFINITY, 0.02));
    assert_eq!((at(210), at(270)), (12.0, f32::INFINITY));
}

#[test]
fn noise_between_frames_and_single_wrong_or_missing_frames_cost_beams_and_no_turns() {
    for (fault, warnings) in [
        (Fault::Noisy, 1),
        (
            Fault::Corrupt {
                below: 1,
                divisor: 10,
            },
            1,
        ),
        (Fault::Missing(10), 0),
    ] {
        let mut wire = Wire::with(fault);
        wire.run(2.0);
        assert!(wire.scans().len() >= 13 && wire.lost().is_none(), "{fault:?}");
        assert_eq!(wire.warnings(), warnings, "{fault:?}");
        let empty = wire.scans()[0]
            .turn
            .ranges
            .iter()
            .filter(|range| range.is_nan())
            .count();
        assert_eq!(empty > 0, fault != Fault::Noisy, "{fault:?}");
    }
}

#[test]
fn a_lidar_without_turns_is_lost_with_the_reason() {
    for (fault, reason) in [
        (Fault::Silent, "nothing comes"),
        (Fault::OtherBaud, "no frames of an LD06"),
        (Fault::Corrupt { below: 3, divisor: 4 }, "wrong checksums"),
        (Fault::ClockStands, "contradict each other"),
        (Fault::Repeats, "contradict each other"),
    ] {
        for found in reasons(fault) {
            assert!(found.contains(reason), "{fault:?}: {found}");
        }
    }
}

#[test]
fn a_wrong_speed_gives_no_turns_and_says_so() {
    for (hertz, words) in [
        (2.0, "it turns 2.0 times"),
        (20.0, "it turns 20.0 times"),
        (0.0, "it turns 0.0 times"),
    ] {
        let mut wire = Wire::with(Fault::None);
        wire.run(1.0);
        wire.events.clear();
        wire.lidar.hertz = hertz;
        wire.run(2.0);
        assert_eq!(wire.scans().len(), 0);
        assert!(
            wire.lost().is_some_and(|reason| reason.contains(words)),
            "{:?}",
            wire.lost()
        );
    }
}

#[test]
fn the_motor_may_take_its_time_at_the_start() {
    let mut wire = Wire::new(EmulatedLd {
        hertz: 1.0,
        ..EmulatedLd::new(room)
    });
    wire.run(4.0);
    wire.lidar.hertz = 10.0;
    wire.run(1.0);
    assert!(wire.lost().is_none() && wire.scans().len() >= 8);
}

#[test]
fn what_waited_during_a_pause_of_the_driver_is_discarded() {
    let mut wire = Wire::with(Fault::None);
    wire.run(1.0);
    wire.events.clear();
    let bytes = wire.lidar.turns(20.0);
    wire.now += Duration::from_secs(2);
    wire.session.receive(&bytes, wire.now, &mut wire.events);
    assert_eq!(wire.events, []);
    wire.run(1.0);
    assert!(wire.lost().is_none() && wire.scans().len() >= 3);
}

/// When the lidar's clock was 0 by the ages of scans that have arrived now, s.
fn origins(wire: &Wire) -> Vec<f64> {
    let origin = |scan: &&Scan| wire.now.as_secs_f64() - scan.age.as_secs_f64() - scan.turn.end;
    wire.scans().iter().map(origin).collect()
}

#[test]
fn what_waited_longer_than_one_reading_takes_is_discarded_too() {
    let mut wire = Wire::with(Fault::None);
    wire.run(1.0);
    wire.events.clear();
    let waited = wire.lidar.turns(200.0);
    wire.now += Duration::from_secs(20);
    for bytes in waited.chunks(64 << 10) {
        wire.session.receive(bytes, wire.now, &mut wire.events);
        wire.now += Duration::from_millis(10);
    }
    assert_eq!(wire.events, []);
    wire.run(1.0);
    assert!(wire.lost().is_none() && wire.scans().len() >= 3);
}

#[test]
fn what_a_network_held_back_is_as_old_as_it_is() {
    let mut wire = Wire::with(Fault::None);
    wire.run(1.0);
    wire.events.clear();
    while wire.scans().is_empty() {
        wire.run(0.001);
    }
    let expected = origins(&wire)[0];
    let held = wire.lidar.turns(9.0);
    for _ in 0..90 {
        wire.now += Duration::from_millis(10);
        wire.session.receive(&[], wire.now, &mut wire.events);
    }
    let mut count = 0;
    for bytes in held.chunks(held.len() / 5 + 1) {
        wire.events.clear();
        wire.session.receive(bytes, wire.now, &mut wire.events);
        for origin in origins(&wire) {
            assert!((origin - expected).abs() < 0.02, "{origin} s, not {expected} s");
            count += 1;
        }
        wire.now += Duration::from_millis(1);
    }
    assert!(count >= 8 && wire.lost().is_none());
}
