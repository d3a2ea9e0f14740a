//! Sessions with the emulator in virtual time.

use super::*;
use crate::emulator::{EmulatedWit, Fault};

/// A session and a unit, connected by a wire.
struct Wire {
    session: WitSession,
    unit: EmulatedWit,
    now: Duration,
    events: Vec<Event<Reading>>,
}

impl Wire {
    fn new(unit: EmulatedWit) -> Self {
        let mut events = Vec::new();
        Self {
            session: WitSession::start(WitConfig { rate: 100.0 }, Duration::ZERO, &mut events),
            unit,
            now: Duration::ZERO,
            events,
        }
    }

    fn with(fault: Fault) -> Self {
        Self::new(EmulatedWit {
            fault,
            ..EmulatedWit::new()
        })
    }

    /// Lets time pass, in steps of a set.
    fn run(&mut self, seconds: f64) {
        let end = self.now + Duration::from_secs_f64(seconds);
        while self.now < end && self.lost().is_none() {
            self.now += Duration::from_secs_f64(1.0 / self.unit.hertz);
            let bytes = self.unit.next_output();
            self.session.receive(&bytes, self.now, &mut self.events);
        }
    }

    fn readings(&self) -> Vec<&Reading> {
        let readings = self.events.iter().filter_map(|event| match event {
            Event::Data(reading) => Some(reading),
            _ => None,
        });
        readings.collect()
    }

    fn lost(&self) -> Option<&str> {
        self.events.iter().find_map(|event| match event {
            Event::Disconnect(reason) => Some(&**reason),
            _ => None,
        })
    }

    fn warnings(&self) -> Vec<&str> {
        let warnings = self.events.iter().filter_map(|event| match event {
            Event::Warn(words) => Some(&**words),
            _ => None,
        });
        warnings.collect()
    }
}

#[test]
fn the_motion_is_read_as_it_is_by_angles_and_by_a_quaternion() {
    for has_quaternion in [false, true] {
        let mut wire = Wire::new(EmulatedWit {
            rates: [10.0, -20.0, 90.0],
            angles: [10.0, -20.0, 150.0],
            has_quaternion,
            ..EmulatedWit::new()
        });
        wire.run(2.0);
        assert!(wire.readings().len() > 140, "{}", wire.readings().len());
        assert!(matches!(wire.events[0], Event::Ready(_)));
        for reading in wire.readings() {
            let degrees = reading.rates.map(f64::to_degrees);
            assert!(
                (degrees[0] - 10.0).abs() < 0.1 && (degrees[2] - 90.0).abs() < 0.1,
                "{degrees:?}"
            );
            let up = reading.acceleration.expect("an acceleration")[2];
            assert!((up - GRAVITY).abs() < 0.01, "at rest, up shows gravity: {up}");
            let [x, y, z, w] = reading.orientation.expect("an orientation");
            let yaw = (2.0 * (w * z + x * y))
                .atan2(1.0 - 2.0 * (y * y + z * z))
                .to_degrees();
            let pitch = (2.0 * (w * y - z * x)).asin().to_degrees();
            let roll = (2.0 * (w * x + y * z))
                .atan2(1.0 - 2.0 * (x * x + y * y))
                .to_degrees();
            let error = (roll - 10.0).abs() + (pitch + 20.0).abs() + (yaw - 150.0).abs();
            assert!(error < 0.1, "{roll}, {pitch}, {yaw}");
        }
    }
}

#[test]
fn a_unit_without_sets_is_lost_with_the_reason() {
    for (fault, reason) in [
        (Fault::Silent, "nothing comes"),
        (Fault::OtherBaud, "no frames of a WIT-Motion"),
        (Fault::Corrupt, "wrong checksums"),
        (Fault::Repeats, "the same numbers"),
        (Fault::NoRates, "no turn rates"),
        (Fault::Saturated, "at the limit"),
    ] {
        let mut first = Wire::with(fault);
        first.run(12.0);
        let mut later = Wire::with(Fault::None);
        later.run(1.0);
        assert!(later.session.is_ready());
        later.unit.fault = fault;
        later.run(12.0);
        for wire in [first, later] {
            let found = wire.lost().expect("the unit is lost");
            assert!(found.contains(reason), "{fault:?}: {found}");
        }
    }
}

#[test]
fn a_unit_whose_turn_rates_alone_are_stuck_is_lost_but_zeros_may_be_a_rest() {
    for rates in [[0.5, -0.3, 20.0], [0.0; 3]] {
        let mut wire = Wire::new(EmulatedWit {
            rates,
            ..EmulatedWit::new()
        });
        wire.run(12.0);
        let lost = wire.lost().map(|why| why.contains("the same turn rates"));
        assert_eq!(lost, (rates != [0.0; 3]).then_some(true), "{:?}", wire.lost());
    }
}

#[test]
fn a_frame_that_is_wrong_costs_its_set_and_no_more() {
    let mut wire = Wire::with(Fault::Rarely);
    wire.run(4.0);
    assert!(wire.readings().len() > 250, "{}", wire.readings().len());
    assert_eq!(wire.warnings().len(), 1, "{:?}", wire.warnings());
    assert_eq!(wire.lost(), None);
}

#[test]
fn a_rate_below_that_asked_for_is_said_once() {
    let mut wire = Wire::new(EmulatedWit {
        hertz: 10.0,
        ..EmulatedWit::new()
    });
    wire.run(12.0);
    let [words] = wire.warnings()[..] else {
        panic!("{:?}", wire.warnings())
    };
    assert!(
        words.starts_with("it sends 1") && words.contains("asks for 100"),
        "{words}"
    );
    let mut wire = Wire::with(Fault::None);
    wire.run(12.0);
    assert_eq!(wire.warnings(), [] as [&str; 0]);
}

#[test]
fn what_waited_during_a_pause_of_the_driver_is_discarded() {
    let mut wire = Wire::with(Fault::None);
    wire.run(1.0);
    wire.events.clear();
    let bytes: Vec<u8> = (0..50).flat_map(|_| wire.unit.next_output()).collect();
    wire.now += Duration::from_secs(2);
    wire.session.receive(&bytes, wire.now, &mut wire.events);
    assert_eq!(wire.events, []);
    wire.run(1.0);
    assert!(wire.lost().is_none() && wire.readings().len() > 30);
}
